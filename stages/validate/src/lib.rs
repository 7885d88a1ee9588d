//! An equation of state and the states it came from, against experiment.
//!
//! `csv.rs` reads reference data; `states.rs` curves straight from molecular dynamics; `hugoniot.rs` and `isotherm.rs` the two
//! stages; `score.rs` what they leave.
mod csv;
pub mod hugoniot;
pub mod isotherm;
mod score;
mod states;
pub use csv::{Csv, CsvError};
pub use score::{Compared, Score, StatePoint, Validation};
