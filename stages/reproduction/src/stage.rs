//! Stage `reproduction`.
use crate::measured::Column;
use crate::verdict::{self, Verdict};
use hvi_empirical::EtaLaw;
use hvi_eos::EosResult;
use hvi_impact::result::Impact;
use hvi_kit::view::{Scalar, View};
use hvi_kit::{Any, Artifact, Ctx, File, Stage, StageError};
use hvi_validate::Validation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// It has no parameters of its own: all are inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

hvi_kit::inputs! {
    /// Inputs of the stage; what is left out is shown as not computed.
    pub struct Inputs {
        /// What was published: columns `result`, `id`, `quantity`, `unit`, `relation`, `value`, `within` [%], `source`.
        published: File,
        /// Copper by the paper's choices.
        paper_copper: Any<EosResult>,
        /// Copper of the paper's impacts.
        paper_impacted: Any<EosResult>,
        /// Its Hugoniot.
        paper_hugoniot: Any<Validation>,
        /// Its isotherm.
        paper_isotherm: Any<Validation>,
        /// Aluminium sphere on copper plate, by the paper's choices.
        paper_sphere: Any<Impact>,
        /// Copper cylinder on aluminium plate, by the paper's choices.
        paper_cylinder: Any<Impact>,
        /// Law of the melted fraction, by the paper's choices.
        paper_eta: Any<EtaLaw>,
        /// Copper by the best known.
        best_copper: Any<EosResult>,
        /// Its Hugoniot.
        best_hugoniot: Any<Validation>,
        /// Its isotherm.
        best_isotherm: Any<Validation>,
        /// Aluminium sphere on copper plate, by the best known.
        best_sphere: Any<Impact>,
        /// Copper cylinder on aluminium plate, by the best known.
        best_cylinder: Any<Impact>,
        /// Law of the melted fraction, by the best known.
        best_eta: Any<EtaLaw>,
    }
}

/// The stage.
pub struct Reproduction;
impl Stage for Reproduction {
    const NAME: &'static str = "reproduction";
    const SUMMARY: &'static str =
        "a paper's published results beside computed ones, by its own choices and by the best known, with verdicts";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Verdict;

    fn run(_: &Params, inputs: Inputs, _: &Ctx<'_>) -> Result<Verdict, StageError> {
        let text = inputs.published.text().map_err(StageError::physics)?;
        let published = crate::published::read(text).map_err(StageError::physics)?;
        let paper = Column {
            copper: inputs.paper_copper.0.first(),
            impacted: inputs.paper_impacted.0.first(),
            hugoniot: inputs.paper_hugoniot.0.first(),
            isotherm: inputs.paper_isotherm.0.first(),
            sphere: inputs.paper_sphere.0.first(),
            cylinder: inputs.paper_cylinder.0.first(),
            eta: inputs.paper_eta.0.first(),
        };
        let best = Column {
            copper: inputs.best_copper.0.first(),
            impacted: None,
            hugoniot: inputs.best_hugoniot.0.first(),
            isotherm: inputs.best_isotherm.0.first(),
            sphere: inputs.best_sphere.0.first(),
            cylinder: inputs.best_cylinder.0.first(),
            eta: inputs.best_eta.0.first(),
        };
        verdict::judge(&published, &[paper, best]).map_err(StageError::physics)
    }
}

impl Artifact for Verdict {
    const KIND: &'static str = "verdict/1";
    fn scalars(&self) -> Vec<Scalar> {
        crate::show::scalars(self)
    }
    fn views(&self) -> Vec<View> {
        crate::show::views(self)
    }
}
