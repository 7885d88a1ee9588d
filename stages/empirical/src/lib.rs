//! Empirical laws fitted to impact runs: the melted fraction of the projectile, eq 35 of the paper.
//!
//! `point.rs` run -> melted fraction; `law.rs` the law and its fit; `spread.rs` its uncertainty; `score.rs` how well it holds, and
//! where that can be checked; `refined.rs` two resolutions and the extrapolation; `eta.rs` the stage; `show.rs` what it shows.
mod eta;
mod law;
mod point;
mod refined;
mod score;
mod show;
mod spread;
pub use eta::{Eta, EtaLaw, Full, Inputs, Params, Zeros};
pub use law::{Fit, Law, Sample, TABLE_4, Unfit, fit};
pub use point::{Measure, Point};
pub use refined::{Limit, Pair, Refined};
pub use score::{Score, Scores, Standing};
pub use spread::{Spread, bootstrap};
