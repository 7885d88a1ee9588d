//! How uncertain a fitted law is, where what it misses goes by D/t: the bootstrap of whole families.
use crate::law::{self, Law, Sample};
use crate::point::close;
use serde::{Deserialize, Serialize};

/// Families from here on can be drawn with replacement to some purpose.
const FEWEST: usize = 3;

/// Spread of the laws fitted to families drawn with replacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Families drawn from.
    pub families: u32,
    /// Standard deviation over the draws.
    pub error: Law,
    /// Range that holds 95 % of the draws.
    pub range: [Law; 2],
}

/// Samples of one D/t together, in the order of each family's first.
pub fn families(samples: &[Sample]) -> Vec<Vec<Sample>> {
    let mut all: Vec<Vec<Sample>> = Vec::new();
    for &s in samples {
        match all.iter_mut().find(|f| close(f[0].ratio, s.ratio)) {
            Some(family) => family.push(s),
            None => all.push(vec![s]),
        }
    }
    all
}

/// Bootstrap of whole D/t families; `None` with fewer than three families, or where fewer than half of the draws can be fitted.
///
/// Runs of one D/t lie on the same side of the law, so that single runs drawn with replacement (or the covariance) would take one
/// family's misfit for as many independent ones as it has runs (Efron and Tibshirani 1993, ch. 8: draw the independent unit). The
/// draws come from splitmix64 (Steele, Lea, Flood, OOPSLA 2014) with the seed given.
pub fn bootstrap(samples: &[Sample], draws: u32, mut seed: u64) -> Option<Spread> {
    let families = families(samples);
    if families.len() < FEWEST {
        return None;
    }
    let mut random = || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut all: [Vec<f64>; 3] = Default::default();
    for _ in 0..draws {
        let drawn: Vec<Sample> =
            families.iter().flat_map(|_| families[(random() % families.len() as u64) as usize].clone()).collect();
        let Ok(fit) = law::fit(&drawn) else { continue };
        all.iter_mut().zip(fit.law.values()).for_each(|(list, x)| list.push(x));
    }
    let n = all[0].len();
    if n < 20 || n < draws as usize / 2 {
        return None;
    }
    all.iter_mut().for_each(|list| list.sort_by(f64::total_cmp));
    let tail = n / 40;
    let [low, high] = [tail, n - 1 - tail].map(|k| Law::each(|i| all[i][k]));
    Some(Spread { families: families.len() as u32, error: Law::each(|i| deviation(&all[i])), range: [low, high] })
}

/// Standard deviation, with n - 1.
fn deviation(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (x.len() - 1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::TABLE_4;

    /// Every family lies off the law by its own offset.
    fn offset(by: [f64; 4]) -> Vec<Sample> {
        let speeds = [2.5, 3.3, 4.2, 4.6, 5.0, 5.4, 5.9, 6.3, 6.7, 7.5];
        let ratios = [0.64, 1.28, 2.56, 5.04];
        let pairs = speeds.iter().flat_map(|&v| (0..4).map(move |k| (v, k)));
        pairs
            .map(|(v, k)| Sample { v, ratio: ratios[k], eta: TABLE_4.at(v, ratios[k]) + by[k], at_limit: false })
            .collect()
    }

    /// Families that differ have a wider spread than the covariance makes of their forty runs; the truth is within it.
    #[test]
    fn systematic_families_spread_more_than_independent_runs() {
        let samples = offset([0.01, -0.02, 0.015, -0.005]);
        let (fit, spread) = (law::fit(&samples).unwrap(), bootstrap(&samples, 400, 1).unwrap());
        assert_eq!(spread.families, 4);
        let gamma = |l: &Law| l.gamma;
        assert!(gamma(&spread.error) > 1.5 * gamma(&fit.error), "{spread:?} {fit:?}");
        let [low, high] = &spread.range;
        assert!(gamma(low) < TABLE_4.gamma && TABLE_4.gamma < gamma(high), "{spread:?}");
        assert_eq!(bootstrap(&samples, 400, 1), Some(spread), "same seed, same answer");
    }

    /// Without any misfit no draw differs from another, whichever families it took: 1e-8 is the fit's own tolerance.
    #[test]
    fn exact_families_do_not_spread() {
        let spread = bootstrap(&offset([0.0; 4]), 200, 3).unwrap();
        for i in 0..3 {
            assert!(spread.error.values()[i] < 1e-8, "{spread:?}");
            assert!((spread.range[1].values()[i] / TABLE_4.values()[i] - 1.0).abs() < 1e-7, "{spread:?}");
        }
    }

    /// A family is drawn as a whole: runs repeated within one change nothing but the weights, and two families are too few.
    #[test]
    fn runs_of_one_ratio_are_one_family() {
        let samples = offset([0.0; 4]);
        let split = families(&samples);
        assert_eq!(split.iter().map(Vec::len).collect::<Vec<_>>(), [10; 4]);
        assert!(split.iter().all(|f| f.iter().all(|s| s.ratio == f[0].ratio)));
        let two: Vec<Sample> = samples.into_iter().filter(|s| s.ratio < 2.0).collect();
        assert_eq!(bootstrap(&two, 200, 1), None);
    }
}
