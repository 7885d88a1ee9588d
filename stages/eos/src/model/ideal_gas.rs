//! Gas of constant gamma: the closed-form partner of solver tests (Noh, Sod).
use crate::{EosError, Phase, Point};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `P = (gamma - 1) E / V`, `T = E / c_v`, `c^2 = gamma (gamma - 1) E`. Negative energies count as zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IdealGas {
    /// Density of the reference state [kg/m3].
    pub density: f64,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// Heat capacity at constant volume c_v [J/kg/K].
    pub heat_capacity: f64,
    /// Temperature of the reference state [K].
    pub reference_temperature: f64,
}

impl IdealGas {
    /// # Errors
    /// [`EosError`] where `gamma <= 1` or another parameter isn't positive.
    pub fn new(density: f64, gamma: f64, heat_capacity: f64, reference_temperature: f64) -> Result<Self, EosError> {
        let wrong = |parameter, why: String| Err(EosError { name: "ideal gas", parameter, why });
        if !(gamma > 1.0 && gamma.is_finite()) {
            return wrong("gamma", format!("is {gamma}, must be above 1"));
        }
        for (parameter, value) in
            [("density", density), ("heat_capacity", heat_capacity), ("reference_temperature", reference_temperature)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must be positive"));
            }
        }
        Ok(Self { density, gamma, heat_capacity, reference_temperature })
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        1.0 / self.density
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.reference_temperature
    }
    pub(crate) fn point(&self, volume: f64, energy: f64) -> Point {
        let energy = energy.max(0.0);
        Point {
            pressure: (self.gamma - 1.0) * energy / volume,
            temperature: energy / self.heat_capacity,
            sound_speed: (self.gamma * (self.gamma - 1.0) * energy).sqrt(),
            phase: Phase::Vapour,
            liquid: 1.0,
        }
    }
    pub(crate) fn energy_at(&self, _volume: f64, temperature: f64) -> f64 {
        self.heat_capacity * temperature
    }
}
