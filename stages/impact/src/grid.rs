//! A sparse grid without a box: blocks of nodes that exist only where particles touch them, and windows over them.
//!
//! Each step it is laid out anew in the order of the blocks of particles, so its numbers depend on the particles alone. The grid
//! keeps sums over particles; a window is a copy of the nodes around one block, in which they have become what the
//! block's particles need. Blocks of one colour share no node: they may add to the grid at the same time, and each node
//! is added to in the order of the colours.
use crate::kernel::{edge, row, span};
use crate::store::{SECOND, Site, Store};
use crate::table::Table;
use crate::task::Crew;
use std::marker::PhantomData;

/// Numbers at a node: mass [kg] and momentum [kg m/s], or force [N] after a place left free, or others in passes of their own.
pub type Node = [f64; 4];

/// Nodes in the largest window.
pub const WINDOW: usize = 7 * 7 * 8;

/// Nodes in the window of a block, the last axis running fastest in rows of [`row`].
#[repr(C, align(64))]
pub struct Window(pub [Node; WINDOW]);

/// A window of nothing.
pub const CLEAR: Window = Window([[0.0; 4]; WINDOW]);

/// The nodes that particles touch.
#[derive(Default)]
pub struct Grid<const D: usize> {
    /// Mass and momentum; once these are whole, mass and velocity.
    pub start: Vec<Node>,
    /// Force, then its change of velocity; and other sums that live shorter.
    pub force: Vec<Node>,
    /// Sums for heat conduction, by material: mass, mass times heat, mass times share.
    pub heat: Vec<Vec<Node>>,
    /// Nodes on a mirror plane, by axis.
    on_plane: [Vec<u32>; 3],
    /// Nodes next to a mirror plane and their images behind it, by axis.
    pub images: [Vec<(u32, u32)>; 3],
    blocks: Vec<[i32; D]>,
    homes: Table<D>,
}

/// Nodes of a block.
pub const fn block<const D: usize>() -> usize {
    edge::<D>().pow(D as u32)
}

impl<const D: usize> Grid<D> {
    /// Lays out zero nodes under all windows of `store`: `materials` fields of heat beside the others.
    pub fn lay_out(&mut self, store: &mut Store<D>, mirrors: &[bool; D], materials: usize) {
        self.homes.clear();
        self.blocks.clear();
        for site in store.sites.iter_mut().flatten() {
            for corner in 0..1usize << D {
                let needed = (0..D).all(|d| corner >> d & 1 == 0 || site.touched[d + 3 - D][1] as usize > edge::<D>());
                if needed {
                    let mut key = site.key;
                    (0..D).for_each(|d| key[d] += (corner >> d & 1) as i32);
                    let (home, new) = self.homes.slot(key);
                    if new {
                        self.blocks.push(key);
                    }
                    site.homes[corner] = home;
                }
            }
        }
        let count = self.blocks.len() * const { block::<D>() };
        self.heat.resize(materials, Vec::new());
        clear(&mut self.start, count);
        clear(&mut self.force, count);
        self.find_mirrors(mirrors);
    }

    /// Makes the sums of heat conduction zero.
    pub fn clear_heat(&mut self) {
        let count = self.blocks.len() * const { block::<D>() };
        self.heat.iter_mut().for_each(|field| clear(field, count));
    }

    /// Nodes next to a mirror reach behind it to one layer, whose partners in front are on the same windows.
    fn find_mirrors(&mut self, mirrors: &[bool; D]) {
        let (n, edge) = const { (block::<D>() as u32, edge::<D>() as u32) };
        for d in 0..D {
            self.on_plane[d].clear();
            self.images[d].clear();
            if !mirrors[d] {
                continue;
            }
            let stride = edge.pow((D - 1 - d) as u32);
            let along = |node: u32| node / stride % edge;
            for (b, key) in self.blocks.iter().enumerate() {
                let start = b as u32 * n;
                if key[d] == 0 {
                    self.on_plane[d].extend((0..n).filter(|&k| along(k) == 0).map(|k| start + k));
                } else if key[d] == -1 {
                    let mut front = *key;
                    front[d] = 0;
                    let Some(front) = self.homes.find(front) else { continue };
                    let last = (0..n).filter(|&k| along(k) == edge - 1);
                    self.images[d].extend(last.map(|k| (front * n + k - (edge - 2) * stride, start + k)));
                }
            }
        }
    }

