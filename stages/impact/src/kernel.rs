//! Weights of the nodes around a particle, for eight particles of a block at a time.
//!
//! All weights reproduce linear fields; those of the quadratic and cubic B-splines also have
//! `sum_i w_i (x_i - x)(x_i - x)^T = D I` with the same D everywhere, which is what the affine transfer rests on (Steffen, Kirby
//! & Berzins 2008; Jiang, Schroeder & Teran 2017).
use hvi_kit::lanes::{Eight, Real};
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

/// Cells along an edge of a block.
pub const fn edge<const D: usize>() -> usize {
    [64, 8, 4][D - 1]
}

/// Nodes along an edge of the window around a block's cells: those of the widest kernel.
pub const fn span<const D: usize>() -> usize {
    edge::<D>() + 3
}

/// Nodes from one row of a window to the next: even, so that nodes are read in pairs within their row.
pub const fn row<const D: usize>() -> usize {
    span::<D>().next_multiple_of(2)
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

    /// Nodes along an axis.
    pub const fn nodes(self) -> usize {
        match self {
            Kernel::Linear => 2,
            Kernel::Gimp | Kernel::Quadratic => 3,
            Kernel::Cubic => 4,
        }
    }

    /// How far below a particle its first node may lie at least, in cells.
    pub const fn reach(self) -> f64 {
        match self {
            Kernel::Linear => 0.0,
            Kernel::Gimp | Kernel::Quadratic => 0.5,
            Kernel::Cubic => 1.0,
        }
    }

    /// Weights and slopes [1/cell] of the nodes of a particle `f` cells (0 to 1) and [`Kernel::reach`] above its first node.
    #[inline(always)]
    pub fn line<R: Real>(self, f: R) -> ([R; 4], [R; 4]) {
        let (one, zero) = (R::of(1.0), R::of(0.0));
        let a = one - f;
        match self {
            Kernel::Linear => ([a, f, zero, zero], [zero - one, one, zero, zero]),
            Kernel::Quadratic => {
                let middle = f.plus(-0.5);
                (
                    [(a * a).times(0.5), R::of(0.75) - middle * middle, (f * f).times(0.5), zero],
                    [zero - a, middle.times(-2.0), f, zero],
                )
            }
            Kernel::Cubic => {
                let (a2, f2) = (a * a, f * f);
                (
                    [
                        (a2 * a).times(1.0 / 6.0),
                        (f2 * f.times(3.0).plus(-6.0)).plus(4.0).times(1.0 / 6.0),
                        (a2 * a.times(3.0).plus(-6.0)).plus(4.0).times(1.0 / 6.0),
                        (f2 * f).times(1.0 / 6.0),
                    ],
                    [a2.times(-0.5), f * f.times(1.5).plus(-2.0), a * (R::of(2.0) - a.times(1.5)), f2.times(0.5)],
                )
            }
            Kernel::Gimp => {
                let (first, middle, last) = (f.plus(0.5), f.plus(-0.5), a.plus(0.5));
                let ((w0, g0), (w2, g2)) = (gimp_outer(first), gimp_outer(last));
                let z = middle.size();
                let side = (zero - one).where_less(zero, middle, one);
                let w1 = (R::of(0.875) - (z * z).times(2.0)).where_less(z, R::of(0.25), one - z);
                let g1 = middle.times(-4.0).where_less(z, R::of(0.25), side);
                ([w0, w1, w2, zero], [g0, g1, zero - g2, zero])
            }
        }
    }
}

/// uGIMP's weight and its slope at a distance of half a cell or more; the particle's half-width is a quarter of a cell.
#[inline(always)]
fn gimp_outer<R: Real>(z: R) -> (R, R) {
    let (near, far, zero) = (R::of(0.75), R::of(1.25), R::of(0.0));
    let left = far - z;
    let weight = (R::of(1.0) - z).where_less(z, near, (left * left).where_less(z, far, zero));
    let slope = R::of(-1.0).where_less(z, near, left.times(-2.0).where_less(z, far, zero));
    (weight, slope)
}

/// Number of the first node along an axis, as a whole number, and how far above it (and its reach) the position lies, in cells.
#[inline(always)]
pub fn first_node<R: Real>(position: R, per_cell: f64, reach: f64) -> (R, R) {
    let at = position.times(per_cell).plus(-reach);
    let first = at.floor();
    (first, at - first)
}

