//! Stage `eos.survey`: how far one equation of state is from another over a field of states, asked so often that the run's CPU time
//! is that of the calls.
use crate::{Eos, EosResult, Point, Points};
use hvi_kit::units::Temperature;
use hvi_kit::view::{Scalar, View};
use hvi_kit::{Artifact, Ctx, Invalid, Stage, StageError, inputs};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Least and largest volume over the reference's.
    pub volumes: [f64; 2],
    /// Coldest and hottest temperature.
    pub temperatures: [Temperature; 2],
    /// States looked at.
    pub states: u32,
    /// Calls, (V, E) -> (P, T, c, phase, share of liquid), in batches as the impact solver's.
    pub calls: u64,
}
impl Default for Params {
    fn default() -> Params {
        let temperatures = [Temperature::new(300.0), Temperature::new(1.2e4)];
        Params { volumes: [0.6, 1.4], temperatures, states: 4096, calls: 1_000_000 }
    }
}

inputs! {
    /// Inputs.
    pub struct Inputs {
        /// What is asked.
        eos: EosResult,
        /// What its answers are held against.
        reference: EosResult,
    }
}

/// Largest and root-mean-square deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Largest.
    pub largest: f64,
    /// Root mean square.
    pub rms: f64,
}

/// What the stage leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Survey {
    /// The model asked.
    pub model: String,
    /// Calls made.
    pub calls: u64,
    /// Of P, relative to the larger of |P| and 1 % of rho0 c0^2.
    pub pressure: Deviation,
    /// Of T, relative to the larger of T and T0.
    pub temperature: Deviation,
    /// Of the sound speed, relative to the larger of it and c0/4.
    pub sound_speed: Deviation,
    /// Of the share of liquid.
    pub liquid: Deviation,
}

impl Artifact for Survey {
    const KIND: &'static str = "eos-survey/1";

    fn scalars(&self) -> Vec<Scalar> {
        let of = |name: &str, d: Deviation| Scalar::number(name, d.largest, "");
        vec![
            Scalar::text("model", &self.model),
            Scalar::number("calls", self.calls as f64, ""),
            of("largest error of P", self.pressure),
            of("largest error of T", self.temperature),
            of("largest error of the sound speed", self.sound_speed),
            of("largest error of the share of liquid", self.liquid),
        ]
    }
    fn views(&self) -> Vec<View> {
        Vec::new()
    }
}

/// The stage.
pub struct SurveyStage;
impl Stage for SurveyStage {
    const NAME: &'static str = "eos.survey";
    const SUMMARY: &'static str =
        "error of an equation of state against another, over a field of states, and the time of its calls";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Survey;

    fn check(p: &Params) -> Result<(), Invalid> {
        let rises = |[a, b]: [f64; 2]| a > 0.0 && b > a && b.is_finite();
        let wrong = |key, why: &str| Err(Invalid::new(key, why));
        match p {
            p if !rises(p.volumes) => wrong("volumes", "are two shares of V0 above 0, the smaller first"),
            p if !rises(p.temperatures.map(|t| t.si())) => wrong("temperatures", "are two above 0 K, the colder first"),
            p if !(1..=1_000_000).contains(&p.states) => wrong("states", "must lie between 1 and 1000000"),
            p if !(1..=100_000_000_000).contains(&p.calls) => wrong("calls", "must lie between 1 and 1e11"),
            _ => Ok(()),
        }
    }

    fn cost(p: &Params) -> f64 {
        0.01 + 3e-8 * p.calls as f64
    }

