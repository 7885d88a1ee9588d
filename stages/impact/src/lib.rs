//! Explicit material point method for hypervelocity impact.
pub mod result;
