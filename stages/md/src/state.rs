//! What a run of molecular dynamics leaves: one equilibrium state.
use hvi_kit::Artifact;
use hvi_kit::view::Scalar;
use serde::{Deserialize, Serialize};

/// Whether the atoms are on a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names say it")]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    Solid,
    Liquid,
}

/// One equilibrium state: averages over a run at fixed volume and temperature, with standard errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Volume of the zero-pressure lattice at 0 K [m3/kg], the unit of `volume_ratio`.
    pub lattice_volume: f64,
    /// Molar mass [kg/mol].
    pub molar_mass: f64,
    /// Mean temperature [K].
    pub temperature: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Standard error of the pressure [Pa].
    pub pressure_error: f64,
    /// Internal energy [J/kg], zero at the lattice at rest at 0 K and zero pressure.
    pub energy: f64,
    /// Standard error of the energy [J/kg].
    pub energy_error: f64,
    /// Standard error of the mean temperature [K].
    pub temperature_error: f64,
    /// Solid or liquid, by a structural measure.
    pub phase: Phase,
    /// Number of atoms.
    pub atoms: u32,
    /// Time averaged over [s].
    pub averaged: f64,
}

impl Artifact for State {
    const KIND: &'static str = "md-state/1";
    fn scalars(&self) -> Vec<Scalar> {
        vec![Scalar::number("pressure", self.pressure / 1e9, "GPa")]
    }
}
