//! An equation of state as people write it, in a file or a pipeline: a published set by its name, or a model with its parameters.
use crate::handbook::Set;
use crate::model::{gray, mie_gruneisen, tillotson};
use crate::{Eos, EosError, EosResult, Gray, IdealGas, MieGruneisen, Patches, StiffenedGas, Tillotson};
use hvi_kit::Invalid;
use hvi_kit::units::{
    Density, ElectronicHeat, MolarMass, Pressure, SpecificEnergy, SpecificHeat, SpecificVolume, Temperature, Velocity,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An equation of state: exactly one key but `source` and `accuracy`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// A published set of GRAY.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set: Option<Set>,
    /// GRAY with these parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gray: Option<GrayParameters>,
    /// Mie-Grueneisen with these parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mie_gruneisen: Option<Linear>,
    /// Tillotson's with these parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tillotson: Option<TillotsonParameters>,
    /// A stiffened gas with these parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffened_gas: Option<StiffenedGasParameters>,
    /// An ideal gas with these parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ideal_gas: Option<IdealGasParameters>,
    /// Of GRAY: a table to this relative error (1e-5 to 0.1) in place of the formulas, for speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Where the parameters come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// Parameters of GRAY; the last seven are Royce's constants unless given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrayParameters {
    /// V0: specific volume at zero pressure and the reference temperature.
    pub volume: SpecificVolume,
    /// C: intercept of Us = C + S up.
    pub sound_speed: Velocity,
    /// S: slope of Us = C + S up.
    pub slope: f64,
    /// gamma0: Grueneisen coefficient at V0.
    pub gruneisen: f64,
    /// a: gamma = gamma0 - a (1 - V/V0).
    pub gruneisen_slope: f64,
    /// G0: electronic heat coefficient at V0.
    pub electronic: ElectronicHeat,
    /// Tm0: melting temperature at V0, not at one atmosphere.
    pub melting_temperature: Temperature,
    /// M.
    pub molar_mass: MolarMass,
    /// Energy of the dilute gas at T -> 0 above the reference state.
    pub cohesive_energy: SpecificEnergy,
    /// T0: temperature of the reference state.
    #[serde(default = "defaults::room")]
    pub reference_temperature: Temperature,
    /// gamma_e: electronic Grueneisen coefficient.
    #[serde(default = "defaults::electronic_gruneisen")]
    pub electronic_gruneisen: f64,
    /// Delta S of melting, in units of R.
    #[serde(default = "defaults::melting_entropy")]
    pub melting_entropy: f64,
    /// alpha: fall of the liquid's heat capacity by T/Tm, in units of R.
    #[serde(default = "defaults::liquid_softening")]
    pub liquid_softening: f64,
    /// V_J / V0: where the vapour begins.
    #[serde(default = "defaults::join_ratio")]
    pub join_ratio: f64,
    /// V_b / V0: excluded volume of the vapour.
    #[serde(default = "defaults::covolume_ratio")]
    pub covolume_ratio: f64,
    /// theta: pole of the vapour's joining functions.
    #[serde(default = "defaults::joining")]
    pub joining: f64,
}

mod defaults {
    use hvi_kit::units::Temperature;
    pub fn room() -> Temperature {
        Temperature::new(300.0)
    }
    pub fn cool_room() -> Temperature {
        Temperature::new(293.0)
    }
    pub fn electronic_gruneisen() -> f64 {
        2.0 / 3.0
    }
    pub fn melting_entropy() -> f64 {
        1.16
    }
    pub fn liquid_softening() -> f64 {
        0.16
    }
    pub fn join_ratio() -> f64 {
        1.5
    }
    pub fn covolume_ratio() -> f64 {
        0.5
    }
    pub fn joining() -> f64 {
        1.0
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
    #[serde(default = "defaults::cool_room")]
    pub reference_temperature: Temperature,
}

/// Parameters of [`Tillotson`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TillotsonParameters {
    /// Reference density rho0.
    pub density: Density,
    /// a, the thermal coefficient that hot and thin matter keeps.
    pub a: f64,
    /// b; a + b is the Grueneisen coefficient of the cold solid.
    pub b: f64,
    /// A: bulk modulus.
    pub bulk: Pressure,
    /// B.
    pub bulk_slope: Pressure,
    /// E0.
    pub energy: SpecificEnergy,
    /// E_iv: energy at which vapour begins to form in expansion.
    pub incipient: SpecificEnergy,
    /// E_cv: energy at which expanded matter is all vapour.
    pub complete: SpecificEnergy,
    /// alpha: how fast b and A fade in expansion.
    pub alpha: f64,
    /// beta: how fast A fades in expansion.
    pub beta: f64,
    /// Heat capacity, for the temperature.
    pub heat_capacity: SpecificHeat,
    /// Temperature of the reference state.
    #[serde(default = "defaults::room")]
    pub reference_temperature: Temperature,
}

