//! Artificial heat conduction where matter is being compressed.
//!
//! Artificial viscosity overheats the few cells in which a shock is born, at a contact or a wall: the two halves of the shock's
//! profile are cut off there, and what they heat too much stays behind (W. F. Noh, J. Comput. Phys. 72, 78 (1987), who adds a
//! heat flux beside the viscosity). Here the thermal energy h of particles of one material goes over to a mean over the nodes and back,
//!
//! `dh_p = sum_i w_i alpha_i (h_i - h_p)`, `h_i = sum m w h / sum m w`, `alpha_i = min(1, nodal mass mean of k dt max(0, -div))`,
//!
//! which conserves energy to rounding, makes no new extreme of h, and is nothing outside shocks. (Were it the whole energy e, matter
//! that is compressed would be robbed of the energy of compression and fall below zero on release.) What a shock of given speed
//! leaves behind where it was born is the difference of the energy in its own profile from that of a sharp front: so a narrow
//! profile with a foot of heat ahead of it leaves less, and the heat conduction pays for a smaller viscosity.
use crate::grid::Grid;
use crate::kernel::Stencil;
use crate::p2g::Work;
use crate::particle::Particle;
use crate::step::Setting;
use crate::tensor;

/// Node fields of the pass, kept between steps for their memory.
#[derive(Default)]
pub struct Conduction {
    /// Sums over a material's particles by node: mass, mass e, mass alpha; `[node * materials + material]`.
    nodes: Vec<[f64; 3]>,
    /// Nodes that conduct.
    active: Vec<bool>,
}

impl Conduction {
    /// Fills in each particle's gain [J] in a step of `dt` [s].
    pub fn conduct<const D: usize>(
        &mut self,
        particles: &[Particle<D>],
        work: &mut [Work<D>],
        grid: &Grid<D>,
        setting: &Setting<D>,
        dt: f64,
    ) {
        let materials = setting.laws.len();
        self.active.clear();
        self.active.resize(grid.nodes.len(), false);
        let share = |p: &Particle<D>, w: &Work<D>| {
            let divergence = tensor::trace(&w.gradient_at_start(p, setting));
            if w.alone || p.is_open() { 0.0 } else { (-setting.method.conduction * dt * divergence).max(0.0) }
        };
        let mut any = false;
        for (p, w) in particles.iter().zip(work.iter_mut()) {
            w.conducted = share(p, w);
            if w.conducted > 0.0 {
                any = true;
                grid.stencil(w.slot).iter().for_each(|&n| self.active[n as usize] = true);
            }
        }
        if !any {
            return;
        }
        self.nodes.clear();
        self.nodes.resize(grid.nodes.len() * materials, [0.0; 3]);
        let touched = |w: &Work<D>| grid.stencil(w.slot).iter().any(|&n| self.active[n as usize]);
        let taking_part: Vec<usize> = (0..work.len()).filter(|&i| touched(&work[i])).collect();
        for &i in &taking_part {
            let (p, w) = (&particles[i], &work[i]);
            let material = setting.material(p.body);
            let heat = setting.laws[material].thermal_energy(p);
            each_weight(w, setting.cell, grid, |node, weight| {
                let sums = &mut self.nodes[node * materials + material];
                let m = p.mass * weight;
                sums[0] += m;
                sums[1] += m * heat;
                sums[2] += m * w.conducted;
            });
        }
        for &(front, behind) in grid.images.iter().flatten() {
            for k in 0..materials {
                let (a, b) = (front as usize * materials + k, behind as usize * materials + k);
                let sum = std::array::from_fn(|c| self.nodes[a][c] + self.nodes[b][c]);
                (self.nodes[a], self.nodes[b]) = (sum, sum);
            }
        }
        for &i in &taking_part {
            let (p, material) = (&particles[i], setting.material(particles[i].body));
            let heat = setting.laws[material].thermal_energy(p);
            let mut gain = 0.0;
            each_weight(&work[i], setting.cell, grid, |node, weight| {
                let [mass, energy, share] = self.nodes[node * materials + material];
                if share > 0.0 {
                    gain += weight * (share / mass).min(1.0) * (energy / mass - heat);
                }
            });
            work[i].conducted = p.mass * gain;
        }
    }
}

/// Every node of a particle, with its weight.
#[inline(always)]
fn each_weight<const D: usize>(w: &Work<D>, cell: f64, grid: &Grid<D>, mut visit: impl FnMut(usize, f64)) {
    let nodes = grid.stencil(w.slot);
    for row in 0..Stencil::<D>::ROWS {
        let r = w.stencil.row(row, cell);
        for k in 0..4 {
            visit(nodes[4 * row + k] as usize, r.weight * w.stencil.weight[D - 1][k]);
        }
    }
}
