//! The stage `empirical.eta`: eq 35 fitted to one set of runs, checked on another.
use crate::law::{self, Law, Sample};
use crate::point::{Measure, Point};
use hvi_impact::result::Impact;
use hvi_kit::view::{Scalar, View};
use hvi_kit::{Artifact, Ctx, Invalid, Stage, StageError};
use serde::{Deserialize, Serialize};

/// What becomes of runs in which nothing melted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Zeros {
    /// They count like any other: leaving them out would select runs by their outcome, and bend the law upwards.
    #[default]
    Keep,
    /// They are left out of the fit.
    Drop,
}

/// What becomes of runs in which all of the projectile melted (0.999 or more): there the law may go on, the fraction can't.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    /// Draws of the bootstrap; 0: none.
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
    }
}

/// How far a law is from runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Number of runs.
    pub runs: u32,
    /// Root mean square deviation of eta.
    pub rms: f64,
    /// Largest deviation of eta, either way.
    pub worst: f64,
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
    /// The parameters.
    pub law: Law,
    /// Their standard errors, from the covariance.
    pub error: Law,
    /// Range that holds 95 % of the bootstrap, where that could be had.
    pub range: Option<[Law; 2]>,
    /// The runs given to the fit.
    pub points: Vec<Point>,
    /// The runs it was checked on.
    pub check: Vec<Point>,
    /// The law on the fitted runs, on the check runs, and Table 4's law on both.
    pub scores: [Score; 4],
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
        let (mut points, check) = (read(&inputs.runs)?, read(&inputs.check.0)?);
        for point in &mut points {
            let cold = point.eta == 0.0 && p.zeros == Zeros::Drop;
            point.used = !(cold || point.is_full() && p.full == Full::Drop);
        }
        let limited = p.full == Full::Limit;
        let samples =
            |points: &[Point]| points.iter().filter(|p| p.used).map(|p| p.sample(limited)).collect::<Vec<_>>();
        let (fitted, checked) = (samples(&points), samples(&check));
        let fit = law::fit(&fitted).map_err(StageError::physics)?;
        ctx.tick(0.5, 1.0, "bootstrap")?;
        let score = |law: &Law, samples: &[Sample]| Score {
            runs: samples.len() as u32,
            rms: (law::squares(samples, law) / samples.len().max(1) as f64).sqrt(),
            worst: samples.iter().map(|s| s.deviation(law).abs()).fold(0.0, f64::max),
        };
        let of = |law: &Law| [score(law, &fitted), score(law, &checked)];
        let ([own, own_check], [paper, paper_check]) = (of(&fit.law), of(&law::TABLE_4));
        Ok(EtaLaw {
            measure: p.measure,
            zeros: p.zeros,
            full: p.full,
            law: fit.law,
            error: fit.error,
            range: law::bootstrap(&fitted, fit.law, p.bootstrap, p.seed),
            points,
            check,
            scores: [own, own_check, paper, paper_check],
        })
    }
}

impl Artifact for EtaLaw {
    const KIND: &'static str = "eta/1";

    fn scalars(&self) -> Vec<Scalar> {
        let mut all = vec![
            Scalar::number("alpha", self.law.alpha, "s2/km2"),
            Scalar::number("beta", self.law.beta, "s/km"),
            Scalar::number("gamma", self.law.gamma, ""),
            Scalar::number("rms", self.scores[0].rms, ""),
            Scalar::number("worst", self.scores[0].worst, ""),
        ];
        if self.scores[1].runs > 0 {
            all.push(Scalar::number("rms on check runs", self.scores[1].rms, ""));
            all.push(Scalar::number("worst on check runs", self.scores[1].worst, ""));
        }
        all
    }

    fn views(&self) -> Vec<View> {
        crate::show::views(self)
    }
}

#[cfg(test)]
mod tests;