/// Parameters of [`StiffenedGas`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffenedGasParameters {
    /// Density of the reference state.
    pub density: Density,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// P_inf.
    pub stiffness: Pressure,
    /// Heat capacity at constant volume.
    pub heat_capacity: SpecificHeat,
    /// Temperature of the reference state.
    #[serde(default = "defaults::room")]
    pub reference_temperature: Temperature,
}

/// Parameters of [`IdealGas`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdealGasParameters {
    /// Density of the reference state.
    pub density: Density,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// Heat capacity at constant volume.
    pub heat_capacity: SpecificHeat,
    /// Temperature of the reference state.
    #[serde(default = "defaults::room")]
    pub reference_temperature: Temperature,
}

/// The keys of which exactly one is wanted.
pub const KEYS: &str = "set, gray, mie_gruneisen, tillotson, stiffened_gas, ideal_gas";

impl Definition {
    /// The published set.
    pub fn of(set: Set) -> Definition {
        Definition { set: Some(set), ..Definition::default() }
    }

    /// What `result` was made of, readable again; `None` for a table, which is written as its states.
    pub fn describe(result: &EosResult) -> Option<Definition> {
        let mut d = Definition { source: Some(result.source.clone()), ..Definition::default() };
        match &result.eos {
            Eos::Gray(m) => d.gray = Some(m.parameters().into()),
            Eos::Patches(m) => {
                d.gray = Some(m.gray().parameters().into());
                d.accuracy = Some(m.accuracy());
            }
            Eos::MieGruneisen(m) => d.mie_gruneisen = Some(m.parameters().into()),
            Eos::Tillotson(m) => d.tillotson = Some(m.parameters().into()),
            Eos::StiffenedGas(m) => d.stiffened_gas = Some(m.into()),
            Eos::IdealGas(m) => d.ideal_gas = Some(m.into()),
            Eos::Table(_) => return None,
        }
        Some(d)
    }

    /// Whether [`Definition::make`] takes it: for each point of a sweep, so without the curves that only the result needs.
    ///
    /// # Errors
    /// As there.
    pub fn check(&self) -> Result<(), Invalid> {
        let others = [self.set.is_some(), self.gray.is_some(), self.tillotson.is_some()];
        let gases = [self.stiffened_gas.is_some(), self.ideal_gas.is_some()];
        match &self.mie_gruneisen {
            Some(p) if self.accuracy.is_none() && !others.iter().chain(&gases).any(|given| *given) => {
                MieGruneisen::check(&p.into()).map_err(|e| Invalid::new("mie_gruneisen", e.to_string()))
            }
            _ => self.make().map(drop),
        }
    }

    /// The equation of state.
    ///
    /// # Errors
    /// [`Invalid`] where none or more than one key is given, or the parameters make no equation of state.
    pub fn make(&self) -> Result<EosResult, Invalid> {
        let named = |key: &'static str| move |e: EosError| Invalid::new(key, e.to_string());
        let mut found = Vec::new();
        if let Some(set) = self.set {
            found.push(Eos::Gray(Gray::new(set.parameters()).map_err(named("set"))?));
        }
        if let Some(p) = &self.gray {
            found.push(Eos::Gray(Gray::new(p.into()).map_err(named("gray"))?));
        }
        if let Some(p) = &self.mie_gruneisen {
            found.push(Eos::MieGruneisen(MieGruneisen::new(p.into()).map_err(named("mie_gruneisen"))?));
        }
        if let Some(p) = &self.tillotson {
            found.push(Eos::Tillotson(Tillotson::new(p.into()).map_err(named("tillotson"))?));
        }
        if let Some(p) = &self.stiffened_gas {
            let gas = StiffenedGas {
                density: p.density.si(),
                gamma: p.gamma,
                stiffness: p.stiffness.si(),
                heat_capacity: p.heat_capacity.si(),
                reference_temperature: p.reference_temperature.si(),
            };
            found.push(Eos::StiffenedGas(gas.new().map_err(named("stiffened_gas"))?));
        }
        if let Some(p) = &self.ideal_gas {
            let (density, heat, room) = (p.density.si(), p.heat_capacity.si(), p.reference_temperature.si());
            found.push(Eos::IdealGas(IdealGas::new(density, p.gamma, heat, room).map_err(named("ideal_gas"))?));
        }
        let given = || self.set.map_or("parameters given by the user", Set::source).to_string();
        match <[Eos; 1]>::try_from(found) {
            Ok([eos]) => Ok(EosResult {
                eos: self.in_patches(eos)?,
                source: self.source.clone().unwrap_or_else(given),
                fit: None,
            }),
            Err(all) => {
                let sets = Set::ALL.map(Set::name).join(", ");
                let why = format!("{} of {KEYS} are given, exactly one is wanted; sets are {sets}", all.len());
                Err(Invalid::new("set", why))
            }
        }
    }
}

