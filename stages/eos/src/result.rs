//! What the equation-of-state stages pass on.
use crate::Eos;
use crate::fit::FitReport;
use hvi_kit::Artifact;
use hvi_kit::view::{Scalar, View};
use serde::{Deserialize, Serialize};

/// An equation of state and where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EosResult {
    /// The equation of state.
    pub eos: Eos,
    /// Where its parameters come from, one sentence.
    pub source: String,
    /// The fit, where it was fitted.
    pub fit: Option<FitReport>,
}

impl Artifact for EosResult {
    const KIND: &'static str = "eos/1";

    fn scalars(&self) -> Vec<Scalar> {
        let mut scalars = vec![
            Scalar::text("model", self.eos.name()),
            Scalar::number("reference density", 1.0 / self.eos.reference_volume(), "kg/m3"),
        ];
        if let Some(fit) = &self.fit {
            let named = |p: &crate::fit::FittedParameter| Scalar::number(&p.symbol, p.value, &p.unit);
            scalars.extend(fit.parameters.iter().skip(1).map(named));
            scalars.push(Scalar::number("rms pressure misfit", fit.pressure_misfit().0 / 1e9, "GPa"));
            scalars.push(Scalar::number("rms temperature misfit", fit.temperature_misfit().0, "K"));
        }
        scalars
    }

    fn views(&self) -> Vec<View> {
        crate::show::views(self)
    }
}
