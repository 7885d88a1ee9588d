//! Curves straight from the states of molecular dynamics: one point an isochore, nothing fitted, never across melting.
use crate::{StatePoint, metal};
use hvi_eos::Eos;
use hvi_eos::fit::{FitError, Reference};
use hvi_md::{Phase, State, isochores};

/// R = 8.314462618 J/mol/K (CODATA 2018): heat capacity 3R of a classical crystal.
const HEAT: f64 = 3.0 * 8.314462618;

/// States by isochore, coldest first, densest isochore last.
pub(crate) struct Isochores<'a> {
    /// The zero-pressure solid at T0.
    pub reference: Reference,
    /// States left out because they have torn.
    pub torn: usize,
    isochores: Vec<Vec<&'a State>>,
}

impl<'a> Isochores<'a> {
    /// Those of `states`, where there are any.
    ///
    /// # Errors
    /// What is wrong where there is no reference state, or it is not of the metal of `eos`.
    pub fn beside(eos: &Eos, states: &'a [State]) -> Result<Option<Isochores<'a>>, String> {
        if states.is_empty() {
            return Ok(None);
        }
        let found = Isochores::new(states, eos.reference_temperature()).map_err(|e| e.to_string())?;
        metal::check(1.0 / eos.reference_volume(), "the states are", 1.0 / found.reference.volume)?;
        Ok(Some(found))
    }

    /// Groups `states`, and finds where the solid isotherm at `t0` [K] has no pressure.
    fn new(states: &'a [State], t0: f64) -> Result<Isochores<'a>, FitError> {
        let reference = Reference::find(states, t0)?;
        let torn = states.iter().filter(|s| s.is_torn()).count();
        Ok(Isochores { reference, torn, isochores: isochores(states).into_iter().rev().collect() })
    }

    /// A sentence on torn states, where there are any.
    pub fn note(&self) -> Option<String> {
        (self.torn > 0).then(|| format!("{} torn states, matter beside voids, are left out.", self.torn))
    }

    /// The Hugoniot: on each isochore below V0, the state with `E - E0 = P (V0 - V) / 2`.
    ///
    /// Linear between two neighbouring temperatures of the same phase; isochores on which the Hugoniot passes between a solid
    /// and a liquid state, or beyond the hottest, have no point.
    pub fn hugoniot(&self) -> Vec<StatePoint> {
        let r = &self.reference;
        let point = |isochore: &Vec<&State>| {
            let work = 0.5 * (r.volume - isochore[0].volume);
            let excess = |s: &State| s.energy - r.energy - work * s.pressure;
            let pair = isochore.windows(2).find(|w| excess(w[0]) <= 0.0 && excess(w[1]) > 0.0)?;
            let (cold, hot) = (pair[0], pair[1]);
            if work <= 0.0 || cold.phase != hot.phase {
                return None;
            }
            let (below, above) = (excess(cold), excess(hot));
            let share = -below / (above - below);
            // The error of P at the crossing: of P itself, and of where the crossing lies.
            let slope = (hot.pressure - cold.pressure) / (above - below);
            let error = |s: &State| {
                let own = s.pressure_error * (1.0 + slope * work);
                let shift = s.energy_error * slope;
                own * own + shift * shift
            };
            Some(StatePoint {
                ratio: cold.volume / r.volume,
                pressure: cold.pressure + share * (hot.pressure - cold.pressure),
                error: ((1.0 - share) * (1.0 - share) * error(cold) + share * share * error(hot)).sqrt(),
                temperature: cold.temperature + share * (hot.temperature - cold.temperature),
                solid: cold.phase == Phase::Solid,
            })
        };
        self.isochores.iter().filter_map(point).collect()
    }

    /// The solid isotherm at `t0` [K]: the state within 30 K of it on each isochore, brought to it with C_V = 3R and gamma = 2.
    pub fn isotherm(&self, t0: f64) -> Vec<StatePoint> {
        let point = |isochore: &Vec<&State>| {
            let near = |s: &&&State| s.phase == Phase::Solid && (s.temperature - t0).abs() <= 30.0;
            let s = isochore.iter().find(near)?;
            let heat = HEAT / s.molar_mass * (t0 - s.temperature);
            Some(StatePoint {
                ratio: s.volume / self.reference.volume,
                pressure: s.pressure + 2.0 * heat / s.volume,
                error: s.pressure_error,
                temperature: t0,
                solid: true,
            })
        };
        self.isochores.iter().filter_map(point).collect()
    }
}

/// Pressure of `points` (volume falling) at `ratio`, with the shape of `model` between them: the ratio of both is interpolated
/// linearly. `None` outside the points, and between a solid and a liquid one.
pub(crate) fn between(points: &[StatePoint], ratio: f64, model: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let pair = points.windows(2).find(|w| w[0].ratio >= ratio && ratio >= w[1].ratio)?;
    if pair[0].solid != pair[1].solid {
        return None;
    }
    let share = (pair[0].ratio - ratio) / (pair[0].ratio - pair[1].ratio);
    let [left, right] = [&pair[0], &pair[1]].map(|p| model(p.ratio).filter(|&m| m > 0.0).map(|m| p.pressure / m));
    Some((left? * (1.0 - share) + right? * share) * model(ratio)?)
}
