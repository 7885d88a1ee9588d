//! Published parameter sets, and the stage `eos.handbook` that hands them out.
use crate::model::gray::{Gray, Parameters};
use crate::model::mie_gruneisen;
use crate::{Eos, EosError, EosResult, MieGruneisen};
use hvi_kit::units::{Density, SpecificHeat, Temperature, Velocity};
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

/// A Mie-Grueneisen material, see [`MieGruneisen`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// Reference density rho0.
    pub density: Density,
    /// Intercept c0 of Us = c0 + s up.
    pub sound_speed: Velocity,
    /// Slope s of Us = c0 + s up.
    pub slope: f64,
    /// Grueneisen coefficient at rho0; gamma rho is constant.
    pub gruneisen: f64,
    /// Heat capacity.
    pub heat_capacity: SpecificHeat,
    /// Temperature of the reference state.
    #[serde(default = "room")]
    pub reference_temperature: Temperature,
}

fn room() -> Temperature {
    Temperature::new(293.0)
}

/// Parameters of the stage: exactly one of both keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// A published set of GRAY.
    #[serde(default)]
    pub set: Option<Set>,
    /// Mie-Grueneisen with these parameters.
    #[serde(default)]
    pub mie_gruneisen: Option<Linear>,
}

/// The stage.
pub struct Handbook;
impl Stage for Handbook {
    const NAME: &'static str = "eos.handbook";
    const SUMMARY: &'static str = "equation of state with published parameters (GRAY sets, or Mie-Grueneisen)";
    type Params = Params;
    type Inputs = ();
    type Output = EosResult;

    fn check(params: &Params) -> Result<(), Invalid> {
        make(params).map(drop)
    }

    fn cost(_: &Params) -> f64 {
        0.01
    }

    fn run(params: &Params, _: (), _: &Ctx<'_>) -> Result<EosResult, StageError> {
        make(params).map_err(|e| StageError::physics(format!("{}: {}", e.key, e.why)))
    }
}

/// The equation of state that `params` names.
fn make(params: &Params) -> Result<EosResult, Invalid> {
    let named = |key: &'static str| move |e: EosError| Invalid::new(key, e.to_string());
    match (params.set, &params.mie_gruneisen) {
        (Some(set), None) => {
            let eos = Eos::Gray(Gray::new(set.parameters()).map_err(named("set"))?);
            Ok(EosResult { eos, source: set.source().into(), fit: None })
        }
        (None, Some(m)) => {
            let parameters = mie_gruneisen::Parameters {
                density: m.density.si(),
                sound_speed: m.sound_speed.si(),
                slope: m.slope,
                gruneisen: m.gruneisen,
                heat_capacity: m.heat_capacity.si(),
                reference_temperature: m.reference_temperature.si(),
            };
            let eos = Eos::MieGruneisen(MieGruneisen::new(parameters).map_err(named("mie_gruneisen"))?);
            Ok(EosResult { eos, source: "parameters given in the pipeline".into(), fit: None })
        }
        _ => Err(Invalid::new(
            "set",
            "give either `set` (copper-royce, copper-paper-md, aluminium-paper) or `mie_gruneisen`",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::Artifact;

    #[test]
    fn every_set_is_an_equation_of_state_to_look_at() {
        for set in Set::ALL {
            let params = Params { set: Some(set), mie_gruneisen: None };
            Handbook::check(&params).unwrap();
            let result = Handbook::run(&params, (), &Ctx::quiet()).unwrap();
            assert_eq!(result.eos.name(), "GRAY");
            assert_eq!(result.views().len(), 3);
        }
    }

    #[test]
    fn one_key_is_wanted_and_a_bad_value_is_named() {
        let wrong = |params: &Params| Handbook::check(params).unwrap_err();
        assert!(wrong(&Params { set: None, mie_gruneisen: None }).why.contains("either `set`"));
        let linear = Linear {
            density: Density::new(2703.0),
            sound_speed: Velocity::new(5240.0),
            slope: 1.4,
            gruneisen: -1.97,
            heat_capacity: SpecificHeat::new(875.0),
            reference_temperature: room(),
        };
        let message = wrong(&Params { set: None, mie_gruneisen: Some(linear) });
        assert_eq!((message.key.as_str(), message.why.contains("gruneisen is -1.97")), ("mie_gruneisen", true));
    }
}