/// Weights of eight particles by level: the last axis is level 2, the one before it level 1. A level that space doesn't have is one
/// node of weight 1.
#[repr(align(64))]
pub struct Lines {
    /// Weights of the nodes.
    pub weight: [[[f64; 8]; 4]; 3],
    /// Their derivatives by the particle's place [1/m].
    pub slope: [[[f64; 8]; 4]; 3],
    /// Weights times distances [m].
    pub moment: [[[f64; 8]; 4]; 3],
    /// `sum w^2` over all nodes; comes with the slopes.
    pub own: [f64; 8],
    /// The first node in the block's window.
    pub first: [f64; 8],
}

impl Default for Lines {
    /// Nothing filled in yet.
    fn default() -> Lines {
        let none = [[[0.0; 8]; 4]; 3];
        let mut weight = none;
        (weight[0][0], weight[1][0]) = ([1.0; 8], [1.0; 8]);
        Lines { weight, slope: none, moment: none, own: [0.0; 8], first: [0.0; 8] }
    }
}

impl Lines {
    /// Weights at `position` [m] of particles in the block whose first cell is `origin`, on cells of `cell` [m]; with `SLOPE` their
    /// slopes, with `MOMENT` their moments.
    #[inline(always)]
    pub fn fill<R: Eight, const D: usize, const N: usize, const SLOPE: bool, const MOMENT: bool>(
        &mut self,
        position: &[[f64; 8]; D],
        origin: &[f64; D],
        kernel: Kernel,
        cell: f64,
    ) {
        let per_cell = 1.0 / cell;
        let (mut own, mut place) = (R::of(1.0), R::of(0.0));
        for d in 0..D {
            let (first, f) = first_node(R::load(&position[d]), per_cell, kernel.reach());
            let inner = if d + 1 < D { span::<D>() } else { row::<D>() };
            place = place.times(inner as f64) + first.plus(-origin[d]);
            let (weight, slope) = kernel.line(f);
            let below = f.plus(kernel.reach());
            let level = d + 3 - D;
            let mut squares = R::of(0.0);
            for k in 0..N {
                weight[k].store(&mut self.weight[level][k]);
                if SLOPE {
                    squares = weight[k].fused(weight[k], squares);
                    slope[k].times(per_cell).store(&mut self.slope[level][k]);
                }
                if MOMENT {
                    let offset = (R::of(k as f64) - below).times(cell);
                    (weight[k] * offset).store(&mut self.moment[level][k]);
                }
            }
            own = own * squares;
        }
        if SLOPE {
            own.store(&mut self.own);
        }
        place.store(&mut self.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit sum, linear reproduction, second moment, and slopes that are the derivatives of the weights (1e-5: uGIMP bends within a
    /// difference of 2e-6).
    #[test]
    fn moments_and_slopes() {
        for kernel in [Kernel::Linear, Kernel::Gimp, Kernel::Quadratic, Kernel::Cubic] {
            for i in 0..57 {
                let x = -3.1 + 0.117 * i as f64;
                let (_, f) = first_node(x, 1.0, kernel.reach());
                let (weight, slope) = kernel.line(f);
                assert!(weight[kernel.nodes()..].iter().chain(&slope[kernel.nodes()..]).all(|&x| x == 0.0));
                let sum = |g: &dyn Fn(f64) -> f64| -> f64 {
                    (0..4).map(|k| weight[k] * g(k as f64 - f - kernel.reach())).sum()
                };
                assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-15);
                assert!(sum(&|r| r).abs() < 1e-15);
                let moment = kernel.moment();
                assert!(moment == 0.0 || (sum(&|r| r * r) - moment).abs() < 1e-15);
                let h = 1e-6;
                if f < h || f > 1.0 - h {
                    continue;
                }
                let (a, b) = (kernel.line(f - h).0, kernel.line(f + h).0);
                for k in 0..4 {
                    let found = (b[k] - a[k]) / (2.0 * h);
                    assert!((found - slope[k]).abs() < 1e-5, "{kernel:?} {k}: {found} {}", slope[k]);
                }
            }
        }
    }
}
