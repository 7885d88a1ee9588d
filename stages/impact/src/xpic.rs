//! FLIP's and XPIC's return of velocity: what is damped away, and the motion that becomes heat.
//!
//! With S the pass from grid to particles and S+ its mass-weighted transpose, XPIC of order k takes `d = (1 - S S+)^k v` from
//! each particle's velocity (C. C. Hammerquist and J. A. Nairn, Comput. Methods Appl. Mech. Eng. 318, 724 (2017)). The loss of
//! kinetic energy is booked where it happens: with `e_j = (1 - S S+)^j v`, and S S+ its own transpose in the mass-weighted
//! product, `sum m v.d` is `sum m |e_j|^2` for k = 2 j and `sum m sum_i w |e_j - (S+ e_j)_i|^2` for k = 2 j + 1.
use crate::grid::Grid;
use crate::grid_update;
use crate::kernel::Stencil;
use crate::method::Transfer;
use crate::p2g::Work;
use crate::particle::Particle;
use crate::step::Setting;

/// Fills in what each particle's velocity loses (`damped`) and the heat of it but for the part with the acceleration.
/// The nodes' `next` fields are used and left at zero.
pub fn damp<const D: usize>(
    particles: &[Particle<D>],
    work: &mut [Work<D>],
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    cut: f64,
) {
    let order = match setting.method.transfer {
        Transfer::Apic | Transfer::Flip => return,
        Transfer::Xpic { order } => order,
    };
    for (p, w) in particles.iter().zip(work.iter_mut()) {
        w.damped = p.velocity;
        w.heat = 0.0;
    }
    for pass in 0..order {
        mean(particles, work, grid, setting, cut);
        for (p, w) in particles.iter().zip(work.iter_mut()) {
            let (left, apart) = remainder(w, grid, setting.cell);
            // The middle of the chain of passes holds the loss, see above.
            if order % 2 == 1 && pass == order / 2 {
                w.heat = p.mass * apart;
            }
            w.damped = left;
            if order % 2 == 0 && pass + 1 == order / 2 {
                w.heat = p.mass * square(&left);
            }
        }
    }
    grid.nodes.iter_mut().for_each(|n| n.next = [0.0; D]);
    for (p, w) in particles.iter().zip(work) {
        w.heat -= 0.5 * p.mass * square(&w.damped);
    }
}

fn square<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// `next_i` = mass-weighted mean of the particles' `damped`.
fn mean<const D: usize>(
    particles: &[Particle<D>],
    work: &[Work<D>],
    grid: &mut Grid<D>,
    setting: &Setting<D>,
    cut: f64,
) {
    grid.nodes.iter_mut().for_each(|n| n.next = [0.0; D]);
    for (p, w) in particles.iter().zip(work) {
        for row in 0..Stencil::<D>::ROWS {
            let r = w.stencil.row(row, setting.cell);
            for k in 0..4 {
                let m = p.mass * r.weight * w.stencil.weight[D - 1][k];
                let node = grid.at(w.slot, 4 * row + k);
                for c in 0..D {
                    node.next[c] += m * w.damped[c];
                }
            }
        }
    }
    grid_update::means(grid, cut);
}

/// The particle's `damped` less its mean over the nodes, and `sum_i w |damped - next_i|^2`.
fn remainder<const D: usize>(w: &Work<D>, grid: &Grid<D>, cell: f64) -> ([f64; D], f64) {
    let (mut left, mut apart) = ([0.0; D], 0.0);
    let nodes = grid.stencil(w.slot);
    for row in 0..Stencil::<D>::ROWS {
        let r = w.stencil.row(row, cell);
        for k in 0..4 {
            let weight = r.weight * w.stencil.weight[D - 1][k];
            let node = &grid.nodes[nodes[4 * row + k] as usize];
            for c in 0..D {
                let x = w.damped[c] - node.next[c];
                left[c] += weight * x;
                apart += weight * x * x;
            }
        }
    }
    (left, apart)
}

/// Gives `p` its own velocity plus the grid's acceleration less what is damped; returns the heat [J]: what was damped, and the
/// grid's motion that the particle can't hold, `m/2 (sum w |dt a_i|^2 - |dt a_p|^2)`.
#[inline(always)]
pub fn transfer<const D: usize>(p: &mut Particle<D>, w: &Work<D>, grid: &Grid<D>, setting: &Setting<D>) -> f64 {
    let (mut gained, mut size) = ([0.0; D], 0.0);
    let nodes = grid.stencil(w.slot);
    for row in 0..Stencil::<D>::ROWS {
        let r = w.stencil.row(row, setting.cell);
        for k in 0..4 {
            let weight = r.weight * w.stencil.weight[D - 1][k];
            let node = &grid.nodes[nodes[4 * row + k] as usize];
            for c in 0..D {
                let x = node.next[c] - node.velocity[c];
                gained[c] += weight * x;
                size += weight * x * x;
            }
        }
    }
    let mut heat = 0.5 * (size - square(&gained));
    for c in 0..D {
        heat += gained[c] * w.damped[c];
        p.velocity[c] += gained[c] - w.damped[c];
    }
    let damped = if setting.method.transfer == Transfer::Flip { 0.0 } else { w.heat };
    p.mass * heat + damped
}
