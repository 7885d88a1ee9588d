//! Embedded-atom potentials: `E = sum_{i<j} phi(r_ij) + sum_i F(sum_{j/=i} f(r_ij))`.
//!
//! `named.rs` what a pipeline says; here what is computed with. To add one: a file with its functions, a name in
//! [`BuiltIn`], a variant of [`Potential`], and an arm in each method.
pub mod element;
pub mod file;
mod mishin_2001;
mod named;
mod setfl;
pub mod spline;
mod zhou_2004;
pub use file::{Format, Malformed, Tabulated};
pub use named::{BuiltIn, FromFile, Named, Unreadable};
pub use setfl::setfl;
use std::sync::{Arc, OnceLock};

/// An embedded-atom potential. Lengths in angstrom, energies in eV.
#[derive(Clone, Debug)]
pub enum Potential {
    /// Copper, EAM1 of Y. Mishin et al., Phys. Rev. B 63, 224106 (2001).
    Mishin2001,
    /// A metal of X. W. Zhou et al., Phys. Rev. B 69, 144113 (2004).
    Zhou2004(&'static zhou_2004::Metal),
    /// From a file.
    Tabulated(Arc<Tabulated>),
}

/// A function's value and its derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// The first derivative.
    pub slope: f64,
}

/// The crystal a potential is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Face-centred cubic.
    Fcc,
    /// Body-centred cubic.
    Bcc,
    /// Hexagonal close-packed.
    Hcp,
    /// Another one.
    Other,
}
impl std::str::FromStr for Structure {
    type Err = std::convert::Infallible;
    fn from_str(name: &str) -> Result<Structure, Self::Err> {
        Ok(match name.to_ascii_lowercase().as_str() {
            "fcc" => Structure::Fcc,
            "bcc" => Structure::Bcc,
            "hcp" => Structure::Hcp,
            _ => Structure::Other,
        })
    }
}
impl Structure {
    /// Distance of nearest sites over the cubic edge; over the basal one for hcp.
    fn contact(self) -> f64 {
        match self {
            Structure::Fcc | Structure::Other => 0.5f64.sqrt(),
            Structure::Bcc => 0.75f64.sqrt(),
            Structure::Hcp => 1.0,
        }
    }
    /// Distance of nearest sites with edge `edge`.
    pub fn nearest(self, edge: f64) -> f64 {
        self.contact() * edge
    }
    /// Edge where nearest sites are `nearest` apart.
    pub fn edge(self, nearest: f64) -> f64 {
        nearest / self.contact()
    }
}

impl Potential {
    /// Molar mass [g/mol].
    pub fn molar_mass(&self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::MOLAR_MASS,
            Potential::Zhou2004(metal) => metal.molar_mass,
            Potential::Tabulated(table) => table.molar_mass,
        }
    }

    /// The crystal it is made for.
    pub fn structure(&self) -> Structure {
        match self {
            Potential::Mishin2001 => Structure::Fcc,
            Potential::Zhou2004(metal) => metal.structure,
            Potential::Tabulated(table) => table.structure,
        }
    }

    /// About the edge of the crystal's cell without pressure [angstrom].
    pub fn lattice_constant(&self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::LATTICE_CONSTANT,
            Potential::Zhou2004(metal) => metal.lattice_constant(),
            Potential::Tabulated(table) => table.lattice_constant,
        }
    }

    /// Distance from which on atoms don't act on each other [angstrom].
    pub fn cutoff(&self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::CUTOFF,
            Potential::Zhou2004(metal) => metal.cutoff(),
            Potential::Tabulated(table) => table.cutoff,
        }
    }

    /// Distance below which it says nothing [angstrom].
    pub fn nearest(&self) -> f64 {
        match self {
            Potential::Mishin2001 | Potential::Zhou2004(_) => 1.0,
            Potential::Tabulated(table) => table.nearest,
        }
    }

    /// Density up to which it says something.
    pub fn densest(&self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::DENSEST,
            Potential::Zhou2004(metal) => metal.densest(),
            Potential::Tabulated(table) => table.embedding.end(),
        }
    }

    /// Pair energy phi [eV] at distance `r` [angstrom].
    pub fn pair(&self, r: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::pair(r),
            Potential::Zhou2004(metal) => metal.pair(r),
            Potential::Tabulated(table) => table.pair(r),
        }
    }

    /// Electron density f that an atom gives at distance `r` [angstrom], in the potential's own unit.
    pub fn density(&self, r: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::density(r),
            Potential::Zhou2004(metal) => metal.density(r),
            Potential::Tabulated(table) => table.density(r),
        }
    }

    /// Embedding energy F [eV] of an atom where the densities of the others sum up to `density`.
    pub fn embedding(&self, density: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::embedding(density),
            Potential::Zhou2004(metal) => metal.embedding(density),
            Potential::Tabulated(table) => table.embedding.at(density),
        }
    }

    /// Where the edge of the lattice without pressure is kept once it was found: every state of a sweep asks for it.
    pub(crate) fn kept_edge(&self) -> &OnceLock<Option<f64>> {
        static MISHIN_2001: OnceLock<Option<f64>> = OnceLock::new();
        match self {
            Potential::Mishin2001 => &MISHIN_2001,
            Potential::Zhou2004(metal) => &metal.edge,
            Potential::Tabulated(table) => &table.edge,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built_in() -> Vec<Potential> {
        BuiltIn::ALL.iter().map(|b| b.potential()).collect()
    }

    /// A central difference of step d is wrong by d^2 f'''/6 and by rounding 1e-16 f/d: with d = 1e-5 and f''' below
    /// 1e4 eV/angstrom^3 (the steep wall at 1 angstrom) 2e-7 of the size of f and f' is ample. Not at the joints of the
    /// embedding functions of Zhou et al., whose slopes jump by 1e-4.
    #[test]
    fn slopes_are_derivatives() {
        let d = 1e-5;
        type Function = fn(&Potential, f64) -> Jet;
        for potential in built_in() {
            let end = potential.cutoff() + 0.1;
            let rho = potential.densest() / 10.0;
            let functions: [(Function, f64, f64); 3] = [
                (Potential::pair, 1.0, end),
                (Potential::density, 1.0, end),
                (Potential::embedding, 0.01 * rho, 6.0 * rho),
            ];
            for (function, from, to) in functions {
                for k in 0..500 {
                    let x = from + (to - from) * f64::from(k) / 499.0;
                    let f = |x| function(&potential, x);
                    let difference = (f(x + d).value - f(x - d).value) / (2.0 * d);
                    let scale = 1.0 + f(x).value.abs() + f(x).slope.abs();
                    assert!(
                        (difference - f(x).slope).abs() < 3e-7 * scale,
                        "{potential:?} {x}: {difference} {:?}",
                        f(x)
                    );
                }
            }
        }
    }

    #[test]
    fn functions_end_smoothly_at_the_cutoff() {
        for potential in built_in() {
            let edge = potential.cutoff() - 1e-5;
            for jet in [potential.pair(edge), potential.density(edge)] {
                assert!(jet.value.abs() < 1e-10 && jet.slope.abs() < 1e-7, "{potential:?} {jet:?}");
            }
            assert_eq!(potential.pair(potential.cutoff()), Jet::default());
        }
    }
}
