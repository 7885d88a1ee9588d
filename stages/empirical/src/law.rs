//! Eq 35, `eta = (alpha v^2 + beta v) (D/t)^gamma`, and its fit.
use hvi_kit::math;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DVector, Dyn, Matrix3, OMatrix, U3, Vector3, storage::Owned};
use serde::{Deserialize, Serialize};

/// Parameters of eq 35, or anything that comes one to each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Law {
    /// alpha [s2/km2].
    pub alpha: f64,
    /// beta [s/km].
    pub beta: f64,
    /// gamma [1].
    pub gamma: f64,
}

/// Table 4 of the paper, for comparison only: nothing is fitted or started from it.
pub const TABLE_4: Law = Law { alpha: 6.480e-3, beta: -7.515e-3, gamma: -0.6963 };

impl Law {
    /// Melted fraction at the impact speed `v` [km/s] and the diameter over the thickness `ratio > 0`; not limited to 0..1.
    pub fn at(&self, v: f64, ratio: f64) -> f64 {
        (self.alpha * v + self.beta) * v * math::pow(ratio, self.gamma)
    }

    /// The lowest speed [km/s] at which the law reaches 1 at the diameter over the thickness `ratio > 0`, where it does.
    pub fn full_from(&self, ratio: f64) -> Option<f64> {
        let c = math::pow(ratio, -self.gamma);
        let root = (self.beta * self.beta + 4.0 * self.alpha * c).sqrt();
        // The form of the quadratic's root that survives alpha = 0; a negative discriminant leaves a NaN, which is no speed.
        Some(2.0 * c / (self.beta + root)).filter(|v| v.is_finite() && *v > 0.0)
    }

    /// alpha, beta, gamma.
    pub fn values(&self) -> [f64; 3] {
        [self.alpha, self.beta, self.gamma]
    }

    /// One number made for each parameter.
    pub fn each(of: impl Fn(usize) -> f64) -> Law {
        Law { alpha: of(0), beta: of(1), gamma: of(2) }
    }

    fn from(p: &Vector3<f64>) -> Law {
        Law::each(|i| p[i])
    }
}

/// One simulated value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Impact speed [km/s].
    pub v: f64,
    /// Diameter over thickness.
    pub ratio: f64,
    /// Melted fraction.
    pub eta: f64,
    /// A law at or above `eta` counts as exact here: the run has melted as much as there is.
    pub at_limit: bool,
}

impl Sample {
    /// What `law` says less what was simulated.
    pub fn deviation(&self, law: &Law) -> f64 {
        let d = law.at(self.v, self.ratio) - self.eta;
        if self.at_limit { d.min(0.0) } else { d }
    }
}

/// Why a set of samples can't determine the law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum Unfit {
    #[error("{0} runs with a melted fraction above 0; the law's three parameters need 4 or more. Add faster runs")]
    TooFew(usize),
    #[error("all runs have the same impact speed, {0} km/s: alpha and beta can't be told apart. Sweep the velocity")]
    OneSpeed(f64),
    #[error("all runs have the same D/t, {0}: gamma can't be found. Sweep the diameter or the thickness")]
    OneRatio(f64),
    #[error(
        "the fit of eq 35 did not converge ({0}). Look at the runs' melted fractions: they may not follow such a law"
    )]
    NotConverged(String),
}

/// A fitted law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The parameters.
    pub law: Law,
    /// Their standard errors: square roots of the diagonal of s^2 (J'J)^-1, with s^2 the residual variance.
    pub error: Law,
}

/// Fits eq 35 by least squares on eta, unweighted.
///
/// Starts from the best of 25 values of gamma from -3 to 3, at each of which alpha and beta follow from a linear fit; so no start
/// value has to be guessed, and none comes from the paper.
///
/// # Errors
/// [`Unfit`] where the samples can't determine three parameters.
pub fn fit(samples: &[Sample]) -> Result<Fit, Unfit> {
    determined(samples)?;
    let start = (0..25).map(|k| linear(samples, -3.0 + 0.25 * f64::from(k)));
    let start = start.min_by(|a, b| squares(samples, a).total_cmp(&squares(samples, b))).expect("25 candidates");
    refine(samples, start)
}

