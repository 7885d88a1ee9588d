//! Piecewise quintic Hermite interpolation of several functions on one uniform grid: twice continuously differentiable.

use crate::lanes::{Eight, Quads, Real};

/// Value, first and second derivative.
pub type Jet = [f64; 3];

/// `N` functions of one variable, each given by its exact value and first two derivatives at the nodes.
///
/// Derivatives are those of the interpolant, so quantities that are derivatives of one another stay exactly consistent.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    start: f64,
    step: f64,
    per_step: f64,
    /// `[interval][function][power]` of the local coordinate 0..1.
    pieces: Vec<[[f64; 6]; N]>,
}

impl Table<2> {
    /// Values of both functions at eight places; where one is NaN, at the range's start.
    #[inline(always)]
    pub fn values<R: Eight>(&self, u: R) -> [R; 2] {
        let position = u.plus(-self.start).times(self.per_step);
        let below = position.at_least(0.0).min(R::of((self.pieces.len() - 1) as f64)).floor();
        let s = (position - below).at_least(0.0).at_most(1.0);
        let mut intervals = [0.0; 8];
        below.store(&mut intervals);
        // The powers of both, in thirds, by lane.
        let mut quads: [Quads; 3] = [[[0.0; 4]; 8]; 3];
        for lane in 0..8 {
            let [a, b] = &self.pieces[intervals[lane] as usize];
            for (third, quads) in quads.iter_mut().enumerate() {
                let k = 2 * third;
                quads[lane] = [a[k], a[k + 1], b[k], b[k + 1]];
            }
        }
        let [a0, a1, b0, b1] = R::columns(&quads[0]);
        let [a2, a3, b2, b3] = R::columns(&quads[1]);
        let [a4, a5, b4, b5] = R::columns(&quads[2]);
        [value([a0, a1, a2, a3, a4, a5], s), value([b0, b1, b2, b3, b4, b5], s)]
    }
}

/// The polynomial of coefficients `c`, constant first, at `s`.
#[inline(always)]
fn value<R: Real>(c: [R; 6], s: R) -> R {
    c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))
}

impl<const N: usize> Table<N> {
    /// Interpolates through `nodes`, node `i` at `start + i step`; at least two nodes, `step > 0`.
    pub fn new(start: f64, step: f64, nodes: &[[Jet; N]]) -> Self {
        let pieces: Vec<_> =
            nodes.windows(2).map(|ends| std::array::from_fn(|k| quintic(ends[0][k], ends[1][k], step))).collect();
        Self { start, step, per_step: 1.0 / step, pieces }
    }

    /// The functions at `u`, clamped to the table's range.
    #[inline]
    pub fn at(&self, u: f64) -> [Jet; N] {
        // `as` truncates and saturates: positions below 0 land in the first interval, NaN too.
        let position = (u - self.start) * self.per_step;
        let interval = (position as usize).min(self.pieces.len() - 1);
        let s = (position - interval as f64).clamp(0.0, 1.0);
        let piece = &self.pieces[interval];
        std::array::from_fn(|k| jet(&piece[k], s, self.per_step))
    }
}

/// Coefficients of the quintic with jets `a` at 0 and `b` at 1, in the coordinate local to an interval of length `h`.
pub(crate) fn quintic(a: Jet, b: Jet, h: f64) -> [f64; 6] {
    let (c0, c1, c2) = (a[0], h * a[1], 0.5 * h * h * a[2]);
    let rise = b[0] - c0 - c1 - c2;
    let slope = h * b[1] - c1 - 2.0 * c2;
    let bend = h * h * b[2] - 2.0 * c2;
    [
        c0,
        c1,
        c2,
        10.0 * rise - 4.0 * slope + 0.5 * bend,
        -15.0 * rise + 7.0 * slope - bend,
        6.0 * rise - 3.0 * slope + 0.5 * bend,
    ]
}

#[inline]
fn jet(c: &[f64; 6], s: f64, per_step: f64) -> Jet {
    let value = value(*c, s);
    let first = c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + s * 5.0 * c[5])));
    let second = 2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + s * 20.0 * c[5]));
    [value, first * per_step, second * per_step * per_step]
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::math::{cos, sin};

    /// The error of a quintic Hermite piece is h^6 / 46080 times the sixth derivative; derivatives lose one power each.
    #[test]
    fn sine_to_the_sixth_order() {
        let error = |n: usize| {
            let h = 3.0 / n as f64;
            let nodes: Vec<_> = (0..=n).map(|i| i as f64 * h).map(|u| [[sin(u), cos(u), -sin(u)]]).collect();
            let table = Table::<1>::new(0.0, h, &nodes);
            let worst = |k: usize, exact: fn(f64) -> f64| {
                let at = |i: usize| (i as f64 + 0.5) * 3.0 / 1000.0;
                (0..1000).map(|i| (table.at(at(i))[0][k] - exact(at(i))).abs()).fold(0.0, f64::max)
            };
            [worst(0, sin), worst(1, cos), worst(2, |u| -sin(u))]
        };
        let (coarse, fine) = (error(10), error(20));
        assert!(coarse[0] <= 0.3f64.powi(6) / 46080.0, "{coarse:?}");
        for (k, order) in [(0, 6.0), (1, 5.0), (2, 4.0)] {
            let found = hvi_kit::math::log(coarse[k] / fine[k]) / std::f64::consts::LN_2;
            assert!((found - order).abs() < 0.3, "derivative {k}: order {found}");
        }
    }

    #[test]
    fn outside_it_holds_its_end_values() {
        let table = Table::<1>::new(1.0, 0.5, &[[[1.0, 1.0, 0.0]], [[1.5, 1.0, 0.0]], [[2.0, 1.0, 0.0]]]);
        assert_eq!(table.at(0.0)[0][0], 1.0);
        assert!((table.at(7.0)[0][0] - 2.0).abs() < 1e-15);
    }
}
