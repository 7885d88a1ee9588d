//! Between a particle and the nodes of its block's window: the inner loops, in quads of numbers a node, two nodes at a time.
//!
//! Weights are products over three levels (see [`Lines`]); sums go level by level, so that each node costs a few products.
use crate::kernel::{Lines, row, span};
use crate::window::{WINDOW, Window};
use hvi_kit::lanes::{Eight, Quads};

/// Nodes of a level with `N` an axis.
pub const fn count<const D: usize, const N: usize>(level: usize) -> usize {
    if level + D >= 3 { N } else { 1 }
}

/// Nodes from one of a level to the next in a window.
const fn stride<const D: usize>(level: usize) -> usize {
    match level {
        0 => span::<D>() * row::<D>(),
        1 => row::<D>(),
        _ => 1,
    }
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
    window: &mut Window,
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
    let window = &mut window.0[first..first + const { extent::<D, N>() }];
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

/// Each quad in both halves.
#[inline(always)]
fn all_twice<R: Eight>(quads: &[Quads; 3], lane: usize) -> [R; 3] {
    let [a, b, c] = [&quads[0][lane], &quads[1][lane], &quads[2][lane]];
    [R::quads(a, a), R::quads(b, b), R::quads(c, c)]
}

/// Sums over the nodes of eight particles, of a quad a node: a quad each.
pub struct Sums {
    /// `sum w u`
    pub mean: Quads,
    /// `sum w_level u`, with slopes in one level.
    pub slope: [Quads; 3],
    /// The same with weights times distances in one level.
    pub moment: [Quads; 3],
}

impl Sums {
    /// Nothing.
    pub const NONE: Sums = Sums { mean: [[0.0; 4]; 8], slope: [[[0.0; 4]; 8]; 3], moment: [[[0.0; 4]; 8]; 3] };

    /// Clears those of the last particles, from number `live` on.
    #[inline(always)]
    pub fn clear_after(&mut self, live: usize) {
        for lane in live..8 {
            self.mean[lane] = [0.0; 4];
            for level in 0..3 {
                (self.slope[level][lane], self.moment[level][lane]) = ([0.0; 4], [0.0; 4]);
            }
        }
    }
}

/// Sums over the nodes of one particle by the place along the last axis, two places a number: what is left to do is weight these.
struct Partial<R> {
    mean: [R; 2],
    slope: [[R; 2]; 2],
    moment: [[R; 2]; 2],
}

/// Gathers the nodes of particle `lane` into its place in `out`: the mean, with `SLOPE` the slopes, with `MOMENT` the moments.
#[inline(always)]
pub fn gather<R: Eight, const D: usize, const N: usize, const SLOPE: bool, const MOMENT: bool>(
    window: &Window,
    lines: &Lines,
    lane: usize,
    out: &mut Sums,
) {
    let lane = lane & 7;
    let first = lines.first[lane] as usize;
    let window = &window.0[first..first + const { extent::<D, N>() }];
    let zero = [R::of(0.0); 2];
    let mut sum = Partial { mean: zero, slope: [zero; 2], moment: [zero; 2] };
    for i in 0..count::<D, N>(0) {
        let (mut plane, mut slope, mut moment) = (zero, zero, zero);
        for j in 0..count::<D, N>(1) {
            let at = i * stride::<D>(0) + j * stride::<D>(1);
            let w = R::of(lines.weight[1][j][lane]);
            for k in 0..N.div_ceil(2) {
                // SAFETY: the stencil ends before `extent`, as long as the window was cut; two nodes are eight numbers.
                let u = R::load(unsafe { &*window.as_ptr().add(at + 2 * k).cast::<[f64; 8]>() });
                plane[k] = u.fused(w, plane[k]);
                if SLOPE && D >= 2 {
                    slope[k] = u.fused(R::of(lines.slope[1][j][lane]), slope[k]);
                }
                if MOMENT && D >= 2 {
                    moment[k] = u.fused(R::of(lines.moment[1][j][lane]), moment[k]);
                }
            }
        }
        let w = R::of(lines.weight[0][i][lane]);
        for k in 0..N.div_ceil(2) {
            sum.mean[k] = plane[k].fused(w, sum.mean[k]);
            if SLOPE {
                sum.slope[1][k] = slope[k].fused(w, sum.slope[1][k]);
                if D == 3 {
                    sum.slope[0][k] = plane[k].fused(R::of(lines.slope[0][i][lane]), sum.slope[0][k]);
                }
            }
            if MOMENT {
                sum.moment[1][k] = moment[k].fused(w, sum.moment[1][k]);
                if D == 3 {
                    sum.moment[0][k] = plane[k].fused(R::of(lines.moment[0][i][lane]), sum.moment[0][k]);
                }
            }
        }
    }
    let w = ends::<R, N>(&lines.weight[2], lane);
    folded::<R, N>(&sum.mean, &w, &mut out.mean[lane]);
    if SLOPE {
        folded::<R, N>(&sum.mean, &ends::<R, N>(&lines.slope[2], lane), &mut out.slope[2][lane]);
        for level in 3 - D..2 {
            folded::<R, N>(&sum.slope[level], &w, &mut out.slope[level][lane]);
        }
    }
    if MOMENT {
        folded::<R, N>(&sum.mean, &ends::<R, N>(&lines.moment[2], lane), &mut out.moment[2][lane]);
        for level in 3 - D..2 {
            folded::<R, N>(&sum.moment[level], &w, &mut out.moment[level][lane]);
        }
    }
}

/// Numbers of the nodes along the last axis, two a number; 0 past the last.
#[inline(always)]
fn ends<R: Eight, const N: usize>(of: &[[f64; 8]; 4], lane: usize) -> [R; 2] {
    let mut both = [R::of(0.0); 2];
    for k in 0..N.div_ceil(2) {
        both[k] = R::halves(of[2 * k][lane], if 2 * k + 1 < N { of[2 * k + 1][lane] } else { 0.0 });
    }
    both
}

/// The weighted sum of both halves of all.
#[inline(always)]
fn folded<R: Eight, const N: usize>(sums: &[R; 2], weights: &[R; 2], to: &mut [f64; 4]) {
    let mut sum = sums[0] * weights[0];
    if N > 2 {
        sum = sums[1].fused(weights[1], sum);
    }
    sum.fold(to);
}

/// 1 for each of the first `live` particles that shares a node with another, else 0: `sum w m_i` is more than its own `m sum w^2`.
/// `masses` of the nodes, `own` of the particles [kg].
#[inline(always)]
pub fn sharing<const D: usize, const N: usize>(
    masses: &[f64; WINDOW],
    lines: &Lines,
    own: &[f64; 8],
    live: usize,
) -> [f64; 8] {
    let mut sharing = [1.0; 8];
    for lane in 0..live {
        let first = lines.first[lane] as usize;
        let near = if N > 2 { 1 } else { 0 };
        let (mut at, mut weight) = (first, 1.0);
        for level in 3 - D..3 {
            at += near * stride::<D>(level);
            weight *= lines.weight[level][near][lane];
        }
        // Mostly one node tells: the rest of the sum is no less than the particle's own.
        let alone = own[lane] * lines.own[lane];
        if weight * (masses[at] - own[lane] * weight) > 2e-9 * alone {
            continue;
        }
        let mut sum = 0.0;
        for i in 0..count::<D, N>(0) {
            for j in 0..count::<D, N>(1) {
                let weight = lines.weight[0][i][lane] * lines.weight[1][j][lane];
                for k in 0..N {
                    let at = first + i * stride::<D>(0) + j * stride::<D>(1) + k;
                    // A kernel narrower than N nodes sees nothing of the last ones, whatever was left there.
                    if lines.weight[2][k][lane] > 0.0 && weight > 0.0 {
                        sum += weight * lines.weight[2][k][lane] * masses[at];
                    }
                }
            }
        }
        sharing[lane] = if alone * (1.0 + 1e-9) < sum { 1.0 } else { 0.0 };
    }
    sharing
}