    /// Adds what the mirrored half of the scene gives the nodes of `field` near each mirror plane, and copies the sum behind
    /// it. A vector's component along the mirror's normal is turned round.
    fn fold(&self, field: &mut [Node], is_vector: bool) {
        let turned = |node: Node, d: usize| if is_vector { turned(node, d) } else { node };
        for d in 0..D {
            for &n in &self.on_plane[d] {
                let node = field[n as usize];
                let image = turned(node, d);
                field[n as usize] = std::array::from_fn(|c| node[c] + image[c]);
            }
            for &(front, behind) in &self.images[d] {
                let image = turned(field[behind as usize], d);
                let node = &mut field[front as usize];
                (0..4).for_each(|c| node[c] += image[c]);
            }
        }
        for d in 0..D {
            for &(front, behind) in &self.images[d] {
                field[behind as usize] = turned(field[front as usize], d);
            }
        }
    }

    /// Copies mass and velocity behind each mirror plane.
    pub fn reflect_start(&mut self) {
        reflect(&self.images, &mut self.start);
    }

    /// Copies forces behind each mirror plane.
    pub fn reflect_force(&mut self) {
        reflect(&self.images, &mut self.force);
    }

    /// Mirrors mass and momentum.
    pub fn fold_start(&mut self) {
        let mut field = std::mem::take(&mut self.start);
        self.fold(&mut field, true);
        self.start = field;
    }

    /// Makes momenta velocities; nodes of no more than `cut` [kg] stand still.
    pub fn find_velocities(&mut self, cut: f64, crew: &mut Crew, threads: usize) {
        let count = self.blocks.len() * const { block::<D>() };
        crew.nodes(threads, &mut self.start[..count], |_, piece| {
            for node in piece {
                let [mass, x, y, z] = *node;
                let per_mass = if mass > cut { 1.0 / mass } else { 0.0 };
                *node = [mass, x * per_mass, y * per_mass, z * per_mass];
            }
        });
    }

    /// Makes forces changes of velocity in a step of `dt` [s]; nodes of no more than `cut` [kg] stand still.
    pub fn find_changes(&mut self, cut: f64, dt: f64, crew: &mut Crew, threads: usize) {
        let count = self.blocks.len() * const { block::<D>() };
        let Grid { start, force, .. } = self;
        crew.nodes(threads, &mut force[..count], |first, piece| {
            for (force, start) in piece.iter_mut().zip(&start[first..]) {
                let kick = if start[0] > cut { dt / start[0] } else { 0.0 };
                let [a, x, y, z] = *force;
                *force = [a * kick, x * kick, y * kick, z * kick];
            }
        });
    }

    /// Mirrors forces, or what else is there.
    pub fn fold_force(&mut self) {
        let mut field = std::mem::take(&mut self.force);
        self.fold(&mut field, true);
        self.force = field;
    }

    /// Mirrors the sums of heat conduction.
    pub fn fold_heat(&mut self) {
        let mut fields = std::mem::take(&mut self.heat);
        fields.iter_mut().for_each(|field| self.fold(field, false));
        self.heat = fields;
    }

    /// Nodes at the same place of the two fields, where bodies have fields of their own.
    pub fn shared(&self) -> Vec<(u32, u32)> {
        let n = const { block::<D>() as u32 };
        let mut pairs = Vec::new();
        for (b, key) in self.blocks.iter().enumerate().filter(|(_, key)| key[0] > SECOND >> 1) {
            let mut first = *key;
            first[0] -= SECOND;
            if let Some(a) = self.homes.find(first) {
                pairs.extend((0..n).map(|k| (a * n + k, b as u32 * n + k)));
            }
        }
        pairs
    }

    /// Number of node blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }
}

/// Makes the first `count` nodes of a field zero; it never shrinks.
fn clear(field: &mut Vec<Node>, count: usize) {
    field.resize(count.max(field.len()), [0.0; 4]);
    field[..count].as_flattened_mut().fill(0.0);
}

/// The image of a vector in a mirror across axis `d`.
fn turned(mut node: Node, d: usize) -> Node {
    node[d + 1] = -node[d + 1];
    node
}

fn reflect(images: &[Vec<(u32, u32)>; 3], field: &mut [Node]) {
    for (d, pairs) in images.iter().enumerate() {
        for &(front, behind) in pairs {
            field[behind as usize] = turned(field[front as usize], d);
        }
    }
}

/// Rows along the last axis of the part of a window that is touched: the row in the window, where it lies on the grid in each of the
/// two blocks it may cross, and how long.
struct Row {
    window: usize,
    grid: usize,
    length: usize,
}

