//! Where a sequence of refinements leads: its limit, with an uncertainty, and the order it comes at.
//!
//! P. J. Roache, J. Fluids Eng. 116, 405 (1994) (grid convergence index); L. F. Richardson, Phil. Trans. A 210, 307 (1911).
use hvi_kit::math::{exp, log};

/// How a limit was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// It is known in closed form.
    Exact,
    /// Extrapolated from runs that approach it.
    Extrapolated,
    /// The finest run: the runs do not approach a limit at one order.
    Finest,
    /// The last run as written: what the others are to agree with.
    Last,
}

/// A limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Its value.
    pub value: f64,
    /// Its uncertainty, in the value's unit.
    pub uncertainty: f64,
    /// How it was found.
    pub how: How,
    /// The order at which it is approached.
    pub order: Option<Order>,
}

/// An observed order p of errors C h^p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// p.
    pub value: f64,
    /// Its uncertainty; `None` where as few runs as unknowns leave none to estimate it by.
    pub uncertainty: Option<f64>,
}

/// Factor of safety of the grid convergence index with three runs or more (Roache 1994).
const SAFETY: f64 = 1.25;
/// Orders that are searched: below it is no convergence to speak of, above the runs are too few or too coarse to tell.
const ORDERS: (f64, f64) = (0.3, 4.0);

/// The limit of `levels`, (h, value) from coarse to fine.
///
/// `f(h) = f0 + C h^p`, weighted by 1/h^2, so that the finer runs decide. The uncertainty is the larger of the grid convergence
/// index of the finest run and what leaving out one run changes. Where the last three runs do not go one way, or p is at an end of
/// the searched range, the finest run stands, its uncertainty the spread of the last three.
pub fn limit(levels: &[(f64, f64)]) -> Option<Limit> {
    let (_, finest) = *levels.last()?;
    let n = levels.len();
    let spread = levels[n.saturating_sub(3)..].iter().map(|l| (l.1 - finest).abs()).fold(0.0, f64::max);
    let stands = Limit { value: finest, uncertainty: spread, how: How::Finest, order: None };
    if n < 3 {
        return Some(Limit { uncertainty: if n == 1 { f64::INFINITY } else { spread }, ..stands });
    }
    let (last, before) = (finest - levels[n - 2].1, levels[n - 2].1 - levels[n - 3].1);
    let Some((value, p)) = fit(levels).filter(|_| last * before > 0.0) else { return Some(stands) };
    let without = |i: usize| -> Option<(f64, f64)> {
        fit(&levels.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, l)| *l).collect::<Vec<_>>())
    };
    let others: Vec<(f64, f64)> = if n > 3 { (0..n).filter_map(without).collect() } else { Vec::new() };
    let change = others.iter().map(|o| (o.0 - value).abs()).fold(0.0, f64::max);
    let moved = others.iter().map(|o| (o.1 - p).abs()).fold(0.0, f64::max);
    let order = Order { value: p, uncertainty: (!others.is_empty()).then_some(moved) };
    let uncertainty = change.max(SAFETY * (finest - value).abs());
    Some(Limit { value, uncertainty, how: How::Extrapolated, order: Some(order) })
}

/// f0 and p of the least-squares fit; `None` where the best p is at the end of the range.
fn fit(levels: &[(f64, f64)]) -> Option<(f64, f64)> {
    let steps = 370;
    let at = |i: usize| ORDERS.0 + (ORDERS.1 - ORDERS.0) * i as f64 / steps as f64;
    let tried: Vec<(f64, f64)> = (0..=steps).map(|i| linear(levels, at(i))).collect();
    let best = (0..=steps).min_by(|&a, &b| tried[a].1.total_cmp(&tried[b].1))?;
    (best > 0 && best < steps && tried[best].0.is_finite()).then(|| (tried[best].0, at(best)))
}

