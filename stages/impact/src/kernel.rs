//! Weights of one particle, and the walk over the rows of its 4^D nodes.
//!
//! All weights reproduce linear fields; those of the quadratic and cubic B-splines also have
//! `sum_i w_i (x_i - x)(x_i - x)^T = D I` with the same D everywhere, which is what the affine transfer rests on (Steffen, Kirby
//! & Berzins 2008; Jiang, Schroeder & Teran 2017). Narrower kernels have zeros at the ends of the four nodes.
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape of the weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// Two nodes an axis; the paper's (eq 9). Not fit below about 2 km/s: its gradient jumps where particles cross cells.
    Linear,
    /// uGIMP: linear weights averaged over a particle half a cell wide (Bardenhagen & Kober 2004); 2 particles a cell and axis.
    Gimp,
    /// Quadratic B-spline, three nodes an axis.
    Quadratic,
    /// Cubic B-spline, four nodes an axis.
    #[default]
    Cubic,
}

impl Kernel {
    /// Second moment of the weights along an axis, over dx^2; 0 where it depends on the place.
    #[inline(always)]
    pub const fn moment(self) -> f64 {
        match self {
            Kernel::Linear | Kernel::Gimp => 0.0,
            Kernel::Quadratic => 0.25,
            Kernel::Cubic => 1.0 / 3.0,
        }
    }

    /// Weights and slopes [1/m] at share `f` of a cell, of the nodes at -1, 0, 1 and 2 cells from its lower end.
    #[inline(always)]
    fn line(self, f: f64, per_cell: f64) -> ([f64; 4], [f64; 4]) {
        let a = 1.0 - f;
        match self {
            Kernel::Cubic => (
                [
                    a * a * a / 6.0,
                    (4.0 + f * f * (3.0 * f - 6.0)) / 6.0,
                    (4.0 + a * a * (3.0 * a - 6.0)) / 6.0,
                    f * f * f / 6.0,
                ],
                [
                    -0.5 * a * a * per_cell,
                    f * (1.5 * f - 2.0) * per_cell,
                    a * (2.0 - 1.5 * a) * per_cell,
                    0.5 * f * f * per_cell,
                ],
            ),
            Kernel::Linear => ([0.0, a, f, 0.0], [0.0, -per_cell, per_cell, 0.0]),
            Kernel::Quadratic => each_node(f, per_cell, |z| match z {
                z if z < 0.5 => (0.75 - z * z, -2.0 * z),
                z if z < 1.5 => (0.5 * (1.5 - z) * (1.5 - z), z - 1.5),
                _ => (0.0, 0.0),
            }),
            // Half-width of the particle: a quarter of a cell.
            Kernel::Gimp => each_node(f, per_cell, |z| match z {
                z if z < 0.25 => (0.875 - 2.0 * z * z, -4.0 * z),
                z if z < 0.75 => (1.0 - z, -1.0),
                z if z < 1.25 => ((1.25 - z) * (1.25 - z), 2.0 * (z - 1.25)),
                _ => (0.0, 0.0),
            }),
        }
    }
}

/// Weight and slope of each of the four nodes by a function of the distance in cells.
#[inline(always)]
fn each_node(f: f64, per_cell: f64, at: impl Fn(f64) -> (f64, f64)) -> ([f64; 4], [f64; 4]) {
    let (mut weight, mut slope) = ([0.0; 4], [0.0; 4]);
    for k in 0..4 {
        let z = f + 1.0 - k as f64;
        let (w, g) = at(z.abs());
        (weight[k], slope[k]) = (w, if z < 0.0 { -g } else { g } * per_cell);
    }
    (weight, slope)
}

/// Weights and slopes of one particle along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<const D: usize> {
    /// Weights of the four nodes along each axis.
    pub weight: [[f64; 4]; D],
    /// Derivatives of the weights [1/m].
    pub slope: [[f64; 4]; D],
    /// First node's position minus the particle's [m].
    pub corner: [f64; D],
}

/// Four nodes in a line along the last axis: what is common to them.
#[derive(Clone, Copy, Debug)]
pub struct Row<const D: usize> {
    /// Product of the weights along the other axes.
    pub weight: f64,
    /// The same product with the slope along axis `d` instead of its weight; the last entry is not used.
    pub slope: [f64; D],
    /// Position minus the particle's along the other axes [m]; the last entry is not used.
    pub offset: [f64; D],
}

