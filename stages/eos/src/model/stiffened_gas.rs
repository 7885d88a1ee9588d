//! Stiffened gas: an ideal gas under the pull of a constant pressure, the closed-form liquid of solver tests.
use crate::{EosError, Phase, Point};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `P = (gamma - 1) c_v T / V - P_inf`, `E = c_v T + P_inf V`, `c^2 = gamma (P + P_inf) V`; below T = 0 the energy counts as the
/// cold one. Source: O. Le Metayer, J. Massoni, R. Saurel, Int. J. Therm. Sci. 43, 265 (2004), eqs 2-6 with q = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffenedGas {
    /// Density of the reference state [kg/m3].
    pub density: f64,
    /// Ratio of specific heats.
    pub gamma: f64,
    /// P_inf [Pa].
    pub stiffness: f64,
    /// Heat capacity at constant volume c_v [J/kg/K].
    pub heat_capacity: f64,
    /// Temperature of the reference state [K].
    pub reference_temperature: f64,
}

impl StiffenedGas {
    /// # Errors
    /// [`EosError`] where `gamma <= 1`, `stiffness < 0`, or another parameter isn't positive.
    pub fn new(self) -> Result<Self, EosError> {
        let wrong = |parameter, why: String| Err(EosError { name: "stiffened gas", parameter, why });
        if !(self.gamma > 1.0 && self.gamma.is_finite()) {
            return wrong("gamma", format!("is {}, must be above 1", self.gamma));
        }
        if !(self.stiffness >= 0.0 && self.stiffness.is_finite()) {
            return wrong("stiffness", format!("is {} Pa, must not be negative", self.stiffness));
        }
        for (parameter, value) in [
            ("density", self.density),
            ("heat_capacity", self.heat_capacity),
            ("reference_temperature", self.reference_temperature),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must be positive"));
            }
        }
        Ok(self)
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        1.0 / self.density
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.reference_temperature
    }
    pub(crate) fn point(&self, volume: f64, energy: f64) -> Point {
        let heat = (energy - self.stiffness * volume).max(0.0);
        Point {
            pressure: (self.gamma - 1.0) * heat / volume - self.stiffness,
            temperature: heat / self.heat_capacity,
            sound_speed: (self.gamma * (self.gamma - 1.0) * heat).sqrt(),
            phase: Phase::Liquid,
            liquid: 1.0,
        }
    }
    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        self.heat_capacity * temperature + self.stiffness * volume
    }
    /// P = 0 at `E / (P_inf gamma / (gamma - 1))`.
    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        let free = (self.gamma - 1.0) * energy / (self.gamma * self.stiffness);
        if free > 0.0 { volume.min(free) } else { volume }
    }
}
