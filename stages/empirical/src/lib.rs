//! Empirical laws fitted to impact runs: the melted fraction of the projectile, eq 35 of the paper.
//!
//! `point.rs` run -> melted fraction; `law.rs` the law, its fit and its uncertainty; `eta.rs` the stage; `show.rs` tables and
//! figures.
mod eta;
mod law;
mod point;
mod show;
pub use eta::{Eta, EtaLaw, Full, Inputs, Params, Zeros};
pub use law::{Fit, Law, Sample, TABLE_4, Unfit, bootstrap, fit};
pub use point::{Measure, Point};
