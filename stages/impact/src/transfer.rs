//! Between a particle and the nodes of its block's window: the inner loops, in quads of numbers a node, two nodes at a time.
//!
//! Weights are products over three levels (see [`Lines`]); sums go level by level, so that each node costs a few products.
use crate::grid::Node;
use crate::kernel::{Lines, span};
use hvi_kit::lanes::{Eight, Quads};

/// Nodes of a level with `N` an axis.
pub const fn count<const D: usize, const N: usize>(level: usize) -> usize {
    if level + D >= 3 { N } else { 1 }
}

/// Nodes from one of a level to the next in a window.
const fn stride<const D: usize>(level: usize) -> usize {
    span::<D>().pow(2 - level as u32)
}

/// Nodes from the first of a stencil to the end of its last pair.
const fn extent<const D: usize, const N: usize>() -> usize {
    (count::<D, N>(0) - 1) * stride::<D>(0) + (count::<D, N>(1) - 1) * stride::<D>(1) + N.next_multiple_of(2)
}

/// Weights that go with the gradient of a field or with distance.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Slopes.
    Slope,
    /// Weights times distances.
    Moment,
}

impl Lines {
    #[inline(always)]
    fn by(&self, by: By) -> &[[[f64; 8]; 4]; 3] {
        match by {
            By::Slope => &self.slope,
            By::Moment => &self.moment,
        }
    }
}

/// Adds `w constant + sum over levels (w with the other weights in that level) linear` to the nodes of particle `lane`.
/// Without `LINEAR` the second part is nothing.
#[inline(always)]
pub fn spread<R: Eight, const D: usize, const N: usize, const LINEAR: bool>(
    window: &mut [Node],
    lines: &Lines,
    lane: usize,
    by: By,
    constant: &Quads,
    linear: &[Quads; 3],
) {
    // No other lane: so that no index needs a look.
    let lane = lane & 7;
    let (w, g) = (&lines.weight, lines.by(by));
    let first = lines.first[lane] as usize;
    let window = &mut window[first..first + const { extent::<D, N>() }];
    let constant = R::quads(&constant[lane], &constant[lane]);
    let mut rows = [R::of(0.0); 2];
    let mut along = [[R::of(0.0); 2]; 2];
    let [a, b, c]: [R; 3] = all_twice(linear, lane);
    for k in 0..N.div_ceil(2) {
        let (low, high) = (2 * k, 2 * k + 1);
        let weight = R::halves(w[2][low][lane], if high < N { w[2][high][lane] } else { 0.0 });
        rows[k] = weight * constant;
        if LINEAR {
            let other = R::halves(g[2][low][lane], if high < N { g[2][high][lane] } else { 0.0 });
            rows[k] = other.fused(c, rows[k]);
            along[k] = [weight * a, weight * b];
        }
    }
    for i in 0..count::<D, N>(0) {
        let (mut plane, mut tilt) = ([R::of(0.0); 2], [R::of(0.0); 2]);
        for k in 0..N.div_ceil(2) {
            let weight = R::of(w[0][i][lane]);
            plane[k] = rows[k] * weight;
            if LINEAR {
                if D == 3 {
                    plane[k] = along[k][0].fused(R::of(g[0][i][lane]), plane[k]);
                }
                tilt[k] = along[k][1] * weight;
            }
        }
        for j in 0..count::<D, N>(1) {
            let at = i * stride::<D>(0) + j * stride::<D>(1);
            for k in 0..N.div_ceil(2) {
                // SAFETY: the stencil ends before `extent`, as long as the window was cut.
                let nodes = unsafe { window.get_unchecked_mut(at + 2 * k..at + 2 * k + 2) };
                // SAFETY: two nodes are eight numbers.
                let nodes = unsafe { &mut *nodes.as_mut_ptr().cast::<[f64; 8]>() };
                let mut sum = plane[k].fused(R::of(w[1][j][lane]), R::load(nodes));
                if LINEAR && D >= 2 {
                    sum = tilt[k].fused(R::of(g[1][j][lane]), sum);
                }
                sum.store(nodes);
            }
        }
    }
}

/// The numbers of nodes j and j + 1, 0 for the second where it is not paired.
#[inline(always)]
fn both<R: Eight>(of: &[[f64; 8]; 4], lane: usize, j: usize, paired: bool) -> R {
    R::halves(of[j][lane], if paired { of[j + 1][lane] } else { 0.0 })
}

