//! What a run with two phases leaves: a point of the melting curve.
use hvi_kit::Artifact;
use hvi_kit::view::{Cell, Scalar, View};
use serde::{Deserialize, Serialize};

/// One phase at the pressure and temperature of melting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseAt {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Standard error of the volume [m3/kg].
    pub volume_error: f64,
    /// Specific enthalpy E + P V [J/kg]; E is zero at the lattice at rest at 0 K and zero pressure.
    pub enthalpy: f64,
    /// Standard error of the enthalpy [J/kg].
    pub enthalpy_error: f64,
}

/// A start that ended with one phase only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Temperature that both phases began with [K].
    pub start: f64,
    /// Share of crystalline atoms at its end.
    pub solid: f64,
    /// Temperature at its end [K].
    pub end: f64,
}

/// One look at the cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Time since walls and heat were let go [s].
    pub time: f64,
    /// Temperature, averaged since the last look [K].
    pub temperature: f64,
    /// Share of crystalline atoms.
    pub solid: f64,
}

/// A point of the melting curve: solid and liquid in equilibrium at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coexistence {
    /// Pressure [Pa].
    pub pressure: f64,
    /// Melting temperature [K].
    pub temperature: f64,
    /// Standard error of the temperature, by blocks [K].
    pub temperature_error: f64,
    /// Volume of the zero-pressure lattice at 0 K [m3/kg].
    pub lattice_volume: f64,
    /// Molar mass [kg/mol].
    pub molar_mass: f64,
    /// The crystal there, alone in its box.
    pub solid: PhaseAt,
    /// The melt there, alone in its box.
    pub liquid: PhaseAt,
    /// Number of atoms in the cell of both phases.
    pub atoms: u32,
    /// Time averaged over [s].
    pub averaged: f64,
    /// Whether the standard error came down to what was asked.
    pub on_target: bool,
    /// Earlier starts that one phase did not survive.
    pub attempts: Vec<Attempt>,
    /// The run, look by look.
    pub looks: Vec<Look>,
    /// Mean order along the cell's long axis at the end, by share of its length; above [`crate::local_order::LEAST`] it is solid.
    pub profile: Vec<f64>,
}

impl Coexistence {
    /// Slope dT/dP of the melting curve [K/Pa] by Clausius and Clapeyron, T dV/dH, and its standard error.
    pub fn slope(&self) -> (f64, f64) {
        let (volume, heat) = (self.liquid.volume - self.solid.volume, self.liquid.enthalpy - self.solid.enthalpy);
        let slope = self.temperature * volume / heat;
        let square = |x: f64| x * x;
        let of = |e: f64, whole: f64| square(e / whole);
        let relative = of(self.liquid.volume_error, volume)
            + of(self.solid.volume_error, volume)
            + of(self.liquid.enthalpy_error, heat)
            + of(self.solid.enthalpy_error, heat);
        (slope, slope.abs() * relative.sqrt())
    }

    /// Entropy of melting at this pressure [J/kg/K].
    pub fn entropy(&self) -> f64 {
        (self.liquid.enthalpy - self.solid.enthalpy) / self.temperature
    }

    /// Half way between both phases' volumes [m3/kg]: where their free energies at this volume and temperature are equal, to
    /// first order in the difference.
    pub fn middle_volume(&self) -> f64 {
        0.5 * (self.solid.volume + self.liquid.volume)
    }
}

impl Artifact for Coexistence {
    const KIND: &'static str = "md-coexistence/1";
    fn scalars(&self) -> Vec<Scalar> {
        let uncertain = |name: &str, value: f64, error: f64, unit: &str| Scalar {
            name: name.into(),
            unit: unit.into(),
            value: Cell::Uncertain(value, error),
        };
        let ratio = |p: &PhaseAt| p.volume / self.lattice_volume;
        let (slope, slope_error) = self.slope();
        let last = self.looks.last().map_or(0.0, |l| l.solid);
        vec![
            Scalar::number("pressure", self.pressure / 1e9, "GPa"),
            uncertain("melting temperature", self.temperature, self.temperature_error, "K"),
            Scalar::number("V/V0 solid", ratio(&self.solid), ""),
            Scalar::number("V/V0 liquid", ratio(&self.liquid), ""),
            Scalar::number("entropy of melting", self.entropy() * self.molar_mass, "J/mol/K"),
            uncertain("slope of the melting curve", slope * 1e9, slope_error * 1e9, "K/GPa"),
            Scalar::number("solid at the end", last, ""),
            Scalar::number("averaged", self.averaged * 1e12, "ps"),
            Scalar::number("failed starts", self.attempts.len() as f64, ""),
            Scalar::text("error target", if self.on_target { "met" } else { "missed" }),
        ]
    }
    fn views(&self) -> Vec<View> {
        super::show::views(self)
    }
}
