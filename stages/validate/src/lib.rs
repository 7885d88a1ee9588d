//! Equations of state, the states they came from, and impacts, against experiment.
//!
//! `csv.rs` reads reference data, `metal.rs` refuses that of another metal; `states.rs` curves straight from molecular dynamics; `hugoniot.rs` and `isotherm.rs` the two
//! stages of equations of state, `score.rs` what they leave; `taylor.rs` bars on an anvil, `debris.rs` holes and debris clouds.
mod csv;
pub mod debris;
pub mod hugoniot;
pub mod isotherm;
mod metal;
mod score;
mod states;
pub mod taylor;
pub use csv::{Csv, CsvError};
pub use score::{Compared, Score, StatePoint, Validation};
