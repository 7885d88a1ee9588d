//! Stage `validate.hugoniot`: the principal Hugoniot against shock experiments.
use crate::score::{Compared, Score, Validation};
use crate::states::{Isochores, between};
use crate::{Csv, CsvError};
use hvi_eos::EosResult;
use hvi_kit::units::Pressure;
use hvi_kit::{Ctx, File, Invalid, Stage, StageError, inputs};
use hvi_md::State;
use serde::{Deserialize, Serialize};

/// Parameters of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Highest measured pressure that counts.
    pub up_to: Pressure,
}
impl Default for Params {
    fn default() -> Params {
        Params { up_to: Pressure::new(400e9) }
    }
}

inputs! {
    /// Inputs of the stage.
    pub struct Inputs {
        /// The equation of state.
        eos: EosResult,
        /// The states of molecular dynamics; without them only the equation of state is judged.
        states: Vec<State>,
        /// Shock states of the LASL compendium: columns `Us`, `up` [km/s], `P` [GPa], `method`.
        marsh: File,
        /// Shock states of the shock wave database: columns `up`, `Us` [km/s], `P_calc` [GPa], `flag`.
        database: File,
    }
}

/// The sets of data, in the order of [`Compared::set`].
const SETS: [&str; 2] = ["LASL compendium (Marsh 1980)", "shock wave database (unflagged)"];
/// A second, lower range of pressure that is scored apart [Pa]: that of most experiments.
const LOWER: f64 = 150e9;

/// The stage.
pub struct Hugoniot;
impl Stage for Hugoniot {
    const NAME: &'static str = "validate.hugoniot";
    const SUMMARY: &'static str =
        "principal Hugoniot, from the equation of state and from the states, against shock experiments";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Validation;

    fn check(params: &Params) -> Result<(), Invalid> {
        match params.up_to.si() > 5e9 {
            true => Ok(()),
            false => Err(Invalid::new("up_to", format!("is {} Pa, must be above 5 GPa", params.up_to.si()))),
        }
    }

    fn run(params: &Params, inputs: Inputs, _: &Ctx<'_>) -> Result<Validation, StageError> {
        validate(params, &inputs)
    }
}

/// Compares; see [`Hugoniot`].
///
/// # Errors
/// [`StageError::Physics`] where a data file is malformed, or the states have no zero-pressure solid.
pub fn validate(params: &Params, inputs: &Inputs) -> Result<Validation, StageError> {
    let eos = &inputs.eos.eos;
    let v0 = eos.reference_volume();
    let model = |ratio: f64| eos.hugoniot(ratio * v0).ok().map(|s| s.pressure);
    let (states, volumes) = if inputs.states.is_empty() {
        (Vec::new(), (v0, v0, 0.0))
    } else {
        let isochores = Isochores::new(&inputs.states, eos.reference_temperature()).map_err(StageError::physics)?;
        (isochores.hugoniot(), (v0, isochores.reference.volume, isochores.reference.volume_error))
    };
    let text = |file: &File| file.text().map(str::to_string).map_err(StageError::physics);
    let mut measured = marsh(&text(&inputs.marsh)?).map_err(StageError::physics)?;
    measured.extend(database(&text(&inputs.database)?).map_err(StageError::physics)?);
    let compare = |&(set, ratio, pressure): &(u8, f64, f64)| Compared {
        set,
        ratio,
        measured: pressure,
        // Beyond the limit scored the model may be far out of range: nothing is claimed there.
        model: model(ratio).filter(|_| pressure <= params.up_to.si()),
        states: between(&states, ratio, model),
    };
    let points: Vec<Compared> = measured.iter().map(compare).collect();
    let mut scores = Vec::new();
    for up_to in [LOWER, params.up_to.si()] {
        for (of, pick) in [("equation of state", pick_model as fn(&Compared) -> Option<f64>), ("states", pick_states)] {
            for (i, name) in SETS.iter().enumerate() {
                scores.push(Score::of(name, of, &points, Some(i as u8), up_to, pick));
            }
            scores.push(Score::of("all data", of, &points, None, up_to, pick));
        }
    }
    let line = (0..=400)
        .map(|i| 1.0 - 0.001 * f64::from(i))
        .filter_map(|ratio| Some((ratio, model(ratio)?)))
        .take_while(|p| p.1 <= params.up_to.si())
        .collect();
    Ok(Validation {
        curve: "Hugoniot".into(),
        sets: SETS.map(String::from).into(),
        points,
        states,
        line,
        scores,
        volumes,
        notes: notes(),
    })
}

fn pick_model(p: &Compared) -> Option<f64> {
    p.model
}
fn pick_states(p: &Compared) -> Option<f64> {
    p.states
}

fn notes() -> Vec<String> {
    [
        "Pressures are compared at equal V/V0: the experiments' V/V0 = 1 - up/Us, free of the density; the computed V/V0 with the \
         computed zero-pressure volume at 300 K. Measured P = rho0 Us up with the sample's density (compendium) or 8.93 g/cm3 \
         (database).",
        "Points below 5 GPa are not scored.",
        "The Hugoniot of the states is linear between two temperatures of one isochore and phase; between isochores it has the \
         shape of the equation of state's; across melting it is not drawn.",
    ]
    .map(String::from)
    .into()
}

/// V/V0 and P [Pa] of the compendium's shock states; its sound-speed row is left out.
fn marsh(text: &str) -> Result<Vec<(u8, f64, f64)>, CsvError> {
    let csv = Csv::read("marsh", text)?;
    let (us, up, p, method) = (csv.numbers("Us")?, csv.numbers("up")?, csv.numbers("P")?, csv.text("method")?);
    Ok((0..p.len()).filter(|&i| method[i] != "ssp").map(|i| (0, 1.0 - up[i] / us[i], p[i] * 1e9)).collect())
}

/// V/V0 and P [Pa] of the database's shock states without a flag: those not in the compendium, each once.
fn database(text: &str) -> Result<Vec<(u8, f64, f64)>, CsvError> {
    let csv = Csv::read("database", text)?;
    let (us, up, p, flag) = (csv.numbers("Us")?, csv.numbers("up")?, csv.numbers("P_calc")?, csv.text("flag")?);
    Ok((0..p.len()).filter(|&i| flag[i].is_empty()).map(|i| (1, 1.0 - up[i] / us[i], p[i] * 1e9)).collect())
}
