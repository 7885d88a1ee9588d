//! Neighbour lists: each pair within cut-off and skin once, in rows of eight, built from cells with sorted atoms.
use crate::lanes::{Kernel, Lanes};
use serde::{Deserialize, Serialize};

/// Where a row's last vector isn't full it names the atom past the last, which stands infinitely far from all others.
pub const NOWHERE: [f64; 4] = [1e100, 1e100, 1e100, 0.0];

/// A box of fewer layers of cells counts as one layer: the wait for the lowest would leave little to gain.
const LEAST_LAYERS: usize = 8;

/// The neighbours of each atom on one side of it (see [`Build`]), those within the cut-off first.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct List {
    /// Atom i has the vectors `start[i]..start[i + 1]`: `[atoms + 1]`.
    pub start: Vec<u32>,
    /// Neighbours by eight; `atoms` where there is none.
    pub vectors: Vec<[u32; 8]>,
    /// Layer k, from below, holds the atoms `layer_start[k]..layer_start[k + 1]`: `[layers + 1]`.
    pub layer_start: Vec<u32>,
    /// Whether atom i is so near a face of the box that neighbours can be images: `[atoms]`.
    pub wraps: Vec<bool>,
}

/// Cells over the periodic box, cell `(z m_y + y) m_x + x`, and the atoms in them.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Cells along each edge.
    per_edge: [usize; 3],
    /// Atoms of cell c, after sorting: `first[c]..first[c + 1]`.
    first: Vec<u32>,
    /// The old index of each sorted atom.
    pub order: Vec<u32>,
}

impl Cells {
    /// Sorts atoms at `position`, all within `[0, edges)`, into cells of at least half of `reach`.
    pub fn sort(position: &[[f64; 4]], edges: [f64; 3], reach: f64) -> Cells {
        let m = edges.map(|edge| ((2.0 * edge / reach) as usize).max(1));
        let along = |p: &[f64; 4], k: usize| ((p[k] / edges[k] * m[k] as f64) as usize).min(m[k] - 1);
        let index = |p: &[f64; 4]| (along(p, 2) * m[1] + along(p, 1)) * m[0] + along(p, 0);
        let cell: Vec<usize> = position.iter().map(index).collect();
        let all = m[0] * m[1] * m[2];
        let mut first = vec![0u32; all + 1];
        for &c in &cell {
            first[c + 1] += 1;
        }
        for c in 0..all {
            first[c + 1] += first[c];
        }
        let (mut next, mut order) = (first.clone(), vec![0; position.len()]);
        for (i, &c) in cell.iter().enumerate() {
            order[next[c] as usize] = i as u32;
            next[c] += 1;
        }
        Cells { per_edge: m, first, order }
    }

    /// First atoms of the layers of cells, and the number of atoms at the end; a box of few layers is one.
    fn layers(&self) -> Vec<u32> {
        let [x, y, z] = self.per_edge;
        let cells = if z < LEAST_LAYERS { x * y * z } else { x * y };
        self.first.iter().step_by(cells).copied().collect()
    }

    /// Indices along axis `axis` that can hold neighbours of cell `c`: itself, two below, and two above unless `below_only`.
    fn range(&self, axis: usize, c: usize, below_only: bool) -> Vec<usize> {
        let m = self.per_edge[axis];
        if m < 5 {
            return (0..m).collect();
        }
        let last = if below_only { 2 } else { 4 };
        let mut range: Vec<usize> = (0..=last).map(|d| (c + m + d - 2) % m).collect();
        range.sort_unstable();
        range
    }

    /// Runs of sorted atoms that can be in the rows of cell (x, y, z), in ascending order.
    fn runs(&self, [x, y, z]: [usize; 3], runs: &mut Vec<(u32, u32)>) {
        runs.clear();
        let (xs, ys) = (self.range(0, x, false), self.range(1, y, false));
        for cz in self.range(2, z, true) {
            for &cy in &ys {
                for &cx in &xs {
                    let c = (cz * self.per_edge[1] + cy) * self.per_edge[0] + cx;
                    let run = (self.first[c], self.first[c + 1]);
                    match runs.last_mut() {
                        Some(last) if last.1 == run.0 => last.1 = run.1,
                        _ => runs.push(run),
                    }
                }
            }
        }
    }
}

