//! Embedded-atom potentials: `E = sum_{i<j} phi(r_ij) + sum_i F(sum_{j/=i} f(r_ij))`.
//!
//! To add one: a file with its functions, a variant here, and an arm in each method.
mod mishin_2001;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A built-in embedded-atom potential. Lengths in angstrom, energies in eV.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Potential {
    /// Copper, EAM1 of Y. Mishin et al., Phys. Rev. B 63, 224106 (2001).
    #[serde(rename = "mishin-2001")]
    Mishin2001,
}

/// A function's value and its derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// The first derivative.
    pub slope: f64,
}

impl Potential {
    /// Molar mass [g/mol].
    pub fn molar_mass(self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::MOLAR_MASS,
        }
    }

    /// Distance from which on atoms don't act on each other [angstrom].
    pub fn cutoff(self) -> f64 {
        match self {
            Potential::Mishin2001 => mishin_2001::CUTOFF,
        }
    }

    /// Pair energy phi [eV] at distance `r` [angstrom].
    pub fn pair(self, r: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::pair(r),
        }
    }

    /// Electron density f that an atom gives at distance `r` [angstrom], in the potential's own unit.
    pub fn density(self, r: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::density(r),
        }
    }

    /// Embedding energy F [eV] of an atom where the densities of the others sum up to `density`.
    pub fn embedding(self, density: f64) -> Jet {
        match self {
            Potential::Mishin2001 => mishin_2001::embedding(density),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A central difference of step d is wrong by d^2 f'''/6 and by rounding 1e-16 f/d: with d = 1e-5 and f''' below
    /// 1e4 eV/angstrom^3 (the steep wall at 1 angstrom) 2e-7 of the size of f and f' is ample.
    #[test]
    fn slopes_are_derivatives() {
        let d = 1e-5;
        type Function = fn(Potential, f64) -> Jet;
        let functions: [(Function, f64, f64); 3] =
            [(Potential::pair, 1.0, 5.6), (Potential::density, 1.0, 5.6), (Potential::embedding, 0.01, 6.0)];
        for (function, from, to) in functions {
            for k in 0..500 {
                let x = from + (to - from) * k as f64 / 499.0;
                let f = |x| function(Potential::Mishin2001, x);
                let difference = (f(x + d).value - f(x - d).value) / (2.0 * d);
                let scale = 1.0 + f(x).value.abs() + f(x).slope.abs();
                assert!((difference - f(x).slope).abs() < 2e-7 * scale, "at {x}: {difference} {}", f(x).slope);
            }
        }
    }

    #[test]
    fn functions_end_smoothly_at_the_cutoff() {
        let potential = Potential::Mishin2001;
        let edge = potential.cutoff() - 1e-4;
        for jet in [potential.pair(edge), potential.density(edge)] {
            assert!(jet.value.abs() < 1e-14 && jet.slope.abs() < 1e-10);
        }
        assert_eq!(potential.pair(potential.cutoff()), Jet::default());
    }
}
