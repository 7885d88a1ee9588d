//! The one interface to every equation of state: a closed enum, and what it answers.
use crate::model::gray::patches::Patches;
use crate::model::stiffened_gas::StiffenedGas;
use crate::model::{gray::Gray, ideal_gas::IdealGas, mie_gruneisen::MieGruneisen, tabulated::Tabulated};
use crate::model::{relax, tillotson::Tillotson};
use crate::{Instructions, Points};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Regimes of matter; `phase as u8` is the code that particles carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names say it")]
#[repr(u8)]
pub enum Phase {
    Solid = 0,
    Melting = 1,
    Liquid = 2,
    HotLiquid = 3,
    Vapour = 4,
}

/// Everything an impact particle needs of its equation of state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Pressure [Pa], unclamped: negative in tension.
    pub pressure: f64,
    /// Temperature [K], 0 where the energy lies below the cold curve.
    pub temperature: f64,
    /// Bulk (adiabatic) sound speed [m/s], with a floor of a tenth of the reference one for the metals: see
    /// [`Eos::least_sound_speed`].
    pub sound_speed: f64,
    /// Regime; a model without phases says [`Phase::Solid`] (a gas: [`Phase::Vapour`]).
    pub phase: Phase,
    /// Share of liquid, 0..1; 1 in the hot liquid and the vapour too.
    pub liquid: f64,
}

/// Parameters that make no equation of state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name}: {parameter} {why}")]
pub struct EosError {
    /// The model.
    pub name: &'static str,
    /// The parameter at fault.
    pub parameter: &'static str,
    /// What it is, what is allowed, with units.
    pub why: String,
}

/// An equation of state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Eos {
    /// Royce's three-phase GRAY.
    Gray(Gray),
    /// GRAY in patches of polynomials.
    Patches(Patches),
    /// Mie-Grueneisen on the linear Us-up Hugoniot.
    MieGruneisen(MieGruneisen),
    /// Gas of constant gamma.
    IdealGas(IdealGas),
    /// Stiffened gas.
    StiffenedGas(StiffenedGas),
    /// Tillotson's.
    Tillotson(Tillotson),
    /// States interpolated.
    Table(Tabulated),
}

macro_rules! each {
    ($eos:expr, $model:ident => $answer:expr) => {
        match $eos {
            Eos::Gray($model) => $answer,
            Eos::Patches($model) => $answer,
            Eos::MieGruneisen($model) => $answer,
            Eos::IdealGas($model) => $answer,
            Eos::StiffenedGas($model) => $answer,
            Eos::Tillotson($model) => $answer,
            Eos::Table($model) => $answer,
        }
    };
}

