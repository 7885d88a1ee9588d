//! Small numerics shared by stages, with the same bits on any host: elementary functions come from the `libm` crate.
pub use libm::{cbrt, cos, exp, log, pow, sin, sqrt};

/// Root of `f` in `[a, b]`, where `f(a)` and `f(b)` differ in sign: bisection to the last bit that matters.
///
/// Returns the midpoint once the bracket is below `tolerance`, or `None` where the signs are equal.
pub fn bisect(mut a: f64, mut b: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let at_a = f(a);
    if at_a == 0.0 {
        return Some(a);
    }
    let product = at_a * f(b);
    if product > 0.0 || product.is_nan() {
        return None;
    }
    for _ in 0..200 {
        let middle = 0.5 * (a + b);
        if (b - a).abs() <= tolerance {
            return Some(middle);
        }
        if at_a * f(middle) > 0.0 { a = middle } else { b = middle }
    }
    Some(0.5 * (a + b))
}

/// Mean of `x` and its standard error by block averages: the largest error over block lengths that leave 8 blocks or more.
///
/// Blocks longer than the correlation time make the error grow to its true value (H. Flyvbjerg and H. G. Petersen,
/// J. Chem. Phys. 91, 461 (1989)). Fewer than 2 samples: the error is infinite.
pub fn block_mean(x: &[f64]) -> (f64, f64) {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    if x.len() < 2 {
        return (mean, f64::INFINITY);
    }
    let mut worst: f64 = 0.0;
    let mut length = 1;
    while length == 1 || x.len() / length >= 8 {
        let blocks: Vec<f64> = x.chunks_exact(length).map(|b| b.iter().sum::<f64>() / length as f64).collect();
        let n = blocks.len() as f64;
        let centre = blocks.iter().sum::<f64>() / n;
        let variance = blocks.iter().map(|b| (b - centre) * (b - centre)).sum::<f64>() / (n - 1.0);
        worst = worst.max((variance / n).sqrt());
        length *= 2;
    }
    (mean, worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_finds_the_root() {
        let root = bisect(0.0, 2.0, 1e-14, |x| x * x - 2.0).unwrap();
        assert!((root - 2f64.sqrt()).abs() < 1e-13);
        assert_eq!(bisect(0.0, 1.0, 1e-9, |x| x + 1.0), None);
    }

    /// An AR(1) series with correlation c has the standard error of white noise times sqrt((1+c)/(1-c)).
    #[test]
    fn block_error_accounts_for_correlation() {
        let (n, c) = (1 << 16, 0.9);
        let (mut seed, mut x) = (1u64, 0.0);
        let series: Vec<f64> = (0..n)
            .map(|_| {
                let mut white = -6.0;
                for _ in 0..12 {
                    seed ^= seed << 13;
                    seed ^= seed >> 7;
                    seed ^= seed << 17;
                    white += (seed >> 11) as f64 / (1u64 << 53) as f64;
                }
                x = c * x + white;
                x
            })
            .collect();
        let expected = (1.0 / (1.0 - c)) / (n as f64).sqrt();
        let (_, error) = block_mean(&series);
        assert!((0.7..1.8).contains(&(error / expected)), "{}", error / expected);
    }
}