    fn run(params: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<Survey, StageError> {
        survey(params, &inputs.eos.eos, &inputs.reference.eos, ctx)
    }
}

/// States a call: what a pass of the impact solver hands over at once.
const BATCH: usize = 64;

/// Deviations of `eos` from `reference`.
///
/// # Errors
/// [`StageError::Physics`] where one of the answers is no number; [`StageError::Cancelled`].
pub fn survey(params: &Params, eos: &Eos, reference: &Eos, ctx: &Ctx<'_>) -> Result<Survey, StageError> {
    let (volume, energy) = field(params, reference);
    let mut out = Points::default();
    let (mut calls, mut from) = (0, 0);
    while calls < params.calls {
        if from == 0 {
            ctx.tick(calls as f64, params.calls as f64, "calls")?;
        }
        let to = (from + BATCH).min(volume.len());
        eos.evaluate(&volume[from..to], &energy[from..to], &mut out);
        calls += (to - from) as u64;
        from = to % volume.len();
    }
    let mut squares = [0.0; 4];
    let mut largest = [0.0f64; 4];
    let scales = Scales::of(reference);
    for (&v, &e) in volume.iter().zip(&energy) {
        let errors = scales.errors(eos.point(v, e), reference.point(v, e));
        if errors.iter().any(|x| !x.is_finite()) {
            let [v, e] = [1e3 * v, e / 1e3];
            let text = format!("at V = {v} cm3/g, E = {e} kJ/kg an answer of {} is no finite number", eos.name());
            return Err(StageError::physics(text));
        }
        for k in 0..4 {
            squares[k] += errors[k] * errors[k];
            largest[k] = largest[k].max(errors[k]);
        }
    }
    let of = |k: usize| Deviation { largest: largest[k], rms: (squares[k] / volume.len() as f64).sqrt() };
    let [pressure, temperature, sound_speed, liquid] = [of(0), of(1), of(2), of(3)];
    Ok(Survey { model: eos.name().into(), calls, pressure, temperature, sound_speed, liquid })
}

/// Volumes [m3/kg] and energies [J/kg] all over the field: M. Roberts' R2 sequence, which leaves no gaps at any number of states.
fn field(params: &Params, reference: &Eos) -> (Vec<f64>, Vec<f64>) {
    // Powers of the plastic number's inverse.
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let [narrow, wide] = params.volumes.map(|share| share * reference.reference_volume());
    let [cold, hot] = params.temperatures.map(|t| t.si());
    let at = |i: u32| {
        let [a, b] = STEP.map(|step| (0.5 + step * f64::from(i + 1)) % 1.0);
        let volume = narrow + a * (wide - narrow);
        (volume, reference.energy_at(volume, cold + b * (hot - cold)))
    };
    (0..params.states).map(at).unzip()
}

/// What errors of P [Pa], T [K] and the sound speed [m/s] are relative to at least, as [`Survey`] says.
struct Scales([f64; 3]);

impl Scales {
    fn of(reference: &Eos) -> Scales {
        let (v0, t0) = (reference.reference_volume(), reference.reference_temperature());
        let c0 = reference.point(v0, reference.energy_at(v0, t0)).sound_speed;
        Scales([0.01 * c0 * c0 / v0, t0, 0.25 * c0])
    }

    /// Of P, T, the sound speed and the share of liquid.
    fn errors(&self, a: Point, b: Point) -> [f64; 4] {
        let relative = |a: f64, b: f64, least: f64| (a - b).abs() / b.abs().max(least);
        let [p, t, c] = self.0;
        [
            relative(a.pressure, b.pressure, p),
            relative(a.temperature, b.temperature, t),
            relative(a.sound_speed, b.sound_speed, c),
            (a.liquid - b.liquid).abs(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handbook::Set;
    use crate::{Gray, Patches};

    fn asked(eos: &Eos, params: &Params) -> Survey {
        let gray = Eos::Gray(Gray::new(Set::CopperRoyce.parameters()).unwrap());
        survey(params, eos, &gray, &Ctx::quiet()).unwrap()
    }

    /// A model agrees with itself to the bit; patches err by what they state at most, and by something.
    #[test]
    fn errors_are_those_of_the_model() {
        let params = Params { calls: 10_000, ..Params::default() };
        let gray = Gray::new(Set::CopperRoyce.parameters()).unwrap();
        let same = asked(&Eos::Gray(gray.clone()), &params);
        assert!(same.calls >= 10_000 && same.calls < 10_000 + BATCH as u64);
        assert_eq!(same.pressure, Deviation::default());
        for accuracy in [1e-2, 1e-4] {
            let patches = asked(&Eos::Patches(Patches::new(gray.clone(), accuracy).unwrap()), &params);
            for d in [patches.pressure, patches.temperature, patches.liquid] {
                assert!(d.largest <= accuracy && d.rms < d.largest && d.rms > 1e-4 * accuracy, "{accuracy}: {d:?}");
            }
        }
    }

    #[test]
    fn fields_that_are_none_are_refused() {
        let refused = |p: Params| SurveyStage::check(&p).unwrap_err().key;
        assert_eq!(refused(Params { volumes: [1.0, 0.5], ..Params::default() }), "volumes");
        assert_eq!(refused(Params { states: 0, ..Params::default() }), "states");
        assert_eq!(refused(Params { calls: 0, ..Params::default() }), "calls");
    }
}