/// Levenberg-Marquardt from `start`.
///
/// # Errors
/// [`Unfit::NotConverged`].
pub fn refine(samples: &[Sample], start: Law) -> Result<Fit, Unfit> {
    let problem = Problem { samples, p: Vector3::from(start.values()) };
    let (found, report) = LevenbergMarquardt::new().with_tol(1e-13).with_patience(200).minimize(problem);
    let law = Law::from(&found.p);
    if !report.termination.was_successful() || law.values().iter().any(|x| !x.is_finite()) {
        return Err(Unfit::NotConverged(format!("{:?}", report.termination)));
    }
    let freedom = (samples.len() - 3).max(1) as f64;
    let variance = squares(samples, &law) / freedom;
    let spread =
        normal(&found).try_inverse().ok_or_else(|| Unfit::NotConverged("the normal matrix is singular".into()))?;
    let error = Vector3::from_fn(|i, _| (variance * spread[(i, i)]).max(0.0).sqrt());
    Ok(Fit { law, error: Law::from(&error) })
}

/// Checks that the samples vary in everything the law depends on.
///
/// # Errors
/// [`Unfit`].
pub fn determined(samples: &[Sample]) -> Result<(), Unfit> {
    let melted: Vec<&Sample> = samples.iter().filter(|s| s.eta > 0.0).collect();
    if melted.len() < 4 {
        return Err(Unfit::TooFew(melted.len()));
    }
    let same = |of: fn(&Sample) -> f64| melted.iter().all(|s| (of(s) / of(melted[0]) - 1.0).abs() < 1e-9);
    if same(|s| s.v) {
        return Err(Unfit::OneSpeed(melted[0].v));
    }
    if same(|s| s.ratio) {
        return Err(Unfit::OneRatio(melted[0].ratio));
    }
    Ok(())
}

/// Sum of squared deviations.
pub fn squares(samples: &[Sample], law: &Law) -> f64 {
    samples.iter().map(|s| s.deviation(law) * s.deviation(law)).sum()
}

/// The best alpha and beta at a given gamma: two linear equations.
fn linear(samples: &[Sample], gamma: f64) -> Law {
    let (mut aa, mut ab, mut bb, mut ya, mut yb) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for s in samples {
        let power = math::pow(s.ratio, gamma);
        let (a, b) = (s.v * s.v * power, s.v * power);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        ya += s.eta * a;
        yb += s.eta * b;
    }
    let determinant = aa * bb - ab * ab;
    Law { alpha: (ya * bb - yb * ab) / determinant, beta: (yb * aa - ya * ab) / determinant, gamma }
}

struct Problem<'a> {
    samples: &'a [Sample],
    p: Vector3<f64>,
}

impl Problem<'_> {
    /// Derivatives of a sample's deviation by alpha, beta and gamma.
    fn slope(&self, s: &Sample) -> [f64; 3] {
        let law = Law::from(&self.p);
        if s.at_limit && law.at(s.v, s.ratio) >= s.eta {
            return [0.0; 3];
        }
        let power = math::pow(s.ratio, law.gamma);
        [s.v * s.v * power, s.v * power, law.at(s.v, s.ratio) * math::log(s.ratio)]
    }
}

/// J'J by sums in the samples' order.
fn normal(problem: &Problem<'_>) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for s in problem.samples {
        let row = problem.slope(s);
        for i in 0..3 {
            for j in 0..3 {
                sum[(i, j)] += row[i] * row[j];
            }
        }
    }
    sum
}

