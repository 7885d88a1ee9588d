//! Grid to particles: velocity, affine field and position (step 4 of the method), then volume, stress, energy and
//! equation of state (steps 5 to 7).
use crate::grid::Grid;
use crate::kernel::Stencil;
use crate::material::{Booked, Law};
use crate::method::{Scheme, Transfer};
use crate::p2g::{Sums, Work, full_gradient};
use crate::particle::Particle;
use crate::step::{Setting, Totals};
use crate::xpic;

/// Updates all particles by the end-of-step velocities on the grid; returns the first that went wrong.
pub fn update<const D: usize>(
    particles: &mut [Particle<D>],
    work: &[Work<D>],
    grid: &Grid<D>,
    setting: &Setting<D>,
    dt: f64,
    totals: &mut Totals,
) -> Option<usize> {
    let mut wrong = None;
    for (i, (p, w)) in particles.iter_mut().zip(work).enumerate() {
        let sums = gather_end(p, w, grid, setting.cell);
        // The middle of the step: half of both gradients, half of both velocities.
        let mut mean = [[0.0; D]; D];
        let mut velocity = [0.0; D];
        for c in 0..D {
            for d in 0..D {
                mean[c][d] = 0.5 * (w.gradient[c][d] + sums.gradient[c][d]);
            }
            velocity[c] = p.velocity[c] + 0.5 * (w.drift[c] + sums.mean[c]);
        }
        let radius = w.radius;
        let start = p.velocity[D.min(2) - 1] + w.drift[D.min(2) - 1];
        let l = full_gradient(&mean, velocity[D.min(2) - 1], radius, setting);
        let moment = setting.method.moment(setting.cell);
        let heat = match setting.method.transfer {
            Transfer::Apic => {
                let heat = w.heat + returned(p, &sums, moment);
                adopt(p, &sums, moment);
                heat
            }
            Transfer::Flip | Transfer::Xpic { .. } => xpic::transfer(p, w, grid, setting),
        };
        for d in 0..D {
            p.position[d] += dt * velocity[d];
        }
        p.alone = w.alone;
        let gained = heat + w.conducted;
        let law = &setting.laws[p.body as usize];
        let booked = match setting.method.scheme {
            _ if w.alone => Law::fly(p, gained),
            Scheme::Midpoint => law.advance(p, &w.stress, &l, gained, dt),
            Scheme::Usf | Scheme::Musl => {
                let booked = Law::work(p, &w.stress, &l, gained, dt);
                law.evaluate(p);
                Booked { limited: w.stress.limited, ..booked }
            }
            Scheme::Usl => {
                let end = full_gradient(&sums.gradient, 2.0 * velocity[D.min(2) - 1] - start, radius, setting);
                let booked = Law::work(p, &w.stress, &l, gained, dt);
                let limited = law.deform(p, &end, dt);
                law.evaluate(p);
                Booked { limited, ..booked }
            }
        };
        if setting.method.scheme != Scheme::Musl {
            reflect(p, &setting.mirrors);
        }
        totals.transfer += heat;
        totals.viscous += booked.viscous;
        totals.floored += booked.floored;
        totals.limited += booked.limited as u64;
        if p.pressure > totals.highest_pressure {
            totals.highest_pressure = p.pressure;
        }
        if p.ratio < totals.least_ratio {
            totals.least_ratio = p.ratio;
        }
        if !(p.energy + p.ratio + p.pressure).is_finite() && wrong.is_none() {
            wrong = Some(i);
        }
    }
    wrong
}

/// Sums of `u = v_i + dt a_i - v`: the shift by the particle's own velocity keeps small differences exact.
#[inline(always)]
pub fn gather_end<const D: usize>(p: &Particle<D>, w: &Work<D>, grid: &Grid<D>, cell: f64) -> Sums<D> {
    let (s, last) = (&w.stencil, D - 1);
    let nodes = grid.stencil(w.slot);
    let mut sums = Sums::<D>::zero();
    for row in 0..Stencil::<D>::ROWS {
        let r = s.row(row, cell);
        let (mut mean, mut slope, mut moment, mut square) = ([0.0; D], [0.0; D], [0.0; D], 0.0);
        for k in 0..4 {
            let node = &grid.nodes[nodes[4 * row + k] as usize];
            let (weight, gradient) = (s.weight[last][k], s.slope[last][k]);
            let offset = weight * (s.corner[last] + k as f64 * cell);
            let mut size = 0.0;
            for c in 0..D {
                let u = node.next[c] - p.velocity[c];
                mean[c] += weight * u;
                slope[c] += gradient * u;
                moment[c] += offset * u;
                size += u * u;
            }
            square += weight * size;
        }
        for c in 0..D {
            let weighted = r.weight * mean[c];
            sums.mean[c] += weighted;
            for d in 0..last {
                sums.gradient[c][d] += r.slope[d] * mean[c];
                sums.moment[c][d] += r.offset[d] * weighted;
            }
            sums.gradient[c][last] += r.weight * slope[c];
            sums.moment[c][last] += r.weight * moment[c];
        }
        sums.square += r.weight * square;
    }
    sums
}

/// Motion on the grid that the particle can't hold: `m/2 [sum w |u|^2 - |mean u|^2 - D |C|^2]` [J], heat from now on.
#[inline(always)]
fn returned<const D: usize>(p: &Particle<D>, sums: &Sums<D>, moment: f64) -> f64 {
    let mut held = 0.0;
    let per_moment = 1.0 / moment;
    for c in 0..D {
        held += sums.mean[c] * sums.mean[c];
        for d in 0..D {
            held += sums.moment[c][d] * sums.moment[c][d] * per_moment;
        }
    }
    0.5 * p.mass * (sums.square - held)
}

