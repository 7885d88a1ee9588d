//! Exponential, logarithm and power of numbers side by side, the same bits on every processor.
//!
//! Errors are relative, measured against libm over the stated ranges (test): `exp` and `log` 4e-16 (`log` of that or of 4e-16 absolute,
//! the greater), `pow` 4e-16 plus 3e-16 times the size of its logarithm.
use super::Real;

/// ln 2 in two parts, the first with 21 low zero bits, so that a whole multiple of it is exact.
const LN2: [f64; 2] = [0.6931471803691238, 1.9082149292705877e-10];

/// `1 / n!` from n = 13 down to 2.
const FACTORIALS: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// `e^x`; x counts from -700 to 700 at most.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    let x = x.at_least(-700.0).at_most(700.0);
    let k = x.times(std::f64::consts::LOG2_E).plus(0.5).floor();
    let r = k.fused(R::of(-LN2[1]), k.fused(R::of(-LN2[0]), x));
    let mut series = R::of(FACTORIALS[0]);
    for c in &FACTORIALS[1..] {
        series = series.fused(r, R::of(*c));
    }
    (series * r).fused(r, r).plus(1.0).scale(k)
}

/// `ln x` of normal positive numbers.
#[inline(always)]
pub fn log<R: Real>(x: R) -> R {
    let (m, k) = (x.mantissa(), x.exponent());
    let root = R::of(std::f64::consts::SQRT_2);
    let k = k.where_less(m, root, k.plus(1.0));
    let m = m.where_less(m, root, m.times(0.5));
    // ln m = 2 artanh s, s = (m - 1) / (m + 1), |s| < .1716: the series' last term is 2e-17 of the first.
    let f = m.plus(-1.0);
    let s = f / m.plus(1.0);
    let z = s * s;
    let mut series = R::of(2.0 / 21.0);
    for n in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = series.fused(z, R::of(2.0 / n));
    }
    // 2 s = f - s f.
    let small = s * (z * series) - s * f;
    k.fused(R::of(LN2[0]), f + k.fused(R::of(LN2[1]), small))
}

/// `x^exponent` of normal positive numbers.
#[inline(always)]
pub fn pow<R: Real>(x: R, exponent: f64) -> R {
    exp(log(x).times(exponent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    /// Against libm (within 1 ulp, 2.2e-16, itself) on 20,000 numbers a function.
    #[test]
    fn errors_are_as_stated() {
        let mut worst = [0.0f64; 3];
        for i in 0..20_000 {
            let t = i as f64 / 20_000.0 - 0.5;
            let (x, y) = (1390.0 * t, math::exp(1300.0 * t));
            worst[0] = worst[0].max((exp(x) / math::exp(x) - 1.0).abs());
            worst[1] = worst[1].max((log(y) - math::log(y)).abs() / math::log(y).abs().max(1.0));
            let n = 0.31 + 0.7 * t;
            let size = (n * math::log(y)).abs();
            worst[2] = worst[2].max((pow(y, n) / math::pow(y, n) - 1.0).abs() / (1.0 + 0.75 * size));
        }
        for (error, bound) in worst.iter().zip([6e-16, 6e-16, 6e-16]) {
            assert!(*error < bound, "{worst:?}");
        }
        let near = log(1.0 + 1e-9) / 1e-9;
        assert!((near - 1.0).abs() < 1e-7 && log(1.0) == 0.0 && exp(0.0) == 1.0);
    }
}