impl LeastSquaresProblem<f64, Dyn, U3> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U3>;
    type ParameterStorage = Owned<f64, U3>;

    fn set_params(&mut self, p: &Vector3<f64>) {
        self.p = *p;
    }

    fn params(&self) -> Vector3<f64> {
        self.p
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let law = Law::from(&self.p);
        Some(DVector::from_iterator(self.samples.len(), self.samples.iter().map(|s| s.deviation(&law))))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U3>> {
        Some(OMatrix::<f64, Dyn, U3>::from_row_iterator(
            self.samples.len(),
            self.samples.iter().flat_map(|s| self.slope(s)),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(law: &Law, noise: impl Fn(usize) -> f64) -> Vec<Sample> {
        let speeds = [2.5, 4.2, 5.0, 5.9, 6.7, 7.5];
        let ratios = [0.64, 1.28, 2.56, 5.04];
        let pairs = speeds.iter().flat_map(|&v| ratios.iter().map(move |&r| (v, r)));
        pairs
            .enumerate()
            .map(|(k, (v, ratio))| Sample { v, ratio, eta: law.at(v, ratio) + noise(k), at_limit: false })
            .collect()
    }

    /// Samples of a law give the law back to the solver's tolerance, from laws of very different shape.
    #[test]
    fn an_exact_law_is_recovered() {
        for law in [TABLE_4, Law { alpha: 0.03, beta: -0.1, gamma: 0.4 }, Law { alpha: 0.001, beta: 0.02, gamma: -1.9 }]
        {
            let found = fit(&grid(&law, |_| 0.0)).unwrap().law;
            for (a, b) in found.values().iter().zip(law.values()) {
                assert!((a / b - 1.0).abs() < 1e-8, "{found:?} for {law:?}");
            }
        }
    }

    /// Known disturbance, the same size everywhere: the truth lies within four of the covariance's errors.
    #[test]
    fn errors_cover_the_truth() {
        let samples = grid(&TABLE_4, |k| 0.01 * math::sin(12.9898 * (k as f64 + 1.0) * (k as f64 + 2.0)));
        let found = fit(&samples).unwrap();
        for i in 0..3 {
            let (truth, x, e) = (TABLE_4.values()[i], found.law.values()[i], found.error.values()[i]);
            assert!(e > 0.0 && (x - truth).abs() < 4.0 * e, "parameter {i}: {x} +- {e} for {truth}");
        }
    }

    /// The speed at which the law passes 1 is where it is 1; a law that never gets there has none.
    #[test]
    fn the_speed_of_full_melting_solves_the_law() {
        for law in [TABLE_4, Law { alpha: -0.002, beta: 0.2, gamma: -0.4 }] {
            for ratio in [0.32, 0.64, 5.04] {
                let v = law.full_from(ratio).unwrap();
                assert!((law.at(v, ratio) - 1.0).abs() < 1e-12 && law.at(0.99 * v, ratio) < 1.0, "{law:?} {ratio}");
            }
        }
        assert_eq!(Law { alpha: -0.1, beta: 0.1, gamma: 0.0 }.full_from(1.0), None);
        assert_eq!(Law { alpha: -0.1, beta: -0.1, gamma: 0.0 }.full_from(1.0), None);
    }

    /// At D/t = 1 the power is 1 whatever gamma is.
    #[test]
    fn samples_at_ratio_one_say_nothing_of_gamma() {
        let flat = |k: usize| if k.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let base = grid(&TABLE_4, flat);
        let at_one: Vec<Sample> =
            base.iter().map(|s| Sample { ratio: 1.0, eta: TABLE_4.at(s.v, 1.0), at_limit: false, v: s.v }).collect();
        let problem = |samples| normal(&Problem { samples, p: Vector3::from(TABLE_4.values()) });
        assert_eq!(problem(&at_one)[(2, 2)], 0.0);
        assert!(problem(&base)[(2, 2)] > 0.0);
    }

    /// The slope is the deviation's derivative: central differences, whose own error is of order 1e-9 here.
    #[test]
    fn slopes_are_derivatives() {
        let samples = grid(&TABLE_4, |_| 0.02);
        for s in &samples {
            let slope = Problem { samples: &samples, p: Vector3::from(TABLE_4.values()) }.slope(s);
            for i in 0..3 {
                let moved = |h: f64| {
                    let mut p = TABLE_4.values();
                    p[i] += h;
                    s.deviation(&Law { alpha: p[0], beta: p[1], gamma: p[2] })
                };
                let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!(
                    (slope[i] - difference).abs() < 1e-7 * (1.0 + difference.abs()),
                    "{i}: {} {difference}",
                    slope[i]
                );
            }
        }
    }

    #[test]
    fn what_cannot_be_determined_is_refused() {
        let all = grid(&TABLE_4, |_| 0.0);
        let keep = |f: &dyn Fn(&Sample) -> bool| all.iter().copied().filter(|s| f(s)).collect::<Vec<_>>();
        assert_eq!(fit(&keep(&|s| s.v == 5.9)), Err(Unfit::OneSpeed(5.9)));
        assert_eq!(fit(&keep(&|s| s.ratio == 0.64)), Err(Unfit::OneRatio(0.64)));
        assert_eq!(fit(&all[..3]), Err(Unfit::TooFew(3)));
        let cold: Vec<Sample> = all.iter().map(|s| Sample { eta: 0.0, ..*s }).collect();
        assert_eq!(fit(&cold), Err(Unfit::TooFew(0)));
    }

    /// A law that goes on above 1 where the runs are saturated is found as if nothing had been cut off.
    #[test]
    fn saturated_runs_only_bound_the_law() {
        let truth = Law { alpha: 0.03, beta: -0.05, gamma: -0.7 };
        let cut: Vec<Sample> = grid(&truth, |_| 0.0)
            .into_iter()
            .map(|s| Sample { eta: s.eta.min(1.0), at_limit: s.eta >= 1.0, ..s })
            .collect();
        assert!(cut.iter().filter(|s| s.at_limit).count() >= 4);
        let found = fit(&cut).unwrap().law;
        for (a, b) in found.values().iter().zip(truth.values()) {
            assert!((a / b - 1.0).abs() < 1e-6, "{found:?}");
        }
    }
}
