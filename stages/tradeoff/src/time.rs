//! How well a stage's prediction of its time holds on a machine.

/// Time taken over time predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// The median of the ratios: what a prediction is multiplied by.
    pub median: f64,
    /// The largest factor by which a prediction, so multiplied, was still off.
    pub worst: f64,
    /// Number of runs.
    pub runs: usize,
}

/// The pace of runs, each (predicted, taken) [s]; `None` without any of a measurable length.
pub fn pace(runs: &[(f64, f64)]) -> Option<Pace> {
    let mut ratios: Vec<f64> = runs.iter().filter(|r| r.0 > 0.0 && r.1 > 0.0).map(|r| r.1 / r.0).collect();
    ratios.sort_by(f64::total_cmp);
    let median = *ratios.get(ratios.len() / 2)?;
    let worst = ratios.iter().map(|r| (r / median).max(median / r)).fold(1.0, f64::max);
    Some(Pace { median, worst, runs: ratios.len() })
}

/// The median of `times`, the lower of the middle two; 0 of none.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len().saturating_sub(1) / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_scales_and_the_worst_is_a_factor() {
        let found = pace(&[(1.0, 2.0), (2.0, 4.0), (1.0, 1.0), (0.0, 5.0)]).unwrap();
        assert_eq!(found, Pace { median: 2.0, worst: 2.0, runs: 3 });
        assert!(pace(&[]).is_none());
        assert_eq!([median(vec![3.0, 1.0, 2.0]), median(vec![4.0, 2.0]), median(vec![])], [2.0, 2.0, 0.0]);
    }
}
