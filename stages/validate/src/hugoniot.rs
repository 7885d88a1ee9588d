//! Stage `validate.hugoniot`: the principal Hugoniot against shock experiments.
use crate::score::{ALL, Compared, Score, Validation, judged};
use crate::states::{Isochores, between};
use crate::{Csv, CsvError, metal};
use hvi_eos::EosResult;
use hvi_kit::units::{Dimension, Pressure};
use hvi_kit::{Any, Ctx, File, Invalid, Stage, StageError, inputs};
use hvi_md::State;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
        states: Any<State>,
        /// Copper's shock states of the LASL compendium: columns `Us`, `up` [km/s], `P` [GPa], `method`.
        marsh: Any<File>,
        /// Copper's shock states of the shock wave database: columns `up`, `Us` [km/s], `P_calc` [GPa], `flag`.
        database: Any<File>,
        /// Shock states of any metal: columns `set`, `V_over_V0`, `P` [GPa]; a line `# rho0: 2.7 g/cm3` says of which.
        shots: Any<File>,
    }
}

/// The sets of copper's data.
const SETS: [&str; 2] = ["LASL compendium (Marsh 1980)", "shock wave database (unflagged)"];
/// Density that copper's data count with [kg/m3].
const COPPER: f64 = 8930.0;
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
/// [`StageError::Physics`] where a data file is malformed, has no points to score or is of another metal, or the states have no
/// zero-pressure solid or are of another metal.
pub fn validate(params: &Params, inputs: &Inputs) -> Result<Validation, StageError> {
    let eos = &inputs.eos.eos;
    let v0 = eos.reference_volume();
    let shock = |ratio: f64| eos.hugoniot(ratio * v0).ok();
    let model = |ratio: f64| shock(ratio).filter(|s| eos.covers(s.volume, s.temperature)).map(|s| s.pressure);
    let isochores = Isochores::beside(eos, &inputs.states.0).map_err(StageError::physics)?;
    let states = isochores.as_ref().map_or(Vec::new(), Isochores::hugoniot);
    let Measured { sets, shots: measured, compendium, checked } = measured(inputs, 1.0 / v0)?;
    let compare = |&(set, ratio, pressure): &Shot| Compared {
        set,
        ratio,
        measured: pressure,
        // Beyond the limit scored the model may be far out of range: nothing is claimed there.
        model: model(ratio).filter(|_| pressure <= params.up_to.si()),
        states: between(&states, ratio, model),
    };
    let points: Vec<Compared> = measured.iter().map(compare).collect();
    let mut scores = Vec::new();
    let smooth: Vec<Compared> = line_through(&compendium).iter().map(compare).collect();
    let up_to = params.up_to.si();
    for up_to in if up_to > LOWER { vec![LOWER, up_to] } else { vec![up_to] } {
        for (of, pick) in [("equation of state", pick_model as fn(&Compared) -> Option<f64>), ("states", pick_states)] {
            for (i, name) in sets.iter().enumerate() {
                scores.push(Score::of(name, of, &points, Some(i as u32), up_to, pick));
            }
            scores.push(Score::of(ALL, of, &points, None, up_to, pick));
            if !smooth.is_empty() {
                scores.push(Score::of("line through the compendium", of, &smooth, None, up_to, pick));
            }
        }
    }
    judged(&scores, params.up_to.si()).map_err(StageError::physics)?;
    let line = (0..=400)
        .map(|i| 1.0 - 0.001 * f64::from(i))
        .filter_map(|ratio| Some((ratio, model(ratio)?)))
        .take_while(|p| p.1 <= params.up_to.si())
        .collect();
    Ok(Validation {
        curve: "Hugoniot".into(),
        sets,
        points,
        states,
        line,
        scores,
        volumes: isochores.as_ref().map_or((v0, v0, 0.0), |i| (v0, i.reference.volume, i.reference.volume_error)),
        notes: notes(!compendium.is_empty(), checked).into_iter().chain(isochores.and_then(|i| i.note())).collect(),
    })
}