/// Builds a [`List`] from sorted atoms.
///
/// A pair belongs to the atom above: the one with greater z of the two nearest images, with ties by y and then x.
/// In a crystal all rows are then equally long, and vectors of eight well filled.
pub struct Build<'a> {
    /// The list to fill.
    pub list: &'a mut List,
    /// Sorted positions, `[atoms]` at least.
    pub position: &'a [[f64; 4]],
    /// Their cells.
    pub cells: &'a Cells,
    /// Edges of the periodic box [angstrom].
    pub edges: [f64; 3],
    /// Cut-off and cut-off with skin, squared [angstrom2].
    pub squares: [f64; 2],
}

impl Kernel for Build<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let n = self.cells.order.len();
        // NaN past the end: compares as out of reach
        let axis = |k: usize| self.position[..n].iter().map(|p| p[k]).chain([f64::NAN; 8]).collect::<Vec<f64>>();
        let axes = [axis(0), axis(1), axis(2)];
        let [ex, ey, ez] = self.edges;
        let (along_x, along_y) = ([l.splat(ex), l.splat(1.0 / ex)], [l.splat(ey), l.splat(1.0 / ey)]);
        let along_z = [l.splat(ez), l.splat(1.0 / ez)];
        let (near2, far2, zero) = (l.splat(self.squares[0]), l.splat(self.squares[1]), l.splat(0.0));
        let (mut near, mut far) = (vec![0u32; n + 8], vec![0u32; n + 8]);
        let (mut runs, m) = (Vec::new(), self.cells.per_edge);
        self.list.start.clear();
        self.list.vectors.clear();
        let (reach, edges) = (self.squares[1].sqrt(), self.edges);
        let near_face = |p: &[f64; 4]| (0..3).any(|k| p[k] < reach || p[k] > edges[k] - reach);
        self.list.wraps.clear();
        self.list.wraps.extend(self.position[..n].iter().map(near_face));
        self.list.start.push(0);
        self.list.layer_start = self.cells.layers();
        for c in 0..m[0] * m[1] * m[2] {
            self.cells.runs([c % m[0], c / m[0] % m[1], c / m[0] / m[1]], &mut runs);
            for i in self.cells.first[c] as usize..self.cells.first[c + 1] as usize {
                let at = [l.splat(axes[0][i]), l.splat(axes[1][i]), l.splat(axes[2][i])];
                let (mut nears, mut fars) = (0, 0);
                for &(from, to) in &runs {
                    let mut j = from;
                    while j < to {
                        let dx = nearest_image(l, at[0], eight(&axes[0], j as usize), along_x);
                        let dy = nearest_image(l, at[1], eight(&axes[1], j as usize), along_y);
                        let dz = nearest_image(l, at[2], eight(&axes[2], j as usize), along_z);
                        let r2 = l.fma(dz, dz, l.fma(dy, dy, l.mul(dx, dx)));
                        let within = l.less(r2, far2) & if to - j < 8 { (1 << (to - j)) - 1 } else { 255 };
                        if within != 0 {
                            let (up, level) = (l.less(zero, dz), !(l.less(zero, dz) | l.less(dz, zero)));
                            let (right, abreast) = (l.less(zero, dy), !(l.less(zero, dy) | l.less(dy, zero)));
                            let mine = within & (up | level & (right | abreast & l.less(zero, dx)));
                            let close = l.less(r2, near2);
                            nears += l.compress(eight_mut(&mut near, nears), j, mine & close);
                            fars += l.compress(eight_mut(&mut far, fars), j, mine & !close);
                        }
                        j += 8;
                    }
                }
                near[nears..nears + fars].copy_from_slice(&far[..fars]);
                self.list.push(n as u32, &mut near, nears + fars);
            }
        }
    }
}