/// Visits the rows of what `site` touches. A macro, since a closure would not be compiled for the lanes' processor; iterators over
/// several slices are not inlined there, so loops over rows count.
macro_rules! rows {
    ($site:ident, |$row:ident| $body:block) => {
        let (edge, span, row) = const { (edge::<D>(), span::<D>(), row::<D>()) };
        let [xs, ys, zs] = &$site.touched;
        let (start, end) = (zs[0] as usize, zs[1] as usize);
        for x in xs[0] as usize..xs[1] as usize {
            for y in ys[0] as usize..ys[1] as usize {
                for half in 0..2 {
                    let from = if half == 0 { start } else { edge.max(start) };
                    let to = if half == 0 { end.min(edge) } else { end };
                    if from < to {
                        let corner = match D {
                            1 => half,
                            2 => y / edge | half << 1,
                            _ => x / edge | y / edge << 1 | half << 2,
                        };
                        let inside = (x % edge * edge + y % edge) * edge + from - half * edge;
                        let $row = Row {
                            window: (x * span + y) * row + from,
                            grid: $site.homes[corner] as usize * const { block::<D>() } + inside,
                            length: to - from,
                        };
                        $body
                    }
                }
            }
        }
    };
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

    /// Nodes of a row.
    ///
    /// # Safety
    /// Nothing else uses them meanwhile.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "that is what the type is for; see the safety")]
    unsafe fn row(&self, row: &Row) -> &mut [Node] {
        assert!(row.grid + row.length <= self.count);
        // SAFETY: within the field, by the assertion; not used by anybody else, by the caller.
        unsafe { std::slice::from_raw_parts_mut(self.nodes.add(row.grid), row.length) }
    }

    /// Adds the window of `site`.
    ///
    /// # Safety
    /// Nothing else uses nodes of the site meanwhile; sites of one colour have none in common.
    #[inline(always)]
    pub unsafe fn add<const D: usize>(&self, site: &Site<D>, window: &Window) {
        rows!(site, |row| {
            // SAFETY: the row is the site's.
            let nodes = unsafe { self.row(&row) };
            let from = &window.0[row.window..][..row.length];
            for k in 0..row.length {
                for c in 0..4 {
                    nodes[k][c] += from[k][c];
                }
            }
        });
    }
}

/// Clears the part of `window` that `site` touches, and the pair that its last node may be read with.
#[inline(always)]
pub fn clear_window<const D: usize>(site: &Site<D>, window: &mut Window) {
    let (span, row) = const { (span::<D>(), row::<D>()) };
    let [xs, ys, zs] = &site.touched;
    let (start, end) = (zs[0] as usize, (zs[1] as usize + 1).min(row));
    for x in xs[0] as usize..xs[1] as usize {
        for y in ys[0] as usize..ys[1] as usize {
            for node in &mut window.0[(x * span + y) * row..][start..end] {
                *node = [0.0; 4];
            }
        }
    }
}

/// `[|u|^2, u]`.
#[inline(always)]
fn with_square(u: [f64; 3]) -> Node {
    [u[0] * u[0] + u[1] * u[1] + u[2] * u[2], u[0], u[1], u[2]]
}

/// Fills the window with `[|u|^2, u]` of the velocity u less `own`, and `masses` [kg].
#[inline(always)]
pub fn see_velocity<const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    own: &[f64; 3],
    window: &mut Window,
    masses: &mut [f64; WINDOW],
) {
    rows!(site, |row| {
        let from = &grid.start[row.grid..][..row.length];
        let (to, mass) = (&mut window.0[row.window..][..row.length], &mut masses[row.window..][..row.length]);
        for k in 0..row.length {
            mass[k] = from[k][0];
            to[k] = with_square([from[k][1] - own[0], from[k][2] - own[1], from[k][3] - own[2]]);
        }
    });
}

/// Fills windows with `[|u|^2, u]` of the velocity at the end of the step less `own`, or of its change through the step,
/// and with that at its middle less `own`.
#[inline(always)]
pub fn see_end<const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    change_only: bool,
    own: &[f64; 3],
    end: &mut Window,
    middle: &mut Window,
) {
    rows!(site, |row| {
        let (starts, changes) = (&grid.start[row.grid..][..row.length], &grid.force[row.grid..][..row.length]);
        let (ends, middles) = (&mut end.0[row.window..][..row.length], &mut middle.0[row.window..][..row.length]);
        for k in 0..row.length {
            let (mut last, mut half) = ([0.0; 3], [0.0; 4]);
            for c in 0..3 {
                let (v, change) = (starts[k][c + 1] - own[c], changes[k][c + 1]);
                last[c] = if change_only { change } else { v + change };
                half[c + 1] = v + 0.5 * change;
            }
            middles[k] = half;
            ends[k] = with_square(last);
        }
    });
}