/// A set's index, V/V0 and P [Pa].
type Shot = (u32, f64, f64);

/// What was measured.
struct Measured {
    sets: Vec<String>,
    shots: Vec<Shot>,
    /// Those of the compendium.
    compendium: Vec<Shot>,
    /// Whether all data say of which density they are.
    checked: bool,
}

/// Reads what was measured, and refuses that of a metal whose density is not `density` [kg/m3].
fn measured(inputs: &Inputs, density: f64) -> Result<Measured, StageError> {
    let (mut sets, mut measured, mut compendium, mut checked) = (Vec::new(), Vec::new(), Vec::new(), true);
    let text = |file: &File| file.text().map(str::to_string).map_err(StageError::physics);
    let numbered = |shots: Vec<Shot>, set: usize| shots.into_iter().map(move |(_, v, p)| (set as u32, v, p));
    if !(inputs.marsh.0.is_empty() && inputs.database.0.is_empty()) {
        metal::check(density, "the data of `marsh` and `database` are", COPPER).map_err(StageError::physics)?;
    }
    for file in &inputs.marsh.0 {
        compendium = numbered(marsh(&text(file)?).map_err(StageError::physics)?, sets.len()).collect();
        measured.extend(compendium.clone());
        sets.push(SETS[0].to_string());
    }
    for file in &inputs.database.0 {
        measured.extend(numbered(database(&text(file)?).map_err(StageError::physics)?, sets.len()));
        sets.push(SETS[1].to_string());
    }
    for file in &inputs.shots.0 {
        let text = text(file)?;
        let (own, shots) = named(&text).map_err(StageError::physics)?;
        match own {
            Some(own) => metal::check(density, "the data of `shots` are", own).map_err(StageError::physics)?,
            None => checked = false,
        }
        for (set, ratio, pressure) in shots {
            let known = sets.iter().position(|s| *s == set).unwrap_or(sets.len());
            if known == sets.len() {
                sets.push(set);
            }
            measured.push((known as u32, ratio, pressure));
        }
    }
    if sets.is_empty() {
        return Err(StageError::physics(
            "no shock data: name a file at `shots`, or copper's at `marsh` and `database`",
        ));
    }
    Ok(Measured { sets, shots: measured, compendium, checked })
}

fn pick_model(p: &Compared) -> Option<f64> {
    p.model
}
fn pick_states(p: &Compared) -> Option<f64> {
    p.states
}

fn notes(compendium: bool, checked: bool) -> Vec<String> {
    let copper = [
        "Copper: measured P = rho0 Us up with the sample's density (compendium) or 8.93 g/cm3 (database).",
        "At equal V/V0 the scatter of the experiments counts fourfold (1 % of Us is 4 % of P at 150 GPa); the least-squares line \
         Us = c + s up through the compendium's states, at 8.93 g/cm3, has none: the deviation from it is the computed curve's own.",
    ];
    let all = [
        "Pressures are compared at equal V/V0: the experiments' V/V0 = 1 - up/Us, free of the density; the computed V/V0 with the \
         computed zero-pressure volume at 300 K.",
        "Points below 5 GPa are not scored. The largest deviation of a set is often a single experiment far off all others: the \
         mean and the rms are the curve's.",
        "The Hugoniot of the states is linear between two temperatures of one isochore and phase; between isochores it has the \
         shape of the equation of state's; across melting it is not drawn.",
    ];
    let unchecked = (!checked).then_some(metal::UNCHECKED);
    all.into_iter().chain(copper.into_iter().filter(|_| compendium)).chain(unchecked).map(String::from).collect()
}

