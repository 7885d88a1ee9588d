//! Stage `md.coexistence`: the melting temperature at a pressure, from crystal and melt in one cell.
//!
//! `search.rs` starts until both phases live; `cell.rs` the cell of both phases; `phase.rs` each phase alone at what was found; `guess.rs` where to begin; `result.rs` what
//! comes out.
//!
//! Two phases side by side at constant pressure and enthalpy: where the cell is too warm some crystal melts and takes up heat,
//! where it is too cold some melt freezes and gives it, until the temperature is that of melting (J. R. Morris, C. Z. Wang, K. M.
//! Ho and C. T. Chan, Phys. Rev. B 49, 3109 (1994); at constant pressure, and the errors of such cells: J. R. Morris and X. Song,
//! J. Chem. Phys. 116, 9352 (2002)). A perfect crystal that is heated overheats by a fifth or more; here there is no barrier.
mod cell;
mod guess;
mod phase;
mod result;
mod search;
mod show;
pub use result::{Attempt, Coexistence, Look, PhaseAt};

use crate::lanes::Isa;
use crate::params::crystal;
use crate::potential::{Named, Potential};
use crate::region;
use crate::system::LEAST_SKIN;
use crate::table::Tables;
use crate::units::{PRESSURE, SPECIFIC_VOLUME, TIME};
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Ctx, File, Invalid, Reach, Stage, StageError};
use schemars::JsonSchema;
use search::Search;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Parameters of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// How atoms act on each other: as in `md`.
    pub potential: Named,
    /// Pressure, -1 to 1000 GPa.
    #[serde(default = "defaults::pressure")]
    pub pressure: Pressure,
    /// Temperature to begin with; by default from Lindemann's rule. A tenth off the truth is near enough; where one phase
    /// dies the stage begins again, warmer or colder.
    #[serde(default)]
    pub guess: Option<Temperature>,
    /// Cubic cells across, along x and y.
    #[serde(default = "defaults::across")]
    pub across: u32,
    /// Cubic cells along z, half of them molten at the start.
    #[serde(default = "defaults::along")]
    pub along: u32,
    /// Time step, 0.1 to 5 fs.
    #[serde(default = "defaults::time_step")]
    pub time_step: Time,
    /// Time that is left out of the average at least.
    #[serde(default = "defaults::settling")]
    pub settling: Time,
    /// Standard error of the melting temperature to stop at.
    #[serde(default = "defaults::target_error")]
    pub target_error: Temperature,
    /// Averaging goes on at least so long after settling.
    #[serde(default = "defaults::shortest")]
    pub shortest: Time,
    /// Averaging goes on no longer than this after settling.
    #[serde(default = "defaults::longest")]
    pub longest: Time,
    /// Time each phase is averaged over alone.
    #[serde(default = "defaults::alone")]
    pub alone: Time,
    /// Seed of the first velocities.
    #[serde(default = "defaults::seed")]
    pub seed: u64,
}

mod defaults {
    use hvi_kit::units::{Pressure, Temperature, Time};
    pub fn pressure() -> Pressure {
        Pressure::new(0.0)
    }
    pub fn across() -> u32 {
        6
    }
    pub fn along() -> u32 {
        16
    }
    pub fn time_step() -> Time {
        Time::new(2e-15)
    }
    pub fn settling() -> Time {
        Time::new(15e-12)
    }
    pub fn target_error() -> Temperature {
        Temperature::new(10.0)
    }
    pub fn shortest() -> Time {
        Time::new(30e-12)
    }
    pub fn longest() -> Time {
        Time::new(150e-12)
    }
    pub fn alone() -> Time {
        Time::new(6e-12)
    }
    pub fn seed() -> u64 {
        1
    }
}

/// The stage.
pub struct TwoPhases;
impl Stage for TwoPhases {
    const NAME: &'static str = "md.coexistence";
    const SUMMARY: &'static str =
        "melting temperature at one pressure, from crystal and melt in one cell (molecular dynamics)";
    type Params = Params;
    type Inputs = crate::Inputs;
    type Output = Coexistence;

    fn check(params: &Params) -> Result<(), Invalid> {
        params.check()
    }
    fn check_files(params: &Params, files: &BTreeMap<String, File>) -> Result<(), Invalid> {
        params.crystal(files).map(drop)
    }
    fn cost(params: &Params) -> f64 {
        params.cost()
    }
    fn is_reached(params: &Params, reach: &Reach) -> Option<bool> {
        Some(region::needs_melting(params, reach))
    }
    fn run(params: &Params, inputs: Self::Inputs, ctx: &Ctx<'_>) -> Result<Coexistence, StageError> {
        run(params, &inputs.file.0, Isa::best(), ctx)
    }
}