/// Fills windows for [`crate::method::Transfer::Aflip`]: with v the velocity at the start of a step of `dt` [s] less `own`, a its change, e = v + a and
/// s the share of damping, `[s e.v, e]`, `[a^2 / 2, v + a / 2]`, `[s, s e]` and `[0, s v]`.
#[inline(always)]
pub fn see_blend<const D: usize>(
    site: &Site<D>,
    grid: &Grid<D>,
    dt: f64,
    own: &[f64; 3],
    [end, middle, damped, still]: &mut [Window; 4],
) {
    let per_step = 1.0 / dt;
    rows!(site, |row| {
        let (starts, changes) = (&grid.start[row.grid..][..row.length], &grid.force[row.grid..][..row.length]);
        for k in 0..row.length {
            let (start, change) = (&starts[k], &changes[k]);
            let (at, share) = (row.window + k, change[0] * per_step);
            let (mut product, mut square) = (0.0, 0.0);
            for c in 0..3 {
                let (v, a) = (start[c + 1] - own[c], change[c + 1]);
                let e = v + a;
                product += e * v;
                square += a * a;
                end.0[at][c + 1] = e;
                middle.0[at][c + 1] = v + 0.5 * a;
                damped.0[at][c + 1] = share * e;
                still.0[at][c + 1] = share * v;
            }
            end.0[at][0] = share * product;
            middle.0[at][0] = 0.5 * square;
            damped.0[at][0] = share;
            still.0[at][0] = 0.0;
        }
    });
}

/// Fills the window with `[|u|^2, u]` of means over mass of the sums in the field of forces; nodes of no more than `cut` [kg] have none.
#[inline(always)]
pub fn see_mean<const D: usize>(site: &Site<D>, grid: &Grid<D>, cut: f64, window: &mut Window) {
    rows!(site, |row| {
        let (starts, sums) = (&grid.start[row.grid..][..row.length], &grid.force[row.grid..][..row.length]);
        let to = &mut window.0[row.window..][..row.length];
        for k in 0..row.length {
            let (mass, sum) = (starts[k][0], &sums[k]);
            let per_mass = if mass > cut { 1.0 / mass } else { 0.0 };
            to[k] = with_square([sum[1] * per_mass, sum[2] * per_mass, sum[3] * per_mass]);
        }
    });
}

/// Fills the window with the share and the share times the mean of heat.
#[inline(always)]
pub fn see_heat<const D: usize>(site: &Site<D>, field: &[Node], window: &mut Window) {
    rows!(site, |row| {
        let (to, from) = (&mut window.0[row.window..][..row.length], &field[row.grid..][..row.length]);
        for k in 0..row.length {
            let [mass, heat, share, _] = from[k];
            let per_mass = if share > 0.0 { 1.0 / mass } else { 0.0 };
            let part = if share * per_mass < 1.0 { share * per_mass } else { 1.0 };
            to[k] = [part, part * (heat * per_mass), 0.0, 0.0];
        }
    });
}

/// Fills the window with a number a node.
#[inline(always)]
pub fn see_scalar<const D: usize>(site: &Site<D>, field: &[f64], window: &mut Window) {
    rows!(site, |row| {
        let (to, from) = (&mut window.0[row.window..][..row.length], &field[row.grid..][..row.length]);
        for k in 0..row.length {
            to[k] = [from[k], 0.0, 0.0, 0.0];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::Particle;
    use crate::store::Frame;

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
        unsafe { Shared::new(&mut grid.start).add(site, &window) };
        grid.fold_start();
        let mut seen = CLEAR;
        see_mean_of(site, &grid.start, &mut seen);
        assert_eq!(seen.0[node(5)], [2.0, 4.0, 5.0 - 3.0, 8.0]);
        assert_eq!(seen.0[node(4)], [2.0, 4.0, 0.0, 8.0]);
        assert_eq!(seen.0[node(3)], [2.0, 4.0, 3.0 - 5.0, 8.0]);
        assert_eq!(seen.0[node(6)], [1.0, 2.0, 6.0, 4.0]);
    }

    fn see_mean_of<const D: usize>(site: &Site<D>, field: &[Node], window: &mut Window) {
        rows!(site, |row| {
            window.0[row.window..][..row.length].copy_from_slice(&field[row.grid..][..row.length]);
        });
    }
}
