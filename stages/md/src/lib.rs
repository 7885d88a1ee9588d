//! Molecular dynamics of a metal: one (V, T) state with its pressure, energy and their errors.
//!
//! `params.rs` what is asked; `run.rs` a run from beginning to end; `pressed.rs` the paper's way to a state; `state.rs` what comes out; `potential/` formulas, one
//! file each; `table.rs` the same as tables; `lattice.rs` the crystal at rest; `lanes/` eight doubles at a time;
//! `neighbor.rs` who is near whom; `force.rs` energy and forces; `system.rs` the atoms and their motion (`system/snapshot.rs` as bytes); `thermostat.rs`
//! the heat bath; `barostat.rs` walls under pressure; `averaging.rs` means and errors; `order.rs` solid or liquid; `void.rs` whole or torn; `lammps.rs` the same by LAMMPS;
//! `sampled.rs` from samples to a state; `region.rs` which states scenes call for; `fault.rs` what can go wrong.
//!
//! Melting: `coexistence.rs` the stage `md.coexistence`, crystal and melt in one cell; `local_order.rs` solid or liquid, atom by
//! atom.
pub mod averaging;
pub mod barostat;
pub mod coexistence;
mod fault;
mod force;
pub mod lammps;
pub mod lanes;
pub mod lattice;
pub mod local_order;
mod neighbor;
pub mod order;
mod params;
pub mod potential;
mod pressed;
mod random;
mod region;
pub mod run;
mod sampled;
mod state;
mod system;
mod table;
mod thermostat;
pub mod units;
pub mod void;
pub use coexistence::{Coexistence, TwoPhases};
pub use fault::Fault;
pub use params::{By, Params};
pub use potential::{Named, Potential};
pub use pressed::Pressed;
pub use state::{Phase, State, isochores};
pub use system::{Snapshot, System};
pub use table::Tables;
pub use thermostat::Chain;

use hvi_kit::engine::Engine;
use hvi_kit::{Ctx, File, Invalid, Needs, Places, Reach, Stage, StageError};
use std::collections::BTreeMap;

hvi_kit::inputs! {
    /// What the stage takes.
    pub struct Inputs {
        /// The potential's file, at `potential.file`, if it is one from a file.
        file: Places<File>,
    }
}

/// The stage `md`: one state of a metal at a volume and a temperature.
pub struct Md;

impl Stage for Md {
    const NAME: &'static str = "md";
    const SUMMARY: &'static str = "pressure and energy of a metal at one volume and temperature, by molecular dynamics with an embedded-atom potential";
    type Params = Params;
    type Inputs = Inputs;
    type Output = State;

    fn check(params: &Params) -> Result<(), Invalid> {
        params.check()
    }

    fn check_files(params: &Params, files: &BTreeMap<String, File>) -> Result<(), Invalid> {
        params.check_files(files)
    }

    fn cost(params: &Params) -> f64 {
        params.cost()
    }

    fn needs(params: &Params) -> Needs {
        params.needs()
    }

    fn is_reached(params: &Params, reach: &Reach) -> Option<bool> {
        Some(region::needs_state(params, reach))
    }

    fn engine(params: &Params) -> Option<&'static Engine> {
        (params.engine == By::Lammps).then_some(&lammps::ENGINE)
    }

    fn run(params: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<State, StageError> {
        match params.engine {
            By::Native => run::state(params, &inputs.file.0, lanes::Isa::best(), ctx),
            By::Lammps => lammps::state(params, &inputs.file.0, ctx),
        }
    }
}
