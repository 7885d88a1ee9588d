//! Stages `eos.table` and `eos.sesame`: tables in place of a fitted equation of state.
use crate::fit::{Reference, one_potential};
use crate::model::sesame;
use crate::model::tabulated::{Isochore, Node, Parameters};
use crate::{Eos, EosResult, Tabulated};
use hvi_kit::units::Temperature;
use hvi_kit::{Ctx, File, Invalid, Stage, StageError, inputs};
use hvi_md::{Phase, State, isochores};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of both stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Temperature of the reference state, which lies at zero pressure.
    pub reference_temperature: Temperature,
}
impl Default for Params {
    fn default() -> Params {
        Params { reference_temperature: Temperature::new(300.0) }
    }
}
impl Params {
    fn check(&self) -> Result<(), Invalid> {
        match self.reference_temperature.si() > 0.0 {
            true => Ok(()),
            false => Err(Invalid::new("reference_temperature", "must be above 0 K")),
        }
    }
}

inputs! {
    /// Inputs of `eos.table`.
    pub struct States {
        /// States of one metal on isochores, solid and, where it melts, liquid.
        states: Vec<State>,
    }
}

/// The stage `eos.table`.
pub struct Table;
impl Stage for Table {
    const NAME: &'static str = "eos.table";
    const SUMMARY: &'static str =
        "equation of state that interpolates the states of molecular dynamics, phase by phase";
    type Params = Params;
    type Inputs = States;
    type Output = EosResult;

    fn check(params: &Params) -> Result<(), Invalid> {
        params.check()
    }
    fn run(params: &Params, inputs: States, _: &Ctx<'_>) -> Result<EosResult, StageError> {
        let eos = tabulate(&inputs.states, params.reference_temperature.si())?;
        let torn = inputs.states.iter().filter(|s| s.is_torn()).count();
        let left_out = if torn > 0 { format!(", {torn} torn ones left out") } else { String::new() };
        let source = format!("table of {} states of molecular dynamics{left_out}", inputs.states.len() - torn);
        Ok(EosResult { eos: Eos::Table(eos), source, fit: None })
    }
}

/// The table of `states`, its energies counted from the zero-pressure solid at `reference_temperature` [K].
///
/// Isochores on which a phase has a single state do not know that phase's heat: the state is left out, and so are torn ones.
///
/// # Errors
/// [`StageError::Physics`] where the states have no zero-pressure solid, or make no table.
pub fn tabulate(states: &[State], reference_temperature: f64) -> Result<Tabulated, StageError> {
    one_potential(states).map_err(StageError::physics)?;
    let reference = Reference::find(states, reference_temperature).map_err(StageError::physics)?;
    let all = isochores(states);
    let node = |s: &&State| Node {
        temperature: s.temperature,
        energy: s.energy - reference.energy,
        pressure: s.pressure,
        errors: [s.energy_error, s.pressure_error],
    };
    let sheet = |phase: Phase| -> Vec<Isochore> {
        let of = |same: &Vec<&State>| Isochore {
            volume: same[0].volume,
            nodes: same.iter().filter(|s| s.phase == phase).map(node).collect(),
        };
        all.iter().map(of).filter(|i| i.nodes.len() >= 2).collect()
    };
    let (solid, liquid) = (sheet(Phase::Solid), sheet(Phase::Liquid));
    let liquid = if liquid.len() >= 2 { liquid } else { Vec::new() };
    let parameters = Parameters { reference_volume: reference.volume, reference_temperature, solid, liquid };
    Tabulated::new(parameters).map_err(StageError::physics)
}

inputs! {
    /// Inputs of `eos.sesame`.
    pub struct Grid {
        /// Pressure and energy on a grid of density and temperature, as text: see [`crate::model::sesame`].
        table: File,
    }
}

/// The stage `eos.sesame`.
pub struct Sesame;
impl Stage for Sesame {
    const NAME: &'static str = "eos.sesame";
    const SUMMARY: &'static str = "equation of state from a table of pressure and energy over density and temperature";
    type Params = Params;
    type Inputs = Grid;
    type Output = EosResult;

    fn check(params: &Params) -> Result<(), Invalid> {
        params.check()
    }
    fn run(params: &Params, inputs: Grid, _: &Ctx<'_>) -> Result<EosResult, StageError> {
        let text = inputs.table.text().map_err(StageError::physics)?;
        let table = sesame::read(text, params.reference_temperature.si()).map_err(StageError::physics)?;
        let eos = Eos::Table(Tabulated::new(table).map_err(StageError::physics)?);
        Ok(EosResult { eos, source: "table like SESAME's 301".into(), fit: None })
    }
}
