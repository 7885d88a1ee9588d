//! What accuracy costs: quantities of results, how far each is from where they lead, and which settings are worth their cost.
//!
//! `measure.rs` the quantities of a state and of an impact, `shock.rs` the planar impact's closed form; `limit.rs` observed orders
//! and extrapolation; `front.rs` which settings no other beats; `time.rs` predicted and taken times; `check.rs` choices held
//! against other runs; `spread.rs` what uncertain inputs do; `study.rs` all of it for a set of runs, `show.rs` how it looks.
//! A library, no stage: costs are the program's to know, they are no part of a result.
mod check;
mod front;
mod limit;
mod measure;
mod shock;
mod show;
mod spread;
mod study;
mod time;
pub use check::{Check, check};
pub use front::{Chosen, MARGIN, cheapest, front, knee, most_accurate};
pub use limit::{How, Limit, Order, limit, order};
pub use measure::{Measure, Measures, Unknown, names, of_fit, of_impact, of_kind, of_state, of_survey};
pub use shock::planar;
pub use show::{TARGETS, checked, choices, views};
pub use spread::{Spread, spread_figure, spread_runs, spread_table, spreads};
pub use study::{Quantity, Row, Sample, study};
pub use time::{Pace, median, pace};
