//! Contact of two bodies that may part and slide: a velocity field for each on the grid, joined only where they press together.
//!
//! Where both fields have mass and close in along the common normal, momentum passes between them until they move together along
//! it, and across it as far as Coulomb friction goes; where they draw apart nothing acts (S. G. Bardenhagen, J. E. Guilkey,
//! K. M. Roessig, J. U. Brackbill, W. M. Witzel and J. C. Foster, CMES 2, 509 (2001)). The normal is that of the difference of the two
//! mass gradients, the same for both, so that momentum is exact. Work done at the contact becomes heat of the particles there.
use crate::grid::{Grid, Node};
use crate::step::Setting;
use crate::store::{Site, Store};
use crate::task::{Crew, Desk, Task};
use crate::transfer::{By, gather, spread};
use crate::window::{Shared, clear_window, see_scalar};
use hvi_kit::lanes::Eight;

/// Nodes that two bodies share, kept between steps for their memory.
#[derive(Default)]
pub struct Contact<const D: usize> {
    /// Node of the first body, of the second, and the normal from the first to the second.
    pairs: Vec<(u32, u32, [f64; D])>,
    /// Heat at each node over its mass [J/kg].
    heat: Vec<f64>,
}

impl<const D: usize> Contact<D> {
    /// Finds the shared nodes heavier than `cut` [kg] and their normals; the field of forces is used and left at zero.
    pub fn find(&mut self, store: &mut Store<D>, grid: &mut Grid<D>, setting: &Setting<D>, cut: f64, crew: &mut Crew) {
        crew.each(store, setting, &Slopes { setting, field: Shared::new(&mut grid.force) });
        grid.fold_force();
        self.pairs.clear();
        for (a, b) in grid.shared() {
            if grid.start[a as usize][0] <= cut || grid.start[b as usize][0] <= cut {
                continue;
            }
            let (first, second) = (grid.force[a as usize], grid.force[b as usize]);
            // The slope of a weight at the particle is minus its slope at the node: this points from the first to the second.
            let across: [f64; D] = std::array::from_fn(|d| first[d + 1] - second[d + 1]);
            let size = across.iter().map(|x| x * x).sum::<f64>().sqrt();
            if size > 0.0 {
                self.pairs.push((a, b, across.map(|x| x / size)));
            }
        }
        self.heat.clear();
        self.heat.resize(grid.start.len(), 0.0);
        grid.force.fill([0.0; 4]);
    }

    /// Joins the velocities at the start of the step. What this takes of motion beyond the transfer's own heat is booked.
    pub fn meet(&mut self, grid: &mut Grid<D>, friction: f64) {
        for k in 0..self.pairs.len() {
            let (a, b, normal) = self.pairs[k];
            let (first, second) = (grid.start[a as usize], grid.start[b as usize]);
            let (m, n) = (first[0], second[0]);
            let (before, other) = (velocity(&first), velocity(&second));
            let (u, v) = join(before, m, other, n, &normal, friction);
            // Kinetic energy lost, less m/2 |change|^2, which the transfer's heat has already.
            let mut heat = 0.0;
            for d in 0..D {
                heat += m * u[d] * (before[d] - u[d]) + n * v[d] * (other[d] - v[d]);
                grid.start[a as usize][d + 1] = u[d];
                grid.start[b as usize][d + 1] = v[d];
            }
            self.book(a, b, heat / (m + n));
        }
        grid.reflect_start();
        self.mirror(grid);
    }

    /// Joins the velocities at the end of a step of `dt` [s] by forces; the impulses' work at the middle of it is booked.
    pub fn part(&mut self, grid: &mut Grid<D>, friction: f64, dt: f64) {
        for k in 0..self.pairs.len() {
            let (a, b, normal) = self.pairs[k];
            let (first, second) = (grid.start[a as usize], grid.start[b as usize]);
            let (m, n) = (first[0], second[0]);
            let (before, other): ([f64; D], [f64; D]) = (velocity(&first), velocity(&second));
            let force = |node: u32, d: usize| grid.force[node as usize][d + 1];
            let next = std::array::from_fn(|d| before[d] + dt * force(a, d) / m);
            let second_next = std::array::from_fn(|d| other[d] + dt * force(b, d) / n);
            let (u, v) = join(next, m, second_next, n, &normal, friction);
            let mut heat = 0.0;
            for d in 0..D {
                let impulse = m * (u[d] - next[d]);
                heat -= 0.5 * impulse * (u[d] + before[d] - v[d] - other[d]);
                grid.force[a as usize][d + 1] += impulse / dt;
                grid.force[b as usize][d + 1] -= impulse / dt;
            }
            self.book(a, b, heat / (m + n));
        }
        grid.reflect_force();
        self.mirror(grid);
    }

    /// Behind a mirror everything is the image of what is in front: there a body may have no nodes of its own to pair with.
    fn mirror(&mut self, grid: &Grid<D>) {
        for &(front, behind) in grid.images.iter().flatten() {
            self.heat[behind as usize] = self.heat[front as usize];
        }
    }

