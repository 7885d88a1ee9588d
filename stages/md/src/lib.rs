//! Molecular dynamics of a metal: one (V, T) state with its pressure, energy and their errors.
//!
//! `params.rs` what is asked; `state.rs` what comes out; `potential/` formulas, one file each; `table.rs` the same as
//! tables; `lattice.rs` the crystal at rest; `lanes/` eight doubles at a time; `neighbor.rs` who is near whom;
//! `force.rs` energy and forces; `system.rs` the atoms and their motion; `thermostat.rs` the heat bath.
mod fault;
mod force;
pub mod lanes;
pub mod lattice;
mod neighbor;
pub mod potential;
mod random;
mod state;
mod system;
mod table;
mod thermostat;
pub mod units;
pub use fault::Fault;
pub use potential::Potential;
pub use state::{Phase, State};
pub use system::System;
pub use table::Tables;
pub use thermostat::Chain;
