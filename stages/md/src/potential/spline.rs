//! A function on equally spaced knots from 0 on, as the cubic spline with which LAMMPS reads tabulated potentials.
//!
//! On each interval the cubic has the values of both ends and slopes by finite differences: of five knots inside, of
//! three next to the ends and of two at the ends (S. J. Plimpton, J. Comput. Phys. 117, 1 (1995) and the documentation
//! of LAMMPS' `pair_style eam`, after the DYNAMO of M. S. Daw and M. I. Baskes). It is the same curve here, so that a
//! file means the same in both programs.
use super::Jet;

/// The cubic pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Distance of knots.
    pub step: f64,
    /// Piece k on `[k, k+1)` steps: ascending powers of the way from knot k, in steps.
    pub pieces: Vec<[f64; 4]>,
    /// Value on the last knot.
    last: f64,
}

impl Spline {
    /// Through `values` at 0, `step`, 2 `step`, ...: five of them or more.
    pub fn new(values: &[f64], step: f64) -> Spline {
        let last = values.len() - 1;
        let v = |k: usize| values[k];
        let slope = |k: usize| match k {
            0 => v(1) - v(0),
            k if k == last => v(last) - v(last - 1),
            k if k == 1 || k == last - 1 => 0.5 * (v(k + 1) - v(k - 1)),
            k => ((v(k - 2) - v(k + 2)) + 8.0 * (v(k + 1) - v(k - 1))) / 12.0,
        };
        let piece = |k: usize| {
            let (rise, a, b) = (v(k + 1) - v(k), slope(k), slope(k + 1));
            [v(k), a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise]
        };
        Spline { step, pieces: (0..last).map(piece).collect(), last: v(last) }
    }

    /// Values on the knots.
    pub fn values(&self) -> Vec<f64> {
        self.pieces.iter().map(|c| c[0]).chain([self.last]).collect()
    }

    /// Where the last piece ends.
    pub fn end(&self) -> f64 {
        self.pieces.len() as f64 * self.step
    }

    /// Value and slope at `x`, `0 <= x <= end()`.
    pub fn at(&self, x: f64) -> Jet {
        let u = x / self.step;
        let piece = (u as usize).min(self.pieces.len() - 1);
        let (t, c) = (u - piece as f64, &self.pieces[piece]);
        let slope = ((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]) / self.step;
        Jet { value: ((c[3] * t + c[2]) * t + c[1]) * t + c[0], slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five-point slopes are exact for cubics, and so is the spline away from its ends.
    #[test]
    fn cubics_are_reproduced() {
        let f = |x: f64| ((0.3 * x - 1.0) * x + 2.0) * x - 5.0;
        let spline = Spline::new(&(0..20).map(|k| f(0.25 * f64::from(k))).collect::<Vec<_>>(), 0.25);
        for x in [0.5, 1.1, 2.3, 4.2] {
            let slope = (0.9 * x - 2.0) * x + 2.0;
            assert!((spline.at(x).value - f(x)).abs() < 1e-13 && (spline.at(x).slope - slope).abs() < 1e-12);
        }
        assert_eq!((spline.end(), spline.at(spline.end()).value), (4.75, f(4.75)));
    }
}
