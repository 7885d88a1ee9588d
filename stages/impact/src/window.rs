//! A window: a copy of the nodes around one block of particles, in which they have become what the block's particles need.
use crate::grid::{Grid, Node, block};
use crate::kernel::{edge, row, span};
use crate::store::Site;
use hvi_kit::lanes::{Eight, Quads};
use std::marker::PhantomData;

/// Nodes in the largest window.
pub const WINDOW: usize = 7 * 7 * 8;

/// Nodes in the window of a block, the last axis running fastest in rows of [`row`].
#[repr(C, align(64))]
pub struct Window(pub [Node; WINDOW]);

/// A window of nothing.
pub const CLEAR: Window = Window([[0.0; 4]; WINDOW]);

/// Four nodes side by side along the last axis, as numbers, two nodes an eight.
type Four = [[f64; 8]; 2];

/// Where four nodes lie in a window, and on the grid.
struct Piece {
    window: usize,
    grid: usize,
}

impl Piece {
    /// Its nodes among `nodes` on the grid.
    #[inline(always)]
    fn on_grid<'a>(&self, nodes: &'a [Node]) -> &'a Four {
        eights(&nodes[self.grid..self.grid + 4])
    }
    /// Its nodes in a window.
    #[inline(always)]
    fn of<'a>(&self, window: &'a mut Window) -> &'a mut Four {
        let nodes = window.0[self.window..self.window + 4].as_flattened_mut();
        nodes.as_chunks_mut().0.try_into().expect("four nodes are two eights")
    }
}

/// Four nodes as numbers.
#[inline(always)]
fn eights(nodes: &[Node]) -> &Four {
    nodes.as_flattened().as_chunks().0.try_into().expect("four nodes are two eights")
}

/// Visits what `site` touches, four nodes along the last axis at a time, with those beside them that are not touched: no block of nodes
/// and no window ends within four. A macro, since a closure would not be compiled for the lanes' processor; iterators over
/// several slices are not inlined there, so loops count.
macro_rules! pieces {
    ($site:ident, |$piece:ident| $body:block) => {
        let (edge, span, row) = const { (edge::<D>(), span::<D>(), row::<D>()) };
        let [xs, ys, zs] = &$site.touched;
        for x in xs[0] as usize..xs[1] as usize {
            for y in ys[0] as usize..ys[1] as usize {
                let inside = (x % edge * edge + y % edge) * edge;
                for z in (zs[0] as usize / 4..(zs[1] as usize).div_ceil(4)).map(|four| 4 * four) {
                    let half = z / edge;
                    let corner = match D {
                        1 => half,
                        2 => y / edge | half << 1,
                        _ => x / edge | y / edge << 1 | half << 2,
                    };
                    let home = $site.homes[corner & 7] as usize * const { block::<D>() };
                    let $piece = Piece { window: (x * span + y) * row + z, grid: home + inside + z % edge };
                    $body
                }
            }
        }
    };
}

/// Visits the planes across the first axis of what `site` touches in `window`, each with all of its rows, in eights of nodes.
macro_rules! planes {
    ($site:ident, $window:expr, |$from:ident, $eight:ident| $body:block) => {
        let (span, row) = const { (span::<D>(), row::<D>()) };
        let [xs, ys, _] = &$site.touched;
        for x in xs[0] as usize..xs[1] as usize {
            let first = (x * span + ys[0] as usize) * row / 8;
            let last = ((x * span + ys[1] as usize) * row).div_ceil(8);
            for k in first..last {
                let $from = 8 * k;
                let $eight: &mut Quads = window_eight($window, k);
                $body
            }
        }
    };
}

/// The `k`th eight nodes of a window.
#[inline(always)]
fn window_eight(window: &mut Window, k: usize) -> &mut Quads {
    window.0[8 * k..8 * k + 8].first_chunk_mut().expect("eight")
}

/// A field that several blocks of particles of one colour add to at the same time.
pub struct Shared<'a> {
    nodes: *mut Node,
    count: usize,
    field: PhantomData<&'a mut [Node]>,
}

// SAFETY: the only way in is `add`, whose callers see to it that no two threads touch the same node.
unsafe impl Sync for Shared<'_> {}

impl<'a> Shared<'a> {
    /// Over `field`.
    pub fn new(field: &'a mut [Node]) -> Self {
        Shared { nodes: field.as_mut_ptr(), count: field.len(), field: PhantomData }
    }

