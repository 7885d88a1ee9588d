//! Particles at one time as results keep them, and how much of each body has melted.
use crate::particle::Particle;
use crate::result::{Melt, Particles, Snapshot, Space};
use crate::step::{Setting, State};
use hvi_eos::Point;

/// The run at this time; `multiple` makes whole masses of the particles' own, `projectile_mass` [kg] is a whole one too.
pub fn snapshot<const D: usize>(
    state: &State<D>,
    setting: &Setting<D>,
    space: Space,
    multiple: f64,
    projectile_mass: f64,
) -> Snapshot {
    let mut order: Vec<Particle<D>> = state.particles().collect();
    order.sort_by_key(|p| p.id);
    let mut out = Particles::default();
    let mut melt = vec![Melt::default(); setting.laws.len()];
    let ring = if space == Space::Axisymmetric { multiple } else { 1.0 };
    for p in order {
        let eos = &setting.laws[p.body as usize].eos;
        let own_volume = eos.reference_volume() * p.ratio;
        let volume = eos.relaxed_volume(own_volume, p.energy);
        let intact = eos.point(volume, p.energy);
        let share = multiple * p.mass / projectile_mass;
        let sums = &mut melt[p.body as usize];
        sums.by_phase[intact.phase as usize] += share;
        sums.by_phase_own_volume[eos.point(own_volume, p.energy).phase as usize] += share;
        sums.liquid += share * intact.liquid;
        push(&mut out, &p, volume, &intact, ring);
    }
    Snapshot { time: state.time, particles: out, melt }
}

fn push<const D: usize>(out: &mut Particles, p: &Particle<D>, volume: f64, intact: &Point, ring: f64) {
    for d in 0..3 {
        out.position[d].push(if d < D { p.position[d] as f32 } else { 0.0 });
        out.velocity[d].push(if d < D { p.velocity[d] as f32 } else { 0.0 });
    }
    out.mass.push((ring * p.mass) as f32);
    out.density.push((1.0 / volume) as f32);
    out.pressure.push(p.pressure() as f32);
    out.temperature.push(intact.temperature as f32);
    out.energy.push(p.energy as f32);
    out.liquid.push(intact.liquid as f32);
    out.phase.push(intact.phase as u8);
    out.body.push(p.body);
    out.failed.push(p.failed() as u8);
}