impl Eos {
    /// Name for people.
    pub fn name(&self) -> &'static str {
        match self {
            Eos::Gray(_) => "GRAY",
            Eos::Patches(_) => "GRAY in patches",
            Eos::MieGruneisen(_) => "Mie-Grueneisen",
            Eos::IdealGas(_) => "ideal gas",
            Eos::StiffenedGas(_) => "stiffened gas",
            Eos::Tillotson(_) => "Tillotson",
            Eos::Table(_) => "table",
        }
    }
    /// Specific volume V0 of the reference state [m3/kg].
    pub fn reference_volume(&self) -> f64 {
        each!(self, m => m.reference_volume())
    }
    /// Temperature T0 of the reference state [K].
    pub fn reference_temperature(&self) -> f64 {
        each!(self, m => m.reference_temperature())
    }
    /// Pressure, temperature, sound speed and phase at specific `volume` V [m3/kg] and `energy` E [J/kg].
    ///
    /// Finite for every finite E and every V > 0 (the models extend themselves beyond their range, see each).
    #[inline]
    pub fn point(&self, volume: f64, energy: f64) -> Point {
        each!(self, m => m.point(volume, energy))
    }
    /// As [`Eos::point`] for each of many states, the same bits: `out` is resized to their number. Several times faster.
    ///
    /// # Panics
    /// Where `volume` and `energy` differ in length.
    pub fn evaluate(&self, volume: &[f64], energy: &[f64], out: &mut Points) {
        self.evaluate_with(Instructions::best(), volume, energy, out);
    }
    /// As [`Eos::evaluate`], on the instruction set given; all give the same bits.
    ///
    /// # Panics
    /// As [`Eos::evaluate`].
    pub fn evaluate_with(&self, set: Instructions, volume: &[f64], energy: &[f64], out: &mut Points) {
        assert_eq!(volume.len(), energy.len(), "as many volumes as energies");
        out.resize(volume.len());
        match self {
            Eos::Gray(m) => return m.evaluate(set, volume, energy, out),
            Eos::Patches(m) => return m.evaluate(set, volume, energy, out),
            Eos::MieGruneisen(m) => return m.evaluate(set, volume, energy, out),
            _ => {}
        }
        for i in 0..volume.len() {
            out.set(i, self.point(volume[i], energy[i]));
            out.melting[i] = self.melting_temperature(volume[i]).unwrap_or(f64::INFINITY);
        }
    }
    /// The floor of [`Point::sound_speed`] [m/s], which stands where matter is softer or not stable at all; `None` for models that
    /// need none.
    pub fn least_sound_speed(&self) -> Option<f64> {
        match self {
            Eos::Gray(m) => Some(m.least_sound_speed()),
            Eos::Patches(m) => Some(m.gray().least_sound_speed()),
            Eos::MieGruneisen(m) => Some(m.least_sound_speed()),
            Eos::Tillotson(m) => Some(m.least_sound_speed()),
            Eos::Table(m) => Some(m.least_sound_speed()),
            Eos::IdealGas(_) | Eos::StiffenedGas(_) => None,
        }
    }
    /// The least volume [m3/kg] for which the model has formulas of its own: denser, its cold curve or Hugoniot goes on along the
    /// tangent; `None` for models whose formulas hold at any.
    pub fn least_volume(&self) -> Option<f64> {
        match self {
            Eos::Gray(m) => Some(m.least_volume()),
            Eos::Patches(m) => Some(m.gray().least_volume()),
            Eos::MieGruneisen(m) => Some(m.least_volume()),
            Eos::Table(m) => Some(m.volumes()[0]),
            Eos::Tillotson(_) | Eos::IdealGas(_) | Eos::StiffenedGas(_) => None,
        }
    }
    /// Whether (`volume` [m3/kg], `temperature` [K]) is where the model was made for: anywhere, but for a table, within its states.
    pub fn covers(&self, volume: f64, temperature: f64) -> bool {
        match self {
            Eos::Table(m) => m.encloses(volume, temperature),
            _ => true,
        }
    }
    /// Energy [J/kg] at specific `volume` [m3/kg] and `temperature` [K].
    pub fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        each!(self, m => m.energy_at(volume, temperature))
    }
    /// Pressure [Pa] at specific `volume` [m3/kg] and `temperature` [K].
    pub fn pressure_at(&self, volume: f64, temperature: f64) -> f64 {
        self.point(volume, self.energy_at(volume, temperature)).pressure
    }
    /// Melting temperature [K] at specific `volume` [m3/kg]; `None` where the model knows no melting.
    pub fn melting_temperature(&self, volume: f64) -> Option<f64> {
        match self {
            Eos::Gray(m) => Some(m.melting_temperature(volume)),
            Eos::Patches(m) => Some(m.gray().melting_temperature(volume)),
            Eos::Table(m) => m.melting_temperature(volume),
            Eos::MieGruneisen(_) | Eos::IdealGas(_) | Eos::StiffenedGas(_) | Eos::Tillotson(_) => None,
        }
    }
    /// Volume of the matter itself in a separated particle [m3/kg]: the smaller of `volume` and the volume at which
    /// P(V, `energy`) = 0.
    ///
    /// A particle that has failed goes on counting the void it opens; its phase and temperature belong to this volume.
    /// Evaluated at the volume with the void, the falling T_m(V) would melt matter that was never heated.
    pub fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        match self {
            Eos::Gray(m) => m.relaxed_volume(volume, energy),
            Eos::Patches(m) => m.relaxed_volume(volume, energy),
            Eos::MieGruneisen(m) => m.relaxed_volume(volume, energy),
            Eos::IdealGas(_) => volume,
            Eos::StiffenedGas(m) => m.relaxed_volume(volume, energy),
            Eos::Tillotson(_) => relax(self.reference_volume(), volume, |v| self.point(v, energy).pressure),
            Eos::Table(m) => m.relaxed_volume(volume, energy),
        }
    }
}