    /// Adds the window of `site`.
    ///
    /// # Safety
    /// Nothing else uses nodes of the site meanwhile; sites of one colour have none in common.
    #[inline(always)]
    pub unsafe fn add<R: Eight, const D: usize>(&self, site: &Site<D>, window: &mut Window) {
        pieces!(site, |piece| {
            assert!(piece.grid + 4 <= self.count);
            // SAFETY: within the field, by the assertion; four nodes are two eights; not used by anybody else, by the caller.
            let nodes = unsafe { &mut *self.nodes.add(piece.grid).cast::<Four>() };
            let from = piece.of(window);
            for k in 0..2 {
                (R::load(&nodes[k]) + R::load(&from[k])).store(&mut nodes[k]);
            }
        });
    }
}

/// Clears the part of `window` that `site` touches, and what lies beside it in its rows.
#[inline(always)]
pub fn clear_window<R: Eight, const D: usize>(site: &Site<D>, window: &mut Window) {
    planes!(site, window, |_from, nodes| {
        R::transposed([R::of(0.0); 4], nodes);
    });
}

/// Squares of the velocities of eight nodes.
#[inline(always)]
fn squares<R: Eight>([_, x, y, z]: [R; 4]) -> R {
    x * x + y * y + z * z
}

/// Puts a number of each of eight nodes first.
#[inline(always)]
fn put_first<R: Eight>(of: R, nodes: &mut Quads) {
    let mut all = [0.0; 8];
    of.store(&mut all);
    for k in 0..8 {
        nodes[k][0] = all[k];
    }
}

/// What two nodes' velocities are told apart from.
#[inline(always)]
fn twice<R: Eight>(own: &[f64; 3]) -> R {
    let own = [0.0, own[0], own[1], own[2]];
    R::quads(&own, &own)
}

/// Fills the window with `[|u|^2, u]` of the velocity u less `own`, and `masses` [kg].
#[inline(always)]
pub fn see_velocity<R: Eight, const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    own: &[f64; 3],
    window: &mut Window,
    masses: &mut [f64; WINDOW],
) {
    let own = twice::<R>(own);
    pieces!(site, |piece| {
        let (from, to) = (piece.on_grid(&grid.start), piece.of(window));
        for k in 0..2 {
            (R::load(&from[k]) - own).store(&mut to[k]);
        }
    });
    planes!(site, window, |from, nodes| {
        let columns = R::columns(nodes);
        columns[0].store(masses[from..from + 8].first_chunk_mut().expect("eight"));
        put_first(squares(columns), nodes);
    });
}

/// Fills windows with `[|u|^2, u]` of the velocity at the end of the step less `own`, or of its change through the step,
/// and with that at its middle less `own`, whose first number is of no use.
#[inline(always)]
pub fn see_end<R: Eight, const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    change_only: bool,
    own: &[f64; 3],
    end: &mut Window,
    middle: &mut Window,
) {
    let own = twice::<R>(own);
    pieces!(site, |piece| {
        let (starts, changes) = (piece.on_grid(&grid.start), piece.on_grid(&grid.force));
        let (ends, middles) = (piece.of(end), piece.of(middle));
        for k in 0..2 {
            let (v, change) = (R::load(&starts[k]) - own, R::load(&changes[k]));
            (v + change.times(0.5)).store(&mut middles[k]);
            let last = if change_only { change } else { v + change };
            last.store(&mut ends[k]);
        }
    });
    planes!(site, end, |_from, nodes| {
        put_first(squares(R::columns(nodes)), nodes);
    });
}

/// Fills windows for [`crate::method::Transfer::Aflip`]: with v the velocity at the start of a step of `dt` [s] less `own`, a its change, e = v + a and
/// s the share of damping, `[s e.v, e]`, `[a^2 / 2, v + a / 2]`, `[s, s e]` and `[0, s v]`.
#[inline(always)]
pub fn see_blend<R: Eight, const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    dt: f64,
    own: &[f64; 3],
    [end, middle, damped, still]: &mut [Window; 4],
) {
    let (own, per_step) = (twice::<R>(own), [1.0 / dt, 1.0, 1.0, 1.0]);
    let scale = R::quads(&per_step, &per_step);
    pieces!(site, |piece| {
        let (starts, changes) = (piece.on_grid(&grid.start), piece.on_grid(&grid.force));
        let (v, a) = (piece.of(still), piece.of(damped));
        for k in 0..2 {
            (R::load(&starts[k]) - own).store(&mut v[k]);
            (R::load(&changes[k]) * scale).store(&mut a[k]);
        }
    });
    planes!(site, still, |from, nodes| {
        let ([_, vx, vy, vz], k, zero) = (R::columns(nodes), from / 8, R::of(0.0));
        let [share, x, y, z] = R::columns(window_eight(damped, k));
        let (ex, ey, ez) = (vx + x, vy + y, vz + z);
        let square = squares([zero, x, y, z]).times(0.5);
        R::transposed([share * (ex * vx + ey * vy + ez * vz), ex, ey, ez], window_eight(end, k));
        R::transposed([square, vx + x.times(0.5), vy + y.times(0.5), vz + z.times(0.5)], window_eight(middle, k));
        R::transposed([share, share * ex, share * ey, share * ez], window_eight(damped, k));
        R::transposed([zero, share * vx, share * vy, share * vz], nodes);
    });
}

