//! Contact of two bodies that may part and slide: a velocity field for each on the grid, joined only where they press together.
//!
//! Where both fields have mass and close in along the common normal, momentum passes between them until they move together along
//! it, and across it as far as Coulomb friction goes; where they draw apart nothing acts (S. G. Bardenhagen, J. E. Guilkey,
//! K. M. Roessig, J. U. Brackbill, W. M. Witzel and J. C. Foster, CMES 2, 509 (2001)). The normal is that of the difference of the two
//! mass gradients, the same for both, so that momentum is exact. Work done at the contact becomes heat of the particles there.
use crate::grid::{Grid, Node};
use crate::grid_update;
use crate::kernel::Stencil;
use crate::p2g::Work;
use crate::particle::Particle;
use crate::step::Setting;

/// Nodes that two bodies share, kept between steps for their memory.
#[derive(Default)]
pub struct Contact<const D: usize> {
    /// Node of the first body, of the second, and the normal from the first to the second.
    pairs: Vec<(u32, u32, [f64; D])>,
    /// Heat at each node over its mass [J/kg].
    heat: Vec<f64>,
}

impl<const D: usize> Contact<D> {
    /// Finds the shared nodes heavier than `cut` [kg] and their normals; the nodes' `next` fields are used and left at zero.
    pub fn find(
        &mut self,
        particles: &[Particle<D>],
        work: &[Work<D>],
        grid: &mut Grid<D>,
        setting: &Setting<D>,
        cut: f64,
    ) {
        for (p, w) in particles.iter().zip(work) {
            let s = &w.stencil;
            for row in 0..Stencil::<D>::ROWS {
                let r = s.row(row, setting.cell);
                for k in 0..4 {
                    let node = grid.at(w.slot, 4 * row + k);
                    for d in 0..D - 1 {
                        node.next[d] += p.mass * r.slope[d] * s.weight[D - 1][k];
                    }
                    node.next[D - 1] += p.mass * r.weight * s.slope[D - 1][k];
                }
            }
        }
        grid_update::means(grid, cut);
        self.pairs.clear();
        for (a, b) in grid.shared() {
            let (first, second) = (grid.nodes[a as usize], grid.nodes[b as usize]);
            if first.mass <= cut || second.mass <= cut {
                continue;
            }
            // The slope of a weight at the particle is minus its slope at the node: this points from the first to the second.
            let across: [f64; D] = std::array::from_fn(|d| first.next[d] * first.mass - second.next[d] * second.mass);
            let size = across.iter().map(|x| x * x).sum::<f64>().sqrt();
            if size > 0.0 {
                self.pairs.push((a, b, across.map(|x| x / size)));
            }
        }
        self.heat.clear();
        self.heat.resize(grid.nodes.len(), 0.0);
        grid.nodes.iter_mut().for_each(|n| n.next = [0.0; D]);
    }

    /// Joins the velocities at the start of the step. What this takes of motion beyond the transfer's own heat is booked.
    pub fn meet(&mut self, grid: &mut Grid<D>, friction: f64) {
        for k in 0..self.pairs.len() {
            let (a, b, normal) = self.pairs[k];
            let (first, second) = (grid.nodes[a as usize], grid.nodes[b as usize]);
            let (u, v) = join(first.velocity, first.mass, second.velocity, second.mass, &normal, friction);
            // Kinetic energy lost, less m/2 |change|^2, which the transfer's heat has already.
            let mut heat = 0.0;
            for d in 0..D {
                heat +=
                    first.mass * u[d] * (first.velocity[d] - u[d]) + second.mass * v[d] * (second.velocity[d] - v[d]);
            }
            (grid.nodes[a as usize].velocity, grid.nodes[b as usize].velocity) = (u, v);
            self.book(a, b, heat / (first.mass + second.mass));
        }
        self.mirror(grid, |node| &mut node.velocity);
    }

    /// Joins the velocities at the end of the step; the impulses' work at the middle of it is booked.
    pub fn part(&mut self, grid: &mut Grid<D>, friction: f64) {
        for k in 0..self.pairs.len() {
            let (a, b, normal) = self.pairs[k];
            let (first, second) = (grid.nodes[a as usize], grid.nodes[b as usize]);
            let (u, v) = join(first.next, first.mass, second.next, second.mass, &normal, friction);
            let mut heat = 0.0;
            for d in 0..D {
                let impulse = first.mass * (u[d] - first.next[d]);
                heat -= 0.5 * impulse * (u[d] + first.velocity[d] - v[d] - second.velocity[d]);
            }
            (grid.nodes[a as usize].next, grid.nodes[b as usize].next) = (u, v);
            self.book(a, b, heat / (first.mass + second.mass));
        }
        self.mirror(grid, |node| &mut node.next);
    }

    /// Behind a mirror everything is the image of what is in front: there a body may have no nodes of its own to pair with.
    fn mirror(&mut self, grid: &mut Grid<D>, field: impl Fn(&mut Node<D>) -> &mut [f64; D]) {
        grid_update::reflect(grid, field);
        for &(front, behind) in grid.images.iter().flatten() {
            self.heat[behind as usize] = self.heat[front as usize];
        }
    }

    fn book(&mut self, a: u32, b: u32, heat: f64) {
        self.heat[a as usize] += heat;
        self.heat[b as usize] += heat;
    }

    /// Adds each particle's share of the contacts' heat to its `conducted` [J].
    pub fn warm(&self, particles: &[Particle<D>], work: &mut [Work<D>], grid: &Grid<D>, cell: f64) {
        if self.pairs.is_empty() {
            return;
        }
        for (p, w) in particles.iter().zip(work) {
            let nodes = grid.stencil(w.slot);
            let mut heat = 0.0;
            for row in 0..Stencil::<D>::ROWS {
                let r = w.stencil.row(row, cell);
                for k in 0..4 {
                    heat += r.weight * w.stencil.weight[D - 1][k] * self.heat[nodes[4 * row + k] as usize];
                }
            }
            w.conducted += p.mass * heat;
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