/// Takes over velocity and affine field `C = B / D` from the sums.
#[inline(always)]
fn adopt<const D: usize>(p: &mut Particle<D>, sums: &Sums<D>, moment: f64) {
    let per_moment = 1.0 / moment;
    p.affine = sums.moment.map(|row| row.map(|x| x * per_moment));
    for c in 0..D {
        p.velocity[c] += sums.mean[c];
    }
}

/// Shear stresses that a reflection of an axis turns round, as places in xx, yy, zz, xy, yz, xz.
const SHEARS: [[usize; 2]; 3] = [[3, 5], [3, 4], [4, 5]];

/// Puts a particle that went through a mirror in its image's place; after the stress has taken its step, since the
/// velocity gradient of the step is that of the side it came from.
#[inline(always)]
pub fn reflect<const D: usize>(p: &mut Particle<D>, mirrors: &[bool; D]) {
    for d in 0..D {
        if mirrors[d] && p.position[d] < 0.0 {
            p.position[d] = -p.position[d];
            p.velocity[d] = -p.velocity[d];
            for c in 0..D {
                p.affine[c][d] = -p.affine[c][d];
                p.affine[d][c] = -p.affine[d][c];
            }
            for k in SHEARS[d] {
                p.stress[k] = -p.stress[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `R m R` with `R` the reflection of axis `d`.
    fn turned(m: [[f64; 3]; 3], d: usize) -> [[f64; 3]; 3] {
        let sign = |i: usize| if i == d { -1.0 } else { 1.0 };
        std::array::from_fn(|i| std::array::from_fn(|j| sign(i) * m[i][j] * sign(j)))
    }

    fn full(s: &[f64; 6]) -> [[f64; 3]; 3] {
        [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]]
    }

    /// Behind a mirror a particle is its own image: `R x`, `R v`, `R C R` and `R S R`; in front it stays as it is.
    #[test]
    fn reflection_is_the_image() {
        let mut start = Particle::<3>::new([-0.1, -0.2, -0.3], [-4.0, -5.0, -6.0], 1.0, 1.0, 0, 0);
        start.affine = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]];
        start.stress = [1.0, 2.0, -3.0, 4.0, 5.0, 6.0];
        for d in 0..3 {
            let mut p = start;
            reflect(&mut p, &std::array::from_fn(|k| k == d));
            for k in 0..3 {
                let sign = if k == d { -1.0 } else { 1.0 };
                assert_eq!((p.position[k], p.velocity[k]), (sign * start.position[k], sign * start.velocity[k]));
            }
            assert_eq!(p.affine, turned(start.affine, d));
            assert_eq!(full(&p.stress), turned(full(&start.stress), d));
            let mut front = start;
            front.position = start.position.map(f64::abs);
            reflect(&mut front, &[true; 3]);
            assert_eq!((front.velocity, front.affine, front.stress), (start.velocity, start.affine, start.stress));
        }
    }

    /// Through a mirror y = 0 or not, the step of matter that reaches beyond it is the same but for the image.
    #[test]
    fn stress_steps_before_it_is_reflected() {
        let material = crate::material::Material::named("copper").expect("shipped");
        let on = crate::material::Switches { strength: true, damage: false, spall: false };
        let step = |mirrored: bool| {
            let mut setting = Setting::<2>::new(1e-3, vec![Law::new(&material, material.eos.clone(), on)]);
            setting.mirrors = [false, mirrored];
            let mut p = Particle::new([0.5e-3, 1e-6], [0.0, -100.0], 1e-3, 1e-7, 0, 0);
            setting.laws[0].prepare(&mut p);
            let mut grid = Grid::default();
            let mut slots = Vec::new();
            grid.lay_out(&[p], setting.cell, &[false; 2], false, &mut slots).expect("in reach");
            // The grid moves by v_x = 2e3 y / s, v_y = -100 m/s: pure shear and a drift through the mirror.
            let mut nodes: Vec<(u32, f64)> = Vec::new();
            for (k, &node) in grid.stencil(slots[0]).iter().enumerate() {
                nodes.push((node, ((k % 4) as f64 - 1.0) * setting.cell));
            }
            for (node, y) in nodes {
                let node = &mut grid.nodes[node as usize];
                node.velocity = [2e3 * y, -100.0];
                node.next = node.velocity;
            }
            let stencil = Stencil::at(&p.position, setting.cell, setting.method.kernel);
            let mut work = Work::new(slots[0], stencil, p.position[1]);
            (work.drift, work.gradient) = ([2e3 * p.position[1], 0.0], [[0.0, 2e3], [0.0; 2]]);
            let mut particles = [p];
            let mut totals = Totals::default();
            assert!(update(&mut particles, &[work], &grid, &setting, 1e-7, &mut totals).is_none());
            particles[0]
        };
        let (free, held) = (step(false), step(true));
        assert!(free.position[1] < 0.0 && free.stress[3] > 1e6, "{free:?}");
        assert_eq!(held.position, [free.position[0], -free.position[1]]);
        assert_eq!(held.velocity, [free.velocity[0], -free.velocity[1]]);
        assert_eq!(held.stress[3], -free.stress[3]);
        assert_eq!(held.stress[..3], free.stress[..3]);
    }
}