impl Params {
    fn check(&self) -> Result<(), Invalid> {
        let within = |key: &str, value: f64, from: f64, to: f64, text: &str| {
            if (from..=to).contains(&value) { Ok(()) } else { Err(Invalid::new(key, text)) }
        };
        within("pressure", self.pressure.si(), -1e9, 1e12, "it must be -1 GPa to 1000 GPa")?;
        if let Some(guess) = self.guess {
            within("guess", guess.si(), 50.0, 2e4, "it must be 50 K to 20000 K")?;
        }
        within("across", f64::from(self.across), 3.0, 64.0, "it must be 3 to 64 cubic cells")?;
        within("along", f64::from(self.along), 8.0, 512.0, "it must be 8 to 512 cubic cells")?;
        within("time_step", self.time_step.si(), 1e-16, 5e-15, "it must be 0.1 fs to 5 fs")?;
        within("settling", self.settling.si(), 0.0, 1e-8, "it must be 0 to 10 ns")?;
        within("target_error", self.target_error.si(), 0.1, 1e3, "it must be 0.1 K to 1000 K")?;
        within("shortest", self.shortest.si(), 5e-12, 1e-7, "it must be 5 ps to 100 ns")?;
        within("longest", self.longest.si(), self.shortest.si(), 1e-7, "it must be from `shortest` to 100 ns")?;
        within("alone", self.alone.si(), 1e-12, 1e-8, "it must be 1 ps to 10 ns")?;
        match &self.potential {
            Named::BuiltIn(_) => self.crystal(&BTreeMap::new()).map(drop),
            Named::File(_) => Ok(()),
        }
    }

    /// The potential, and the cubic edge of its lattice at rest without pressure [angstrom].
    fn crystal(&self, files: &BTreeMap<String, File>) -> Result<(Potential, f64), Invalid> {
        let (potential, ground) = crystal(&self.potential, files)?;
        self.check_width(&potential, ground)?;
        Ok((potential, ground))
    }

    fn check_width(&self, potential: &Potential, ground: f64) -> Result<(), Invalid> {
        let edge = guess::edge(potential, ground, self.pressure.si() / PRESSURE, 300.0);
        // a cold crystal is narrower than a hot one by 2 % or so
        let needed = (2.0 * (potential.cutoff() + LEAST_SKIN) / edge).ceil() as u32;
        if self.across >= needed && self.along >= 2 * needed {
            return Ok(());
        }
        Err(Invalid::new(
            if self.across < needed { "across" } else { "along" },
            format!(
                "at this pressure the potential reaches so far that it takes {needed} cells across and {} along",
                2 * needed
            ),
        ))
    }

    /// Predicted core-seconds.
    fn cost(&self) -> f64 {
        let atoms = f64::from(4 * self.across * self.across * self.along);
        let steps = |time: f64| time / self.time_step.si();
        let cell = atoms * steps(8e-12 + self.settling.si() + 1.3 * self.shortest.si());
        let alone = 1200.0 * steps(7.5e-12 + 2.0 * self.alone.si());
        (cell + alone) * 260e-9
    }
}

/// Runs what `params`, which have been checked, describe.
///
/// # Errors
/// [`StageError::Physics`] where no start keeps both phases, with what to change; as [`crate::run::state`] otherwise.
pub fn run(
    params: &Params,
    files: &BTreeMap<String, File>,
    isa: Isa,
    ctx: &Ctx<'_>,
) -> Result<Coexistence, StageError> {
    let (potential, ground) = params.crystal(files).map_err(|e| StageError::physics(e.why))?;
    let tables = Tables::new(potential.clone());
    let mut search = Search::begin(params, &tables, ground, isa, ctx)?;
    search.find(ctx)?;
    let (temperature, error, averaged) = search.average();
    let [solid, liquid] = search.phases(temperature, ctx)?;
    let molar = potential.molar_mass();
    let (cell, attempts) = search.end();
    Ok(Coexistence {
        pressure: params.pressure.si(),
        temperature,
        temperature_error: error,
        lattice_volume: 0.25 * ground * ground * ground * SPECIFIC_VOLUME / molar,
        molar_mass: molar * 1e-3,
        solid,
        liquid,
        atoms: cell.atoms() as u32,
        averaged: averaged * TIME,
        on_target: error <= params.target_error.si(),
        attempts,
        profile: cell.profile(),
        looks: cell.looks,
    })
}
