//! The stage `empirical.eta`: eq 35 fitted to one set of runs, checked on another, and extrapolated to a vanishing cell by a finer
//! third.
use crate::law::{self, Fit, Law, Sample};
use crate::point::{Measure, Point};
use crate::refined::{self, Refined};
use crate::score::{Score, Scores};
use crate::spread::{self, Spread};
use hvi_impact::result::Impact;
use hvi_kit::view::{Cell, Scalar, View};
use hvi_kit::{Artifact, Ctx, Invalid, Stage, StageError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What becomes of runs in which nothing melted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Zeros {
    /// They count like any other: leaving them out would select runs by their outcome, and bend the law upwards.
    #[default]
    Keep,
    /// They are left out of the fit.
    Drop,
}

/// What becomes of runs in which all of the projectile melted (0.999 or more): there the law may go on, the fraction can't.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Full {
    /// A law above the run's fraction counts as exact, one below it as wrong.
    #[default]
    Limit,
    /// They count like any other.
    Keep,
    /// They are left out of the fit.
    Drop,
}

/// How to fit eq 35.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// What counts as melted.
    #[serde(default)]
    pub measure: Measure,
    /// Runs with nothing melted.
    #[serde(default)]
    pub zeros: Zeros,
    /// Runs with all melted.
    #[serde(default)]
    pub full: Full,
    /// Draws of the bootstrap of whole D/t families; 0: none.
    #[serde(default = "default_draws")]
    pub bootstrap: u32,
    /// Seed of the draws.
    #[serde(default = "default_seed")]
    pub seed: u64,
}

fn default_draws() -> u32 {
    400
}

fn default_seed() -> u64 {
    1
}

hvi_kit::inputs! {
    /// What the fit takes.
    pub struct Inputs {
        /// Runs to fit.
        runs: Vec<Impact>,
        /// Runs to check the law on, not fitted; may be none.
        check: hvi_kit::Any<Impact>,
        /// Some of `runs` again with smaller cells, to extrapolate the melted fraction to a vanishing cell; may be none.
        finer: hvi_kit::Any<Impact>,
    }
}

/// The fitted law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EtaLaw {
    /// What counts as melted.
    pub measure: Measure,
    /// How runs with nothing melted entered.
    pub zeros: Zeros,
    /// How runs with all melted entered.
    pub full: Full,
    /// The law, with errors from the covariance, which takes the runs for independent.
    pub fit: Fit,
    /// Its spread over whole families of D/t, where that could be had: the errors to go by.
    pub spread: Option<Spread>,
    /// The runs given to the fit.
    pub points: Vec<Point>,
    /// The runs it was checked on.
    pub check: Vec<Point>,
    /// The extrapolation to a vanishing cell, where finer runs were given.
    pub refined: Option<Refined>,
    /// The law on the fitted runs as the fit counts them: by the treatment of runs in which all has melted.
    pub counted: Score,
    /// The law on all runs, raw.
    pub own: Scores,
    /// Table 4's law on the same, raw.
    pub paper: Scores,
}

/// The stage `empirical.eta`.
pub struct Eta;

impl Stage for Eta {
    const NAME: &'static str = "empirical.eta";
    const SUMMARY: &'static str = "melted fraction of the projectile as a law of speed and D/t (eq 35), by Levenberg-Marquardt, checked on other runs";
    type Params = Params;
    type Inputs = Inputs;
    type Output = EtaLaw;

    fn check(p: &Params) -> Result<(), Invalid> {
        match p.bootstrap {
            0 | 50..=100_000 => Ok(()),
            n => Err(Invalid::new("bootstrap", format!("{n} draws; 0 for none, or 50 to 100000"))),
        }
    }

    fn cost(p: &Params) -> f64 {
        0.5 + 1e-4 * f64::from(p.bootstrap)
    }

    fn run(p: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<EtaLaw, StageError> {
        let read = |runs: &[Impact]| runs.iter().map(|r| Point::new(r, p.measure)).collect::<Result<Vec<_>, _>>();
        let (mut points, check, finer) = (read(&inputs.runs)?, read(&inputs.check.0)?, read(&inputs.finer.0)?);
        for point in &mut points {
            let cold = point.eta == 0.0 && p.zeros == Zeros::Drop;
            point.used = !(cold || point.is_full() && p.full == Full::Drop);
        }
        let used = points.iter().filter(|p| p.used);
        let samples: Vec<Sample> = used.map(|point| point.sample(p.full == Full::Limit)).collect();
        let pairs = refined::pairs(&points, &finer)?;
        let fit = law::fit(&samples).map_err(StageError::physics)?;
        ctx.tick(0.5, 1.0, "bootstrap")?;
        Ok(EtaLaw {
            measure: p.measure,
            zeros: p.zeros,
            full: p.full,
            fit,
            spread: spread::bootstrap(&samples, p.bootstrap, p.seed),
            refined: (!pairs.is_empty()).then(|| refined::refined(pairs, p)),
            counted: Score::of(samples.iter().map(|s| s.deviation(&fit.law))),
            own: Scores::new(&fit.law, &points, &check),
            paper: Scores::new(&law::TABLE_4, &points, &check),
            points,
            check,
        })
    }
}

impl EtaLaw {
    /// The errors to go by: over families of D/t where there are enough, or else from the covariance.
    pub fn error(&self) -> Law {
        self.spread.map_or(self.fit.error, |s| s.error)
    }
}

impl Artifact for EtaLaw {
    const KIND: &'static str = "eta/3";

    fn scalars(&self) -> Vec<Scalar> {
        let error = self.error().values();
        let parameter = |name: &str, i: usize, unit: &str| Scalar {
            value: Cell::Uncertain(self.fit.law.values()[i], error[i]),
            ..Scalar::number(name, 0.0, unit)
        };
        let mut all = vec![parameter("alpha", 0, "s2/km2"), parameter("beta", 1, "s/km"), parameter("gamma", 2, "")];
        all.push(Scalar::number("rms", self.own.fitted.rms, ""));
        all.push(Scalar::number("worst", self.own.fitted.worst, ""));
        if self.own.new.runs > 0 {
            all.push(Scalar::number("rms on new check runs", self.own.new.rms, ""));
            all.push(Scalar::number("worst on new check runs", self.own.new.worst, ""));
        }
        all
    }

    fn views(&self) -> Vec<View> {
        crate::show::views(self)
    }
}

#[cfg(test)]
mod tests;
