//! Published parameter sets.
use crate::model::gray::Parameters;
use serde::{Deserialize, Serialize};

/// A published set of GRAY parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Set {
    /// Copper of Royce (1971): Liu, Wang, Zhang (2013), Table 1, "Experiment".
    CopperRoyce,
    /// Copper fitted to molecular dynamics by Liu, Wang, Zhang (2013), Table 1, "Numerical".
    CopperPaperMd,
    /// Aluminium of Liu, Wang, Zhang (2013), Table 3.
    AluminiumPaper,
}

/// Molar mass of copper and of aluminium [kg/mol].
pub const COPPER_MOLAR_MASS: f64 = 63.546e-3;
/// See [`COPPER_MOLAR_MASS`].
pub const ALUMINIUM_MOLAR_MASS: f64 = 26.9815e-3;
/// Energy of the dilute gas at T -> 0 above the solid at 300 K [J/mol]: heat of formation of the gas at 298 K minus
/// 2.5 R 298 K (337.4 and 330.0 kJ/mol, NIST-JANAF).
pub const COPPER_COHESION: f64 = 331.2e3;
/// See [`COPPER_COHESION`].
pub const ALUMINIUM_COHESION: f64 = 323.8e3;

impl Set {
    /// Every set.
    pub const ALL: [Set; 3] = [Set::CopperRoyce, Set::CopperPaperMd, Set::AluminiumPaper];

    /// The parameters, converted from the paper's units (cm3/g, cm/us, kJ/mol/K2, K).
    pub fn parameters(self) -> Parameters {
        let (cu, al) = ((COPPER_MOLAR_MASS, COPPER_COHESION), (ALUMINIUM_MOLAR_MASS, ALUMINIUM_COHESION));
        let set =
            |v0, c, s, g0, a, ge, tm, (mass, cohesion)| Parameters::metal(v0, c, s, g0, a, ge, tm, mass, cohesion);
        match self {
            Set::CopperRoyce => set(0.1118e-3, 3940.0, 1.489, 1.97, 1.5, 4.9e-4, 1790.0, cu),
            Set::CopperPaperMd => set(0.1119e-3, 3980.0, 1.301, 1.86, 1.7, 8.3e-4, 2006.0, cu),
            Set::AluminiumPaper => set(0.359e-3, 5330.0, 1.338, 2.18, 1.7, 8.7e-4, 1220.0, al),
        }
    }

    /// Where the numbers come from.
    pub fn source(self) -> &'static str {
        match self {
            Set::CopperRoyce => "copper, Royce (1971), as quoted by Liu, Wang, Zhang (2013), Table 1, experiment",
            Set::CopperPaperMd => "copper, Liu, Wang, Zhang (2013), Table 1, fitted to molecular dynamics",
            Set::AluminiumPaper => "aluminium, Liu, Wang, Zhang (2013), Table 3",
        }
    }
}