/// Nodes of a stencil: 4^D.
pub const fn nodes<const D: usize>() -> usize {
    4usize.pow(D as u32)
}

/// Cell of `position` [m] on a grid of spacing `cell` [m], as a whole number kept in f64.
#[inline(always)]
pub fn cell_of(position: f64, cell: f64) -> f64 {
    (position / cell).floor()
}

impl<const D: usize> Stencil<D> {
    /// Weights at `position` [m] on a grid of spacing `cell` [m].
    #[inline(always)]
    pub fn at(position: &[f64; D], cell: f64, kernel: Kernel) -> Self {
        let mut s = Stencil { weight: [[0.0; 4]; D], slope: [[0.0; 4]; D], corner: [0.0; D] };
        let per_cell = 1.0 / cell;
        for d in 0..D {
            let f = position[d] / cell - cell_of(position[d], cell);
            (s.weight[d], s.slope[d]) = kernel.line(f, per_cell);
            s.corner[d] = -(1.0 + f) * cell;
        }
        s
    }

    /// Rows of the stencil: 4^(D-1).
    pub const ROWS: usize = 4usize.pow(D as u32 - 1);

    /// Row `row` of the stencil; its nodes are number `4 row .. 4 row + 4` of the cell's list.
    #[inline(always)]
    pub fn row(&self, row: usize, cell: f64) -> Row<D> {
        let mut weight = 1.0;
        let mut slope = [1.0; D];
        let mut offset = [0.0; D];
        for d in 0..D - 1 {
            let digit = (row >> (2 * (D - 2 - d))) & 3;
            let (w, g) = (self.weight[d][digit], self.slope[d][digit]);
            weight *= w;
            for e in 0..D - 1 {
                slope[e] *= if e == d { g } else { w };
            }
            offset[d] = self.corner[d] + digit as f64 * cell;
        }
        Row { weight, slope, offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit sum, linear reproduction, second moment, and slopes that are the derivatives of the weights (1e-5: uGIMP bends within a
    /// difference of 2e-6).
    #[test]
    fn moments_and_slopes() {
        let cell = 0.7;
        for kernel in [Kernel::Linear, Kernel::Gimp, Kernel::Quadratic, Kernel::Cubic] {
            for i in 0..57 {
                let x = -3.1 + 0.117 * i as f64;
                let s = Stencil::<1>::at(&[x], cell, kernel);
                let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
                    (0..4).map(|k| s.weight[0][k] * f(s.corner[0] + k as f64 * cell)).sum()
                };
                assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-15);
                assert!(sum(&|r| r).abs() < 1e-15);
                let moment = kernel.moment() * cell * cell;
                assert!(moment == 0.0 || (sum(&|r| r * r) - moment).abs() < 1e-15);
                let h = 1e-6;
                if cell_of(x - h, cell) != cell_of(x + h, cell) {
                    continue;
                }
                let (a, b) = (Stencil::<1>::at(&[x - h], cell, kernel), Stencil::<1>::at(&[x + h], cell, kernel));
                for k in 0..4 {
                    let slope = (b.weight[0][k] - a.weight[0][k]) / (2.0 * h);
                    assert!((slope - s.slope[0][k]).abs() < 1e-5, "{kernel:?} {k}: {slope} {}", s.slope[0][k]);
                }
            }
        }
    }

    /// In three dimensions the rows' weights sum to one and their slopes to zero.
    #[test]
    fn rows_make_the_tensor_product() {
        let s = Stencil::<3>::at(&[0.31, -1.7, 12.9], 1.0, Kernel::Cubic);
        let mut sum = 0.0;
        let mut gradient = [0.0; 2];
        for row in 0..Stencil::<3>::ROWS {
            let r = s.row(row, 1.0);
            sum += r.weight;
            gradient[0] += r.slope[0];
            gradient[1] += r.slope[1];
        }
        assert!((sum - 1.0).abs() < 1e-15 && gradient[0].abs() < 1e-15 && gradient[1].abs() < 1e-15);
    }
}