impl Definition {
    /// `eos`, in patches where an accuracy is given.
    fn in_patches(&self, eos: Eos) -> Result<Eos, Invalid> {
        let wrong = |why: String| Invalid::new("accuracy", why);
        match (eos, self.accuracy) {
            (eos, None) => Ok(eos),
            (Eos::Gray(gray), Some(accuracy)) => {
                Patches::new(gray, accuracy).map(Eos::Patches).map_err(|e| wrong(e.to_string()))
            }
            (other, Some(_)) => Err(wrong(format!("is given for {}: only GRAY is tabulated so", other.name()))),
        }
    }
}

impl From<&GrayParameters> for gray::Parameters {
    fn from(p: &GrayParameters) -> Self {
        Self {
            volume: p.volume.si(),
            sound_speed: p.sound_speed.si(),
            slope: p.slope,
            gruneisen: p.gruneisen,
            gruneisen_slope: p.gruneisen_slope,
            electronic: p.electronic.si(),
            melting_temperature: p.melting_temperature.si(),
            molar_mass: p.molar_mass.si(),
            cohesive_energy: p.cohesive_energy.si(),
            reference_temperature: p.reference_temperature.si(),
            electronic_gruneisen: p.electronic_gruneisen,
            melting_entropy: p.melting_entropy,
            liquid_softening: p.liquid_softening,
            join_ratio: p.join_ratio,
            covolume_ratio: p.covolume_ratio,
            joining: p.joining,
        }
    }
}
impl From<&gray::Parameters> for GrayParameters {
    fn from(p: &gray::Parameters) -> Self {
        Self {
            volume: SpecificVolume::new(p.volume),
            sound_speed: Velocity::new(p.sound_speed),
            slope: p.slope,
            gruneisen: p.gruneisen,
            gruneisen_slope: p.gruneisen_slope,
            electronic: ElectronicHeat::new(p.electronic),
            melting_temperature: Temperature::new(p.melting_temperature),
            molar_mass: MolarMass::new(p.molar_mass),
            cohesive_energy: SpecificEnergy::new(p.cohesive_energy),
            reference_temperature: Temperature::new(p.reference_temperature),
            electronic_gruneisen: p.electronic_gruneisen,
            melting_entropy: p.melting_entropy,
            liquid_softening: p.liquid_softening,
            join_ratio: p.join_ratio,
            covolume_ratio: p.covolume_ratio,
            joining: p.joining,
        }
    }
}
impl From<&Linear> for mie_gruneisen::Parameters {
    fn from(p: &Linear) -> Self {
        Self {
            density: p.density.si(),
            sound_speed: p.sound_speed.si(),
            slope: p.slope,
            gruneisen: p.gruneisen,
            heat_capacity: p.heat_capacity.si(),
            reference_temperature: p.reference_temperature.si(),
        }
    }
}
impl From<&mie_gruneisen::Parameters> for Linear {
    fn from(p: &mie_gruneisen::Parameters) -> Self {
        Self {
            density: Density::new(p.density),
            sound_speed: Velocity::new(p.sound_speed),
            slope: p.slope,
            gruneisen: p.gruneisen,
            heat_capacity: SpecificHeat::new(p.heat_capacity),
            reference_temperature: Temperature::new(p.reference_temperature),
        }
    }
}
impl From<&TillotsonParameters> for tillotson::Parameters {
    fn from(p: &TillotsonParameters) -> Self {
        Self {
            density: p.density.si(),
            a: p.a,
            b: p.b,
            bulk: p.bulk.si(),
            bulk_slope: p.bulk_slope.si(),
            energy: p.energy.si(),
            incipient: p.incipient.si(),
            complete: p.complete.si(),
            alpha: p.alpha,
            beta: p.beta,
            heat_capacity: p.heat_capacity.si(),
            reference_temperature: p.reference_temperature.si(),
        }
    }
}
impl From<&tillotson::Parameters> for TillotsonParameters {
    fn from(p: &tillotson::Parameters) -> Self {
        Self {
            density: Density::new(p.density),
            a: p.a,
            b: p.b,
            bulk: Pressure::new(p.bulk),
            bulk_slope: Pressure::new(p.bulk_slope),
            energy: SpecificEnergy::new(p.energy),
            incipient: SpecificEnergy::new(p.incipient),
            complete: SpecificEnergy::new(p.complete),
            alpha: p.alpha,
            beta: p.beta,
            heat_capacity: SpecificHeat::new(p.heat_capacity),
            reference_temperature: Temperature::new(p.reference_temperature),
        }
    }
}
impl From<&StiffenedGas> for StiffenedGasParameters {
    fn from(p: &StiffenedGas) -> Self {
        Self {
            density: Density::new(p.density),
            gamma: p.gamma,
            stiffness: Pressure::new(p.stiffness),
            heat_capacity: SpecificHeat::new(p.heat_capacity),
            reference_temperature: Temperature::new(p.reference_temperature),
        }
    }
}
impl From<&IdealGas> for IdealGasParameters {
    fn from(p: &IdealGas) -> Self {
        Self {
            density: Density::new(p.density),
            gamma: p.gamma,
            heat_capacity: SpecificHeat::new(p.heat_capacity),
            reference_temperature: Temperature::new(p.reference_temperature),
        }
    }
}
