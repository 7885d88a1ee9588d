//! Particles at one time as results keep them, and how much of each body has melted.
use crate::particle::Particle;
use crate::result::{Melt, Particles, Snapshot, Space};
use crate::step::{Setting, State};
use hvi_eos::Point;
use std::collections::BTreeMap;

/// Cells that artificial viscosity overheats where bodies meet.
const OVERHEATED: f64 = 3.0;

/// Whether each of `particles`, as they begin, lies within [`OVERHEATED`] cells of where bodies meet: of its body's front, for the
/// projectile, or of the side turned towards it, column by column of a cell's width.
pub fn at_contact<const D: usize>(particles: &[Particle<D>], cell: f64) -> Vec<bool> {
    let sign = |p: &Particle<D>| if p.body == 0 { 1.0 } else { -1.0 };
    let column = |p: &Particle<D>| {
        let across = |d: usize| p.position.get(d).map_or(0, |x| (x / cell).floor() as i64);
        (p.body, across(1), across(2))
    };
    let mut front: BTreeMap<(u8, i64, i64), f64> = BTreeMap::new();
    for p in particles {
        let at = front.entry(column(p)).or_insert(f64::NEG_INFINITY);
        *at = at.max(sign(p) * p.position[0]);
    }
    particles.iter().map(|p| front[&column(p)] - sign(p) * p.position[0] < OVERHEATED * cell).collect()
}

/// The run at this time; `multiple` makes whole masses of the particles' own, `projectile_mass` [kg] is a whole one too; `contact` as
/// [`at_contact`] says, by particle.
pub fn snapshot<const D: usize>(
    state: &State<D>,
    setting: &Setting<D>,
    space: Space,
    [multiple, projectile_mass]: [f64; 2],
    contact: &[bool],
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
        sums.contact += if contact[p.id as usize] { share * intact.liquid } else { 0.0 };
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of ten particles a body, two a cell, that meet at 0: the six nearest are within three cells, and a particle in a column
    /// of its own is its own front.
    #[test]
    fn three_cells_on_both_sides() {
        let at = |x: f64, y: f64, body: u8| Particle::<2>::new([x, y], [0.0; 2], 1.0, 1.0, 0, body);
        let row = |body: u8, sign: f64| (0..10).map(move |i| at(sign * (0.25 + 0.5 * f64::from(i)), 0.5, body));
        let all: Vec<_> = row(0, -1.0).chain(row(1, 1.0)).chain([at(-4.75, 1.5, 0)]).collect();
        let near = at_contact(&all, 1.0);
        let expected = |i: usize| i < 6;
        for i in 0..10 {
            assert_eq!([near[i], near[10 + i]], [expected(i); 2], "{i}");
        }
        assert!(near[20]);
    }
}
