//! How far each particle is smeared: over its own matter, or up to its neighbours where a cloud has thinned.
use crate::project::size;
use hvi_impact::result::{Impact, Particles, Space};
use std::collections::BTreeMap;

/// Particles alone are smeared over at most this many cells.
const FARTHEST: i32 = 6;

type Bin = [i32; 3];

/// Neighbours that are looked at.
const NEAREST: usize = 8;

/// Side of the square or cube that each particle's mass covers on the film [m].
///
/// With `smooth`, at least the distance to the second neighbour (third in 3-D), and at least that to the eighth over what it is
/// at the corner of a lattice, in spacings: 2 sqrt(2), or 2 in 3-D. So undisturbed matter stays as it is up to its edges and
/// corners, while a stretched cloud stays a cloud instead of falling apart into lines.
pub fn sides(run: &Impact, p: &Particles, smooth: bool) -> Vec<f64> {
    let own = (0..p.mass.len()).map(|i| size(run.space, p, i, run.cell));
    if !smooth {
        return own.collect();
    }
    // A hair more than the lattice's own ratio, so that rounding of positions doesn't tell.
    let (axes, rank, reach) = if matches!(run.space, Space::Full { .. }) { (3, 3, 2.01) } else { (2, 2, 2.84) };
    let at = |i: usize| {
        let mut x = [0.0; 3];
        (0..axes).for_each(|axis| x[axis] = f64::from(p.position[axis][i]));
        x
    };
    let points: Vec<[f64; 3]> = (0..p.mass.len()).map(at).collect();
    let bins = Bins::new(&points, run.cell, axes);
    let gap = |i: usize| {
        let nearest = bins.neighbours(&points, i);
        nearest[rank - 1].max(nearest[NEAREST - 1] / reach)
    };
    own.enumerate().map(|(i, side)| side.max(gap(i))).collect()
}

/// Particles by cubes of one cell.
struct Bins {
    cell: f64,
    axes: usize,
    members: BTreeMap<Bin, Vec<u32>>,
}

impl Bins {
    fn new(points: &[[f64; 3]], cell: f64, axes: usize) -> Bins {
        let mut bins = Bins { cell, axes, members: BTreeMap::new() };
        for (i, &x) in points.iter().enumerate() {
            bins.members.entry(bins.bin(x)).or_default().push(i as u32);
        }
        bins
    }

    fn bin(&self, x: [f64; 3]) -> Bin {
        x.map(|c| (c / self.cell).floor() as i32)
    }

    /// Distances to the nearest neighbours of particle `i`, in order, each at most [`FARTHEST`] cells [m].
    fn neighbours(&self, points: &[[f64; 3]], i: usize) -> [f64; NEAREST] {
        let home = self.bin(points[i]);
        let mut nearest = [f64::from(FARTHEST) * self.cell; NEAREST];
        for ring in 0..=FARTHEST {
            // Whoever is not yet seen is farther than the bins already searched.
            if nearest[NEAREST - 1] <= f64::from(ring - 1) * self.cell {
                break;
            }
            self.search(points, i, home, ring, &mut nearest);
        }
        nearest
    }

    /// Looks through the bins `ring` steps away; `nearest` stays sorted.
    fn search(&self, points: &[[f64; 3]], i: usize, home: Bin, ring: i32, nearest: &mut [f64]) {
        let depth = if self.axes == 3 { ring } else { 0 };
        for dz in -depth..=depth {
            for dy in -ring..=ring {
                let inside = dz.abs() < ring && dy.abs() < ring;
                let step = if inside { 2 * ring.max(1) } else { 1 };
                for dx in (-ring..=ring).step_by(step as usize) {
                    let bin = [home[0].saturating_add(dx), home[1].saturating_add(dy), home[2].saturating_add(dz)];
                    for &j in self.members.get(&bin).into_iter().flatten().filter(|&&j| j as usize != i) {
                        insert(nearest, distance(points[i], points[j as usize]));
                    }
                }
            }
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

fn insert(nearest: &mut [f64], d: f64) {
    let place = nearest.partition_point(|&n| n <= d);
    if place < nearest.len() {
        nearest[place..].rotate_right(1);
        nearest[place] = d;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against looking at every pair, on points scattered over tens of cells.
    #[test]
    fn the_neighbour_is_the_right_one() {
        let mut seed = 7u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for axes in [2, 3] {
            let points: Vec<[f64; 3]> = (0..400)
                .map(|_| [20.0 * random(), 20.0 * random(), if axes == 3 { 8.0 * random() } else { 0.0 }])
                .collect();
            let bins = Bins::new(&points, 1.0, axes);
            for i in 0..points.len() {
                let mut all: Vec<f64> = points.iter().map(|&x| distance(x, points[i])).collect();
                all.sort_by(f64::total_cmp);
                let expected: Vec<f64> = all[1..=NEAREST].iter().map(|d| d.min(6.0)).collect();
                assert_eq!(bins.neighbours(&points, i).as_slice(), expected, "{axes}-D, point {i}");
            }
        }
    }
}
