//! Crystal or not, atom by atom: how well the nearest neighbours lie where a face-centred crystal has them.
//!
//! J. R. Morris and X. Song, J. Chem. Phys. 116, 9352 (2002), eq 5, with the four {111} reciprocal lattice vectors G, for which
//! exp(i G.r) is 1 for every lattice vector: the square of its mean over the nearest neighbours' vectors r, averaged with
//! theirs. The lattice's direction must be known: it is that of the box.
use crate::system::System;
use hvi_kit::math::{cos, sin};

/// Above this an atom is crystalline: half way between what hot copper crystals and their melts have (see the tests).
pub const LEAST: f64 = 0.25;
/// Neighbours are nearest up to this distance, over that of nearest sites: half way to the second shell.
const NEAREST: f64 = 1.207;

/// The order parameter of each atom of `system`, in its present order, against a lattice of cubic edges `lattice` [angstrom]
/// along the box: `[atoms]`, 1 in a crystal at rest, near 0 in a liquid.
pub fn of(system: &System, lattice: [f64; 3]) -> Vec<f64> {
    let positions: Vec<[f64; 3]> = system.positions().collect();
    of_positions(&positions, system.edges(), lattice)
}

/// As [`of`], of atoms at `positions` in a periodic box of edges `edges` [angstrom].
pub fn of_positions(positions: &[[f64; 3]], edges: [f64; 3], lattice: [f64; 3]) -> Vec<f64> {
    let shortest = lattice.into_iter().fold(f64::MAX, f64::min);
    let near = neighbours(positions, edges, NEAREST * std::f64::consts::FRAC_1_SQRT_2 * shortest);
    let own: Vec<f64> = near.iter().map(|n| bragg(n.iter().map(|(_, r)| *r), lattice)).collect();
    let smooth = |(i, n): (usize, &Vec<(usize, [f64; 3])>)| {
        (own[i] + n.iter().map(|(j, _)| own[*j]).sum::<f64>()) / (n.len() + 1) as f64
    };
    near.iter().enumerate().map(smooth).collect()
}

/// Square of the mean of exp(i G.r) over the vectors `around` and the four {111} vectors G.
fn bragg(around: impl ExactSizeIterator<Item = [f64; 3]>, lattice: [f64; 3]) -> f64 {
    let count = around.len() as f64;
    if count == 0.0 {
        return 0.0;
    }
    let (mut re, mut im) = (0.0, 0.0);
    for r in around {
        let phase = [0, 1, 2].map(|k| std::f64::consts::TAU * r[k] / lattice[k]);
        let (c, s) = (phase.map(cos), phase.map(sin));
        // the sum of exp(i(+-p +-q + r)) over the four signs is 4 cos p cos q exp(i r)
        re += c[0] * c[1] * c[2];
        im += c[0] * c[1] * s[2];
    }
    (re * re + im * im) / (count * count)
}

/// Each atom's neighbours within `reach`, and the vectors to them [angstrom].
fn neighbours(positions: &[[f64; 3]], edges: [f64; 3], reach: f64) -> Vec<Vec<(usize, [f64; 3])>> {
    let m = edges.map(|e| ((e / reach) as usize).max(1));
    let index = |p: &[f64; 3]| {
        let at = [0, 1, 2].map(|k| {
            let share = p[k] / edges[k];
            (((share - share.floor()) * m[k] as f64) as usize).min(m[k] - 1)
        });
        (at[2] * m[1] + at[1]) * m[0] + at[0]
    };
    let mut cells = vec![Vec::new(); m[0] * m[1] * m[2]];
    positions.iter().enumerate().for_each(|(i, p)| cells[index(p)].push(i));
    let around = |c: usize, m: usize| {
        let mut all = vec![(c + m - 1) % m, c, (c + 1) % m];
        all.sort_unstable();
        all.dedup();
        all
    };
    let vector = |i: usize, j: usize| {
        [0, 1, 2].map(|k| {
            let d = positions[j][k] - positions[i][k];
            d - edges[k] * (d / edges[k]).round()
        })
    };
    let of = |i: usize| {
        let c = index(&positions[i]);
        let mut near = Vec::with_capacity(16);
        for z in around(c / m[0] / m[1], m[2]) {
            for y in around(c / m[0] % m[1], m[1]) {
                for x in around(c % m[0], m[0]) {
                    for &j in cells[(z * m[1] + y) * m[0] + x].iter().filter(|&&j| j != i) {
                        let r = vector(i, j);
                        if r[0] * r[0] + r[1] * r[1] + r[2] * r[2] < reach * reach {
                            near.push((j, r));
                        }
                    }
                }
            }
        }
        near
    };
    (0..positions.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::random::Random;
    use hvi_kit::math::exp;

    /// 1 at rest. With sites shaken by a normal u, w = 2 pi u/a: the neighbours' u leave exp(-3 w^2), an atom's own
    /// ((1 + exp(-2 w^2))/2)^2, and twelve neighbours a noise of a twelfth of what is lost. Scattered atoms have that noise alone.
    #[test]
    fn crystals_and_scattered_atoms_are_told_apart() {
        let (a, mut random) = (3.6, Random::new(3));
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
        let edges = [6.0 * a, 6.0 * a, 8.0 * a];
        let sites = lattice::block([6, 6, 8], [a; 3]);
        assert!(of_positions(&sites, edges, [a; 3]).iter().all(|o| (o - 1.0).abs() < 1e-12));
        let shaken: Vec<[f64; 3]> = sites.iter().map(|s| s.map(|x| x + 0.17 * random.normal())).collect();
        let wave = std::f64::consts::TAU / a * 0.17;
        let (others, own) = (exp(-3.0 * wave * wave), 0.5 * (1.0 + exp(-2.0 * wave * wave)));
        let (found, expected) = (mean(&of_positions(&shaken, edges, [a; 3])), others * own * own);
        assert!((found - expected).abs() < 0.05, "{found} {expected}");
        let scattered: Vec<[f64; 3]> = sites.iter().map(|_| edges.map(|e| e * random.uniform())).collect();
        assert!(mean(&of_positions(&scattered, edges, [a; 3])) < 0.1);
    }
}