/// f0 of the weighted fit at order `p`, and the sum of weighted squared residuals.
fn linear(levels: &[(f64, f64)], p: f64) -> (f64, f64) {
    let rows: Vec<(f64, f64, f64)> = levels.iter().map(|&(h, f)| (exp(p * log(h)), f, 1.0 / (h * h))).collect();
    let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| rows.iter().map(|r| r.2 * of(r)).sum::<f64>();
    let all = sum(&|_| 1.0);
    let (x, f) = (sum(&|r| r.0) / all, sum(&|r| r.1) / all);
    let slope = sum(&|r| (r.0 - x) * (r.1 - f)) / sum(&|r| (r.0 - x) * (r.0 - x));
    let start = f - slope * x;
    (start, sum(&|r| (r.1 - start - slope * r.0) * (r.1 - start - slope * r.0)))
}

/// The order of `errors`, (h, error > 0): the slope of log error over log h, with its standard error. Two or more are needed.
pub fn order(errors: &[(f64, f64)]) -> Option<Order> {
    let rows: Vec<(f64, f64)> =
        errors.iter().filter(|e| e.0 > 0.0 && e.1 > 0.0).map(|&(h, e)| (log(h), log(e))).collect();
    let n = rows.len() as f64;
    if rows.len() < 2 {
        return None;
    }
    let (x, y) = (rows.iter().map(|r| r.0).sum::<f64>() / n, rows.iter().map(|r| r.1).sum::<f64>() / n);
    let wide: f64 = rows.iter().map(|r| (r.0 - x) * (r.0 - x)).sum();
    let value = rows.iter().map(|r| (r.0 - x) * (r.1 - y)).sum::<f64>() / wide;
    let left: f64 = rows.iter().map(|r| r.1 - y - value * (r.0 - x)).map(|d| d * d).sum();
    let uncertainty = (rows.len() > 2).then(|| (left / (n - 2.0) / wide).sqrt());
    value.is_finite().then_some(Order { value, uncertainty })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 7 + 2 h^1.5 is found again, from three runs and from five; the search steps in 0.01, and the limit is as good as p.
    #[test]
    fn a_known_limit_and_order_are_found() {
        let of = |hs: &[f64]| hs.iter().map(|&h| (h, 7.0 + 2.0 * h * h.sqrt())).collect::<Vec<_>>();
        for hs in [&[0.4, 0.2, 0.1][..], &[0.5, 0.35, 0.2, 0.1, 0.05]] {
            let found = limit(&of(hs)).unwrap();
            assert_eq!(found.how, How::Extrapolated);
            assert!((found.value - 7.0).abs() < 1e-3 && (found.order.unwrap().value - 1.5).abs() < 0.02, "{found:?}");
            assert!(found.uncertainty >= (found.value - 7.0).abs());
        }
        let errors: Vec<_> = [0.4, 0.2, 0.1].iter().map(|&h: &f64| (h, 3.0 * h * h)).collect();
        let p = order(&errors).unwrap();
        assert!((p.value - 2.0).abs() < 1e-12 && p.uncertainty.unwrap() < 1e-6);
    }

    #[test]
    fn what_does_not_converge_is_not_extrapolated() {
        let scattered = limit(&[(0.4, 1.0), (0.2, 1.4), (0.1, 0.9), (0.05, 1.2)]).unwrap();
        assert_eq!((scattered.how, scattered.value, scattered.order), (How::Finest, 1.2, None));
        assert!((scattered.uncertainty - 0.3).abs() < 1e-12);
        let apart = limit(&[(0.4, 1.0), (0.2, 1.5), (0.1, 2.5)]).unwrap();
        assert_eq!((apart.how, apart.uncertainty), (How::Finest, 1.5));
        assert!(limit(&[]).is_none() && limit(&[(1.0, 2.0)]).unwrap().uncertainty.is_infinite());
        assert!(order(&[(0.1, 0.0), (0.2, 1.0)]).is_none());
    }
}
