//! Piecewise cubic interpolation through given points that overshoots nowhere.

/// Slopes at the points (`x` rising) for cubic Hermite pieces that rise and fall only where the data do.
///
/// Weighted harmonic means of the neighbouring secants, zero at extremes; at the ends the secant of the end interval, bent by
/// its neighbour. Source: F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5, 300 (1984).
pub fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let secant = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    if n == 2 {
        return vec![secant(0); 2];
    }
    let end = |near: f64, far: f64, h: f64, next: f64| {
        let bent = ((2.0 * h + next) * near - h * far) / (h + next);
        if bent * near <= 0.0 {
            0.0
        } else if near * far <= 0.0 && bent.abs() > 3.0 * near.abs() {
            3.0 * near
        } else {
            bent
        }
    };
    let inner = |i: usize| {
        let (left, right) = (secant(i - 1), secant(i));
        if left * right <= 0.0 {
            return 0.0;
        }
        let (a, b) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let (first, second) = (2.0 * b + a, b + 2.0 * a);
        (first + second) / (first / left + second / right)
    };
    (0..n)
        .map(|i| match i {
            0 => end(secant(0), secant(1), x[1] - x[0], x[2] - x[1]),
            _ if i == n - 1 => end(secant(n - 2), secant(n - 3), x[n - 1] - x[n - 2], x[n - 2] - x[n - 3]),
            _ => inner(i),
        })
        .collect()
}

/// Value and derivative at `x` of the cubic through `(x0, y0)` and `(x1, y1)` with slopes `d0` and `d1` there.
pub fn hermite(x: f64, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], [d0, d1]: [f64; 2]) -> (f64, f64) {
    let h = x1 - x0;
    let (s, secant) = ((x - x0) / h, (y1 - y0) / h);
    let (bend, twist) = (3.0 * secant - 2.0 * d0 - d1, d0 + d1 - 2.0 * secant);
    (y0 + h * s * (d0 + s * (bend + s * twist)), d0 + s * (2.0 * bend + 3.0 * s * twist))
}

/// The interval of `x` (rising, two or more) that holds `at`: the first or last one outside.
pub fn interval(x: &[f64], at: f64) -> usize {
    x.partition_point(|&x| x <= at).clamp(1, x.len() - 1) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step stays between its values; a cubic's data are followed to third order.
    #[test]
    fn no_overshoot_and_third_order() {
        let x: Vec<f64> = (0..8).map(f64::from).collect();
        let y = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 4.0, 5.0];
        let d = slopes(&x, &y);
        let mut last = 0.0;
        for i in 0..=700 {
            let at = f64::from(i) / 100.0;
            let k = interval(&x, at);
            let (value, _) = hermite(at, [x[k], x[k + 1]], [y[k], y[k + 1]], [d[k], d[k + 1]]);
            assert!(value >= last - 1e-15 && value <= 5.0, "{at} {value}");
            last = value;
        }
        let error = |n: usize| {
            let x: Vec<f64> = (0..=n).map(|i| 1.0 + i as f64 / n as f64).collect();
            let y: Vec<f64> = x.iter().map(|x| x * x * x).collect();
            let d = slopes(&x, &y);
            let off = |at: f64| {
                let k = interval(&x, at);
                (hermite(at, [x[k], x[k + 1]], [y[k], y[k + 1]], [d[k], d[k + 1]]).0 - at * at * at).abs()
            };
            (0..1000).map(|i| off(1.0 + (f64::from(i) + 0.5) / 1000.0)).fold(0.0, f64::max)
        };
        // Harmonic means are second-order slopes, so values are third: a factor of 8 a halving.
        assert!(error(10) / error(20) > 6.0, "{} {}", error(10), error(20));
    }
}
