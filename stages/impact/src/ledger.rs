//! Sums over the whole scene.
use crate::material::Law;
use crate::particle::Particle;
use crate::result::Ledger;
use crate::step::{Setting, State};
use hvi_eos::{Eos, Instructions, Points};

/// Momentum along the impact, kinetic and internal energy (by body), mass: all times `multiple`.
pub fn entry<const D: usize>(state: &State<D>, setting: &Setting<D>, multiple: f64, start: Option<&Ledger>) -> Ledger {
    let totals = &state.totals;
    let moment = setting.method.moment(setting.cell);
    let (mut mass, mut momentum, mut kinetic, mut flying) = (0.0, 0.0, 0.0, 0.0);
    let mut internal = vec![0.0; setting.laws.len()];
    let mut intact: Vec<Intact> = setting.laws.iter().map(|_| Intact::default()).collect();
    state.visit(|p| {
        let (motion, inside) = (p.kinetic(moment), p.mass * p.energy);
        mass += p.mass;
        momentum += p.mass * p.velocity[0];
        kinetic += motion;
        internal[p.body as usize] += inside;
        flying += if p.alone { motion + inside } else { 0.0 };
        intact[p.body as usize].add(&p, &setting.laws[p.body as usize]);
    });
    internal.iter_mut().for_each(|e| *e *= multiple);
    let each = setting.laws.iter().zip(&intact);
    let by_phase =
        each.map(|(law, own)| own.by_phase(&law.eos, setting.instructions).map(|heat| multiple * heat)).collect();
    let mut entry = Ledger {
        time: state.time,
        step: state.steps,
        mass: multiple * mass,
        momentum: multiple * momentum,
        kinetic: multiple * kinetic,
        internal,
        by_phase,
        flying: multiple * flying,
        viscous: multiple * totals.viscous,
        transfer: multiple * totals.transfer,
        unresolved: multiple * totals.unresolved,
        floored: multiple * totals.floored,
        drift: 0.0,
        highest_pressure: totals.highest_pressure,
        highest_compression: 1.0 / totals.least_ratio,
        time_step: state.dt,
    };
    if let Some(start) = start {
        entry.drift = total(&entry) / total(start) - 1.0;
    }
    entry
}

/// Matter of a body that is under pressure and so fills its volume: its phase depends on that.
#[derive(Default)]
struct Intact {
    /// Specific volumes [m3/kg].
    volume: Vec<f64>,
    /// Specific energies [J/kg].
    energy: Vec<f64>,
    /// Internal energies [J].
    heat: Vec<f64>,
    /// Internal energy of the others by phase [J].
    parted: [f64; 5],
}

impl Intact {
    #[inline(always)]
    fn add<const D: usize>(&mut self, p: &Particle<D>, law: &Law) {
        let heat = p.mass * p.energy;
        if p.unclamped < 0.0 {
            self.parted[law.released.phase(p.energy) as usize] += heat;
            return;
        }
        self.volume.push(law.eos.reference_volume() * p.ratio);
        self.energy.push(p.energy);
        self.heat.push(heat);
    }

    /// Internal energy by phase [J].
    fn by_phase(&self, eos: &Eos, set: Instructions) -> [f64; 5] {
        let (mut points, mut sums) = (Points::default(), self.parted);
        eos.evaluate_with(set, &self.volume, &self.energy, &mut points);
        for (phase, heat) in points.phase.iter().zip(&self.heat) {
            sums[*phase as usize] += heat;
        }
        sums
    }
}

/// Kinetic, unresolved and internal energy, less what the floor put in [J].
fn total(entry: &Ledger) -> f64 {
    entry.kinetic + entry.unresolved + entry.internal.iter().sum::<f64>() - entry.floored
}

/// Velocity along the impact [m/s] that the leading `share` of the mass of `body` has at least.
pub fn leading<const D: usize>(particles: impl Iterator<Item = Particle<D>>, body: u8, share: f64) -> f64 {
    let mut by_speed: Vec<(f64, f64)> = particles.filter(|p| p.body == body).map(|p| (p.velocity[0], p.mass)).collect();
    by_speed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let wanted = share * by_speed.iter().map(|p| p.1).sum::<f64>();
    let mut sum = 0.0;
    for (speed, mass) in by_speed {
        sum += mass;
        if sum >= wanted {
            return speed;
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Material, Switches};

    /// A block that shrinks evenly, one short step: the ledger's columns are `multiple` times the particles' sums.
    /// The linear velocity field is carried exactly, so viscous heat is `m |div| dt dx (c2 dx |div| + c1 c)` of each of the 27
    /// particles and the transfer makes no heat but rounding; 1e-15 s is too short to change either by 1e-6.
    #[test]
    fn columns_of_a_shrinking_block() {
        let material = Material::named("copper").expect("shipped");
        let on = Switches { strength: false, damage: false, spall: false };
        let law = Law::new(&material, material.eos.clone(), on);
        let density = 1.0 / law.eos.reference_volume();
        let (cell, jump, dt) = (1e-3, 300.0, 1e-15);
        let rate = jump / cell;
        let setting = Setting::<3>::new(cell, vec![law]);
        let volume = 0.125 * cell * cell * cell;
        let at = |i: usize| 0.5 * cell * (i as f64 - 1.0);
        let particles: Vec<Particle<3>> = (0..27)
            .map(|i| {
                let x = [at(i / 9), at(i / 3 % 3), at(i % 3)];
                let mut p = Particle::new(x, x.map(|x| -rate / 3.0 * x), density * volume, volume, i as u32, 0);
                (0..3).for_each(|d| p.affine[d][d] = -rate / 3.0);
                p
            })
            .collect();
        let mut state = State::new(particles, &setting);
        let (sound, mass) = (state.particles().next().expect("one").sound_speed, 27.0 * density * volume);
        let start = entry(&state, &setting, 4.0, None);
        state.step(&setting, dt).expect("a step");
        let end = entry(&state, &setting, 4.0, Some(&start));
        let viscous = 4.0 * mass * rate * dt * (0.7 * jump + 0.3 * sound) * jump;
        assert!((end.viscous / viscous - 1.0).abs() < 1e-6, "{:e} J, expected {viscous:e} J", end.viscous);
        assert!(end.transfer.abs() < 1e-6 * viscous, "{:e} J", end.transfer);
        assert!((end.mass / (4.0 * mass) - 1.0).abs() < 1e-14 && end.momentum.abs() < 1e-12 * mass * jump);
        assert!((end.internal[0] - start.internal[0]) / viscous > 0.9, "{:e} J", end.internal[0] - start.internal[0]);
        assert_eq!((end.floored, end.time, end.step), (0.0, dt, 1));
    }
}
