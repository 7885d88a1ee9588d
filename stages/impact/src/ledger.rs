//! Sums over the whole scene.
use crate::particle::Particle;
use crate::result::Ledger;
use crate::step::{Setting, State};

/// Momentum along the impact, kinetic and internal energy (by body), mass: all times `multiple`.
pub fn entry<const D: usize>(state: &State<D>, setting: &Setting<D>, multiple: f64, start: Option<&Ledger>) -> Ledger {
    let totals = &state.totals;
    let sum = |f: &dyn Fn(&Particle<D>) -> f64| multiple * state.particles.iter().map(f).sum::<f64>();
    let internal: Vec<f64> = (0..setting.laws.len())
        .map(|body| sum(&|p| if p.body as usize == body { p.mass * p.energy } else { 0.0 }))
        .collect();
    let mut entry = Ledger {
        time: state.time,
        step: state.steps,
        mass: sum(&|p| p.mass),
        momentum: sum(&|p| p.mass * p.velocity[0]),
        kinetic: sum(&|p| p.kinetic(setting.cell)),
        internal,
        viscous: multiple * totals.viscous,
        transfer: multiple * totals.transfer,
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

/// Kinetic plus internal energy, less what the floor put in [J].
fn total(entry: &Ledger) -> f64 {
    entry.kinetic + entry.internal.iter().sum::<f64>() - entry.floored
}

/// Velocity along the impact [m/s] that the leading `share` of the mass of `body` has at least.
pub fn leading<const D: usize>(particles: &[Particle<D>], body: u8, share: f64) -> f64 {
    let mut by_speed: Vec<(f64, f64)> =
        particles.iter().filter(|p| p.body == body).map(|p| (p.velocity[0], p.mass)).collect();
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
