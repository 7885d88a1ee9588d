//! What a run of molecular dynamics leaves: one equilibrium state.
use crate::potential::element::symbol;
use crate::void::TORN;
use hvi_kit::Artifact;
use hvi_kit::view::{Cell, Frame, Scalar, Trajectory, View};
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
///
/// Pressure and energy are those of a large piece of metal: the motion of the centre of mass, which the run lacks, is
/// added (see [`crate::averaging`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Volume of the zero-pressure lattice at 0 K [m3/kg], the unit of `volume_ratio`.
    pub lattice_volume: f64,
    /// Molar mass [kg/mol].
    pub molar_mass: f64,
    /// Temperature of the heat bath [K], which pressure and energy belong to.
    pub temperature: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Standard error of the pressure [Pa]; in a crystal with a floor for modes that keep their energy, good to a factor of 2.
    pub pressure_error: f64,
    /// Internal energy [J/kg], zero at the lattice at rest at 0 K and zero pressure.
    pub energy: f64,
    /// Standard error of the energy [J/kg].
    pub energy_error: f64,
    /// Standard error of the temperature [K]: 0, the bath's is given and its noise is in the other errors.
    pub temperature_error: f64,
    /// Solid or liquid, by a structural measure.
    pub phase: Phase,
    /// Number of atoms.
    pub atoms: u32,
    /// Time averaged over [s].
    pub averaged: f64,
    /// Steps taken in all, equilibration included.
    pub steps: u64,
    /// Whether averages are harmonically mapped (solids whose atoms all stayed at their sites), or plain.
    pub mapped: bool,
    /// Whether the pressure's standard error came down to what was asked; else the longest time was spent.
    pub on_target: bool,
    /// Translational order, 1 in a crystal at rest, 1/atoms where there is no lattice (see [`crate::order`]).
    pub order: f64,
    /// Root mean square way of atoms from their sites, over the distance of nearest sites.
    pub displacement: f64,
    /// Share of the box that is void at the end (see [`crate::void`]).
    pub void: f64,
    /// Frames of the averaging, where they were asked for, those before a change of phase too.
    pub trajectory: Vec<Frame>,
}

impl State {
    /// Whether it has torn: matter beside voids, which is neither crystal nor melt at its volume. Fits and tables leave it out.
    pub fn is_torn(&self) -> bool {
        self.void > TORN
    }
}

/// The states that are not torn by isochore, volumes rising, temperatures rising on each.
pub fn isochores(states: &[State]) -> Vec<Vec<&State>> {
    let mut sorted: Vec<&State> = states.iter().filter(|s| !s.is_torn()).collect();
    sorted.sort_by(|a, b| a.volume.total_cmp(&b.volume).then(a.temperature.total_cmp(&b.temperature)));
    // Volumes of one isochore may differ by rounding only.
    let mut all: Vec<Vec<&State>> =
        sorted.chunk_by(|a, b| (a.volume - b.volume).abs() < 1e-6 * a.volume).map(<[&State]>::to_vec).collect();
    all.iter_mut().for_each(|same| same.sort_by(|a, b| a.temperature.total_cmp(&b.temperature)));
    all
}

impl Artifact for State {
    const KIND: &'static str = "md-state/3";
    fn scalars(&self) -> Vec<Scalar> {
        let uncertain = |name: &str, value: f64, error: f64, unit: &str| Scalar {
            name: name.into(),
            unit: unit.into(),
            value: Cell::Uncertain(value, error),
        };
        let phase = match self.phase {
            _ if self.is_torn() => "torn",
            Phase::Solid => "solid",
            Phase::Liquid => "liquid",
        };
        vec![
            Scalar::number("V/V0", self.volume / self.lattice_volume, ""),
            Scalar::number("temperature", self.temperature, "K"),
            uncertain("pressure", self.pressure / 1e9, self.pressure_error / 1e9, "GPa"),
            uncertain("energy", self.energy / 1e3, self.energy_error / 1e3, "kJ/kg"),
            Scalar::text("phase", phase),
            Scalar::number("averaged", self.averaged * 1e12, "ps"),
            Scalar::number("steps", self.steps as f64, ""),
            Scalar::text("error target", if self.on_target { "met" } else { "missed" }),
        ]
    }
    fn views(&self) -> Vec<View> {
        if self.trajectory.is_empty() {
            return Vec::new();
        }
        let element = symbol(self.molar_mass * 1e3).to_string();
        vec![View::Trajectory(Trajectory { title: "Trajectory".into(), element, frames: self.trajectory.clone() })]
    }
}
