//! Published parameter sets, and the stage `eos.handbook` that hands them out.
use crate::EosResult;
use crate::definition::Definition;
use crate::model::gray::Parameters;
use hvi_kit::{Ctx, Invalid, Stage, StageError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A published set of GRAY parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Set::CopperRoyce => "copper-royce",
            Set::CopperPaperMd => "copper-paper-md",
            Set::AluminiumPaper => "aluminium-paper",
        }
    }

    /// The set called `name`.
    pub fn named(name: &str) -> Option<Set> {
        Set::ALL.into_iter().find(|s| s.name() == name)
    }

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

/// The stage.
pub struct Handbook;
impl Stage for Handbook {
    const NAME: &'static str = "eos.handbook";
    const SUMMARY: &'static str = "equation of state by a published set's name, or with parameters given (GRAY, Mie-Grueneisen, Tillotson, gases)";
    type Params = Definition;
    type Inputs = ();
    type Output = EosResult;

    fn check(params: &Definition) -> Result<(), Invalid> {
        params.check()
    }

    fn cost(params: &Definition) -> f64 {
        // Patches to 1e-4 take some 60 ms, to 1e-5 some .3 s; all else next to nothing.
        0.001 + params.accuracy.map_or(0.0, |accuracy| 4e-6 / accuracy)
    }

    fn run(params: &Definition, _: (), _: &Ctx<'_>) -> Result<EosResult, StageError> {
        params.make().map_err(|e| StageError::physics(format!("{}: {}", e.key, e.why)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Eos;
    use crate::definition::Linear;
    use hvi_kit::Artifact;
    use hvi_kit::units::{Density, SpecificHeat, Temperature, Velocity};
    use hvi_kit::view::View;

    #[test]
    fn every_set_is_an_equation_of_state_to_look_at() {
        for set in Set::ALL {
            assert_eq!(Set::named(set.name()), Some(set));
            assert_eq!(serde_json::to_value(set).unwrap(), set.name());
            let params = Definition::of(set);
            Handbook::check(&params).unwrap();
            let result = Handbook::run(&params, (), &Ctx::quiet()).unwrap();
            assert_eq!(result.eos.name(), "GRAY");
            assert_eq!(result.views().len(), 4);
        }
    }

    /// Written out with units and read back: the same bits.
    #[test]
    fn a_description_reads_back() {
        for set in Set::ALL {
            let result = Definition::of(set).make().unwrap();
            let text = serde_json::to_string(&Definition::describe(&result).unwrap()).unwrap();
            assert!(text.contains(" m3/kg\""), "{text}");
            let Some(View::Text(file)) = result.views().pop() else { panic!("the last view is the file") };
            let read = toml::from_str::<Definition>(&file.text).unwrap().make().unwrap();
            assert_eq!((file.extension.as_str(), read), ("toml", result.clone()));
            let again = serde_json::from_str::<Definition>(&text).unwrap().make().unwrap();
            assert_eq!(again, result);
        }
        let gas = r#"{"ideal_gas": {"density": "1.2 kg/m3", "gamma": 1.4, "heat_capacity": "718 J/kg/K"}}"#;
        let gas = serde_json::from_str::<Definition>(gas).unwrap().make().unwrap();
        assert!(matches!(&gas.eos, Eos::IdealGas(g) if g.reference_temperature == 300.0));
        assert_eq!(Definition::describe(&gas).unwrap().make().unwrap(), gas);
    }

    #[test]
    fn one_key_is_wanted_and_a_bad_value_is_named() {
        let wrong = |params: &Definition| Handbook::check(params).unwrap_err();
        assert!(wrong(&Definition::default()).why.contains("exactly one is wanted"));
        let linear = Linear {
            density: Density::new(2703.0),
            sound_speed: Velocity::new(5240.0),
            slope: 1.4,
            gruneisen: -1.97,
            heat_capacity: SpecificHeat::new(875.0),
            reference_temperature: Temperature::new(293.0),
        };
        let message = wrong(&Definition { mie_gruneisen: Some(linear), ..Definition::default() });
        assert_eq!((message.key.as_str(), message.why.contains("gruneisen is -1.97")), ("mie_gruneisen", true));
    }
}
