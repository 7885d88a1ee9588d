//! How much of a box is empty: a crystal or melt that is stretched too far tears, and its average is that of no phase.
use hvi_kit::math::cbrt;

/// Above this share of voids a state is torn. Crystals have none, with a vacancy or without; points scattered at random, which no
/// fluid of atoms is, 0.0007.
pub const TORN: f64 = 0.01;
/// A place is void where no atom is so near, over the edge of an atom's share of the volume. The hole of a vacancy reaches 1.12.
const REACH: f64 = 1.2;
/// Least number of places along an edge that are looked at; there are no fewer than atoms.
const LEAST: usize = 16;

/// The share of a periodic box of edges `edges` that is farther than [`REACH`] from each of the atoms at `positions` [angstrom].
pub fn share(positions: &[[f64; 3]], edges: [f64; 3]) -> f64 {
    let reach = REACH * cbrt(edges[0] * edges[1] * edges[2] / positions.len() as f64);
    let cells = Cells::new(positions, edges, reach);
    let along = (cbrt(positions.len() as f64).ceil() as usize).max(LEAST);
    let mut empty = 0usize;
    for place in 0..along * along * along {
        let index = [place % along, place / along % along, place / along / along];
        let at = [0, 1, 2].map(|k| (index[k] as f64 + 0.5) / along as f64 * edges[k]);
        empty += usize::from(!cells.any_within(at, reach));
    }
    empty as f64 / (along * along * along) as f64
}

/// Atoms by cells that are no narrower than the reach, unless the box is.
struct Cells<'a> {
    positions: &'a [[f64; 3]],
    edges: [f64; 3],
    /// Cells along each edge.
    count: [usize; 3],
    /// Atoms of cell (x, y, z): `[(z count_y + y) count_x + x]`.
    atoms: Vec<Vec<u32>>,
}

impl<'a> Cells<'a> {
    fn new(positions: &'a [[f64; 3]], edges: [f64; 3], reach: f64) -> Cells<'a> {
        let count = edges.map(|e| ((e / reach) as usize).max(1));
        let mut cells = Cells { positions, edges, count, atoms: vec![Vec::new(); count[0] * count[1] * count[2]] };
        for (i, p) in positions.iter().enumerate() {
            let [x, y, z] = cells.cell(p);
            cells.atoms[(z * count[1] + y) * count[0] + x].push(i as u32);
        }
        cells
    }

    fn cell(&self, p: &[f64; 3]) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let share = p[k] / self.edges[k];
            (((share - share.floor()) * self.count[k] as f64) as usize).min(self.count[k] - 1)
        })
    }

    /// Whether any atom is within `reach` of `at`, images counted.
    fn any_within(&self, at: [f64; 3], reach: f64) -> bool {
        let own = self.cell(&at);
        // The cell itself first: mostly there is an atom in it.
        let around = |k: usize| [0, 1, self.count[k] - 1].map(|d| (own[k] + d) % self.count[k]);
        let near = |&i: &u32| {
            let d = [0, 1, 2].map(|k| {
                let d = self.positions[i as usize][k] - at[k];
                d - self.edges[k] * (d / self.edges[k]).round()
            });
            d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= reach * reach
        };
        around(2).into_iter().any(|z| {
            around(1).into_iter().any(|y| {
                around(0).into_iter().any(|x| self.atoms[(z * self.count[1] + y) * self.count[0] + x].iter().any(near))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::random::Random;

    /// None in a crystal, shaken or not, nor in one with a vacancy; exp(-4/3 pi 1.2^3) = 7e-4 among points scattered at random,
    /// whose number within reach is Poisson's; and of a box with an empty slab on top its share, less what lies within reach
    /// of the atoms on both sides.
    #[test]
    fn voids_are_told_from_scatter() {
        let (a, mut random) = (3.6, Random::new(7));
        let sites = lattice::sites(6, a);
        let edges = [6.0 * a; 3];
        assert_eq!(share(&sites, edges), 0.0);
        assert_eq!(share(&sites[1..], edges), 0.0);
        let shaken: Vec<[f64; 3]> = sites.iter().map(|s| s.map(|x| x + 0.2 * random.normal())).collect();
        assert_eq!(share(&shaken, edges), 0.0);
        let scattered: Vec<[f64; 3]> = (0..4000).map(|_| edges.map(|e| e * random.uniform())).collect();
        assert!(share(&scattered, edges) < 0.3 * TORN);
        let taller = [edges[0], edges[1], 1.4 * edges[2]];
        let reach = REACH * cbrt(0.25 * 1.4) * a;
        let expected = (0.4 * 6.0 * a - 2.0 * reach + 0.5 * a) / (1.4 * 6.0 * a);
        // Layers of places are a sixteenth apart.
        assert!((share(&sites, taller) - expected).abs() < 1.0 / 16.0, "{} {expected}", share(&sites, taller));
        assert!(share(&sites, taller) > 5.0 * TORN);
    }
}