/// `at - other` along one axis, of the nearest images. (No closure: kernels' code must be inlined whole.)
#[inline(always)]
fn nearest_image<L: Lanes>(l: L, at: L::F, other: &[f64; 8], [edge, per_edge]: [L::F; 2]) -> L::F {
    let d = l.sub(at, l.load(other));
    l.fnma(l.round(l.mul(d, per_edge)), edge, d)
}

impl List {
    /// Vectors of atom `i`.
    #[inline(always)]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// Number of layers.
    #[inline(always)]
    pub fn layers(&self) -> usize {
        self.layer_start.len() - 1
    }

    /// How many layers below its own (and below the lowest those at the top) a row can reach.
    #[inline(always)]
    pub fn lag(&self) -> usize {
        if self.layers() == 1 { 0 } else { 2 }
    }

    /// Atoms of layer `k`.
    #[inline(always)]
    pub fn layer(&self, k: usize) -> std::ops::Range<usize> {
        self.layer_start[k] as usize..self.layer_start[k + 1] as usize
    }

    /// Vectors of the rows of atoms `rows`.
    pub fn vectors_of(&self, rows: std::ops::Range<usize>) -> std::ops::Range<usize> {
        self.start[rows.start] as usize..self.start[rows.end] as usize
    }

    /// Appends the first `length` of `row` as a row, its last vector filled up with `nobody`.
    #[inline(always)]
    fn push(&mut self, nobody: u32, row: &mut [u32], length: usize) {
        let vectors = length.div_ceil(8);
        row[length..8 * vectors].fill(nobody);
        self.vectors.extend((0..vectors).map(|v| *eight_mut(row, 8 * v)));
        self.start.push(self.vectors.len() as u32);
    }
}

#[inline(always)]
fn eight(all: &[f64], from: usize) -> &[f64; 8] {
    all[from..from + 8].try_into().expect("eight of them")
}

#[inline(always)]
fn eight_mut(all: &mut [u32], from: usize) -> &mut [u32; 8] {
    (&mut all[from..from + 8]).try_into().expect("eight of them")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Isa, run};
    use crate::lattice;

    /// Every pair within reach, found by looking at all of them, is in the list exactly once; small boxes look at all
    /// atoms, large ones (7 cubic cells, 8 list cells an edge) at the cells around, long ones at either by axis.
    #[test]
    fn each_pair_is_listed_once() {
        for cells in [[4, 4, 4], [7, 7, 7], [4, 5, 7]] {
            let edges = cells.map(|n| 3.6 * n as f64);
            let mut position: Vec<[f64; 4]> = lattice::block(cells, [3.6; 3])
                .iter()
                .enumerate()
                .map(|(k, s)| {
                    let shake = |axis: usize| 0.2 * ((k * (axis + 2) * 7919 % 1000) as f64 / 1000.0 - 0.5);
                    let at = |axis: usize| (s[axis] + shake(axis)).rem_euclid(edges[axis]);
                    [at(0), at(1), at(2), 0.0]
                })
                .collect();
            let sorted = Cells::sort(&position, edges, 6.0);
            position = sorted.order.iter().map(|&i| position[i as usize]).collect();
            let mut list = List::default();
            let squares = [5.5 * 5.5, 36.0];
            run(Isa::best(), Build { list: &mut list, position: &position, cells: &sorted, edges, squares });
            let mut listed = Vec::new();
            for i in 0..position.len() {
                let row = &list.vectors[list.start[i] as usize..list.start[i + 1] as usize];
                let atoms: Vec<usize> = row.as_flattened().iter().map(|&j| j as usize).collect();
                listed.extend(atoms.iter().filter(|&&j| j < position.len()).map(|&j| (i.min(j), i.max(j))));
            }
            let distance2 = |a: [f64; 4], b: [f64; 4]| {
                let d = [0, 1, 2].map(|k| a[k] - b[k] - edges[k] * ((a[k] - b[k]) / edges[k]).round());
                d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
            };
            let mut expected = Vec::new();
            for i in 0..position.len() {
                expected.extend(
                    (i + 1..position.len()).filter(|&j| distance2(position[i], position[j]) < 36.0).map(|j| (i, j)),
                );
            }
            listed.sort_unstable();
            assert_eq!(listed, expected);
        }
    }
}
