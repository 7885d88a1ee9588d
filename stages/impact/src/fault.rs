//! What is said where a run goes wrong: where, what, what was allowed, the likely cause, and what to do.
use crate::particle::Particle;
use crate::result::{Body, Crossing, Ledger};
use crate::step::{Setting, State, Stop};
use hvi_kit::StageError;

/// Largest energy drift a run may go on with: a thousand times what rounding makes of 1e6 particles and 1e4 steps.
const DRIFT: f64 = 1e-8;

/// Checks the last entry's drift.
///
/// # Errors
/// A drift beyond the bound: when, what happened since the entry before, and the particle of the highest specific energy, where an
/// error of energy shows first.
pub fn check_drift<const D: usize>(
    entries: &[Ledger],
    state: &State<D>,
    setting: &Setting<D>,
    bodies: &[Body],
) -> Result<(), StageError> {
    let [.., before, last] = entries else { return Ok(()) };
    if last.drift.abs() <= DRIFT {
        return Ok(());
    }
    let moment = setting.method.moment(setting.cell);
    let specific = |p: &Particle<D>| p.energy + p.kinetic(moment) / p.mass;
    let hottest = state.particles().max_by(|a, b| specific(a).total_cmp(&specific(b)));
    Err(StageError::physics(format_args!(
        "step {}, {:.4} us: energy has drifted by {:.2e} of the start's, {DRIFT:.0e} is allowed, and by {:.2e} of it since step {}, \
         {:.4} us. {}. The highest specific energy is that of {}. Nothing of the method makes or loses energy: this is a fault of \
         the program, please report the parameters; a smaller cfl ({} now) may go round it",
        last.step,
        last.time * 1e6,
        last.drift,
        last.drift - before.drift,
        before.step,
        before.time * 1e6,
        cause(before, last, state.totals.limited, setting),
        hottest.map_or("no particle".into(), |p| place(&p, bodies)),
        setting.cfl
    )))
}

/// What is likeliest to have done it.
fn cause<const D: usize>(before: &Ledger, last: &Ledger, limited: u64, setting: &Setting<D>) -> String {
    let floored = last.floored - before.floored;
    if !(last.kinetic + last.internal.iter().sum::<f64>()).is_finite() {
        "The sum itself is no number: some particle's energy or velocity isn't".into()
    } else if limited > 0 {
        format!("Likely cause: a volume change too large for one step ({limited} particle-steps were limited so far)")
    } else if floored > 0.0 {
        format!("Likely cause: energies below zero were lifted to it ({floored:.2e} J since then)")
    } else if setting.method.friction.is_some() {
        "Likely cause: work at the contact of two bodies".into()
    } else {
        "No step limited a volume or lifted an energy".into()
    }
}

/// A particle, where it is, and its state.
fn place<const D: usize>(p: &Particle<D>, bodies: &[Body]) -> String {
    format!(
        "particle {} of the {} at {:?} mm, {:?} m/s (V/V0 {:.4e}, {:.4e} J/kg, sound speed {:.4e} m/s)",
        p.id,
        bodies[p.body as usize].name,
        p.position.map(|x| x * 1e3),
        p.velocity,
        p.ratio,
        p.energy,
        p.sound_speed
    )
}

/// An effect that was left off and is missing, where the run is to stop at that.
pub fn crossed(crossing: &Crossing) -> StageError {
    StageError::physics(format_args!(
        "{:.4} us: {} is {:.3e}, {:.0e} is allowed with {} off, as effects = \"auto\" had decided; set {} on, or guard = \"rerun\"",
        crossing.time * 1e6,
        crossing.what,
        crossing.number,
        crossing.threshold,
        crossing.effect.name(),
        crossing.effect.name()
    ))
}

/// Says where and what, and what to do.
pub fn stopped<const D: usize>(stop: &Stop, state: &State<D>, setting: &Setting<D>, bodies: &[Body]) -> StageError {
    let (id, what) = match *stop {
        Stop::Lost(id) => (id, "its position is not within 5e8 cells of the origin"),
        Stop::NotFinite(id) => (id, "energy, V/V0 and pressure must all be finite"),
        Stop::Collapsed(id, dt) => (
            id,
            &*format!("it asks for a time step of {dt:.2e} s, at least {:.2e} s is allowed", 1e-3 * state.first_dt),
        ),
    };
    let found = state.particles().find(|p| p.id == id);
    StageError::physics(format_args!(
        "step {}, {:.4} us: {}: {what}; try a smaller cfl, or a different number of cells ({:.4} mm now)",
        state.steps,
        state.time * 1e6,
        found.map_or_else(|| format!("particle {id}"), |p| place(&p, bodies)),
        setting.cell * 1e3
    ))
}