/// Fills the window with `[|u|^2, u]` of means over mass of the sums in the field of forces; nodes of no more than `cut` [kg] have none.
#[inline(always)]
pub fn see_mean<R: Eight, const D: usize>(site: &Site<D>, grid: &Grid<D>, cut: f64, window: &mut Window) {
    pieces!(site, |piece| {
        for k in 0..4 {
            let (mass, [_, x, y, z]) = (grid.start[piece.grid + k][0], grid.force[piece.grid + k]);
            let per_mass = if mass > cut { 1.0 / mass } else { 0.0 };
            window.0[piece.window + k] = [0.0, x * per_mass, y * per_mass, z * per_mass];
        }
    });
    planes!(site, window, |_from, nodes| {
        put_first(squares(R::columns(nodes)), nodes);
    });
}

/// Fills the window with the share and the share times the mean of heat.
#[inline(always)]
pub fn see_heat<R: Eight, const D: usize>(site: &Site<D>, field: &[Node], window: &mut Window) {
    pieces!(site, |piece| {
        let (from, to) = (piece.on_grid(field), piece.of(window));
        for k in 0..2 {
            R::load(&from[k]).store(&mut to[k]);
        }
    });
    planes!(site, window, |_from, nodes| {
        let ([mass, heat, share, _], zero) = (R::columns(nodes), R::of(0.0));
        let per_mass = (R::of(1.0) / mass).where_less(zero, share, zero);
        let part = (share * per_mass).at_most(1.0);
        R::transposed([part, part * (heat * per_mass), zero, zero], nodes);
    });
}

/// Fills the window with a number a node.
#[inline(always)]
pub fn see_scalar<const D: usize>(site: &Site<D>, field: &[f64], window: &mut Window) {
    pieces!(site, |piece| {
        for k in 0..4 {
            window.0[piece.window + k] = [field[piece.grid + k], 0.0, 0.0, 0.0];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Particle;
    use crate::store::{Frame, Store};
    use hvi_kit::lanes::Plain;

    /// What is added behind a mirror arrives in front of it, turned round, and what is on it is its own image.
    #[test]
    fn mirrors_fold() {
        let frame = Frame { cell: 1.0, reach: 1.0, apart: false };
        let one = Particle::<3>::new([0.5; 3], [0.0; 3], 1.0, 1.0, 0, 0);
        let mut store = Store::new(&[one], frame).0;
        store.touch(4);
        let mut grid = Grid::<3>::default();
        grid.lay_out(&mut store, &[false, true, false], 0);
        let mut window = CLEAR;
        // Its nodes along y lie at -1, 0, 1, 2: the last three nodes of the block's window and one beyond.
        let node = |y: usize| (3 * 7 + y) * 8 + 3;
        for y in 3..7 {
            window.0[node(y)] = [1.0, 2.0, y as f64, 4.0];
        }
        let site = store.sites.iter().flatten().next().expect("one");
        // SAFETY: nothing else uses the field.
        unsafe { Shared::new(&mut grid.start).add::<Plain, 3>(site, &mut window) };
        grid.fold_start();
        let mut seen = CLEAR;
        see_mean_of(site, &grid.start, &mut seen);
        assert_eq!(seen.0[node(5)], [2.0, 4.0, 5.0 - 3.0, 8.0]);
        assert_eq!(seen.0[node(4)], [2.0, 4.0, 0.0, 8.0]);
        assert_eq!(seen.0[node(3)], [2.0, 4.0, 3.0 - 5.0, 8.0]);
        assert_eq!(seen.0[node(6)], [1.0, 2.0, 6.0, 4.0]);
    }

    fn see_mean_of<const D: usize>(site: &Site<D>, field: &[Node], window: &mut Window) {
        pieces!(site, |piece| {
            *piece.of(window) = *piece.on_grid(field);
        });
    }
}
