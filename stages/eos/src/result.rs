//! What the equation-of-state stages pass on.
use crate::Eos;
use hvi_kit::Artifact;
use hvi_kit::view::Scalar;
use serde::{Deserialize, Serialize};

/// An equation of state and where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EosResult {
    /// The equation of state.
    pub eos: Eos,
    /// Where its parameters come from, one sentence.
    pub source: String,
}

impl Artifact for EosResult {
    const KIND: &'static str = "eos/1";
    fn scalars(&self) -> Vec<Scalar> {
        vec![
            Scalar::text("model", self.eos.name()),
            Scalar::number("reference density", 1.0 / self.eos.reference_volume(), "kg/m3"),
        ]
    }
}
