//! The paper's published results beside computed ones, twice: by its own choices, and by the best known; with verdicts.
//!
//! `published.rs` reads what was published; `measured.rs` takes the same quantities out of results; `verdict.rs` compares;
//! `why.rs` says what makes the difference; `stage.rs` the stage `reproduction`; `show.rs` what a person sees.
mod measured;
mod published;
mod show;
mod stage;
mod verdict;
mod why;
pub use stage::{Inputs, Params, Reproduction};
pub use verdict::{Found, Reproduced, Row, Verdict};