/// Each quad in both halves.
#[inline(always)]
fn all_twice<R: Eight>(quads: &[Quads; 3], lane: usize) -> [R; 3] {
    let [a, b, c] = [&quads[0][lane], &quads[1][lane], &quads[2][lane]];
    [R::quads(a, a), R::quads(b, b), R::quads(c, c)]
}

/// Which square a gather sums up too.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Square {
    /// None.
    Nothing,
    /// Of the field.
    Field,
    /// Of an affine field less the field.
    Affine,
}

/// Sums over the nodes of eight particles, of a field u less the particle's own: a quad each.
pub struct Sums {
    /// `sum w u`
    pub mean: Quads,
    /// `sum w_level u`, with slopes or moments in one level.
    pub linear: [Quads; 3],
    /// `sum w |..|^2`, component by component.
    pub square: Quads,
}

impl Sums {
    /// Nothing.
    pub const NONE: Sums = Sums { mean: [[0.0; 4]; 8], linear: [[[0.0; 4]; 8]; 3], square: [[0.0; 4]; 8] };
}

/// Gathers the nodes of particle `lane` into its place in `out`; `own` is taken off each node, `affine` by level is the field for [`Square::Affine`].
#[inline(always)]
pub fn gather<R: Eight, const D: usize, const N: usize>(
    window: &[Node],
    lines: &Lines,
    lane: usize,
    by: By,
    square: Square,
    own: &Quads,
    affine: &[Quads; 3],
    out: &mut Sums,
) {
    let lane = lane & 7;
    let zero = R::of(0.0);
    let (w, g, x) = (&lines.weight, lines.by(by), &lines.offset);
    let first = lines.first[lane] as usize;
    let window = &window[first..first + const { extent::<D, N>() }];
    let own = R::quads(&own[lane], &own[lane]);
    let [a, b, c]: [R; 3] = all_twice(affine, lane);
    let (mut mean, mut linear, mut squares) = (zero, [zero; 3], zero);
    for i in 0..count::<D, N>(0) {
        let (mut plane, mut plane_1, mut plane_2, mut plane_square) = (zero, zero, zero, zero);
        for pair in 0..count::<D, N>(1).div_ceil(2) {
            let j = 2 * pair;
            let paired = j + 1 < count::<D, N>(1);
            let other = if paired { j + 1 } else { j };
            let rows = [i * stride::<D>(0) + j * stride::<D>(1), i * stride::<D>(0) + other * stride::<D>(1)];
            let mut start = zero;
            if square == Square::Affine {
                start = (a * R::of(x[0][i][lane])) + b * R::halves(x[1][j][lane], x[1][other][lane]);
            }
            let (mut row, mut row_2, mut row_square) = (zero, zero, zero);
            for k in 0..N {
                // SAFETY: the stencil ends before `extent`, as long as the window was cut.
                let (low, high) = unsafe { (window.get_unchecked(rows[0] + k), window.get_unchecked(rows[1] + k)) };
                let u = R::quads(low, high) - own;
                let weight = R::of(w[2][k][lane]);
                row_2 = u.fused(R::of(g[2][k][lane]), row_2);
                if square == Square::Field {
                    let weighted = u * weight;
                    row = row + weighted;
                    row_square = weighted.fused(u, row_square);
                } else {
                    row = u.fused(weight, row);
                }
                if square == Square::Affine {
                    let apart = c.fused(R::of(x[2][k][lane]), start) - u;
                    row_square = (apart * weight).fused(apart, row_square);
                }
            }
            let weight = both::<R>(&w[1], lane, j, paired);
            plane = row.fused(weight, plane);
            plane_2 = row_2.fused(weight, plane_2);
            if D >= 2 {
                plane_1 = row.fused(both(&g[1], lane, j, paired), plane_1);
            }
            plane_square = row_square.fused(weight, plane_square);
        }
        let weight = R::of(w[0][i][lane]);
        mean = plane.fused(weight, mean);
        linear[1] = plane_1.fused(weight, linear[1]);
        linear[2] = plane_2.fused(weight, linear[2]);
        if D == 3 {
            linear[0] = plane.fused(R::of(g[0][i][lane]), linear[0]);
        }
        squares = plane_square.fused(weight, squares);
    }
    mean.fold(&mut out.mean[lane]);
    for level in 3 - D..3 {
        linear[level].fold(&mut out.linear[level][lane]);
    }
    if square != Square::Nothing {
        squares.fold(&mut out.square[lane]);
    }
}