/// The least-squares line Us = c + s up through shock states, as points every 0.005 of V/V0 over the states' range.
///
/// From V/V0 and P alone: `up^2 = P V0 x` and `Us^2 = P V0 / x` with x = 1 - V/V0 and V0 of 8.93 g/cm3.
fn line_through(states: &[Shot]) -> Vec<Shot> {
    let v0 = 1.0 / COPPER;
    let velocities = states.iter().map(|&(_, ratio, p)| {
        let x = 1.0 - ratio;
        ((p * v0 * x).sqrt(), (p * v0 / x).sqrt())
    });
    let n = states.len() as f64;
    let (mut up, mut us) = (0.0, 0.0);
    for (u, s) in velocities.clone() {
        up += u / n;
        us += s / n;
    }
    let (mut square, mut product) = (0.0, 0.0);
    for (u, s) in velocities {
        square += (u - up) * (u - up);
        product += (u - up) * (s - us);
    }
    let slope = product / square;
    let c = us - slope * up;
    let densest = states.iter().map(|s| s.1).fold(1.0, f64::min);
    (1..)
        .map(|i| 0.005 * f64::from(i))
        .take_while(|&x| 1.0 - x >= densest)
        .map(|x| (0, 1.0 - x, c * c * x / (v0 * (1.0 - slope * x) * (1.0 - slope * x))))
        .collect()
}

/// V/V0 and P [Pa] of the compendium's shock states; its sound-speed row is left out.
fn marsh(text: &str) -> Result<Vec<Shot>, CsvError> {
    let csv = Csv::read("marsh", text)?;
    let (us, up, p, method) = (csv.numbers("Us")?, csv.numbers("up")?, csv.numbers("P")?, csv.text("method")?);
    let points = (0..p.len()).filter(|&i| method[i] != "ssp").map(|i| (0, 1.0 - up[i] / us[i], p[i] * 1e9)).collect();
    csv.any(points, "Us, up [km/s], P [GPa] and a method other than ssp")
}

/// V/V0 and P [Pa] of the database's shock states without a flag: those not in the compendium, each once.
fn database(text: &str) -> Result<Vec<Shot>, CsvError> {
    let csv = Csv::read("database", text)?;
    let (us, up, p, flag) = (csv.numbers("Us")?, csv.numbers("up")?, csv.numbers("P_calc")?, csv.text("flag")?);
    let points = (0..p.len()).filter(|&i| flag[i].is_empty()).map(|i| (1, 1.0 - up[i] / us[i], p[i] * 1e9)).collect();
    csv.any(points, "up, Us [km/s], P_calc [GPa] and an empty flag")
}

/// Set, V/V0 and P [Pa] of a shock state.
type NamedShot = (String, f64, f64);

/// A metal's density [kg/m3], where it is said, and its shock states.
fn named(text: &str) -> Result<(Option<f64>, Vec<NamedShot>), CsvError> {
    let csv = Csv::read("shots", text)?;
    let density = csv.quantity("rho0", Dimension::Density)?;
    let (set, ratio, p) = (csv.text("set")?, csv.numbers("V_over_V0")?, csv.numbers("P")?);
    let points = (0..p.len()).map(|i| (set[i].to_string(), ratio[i], p[i] * 1e9)).collect();
    Ok((density, csv.any(points, "set, V_over_V0 and P [GPa]")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The file's own header: a least-squares line through the 144 states has Us = 3.911 + 1.508 up km/s.
    #[test]
    fn the_line_is_the_files_own() {
        let text = include_str!("../../../pipelines/data/cu_hugoniot_marsh1980.csv");
        for (_, ratio, p) in line_through(&marsh(text).unwrap()) {
            let x = 1.0 - ratio;
            let us = 3911.0 / (1.0 - 1.508 * x);
            let expected = 8930.0 * us * us * x;
            // Samples of 8.89 to 8.93 g/cm3 counted as 8.93, and three digits of c and s.
            assert!((p / expected - 1.0).abs() < 3e-3, "{ratio} {p} {expected}");
        }
    }
}