    fn book(&mut self, a: u32, b: u32, heat: f64) {
        self.heat[a as usize] += heat;
        self.heat[b as usize] += heat;
    }

    /// Adds each particle's share of the contacts' heat to its own.
    pub fn warm(&self, store: &mut Store<D>, setting: &Setting<D>, crew: &mut Crew) {
        if !self.pairs.is_empty() {
            crew.each(store, setting, &Warm { setting, heat: &self.heat });
        }
    }
}

fn velocity<const D: usize>(node: &Node) -> [f64; D] {
    std::array::from_fn(|d| node[d + 1])
}

/// Sums of mass times the slope of the weights.
struct Slopes<'a, const D: usize> {
    setting: &'a Setting<D>,
    field: Shared<'a>,
}

impl<const D: usize> Task<D> for Slopes<'_, D> {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        let Desk { lines, windows, quads, .. } = desk;
        let [constant, columns @ ..] = quads;
        *constant = [[0.0; 4]; 8];
        clear_window::<R, D>(site, &mut windows[0]);
        let origin = site.origin();
        for group in &site.groups {
            for (k, pack) in group.packs.iter().enumerate() {
                lines.fill::<R, D, N, true, false>(
                    &pack.position,
                    &origin,
                    self.setting.method.kernel,
                    self.setting.cell,
                );
                for d in 0..D {
                    let mut only = [R::of(0.0); 4];
                    only[d + 1] = R::load(&pack.matter.mass);
                    R::transposed(only, &mut columns[d + 3 - D]);
                }
                for lane in 0..group.live(k) {
                    spread::<R, D, N, true>(&mut windows[0], lines, lane, By::Slope, constant, columns);
                }
            }
        }
        // SAFETY: passes do blocks of one colour at a time, and those share no node.
        unsafe { self.field.add::<R, D>(site, &mut windows[0]) };
    }
}

/// Heat of the nodes to the particles.
struct Warm<'a, const D: usize> {
    setting: &'a Setting<D>,
    heat: &'a [f64],
}

impl<const D: usize> Task<D> for Warm<'_, D> {
    #[inline(always)]
    fn run<R: Eight, const N: usize>(&self, site: &mut Site<D>, desk: &mut Desk) {
        let Desk { lines, windows, sums, .. } = desk;
        see_scalar(site, self.heat, &mut windows[0]);
        let origin = site.origin();
        for group in &mut site.groups {
            for k in 0..group.packs.len() {
                let live = group.live(k);
                let pack = &mut group.packs[k];
                lines.fill::<R, D, N, false, false>(
                    &pack.position,
                    &origin,
                    self.setting.method.kernel,
                    self.setting.cell,
                );
                for lane in 0..live {
                    gather::<R, D, N, false, false>(&windows[0], lines, lane, &mut sums[0]);
                    pack.heat[lane] += pack.matter.mass[lane] * sums[0].mean[lane][0];
                }
            }
        }
    }
}

/// The velocities `u` of mass `m` and `v` of mass `n` [kg] after contact along `normal`, from the first to the second.
fn join<const D: usize>(
    mut u: [f64; D],
    m: f64,
    mut v: [f64; D],
    n: f64,
    normal: &[f64; D],
    friction: f64,
) -> ([f64; D], [f64; D]) {
    let relative: [f64; D] = std::array::from_fn(|d| u[d] - v[d]);
    let closing: f64 = (0..D).map(|d| relative[d] * normal[d]).sum();
    if closing <= 0.0 {
        return (u, v);
    }
    let reduced = m * n / (m + n);
    let across: [f64; D] = std::array::from_fn(|d| relative[d] - closing * normal[d]);
    let sliding = across.iter().map(|x| x * x).sum::<f64>().sqrt();
    let grip = if sliding > 0.0 { (friction * closing / sliding).min(1.0) } else { 0.0 };
    for d in 0..D {
        let impulse = reduced * (closing * normal[d] + grip * across[d]);
        u[d] -= impulse / m;
        v[d] += impulse / n;
    }
    (u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Momentum is kept; closing bodies end with no relative velocity along the normal, and slide on less the friction's share;
    /// parting ones keep theirs.
    #[test]
    fn joined_velocities() {
        let (u, v, normal) = ([3.0, 1.0], [-1.0, 0.5], [1.0, 0.0]);
        for friction in [0.0, 0.05, 10.0] {
            let (a, b) = join(u, 2.0, v, 3.0, &normal, friction);
            for d in 0..2 {
                assert!((2.0 * a[d] + 3.0 * b[d] - 2.0 * u[d] - 3.0 * v[d]).abs() < 1e-14);
            }
            assert!((a[0] - b[0]).abs() < 1e-14);
            assert!(((a[1] - b[1]) - (0.5 - 4.0 * friction).max(0.0)).abs() < 1e-14, "{friction}");
        }
        assert_eq!(join(v, 2.0, u, 3.0, &normal, 1.0), (v, u));
    }
}
