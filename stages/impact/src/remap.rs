//! The last part of a MUSL step: the particles' new velocities go to the grid once more, and their gradient there deforms matter.
use crate::g2p;
use crate::grid::Grid;
use crate::grid_update;
use crate::kernel::Stencil;
use crate::p2g::{Work, full_gradient};
use crate::particle::Particle;
use crate::step::{Setting, Totals};

/// Deforms all particles by the gradient of their own velocities on the grid, at the weights of the start of the step.
pub fn deform<const D: usize>(
    particles: &mut [Particle<D>],
    work: &[Work<D>],
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    cut: f64,
    dt: f64,
    totals: &mut Totals,
) {
    grid.nodes.iter_mut().for_each(|n| n.next = [0.0; D]);
    for (p, w) in particles.iter().zip(work) {
        for row in 0..Stencil::<D>::ROWS {
            let r = w.stencil.row(row, setting.cell);
            for k in 0..4 {
                let m = p.mass * r.weight * w.stencil.weight[D - 1][k];
                let node = grid.at(w.slot, 4 * row + k);
                for c in 0..D {
                    node.next[c] += m * p.velocity[c];
                }
            }
        }
    }
    grid_update::means(grid, cut);
    for (p, w) in particles.iter_mut().zip(work) {
        if !w.alone {
            let sums = g2p::gather_end(p, w, grid, setting.cell);
            let radial = p.velocity[D.min(2) - 1] + sums.mean[D.min(2) - 1];
            let l = full_gradient(&sums.gradient, radial, w.radius, setting);
            let law = &setting.laws[p.body as usize];
            totals.limited += law.deform(p, &l, dt) as u64;
            law.evaluate(p);
        }
        g2p::reflect(p, &setting.mirrors);
    }
}
