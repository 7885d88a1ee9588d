//! Stage `validate.isotherm`: the room-temperature isotherm against diamond-anvil experiments.
use crate::score::{ALL, Compared, Score, Validation, judged};
use crate::states::{Isochores, between};
use crate::{Csv, CsvError};
use hvi_eos::EosResult;
use hvi_kit::{Any, Ctx, File, Stage, StageError, inputs};
use hvi_md::State;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The stage has no parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

inputs! {
    /// Inputs of the stage.
    pub struct Inputs {
        /// The equation of state.
        eos: EosResult,
        /// The states of molecular dynamics; without them only the equation of state is judged.
        states: Any<State>,
        /// Diamond-anvil points: columns `P_revised` [GPa] and `V_over_V0`.
        data: File,
    }
}

/// Name of the data.
const SET: &str = "diamond anvil (Dewaele 2004)";

/// The stage.
pub struct Isotherm;
impl Stage for Isotherm {
    const NAME: &'static str = "validate.isotherm";
    const SUMMARY: &'static str =
        "room-temperature isotherm, from the equation of state and from the states, against diamond-anvil experiments";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Validation;

    fn run(_: &Params, inputs: Inputs, _: &Ctx<'_>) -> Result<Validation, StageError> {
        validate(&inputs)
    }
}

/// Compares; see [`Isotherm`].
///
/// # Errors
/// [`StageError::Physics`] where the data file is malformed or has no points to score, or the states have no zero-pressure solid.
pub fn validate(inputs: &Inputs) -> Result<Validation, StageError> {
    let eos = &inputs.eos.eos;
    let (v0, t0) = (eos.reference_volume(), eos.reference_temperature());
    let model = |ratio: f64| Some(eos.pressure_at(ratio * v0, t0));
    let (states, volumes) = if inputs.states.0.is_empty() {
        (Vec::new(), (v0, v0, 0.0))
    } else {
        let isochores = Isochores::new(&inputs.states.0, t0).map_err(StageError::physics)?;
        (isochores.isotherm(t0), (v0, isochores.reference.volume, isochores.reference.volume_error))
    };
    let measured = anvil(inputs.data.text().map_err(StageError::physics)?).map_err(StageError::physics)?;
    let compare = |&(ratio, pressure): &(f64, f64)| Compared {
        set: 0,
        ratio,
        measured: pressure,
        model: model(ratio),
        states: between(&states, ratio, model),
    };
    let points: Vec<Compared> = measured.iter().map(compare).collect();
    let up_to = points.iter().map(|p| p.measured).fold(0.0, f64::max);
    let scores = vec![
        Score::of(ALL, "equation of state", &points, None, up_to, |p| p.model),
        Score::of(ALL, "states", &points, None, up_to, |p| p.states),
    ];
    judged(&scores, up_to).map_err(StageError::physics)?;
    let line = (0..=400)
        .map(|i| 1.0 - 0.001 * f64::from(i))
        .filter_map(|ratio| Some((ratio, model(ratio)?)))
        .take_while(|p| p.1 <= 1.2 * up_to)
        .collect();
    Ok(Validation {
        curve: format!("{t0:.0} K isotherm"),
        sets: vec![SET.into()],
        points,
        states,
        line,
        scores,
        volumes,
        notes: notes(),
    })
}

fn notes() -> Vec<String> {
    [
        "Pressures are compared at equal V/V0: the experiment's with its own V0 (11.810 cubic angstrom an atom), the computed with \
         the computed zero-pressure volume.",
        "The experiment is at 298 K, on the revised ruby scale; 2 K more are 0.015 GPa.",
        "Points below 5 GPa are not scored. Between isochores the states' isotherm has the shape of the equation of state's.",
    ]
    .map(String::from)
    .into()
}

/// V/V0 and P [Pa].
fn anvil(text: &str) -> Result<Vec<(f64, f64)>, CsvError> {
    let csv = Csv::read("data", text)?;
    let (ratio, pressure) = (csv.numbers("V_over_V0")?, csv.numbers("P_revised")?);
    let points = ratio.into_iter().zip(pressure.iter().map(|p| p * 1e9)).collect();
    csv.any(points, "V_over_V0 and P_revised [GPa]")
}
