//! Least squares in logarithms of positive parameters, by Levenberg and Marquardt, with the covariance at the minimum.
use hvi_kit::math::{exp, log};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// A minimum.
pub(super) struct Minimum {
    /// The parameters, all positive.
    pub parameters: Vec<f64>,
    /// Whether the search ended at a minimum.
    pub converged: bool,
    /// `s^2 (J'J)^-1` of the logarithms, s^2 the residuals' variance; `None` where J'J is singular.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Condition number of J with its columns scaled to unit length; infinite where a column is zero.
    pub condition: f64,
}

/// Step of the central differences in the logarithms: truncation 1e-8, rounding 1e-11 of the residuals' size.
const STEP: f64 = 1e-4;
/// Residual of parameters outside the model's domain: larger than any real one, so that the step is refused.
const REFUSED: f64 = 1e6;

struct Problem<F> {
    x: DVector<f64>,
    model: F,
    count: usize,
}

impl<F: Fn(&[f64]) -> Option<Vec<f64>>> Problem<F> {
    fn at(&self, x: &DVector<f64>) -> Vec<f64> {
        let parameters: Vec<f64> = x.iter().map(|&x| exp(x)).collect();
        let residuals = (self.model)(&parameters).filter(|r| r.iter().all(|r| r.is_finite()));
        residuals.unwrap_or_else(|| vec![REFUSED; self.count])
    }
}

impl<F: Fn(&[f64]) -> Option<Vec<f64>>> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<F> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
    }
    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }
    fn residuals(&self) -> Option<DVector<f64>> {
        Some(DVector::from_vec(self.at(&self.x)))
    }
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(self.count, self.x.len());
        for k in 0..self.x.len() {
            let [below, above] = [-STEP, STEP].map(|step| {
                let mut x = self.x.clone();
                x[k] += step;
                self.at(&x)
            });
            for i in 0..self.count {
                jacobian[(i, k)] = (above[i] - below[i]) / (2.0 * STEP);
            }
        }
        Some(jacobian)
    }
}

/// Minimises the sum of squares of `model`'s `count` residuals from `start` (positive parameters).
///
/// `model` returns `None` outside its domain.
pub(super) fn minimise(start: &[f64], count: usize, model: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Minimum {
    let x = DVector::from_iterator(start.len(), start.iter().map(|&x| log(x)));
    let (problem, report) =
        LevenbergMarquardt::new().with_tol(1e-10).with_patience(60).minimize(Problem { x, model, count });
    let residuals = problem.at(&problem.x);
    let jacobian = problem.jacobian().expect("it always has one");
    let n = start.len();
    let freedom = count.saturating_sub(n).max(1) as f64;
    let variance = residuals.iter().map(|r| r * r).sum::<f64>() / freedom;
    let product = |a: usize, b: usize| (0..count).map(|i| jacobian[(i, a)] * jacobian[(i, b)]).sum::<f64>();
    let normal = DMatrix::from_fn(n, n, product);
    let scaled =
        DMatrix::from_fn(n, n, |a, b| normal[(a, b)] / (normal[(a, a)] * normal[(b, b)]).sqrt().max(f64::MIN_POSITIVE));
    let eigen = scaled.clone().symmetric_eigenvalues();
    let (low, high) = (eigen.min(), eigen.max());
    let empty = (0..n).any(|a| normal[(a, a)] == 0.0);
    let condition = if empty || low <= 0.0 { f64::INFINITY } else { (high / low).sqrt() };
    let inverse = if condition < 1e7 { normal.try_inverse() } else { None };
    Minimum {
        parameters: problem.x.iter().map(|&x| exp(x)).collect(),
        converged: report.termination.was_successful() && residuals.iter().all(|&r| r != REFUSED),
        covariance: inverse.map(|c| (0..n).map(|a| (0..n).map(|b| variance * c[(a, b)]).collect()).collect()),
        condition,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = A exp(-k t) from exact data, and a parameter that the data do not know.
    #[test]
    fn finds_the_decay_and_sees_what_it_cannot_know() {
        let data: Vec<(f64, f64)> = (0..20).map(|i| (0.1 * i as f64, 3.0 * exp(-0.2 * i as f64))).collect();
        let model = |p: &[f64]| Some(data.iter().map(|&(t, y)| p[0] * exp(-p[1] * t) - y).collect());
        let found = minimise(&[1.0, 1.0], data.len(), model);
        assert!(
            found.converged && (found.parameters[0] - 3.0).abs() < 1e-8 && (found.parameters[1] - 2.0).abs() < 1e-8
        );
        assert!(found.condition < 10.0);
        let blind = minimise(&[1.0, 1.0], data.len(), |p| Some(data.iter().map(|&(_, y)| p[0] - y).collect()));
        assert!(blind.condition.is_infinite() && blind.covariance.is_none());
    }
}
