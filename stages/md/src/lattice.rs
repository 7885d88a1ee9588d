//! The perfect face-centred cubic lattice: its sites, and its energy and pressure at rest.
use crate::potential::{Potential, Structure};
use hvi_kit::math::{bisect, cbrt};

/// Atoms in the cubic cell, in units of its edge.
const BASIS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]];

/// Distance of nearest sites, in units of the edge: the root of 1/2.
pub const NEAREST: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Sites of `cells`^3 cubic cells of edge `edge` [angstrom], x fastest by cell: `[4 cells^3][3]`.
pub fn sites(cells: usize, edge: f64) -> Vec<[f64; 3]> {
    block([cells; 3], [edge; 3])
}

/// Sites of a block of `cells` cells of edges `edges` [angstrom] along x, y and z, x fastest by cell: `[4 cells][3]`.
pub fn block(cells: [usize; 3], edges: [f64; 3]) -> Vec<[f64; 3]> {
    let mut sites = Vec::with_capacity(4 * cells[0] * cells[1] * cells[2]);
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let corner = [x as f64, y as f64, z as f64];
                sites.extend(BASIS.map(|b| [0, 1, 2].map(|k| (corner[k] + b[k]) * edges[k])));
            }
        }
    }
    sites
}

/// The lattice at rest at one edge length.
#[derive(Clone, Copy, Debug)]
pub struct Static {
    /// Energy of an atom [eV].
    pub energy: f64,
    /// Pressure [eV/angstrom3].
    pub pressure: f64,
    /// Sum of the neighbours' densities at an atom.
    pub density: f64,
}

/// Energy, pressure `-dE/dV` and density sum of the potential's cubic lattice (body-centred, or else face-centred) with edge
/// `edge` [angstrom], from the formulas themselves.
pub fn at_rest(potential: &Potential, edge: f64) -> Static {
    let body = potential.structure() == Structure::Bcc;
    let reach = (2.0 * potential.cutoff() / edge) as i32 + 1;
    let (mut pair, mut pair_virial, mut density, mut density_virial) = (0.0, 0.0, 0.0, 0.0);
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                // neighbours in half-edges: face-centred, their sum is even; body-centred, all are even or all odd
                let square = x * x + y * y + z * z;
                let site = if body { (x + y) % 2 == 0 && (y + z) % 2 == 0 } else { (x + y + z) % 2 == 0 };
                if !site || square == 0 {
                    continue;
                }
                let r = 0.5 * edge * f64::from(square).sqrt();
                let (phi, f) = (potential.pair(r), potential.density(r));
                pair += 0.5 * phi.value;
                pair_virial += 0.5 * phi.slope * r;
                density += f.value;
                density_virial += f.slope * r;
            }
        }
    }
    let embedding = potential.embedding(density);
    let volume = if body { 0.5 } else { 0.25 } * edge * edge * edge;
    Static {
        energy: pair + embedding.value,
        pressure: -(pair_virial + embedding.slope * density_virial) / (3.0 * volume),
        density,
    }
}

/// Cubic edge of the lattice without pressure [angstrom], nearest to what the potential says of itself; `None` where the
/// pressure doesn't change its sign from 0.7 to 1.4 of that, so that the potential has no such lattice.
pub fn equilibrium_edge(potential: &Potential) -> Option<f64> {
    *potential.kept_edge().get_or_init(|| find_equilibrium_edge(potential))
}

/// Cubic edge at `volume_ratio` times the volume of the lattice without pressure [angstrom], if there is one.
pub fn edge(potential: &Potential, volume_ratio: f64) -> Option<f64> {
    Some(equilibrium_edge(potential)? * cbrt(volume_ratio))
}

fn find_equilibrium_edge(potential: &Potential) -> Option<f64> {
    let nearest = potential.structure().nearest(potential.lattice_constant());
    let about = if potential.structure() == Structure::Bcc { Structure::Bcc } else { Structure::Fcc }.edge(nearest);
    let pressure = |edge: f64| at_rest(potential, edge).pressure;
    let (from, to) = (0.7 * about, 1.4 * about);
    let mut bracket = (about, about);
    while bracket.0 > from || bracket.1 < to {
        let wider = ((0.99 * bracket.0).max(from), (1.01 * bracket.1).min(to));
        // stable: pressed together it presses back
        for (a, b) in [(wider.0, bracket.0), (bracket.1, wider.1)] {
            if pressure(a) > 0.0 && pressure(b) <= 0.0 {
                return bisect(a, b, 1e-12, pressure);
            }
        }
        bracket = wider;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::PRESSURE;
    const COPPER: &Potential = &Potential::Mishin2001;

    /// Mishin et al. (2001), table III: a0 3.615, E0 -3.54, B 138.3 GPa; further digits from the formulas by another program.
    #[test]
    fn copper_lattice_is_that_of_the_paper() {
        let a0 = equilibrium_edge(COPPER).unwrap();
        assert!((a0 - 3.61493).abs() < 5e-6, "{a0}");
        let ground = at_rest(COPPER, a0);
        assert!((ground.energy + 3.54022).abs() < 5e-6, "{ground:?}");
        assert!((ground.density - 1.0).abs() < 5e-4, "{ground:?}");
        // the embedding function's third derivative jumps at density 1, where the lattice is: the step must be small
        let d = 1e-5;
        let modulus =
            -(at_rest(COPPER, a0 * (1.0 + d)).pressure - at_rest(COPPER, a0 * (1.0 - d)).pressure) / (6.0 * d);
        assert!((modulus * PRESSURE * 1e-9 - 138.3).abs() < 0.05, "{modulus}");
    }

    /// Pressures of the same formulas by another program, to the digits it gave.
    #[test]
    fn cold_pressures_are_known() {
        for (ratio, gigapascal) in [(0.9, 18.0), (0.8, 52.1), (0.7, 118.6), (0.6, 252.7)] {
            let p = at_rest(COPPER, edge(COPPER, ratio).unwrap()).pressure * PRESSURE * 1e-9;
            assert!((p - gigapascal).abs() < 0.05, "{ratio}: {p}");
        }
    }

    /// The slope of the energy by a central difference of relative step 1e-5: wrong by 1e-10 and by rounding 1e-11.
    #[test]
    fn pressure_is_the_slope_of_the_energy() {
        for ratio in [1.5, 1.0, 0.7, 0.5] {
            let (a, d) = (edge(COPPER, ratio).unwrap(), 1e-5);
            let (up, down) = (a * (1.0 + d), a * (1.0 - d));
            let volume = |a: f64| 0.25 * a * a * a;
            let slope = (at_rest(COPPER, up).energy - at_rest(COPPER, down).energy) / (volume(up) - volume(down));
            assert!((slope + at_rest(COPPER, a).pressure).abs() < 1e-8, "{ratio}");
        }
    }

    #[test]
    fn sites_fill_the_cell() {
        let all = sites(3, 2.0);
        assert_eq!(all.len(), 108);
        let nearest = all[1..].iter().map(|s| s.iter().map(|x| x * x).sum::<f64>()).fold(f64::MAX, f64::min);
        assert!((nearest - 2.0).abs() < 1e-12);
    }
}
