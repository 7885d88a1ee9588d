//! Grid to particles: velocity, affine field and position (step 4 of the method), then volume, stress, energy and
//! equation of state (steps 5 to 7).
use crate::grid::Grid;
use crate::kernel::{MOMENT, Stencil};
use crate::material::Law;
use crate::p2g::{Sums, Work, full_gradient};
use crate::particle::Particle;
use crate::step::{Setting, Totals};

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
        let radius = p.position[D.min(2) - 1];
        let l = full_gradient(&mean, velocity[D.min(2) - 1], radius, setting);
        let heat = w.heat + returned(p, &sums, setting.cell);
        transfer(p, &sums, &velocity, setting, dt);
        p.alone = w.alone;
        let booked =
            if w.alone { Law::fly(p, heat) } else { setting.laws[p.body as usize].advance(p, &w.stress, &l, heat, dt) };
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
fn gather_end<const D: usize>(p: &Particle<D>, w: &Work<D>, grid: &Grid<D>, cell: f64) -> Sums<D> {
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

/// Affine field C from the moment sums: `C = B / D`.
#[inline(always)]
fn affine<const D: usize>(sums: &Sums<D>, cell: f64) -> [[f64; D]; D] {
    let factor = 1.0 / (MOMENT * cell * cell);
    sums.moment.map(|row| row.map(|x| x * factor))
}

/// Motion on the grid that the particle can't hold: `m/2 [sum w |u|^2 - |mean u|^2 - D |C|^2]` [J], heat from now on.
#[inline(always)]
fn returned<const D: usize>(p: &Particle<D>, sums: &Sums<D>, cell: f64) -> f64 {
    let mut held = 0.0;
    let per_moment = 1.0 / (MOMENT * cell * cell);
    for c in 0..D {
        held += sums.mean[c] * sums.mean[c];
        for d in 0..D {
            held += sums.moment[c][d] * sums.moment[c][d] * per_moment;
        }
    }
    0.5 * p.mass * (sums.square - held)
}

/// Takes over velocity and affine field, moves by the mean `velocity` of the step, and keeps in front of the mirrors.
#[inline(always)]
fn transfer<const D: usize>(p: &mut Particle<D>, sums: &Sums<D>, velocity: &[f64; D], setting: &Setting<D>, dt: f64) {
    p.affine = affine(sums, setting.cell);
    for c in 0..D {
        p.velocity[c] += sums.mean[c];
        p.position[c] += dt * velocity[c];
    }
    for d in 0..D {
        if setting.mirrors[d] && p.position[d] < 0.0 {
            p.position[d] = -p.position[d];
            p.velocity[d] = -p.velocity[d];
            for c in 0..D {
                p.affine[c][d] = -p.affine[c][d];
                p.affine[d][c] = -p.affine[d][c];
            }
        }
    }
}
