//! Stage `validate.isotherm`: the room-temperature isotherm against static experiments.
use crate::score::{ALL, Compared, Score, Validation, judged};
use crate::states::{Isochores, between};
use crate::{Csv, CsvError, metal};
use hvi_eos::{Eos, EosResult};
use hvi_kit::units::Dimension;
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
        /// Points of a diamond anvil: columns `P_revised` [GPa] and `V_over_V0`. Lines say what they are: `# set: diamond anvil (...)`,
        /// `# T: 298 K`, `# rho0: 8.94 g/cm3`, the density at V0.
        data: File,
    }
}

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
/// [`StageError::Physics`] where the data file is malformed, has no points to score or is of another metal, or the states have no
/// zero-pressure solid or are of another metal.
pub fn validate(inputs: &Inputs) -> Result<Validation, StageError> {
    let eos = &inputs.eos.eos;
    let (v0, t0) = (eos.reference_volume(), eos.reference_temperature());
    let model = |ratio: f64| Some(ratio * v0).filter(|v| eos.covers(*v, t0)).map(|v| eos.pressure_at(v, t0));
    let isochores = Isochores::beside(eos, &inputs.states.0).map_err(StageError::physics)?;
    let states = isochores.as_ref().map_or(Vec::new(), |i| i.isotherm(t0));
    let Anvil { set, temperature, density, points: measured } =
        anvil(inputs.data.text().map_err(StageError::physics)?).map_err(StageError::physics)?;
    if let Some(density) = density {
        metal::check(1.0 / v0, "the data are", density).map_err(StageError::physics)?;
    }
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
        sets: vec![set],
        points,
        states,
        line,
        scores,
        volumes: isochores.as_ref().map_or((v0, v0, 0.0), |i| (v0, i.reference.volume, i.reference.volume_error)),
        notes: notes(eos, temperature, density).into_iter().chain(isochores.and_then(|i| i.note())).collect(),
    })
}

fn notes(eos: &Eos, temperature: Option<f64>, density: Option<f64>) -> Vec<String> {
    let mut all = vec![
        "Pressures are compared at equal V/V0: the experiment's with its own V0, the computed with the computed zero-pressure volume."
            .to_string(),
    ];
    if let Some(t) = temperature {
        let (v0, t0) = (eos.reference_volume(), eos.reference_temperature());
        let apart = eos.pressure_at(v0, t0) - eos.pressure_at(v0, t);
        all.push(format!(
            "The experiment is at {t:.0} K, the computed isotherm at {t0:.0} K: {:.3} GPa apart.",
            apart / 1e9
        ));
    }
    all.push(
        "Points below 5 GPa are not scored. Between isochores the states' isotherm has the shape of the equation of state's.".into(),
    );
    all.extend(density.is_none().then(|| metal::UNCHECKED.to_string()));
    all
}

/// What was measured.
struct Anvil {
    /// Its name.
    set: String,
    /// Temperature [K] and density at V0 [kg/m3], where they are said.
    temperature: Option<f64>,
    density: Option<f64>,
    /// V/V0 and P [Pa].
    points: Vec<(f64, f64)>,
}

fn anvil(text: &str) -> Result<Anvil, CsvError> {
    let csv = Csv::read("data", text)?;
    let (ratio, pressure) = (csv.numbers("V_over_V0")?, csv.numbers("P_revised")?);
    let points = ratio.into_iter().zip(pressure.iter().map(|p| p * 1e9)).collect();
    Ok(Anvil {
        set: csv.said("set").unwrap_or("measured").to_string(),
        temperature: csv.quantity("T", Dimension::Temperature)?,
        density: csv.quantity("rho0", Dimension::Density)?,
        points: csv.any(points, "V_over_V0 and P_revised [GPa]")?,
    })
}
