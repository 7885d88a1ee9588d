//! Parameters of GRAY, and the domain in which they make an equation of state.
use crate::EosError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Molar gas constant [J/mol/K] (CODATA 2018, exact).
pub const GAS_CONSTANT: f64 = 8.314462618;

/// Parameters of [`super::Gray`], SI per kilogram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parameters {
    /// V0: specific volume at zero pressure and T0 [m3/kg].
    pub volume: f64,
    /// C: intercept of Us = C + S up [m/s].
    pub sound_speed: f64,
    /// S: slope of Us = C + S up.
    pub slope: f64,
    /// gamma0: Grueneisen coefficient at V0.
    pub gruneisen: f64,
    /// a: gamma = gamma0 - a (1 - V/V0).
    pub gruneisen_slope: f64,
    /// G0: electronic heat coefficient at V0 [J/kg/K2]; g_e / M.
    pub electronic: f64,
    /// Tm0: melting temperature at V = V0 [K], not at one atmosphere.
    pub melting_temperature: f64,
    /// M [kg/mol].
    pub molar_mass: f64,
    /// Energy of the dilute gas at T -> 0 above the reference state [J/kg]; sets the vapour's attraction a_y.
    pub cohesive_energy: f64,
    /// T0: temperature of the reference state [K].
    pub reference_temperature: f64,
    /// gamma_e: electronic Grueneisen coefficient.
    pub electronic_gruneisen: f64,
    /// Delta S of melting along the melting curve, in units of R.
    pub melting_entropy: f64,
    /// alpha: fall of the liquid's heat capacity by T/Tm, in units of R.
    pub liquid_softening: f64,
    /// V_J / V0: where the vapour begins.
    pub join_ratio: f64,
    /// V_b / V0: excluded volume of the vapour.
    pub covolume_ratio: f64,
    /// theta: pole of the vapour's joining functions.
    pub joining: f64,
}

impl Parameters {
    /// A metal by its seven paper parameters, in SI, with Royce's constants for the rest.
    ///
    /// - `volume` V0 [m3/kg], `sound_speed` C [m/s], `slope` S, `gruneisen` gamma0, `gruneisen_slope` a
    /// - `electronic` g_e [J/mol/K2], `melting_temperature` Tm0 [K] at V0
    /// - `molar_mass` [kg/mol], `cohesive_energy` [J/mol]: energy of the dilute gas at T -> 0 above (V0, 300 K)
    pub fn metal(
        volume: f64,
        sound_speed: f64,
        slope: f64,
        gruneisen: f64,
        gruneisen_slope: f64,
        electronic: f64,
        melting_temperature: f64,
        molar_mass: f64,
        cohesive_energy: f64,
    ) -> Parameters {
        Parameters {
            volume,
            sound_speed,
            slope,
            gruneisen,
            gruneisen_slope,
            electronic: electronic / molar_mass,
            melting_temperature,
            molar_mass,
            cohesive_energy: cohesive_energy / molar_mass,
            reference_temperature: 300.0,
            electronic_gruneisen: 2.0 / 3.0,
            melting_entropy: 1.16,
            liquid_softening: 0.16,
            join_ratio: 1.5,
            covolume_ratio: 0.5,
            joining: 1.0,
        }
    }

    /// R' = R / M [J/kg/K].
    pub fn specific_gas_constant(&self) -> f64 {
        GAS_CONSTANT / self.molar_mass
    }

    /// Compression x = 1 - V/V0 up to which the cold curve follows the Hugoniot; beyond, its tangent.
    pub fn cap(&self) -> f64 {
        (0.92 / self.slope).min(0.6)
    }

    /// Largest compression with dense formulas: where the Lindemann exponent lambda would fall to a tenth, 0.95 at most.
    pub(super) fn densest(&self) -> f64 {
        ((self.gruneisen - 1.0 / 3.0 - 0.05) / self.gruneisen_slope).min(0.95)
    }

    /// The largest a that leaves the Grueneisen coefficient above 1/3 wherever the cold curve follows the Hugoniot.
    pub fn steepest_gruneisen(&self) -> f64 {
        (self.gruneisen - 1.0 / 3.0 - 0.05) / self.cap()
    }

    /// Checks each parameter by itself and those that meet in a pole or a sign.
    pub(super) fn check(&self) -> Result<(), EosError> {
        for (parameter, value) in [
            ("volume", self.volume),
            ("sound_speed", self.sound_speed),
            ("slope", self.slope),
            ("gruneisen", self.gruneisen),
            ("gruneisen_slope", self.gruneisen_slope),
            ("electronic", self.electronic),
            ("melting_temperature", self.melting_temperature),
            ("molar_mass", self.molar_mass),
            ("cohesive_energy", self.cohesive_energy),
            ("reference_temperature", self.reference_temperature),
            ("electronic_gruneisen", self.electronic_gruneisen),
            ("melting_entropy", self.melting_entropy),
            ("liquid_softening", self.liquid_softening),
            ("join_ratio", self.join_ratio),
            ("covolume_ratio", self.covolume_ratio),
            ("joining", self.joining),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must be positive and finite"));
            }
        }
        if self.slope > 10.0 {
            return wrong("slope", format!("is {}: the pole at x = 1/S leaves no range, 10 at most", self.slope));
        }
        if self.densest() < self.cap() {
            let why = format!(
                "is {}: the Grueneisen coefficient falls below 1/3 within the range of compression x <= {:.3}; melting \
                 would then fall with pressure. At most {:.3} with gamma0 = {}",
                self.gruneisen_slope,
                self.cap(),
                self.steepest_gruneisen(),
                self.gruneisen
            );
            return wrong("gruneisen_slope", why);
        }
        if 1.5 * self.liquid_softening >= self.melting_entropy {
            let why = format!(
                "is {} R: it must be below two thirds of the melting entropy {} R",
                self.liquid_softening, self.melting_entropy
            );
            return wrong("liquid_softening", why);
        }
        if self.join_ratio <= 1.1 {
            return wrong("join_ratio", format!("is {}: the vapour must begin above 1.1 V0", self.join_ratio));
        }
        let packing = self.covolume_ratio / self.join_ratio;
        if packing >= self.joining.min(1.0) {
            let why = format!(
                "is {}: V_b/V_J = {packing:.3} must be below 1 and below theta = {}",
                self.covolume_ratio, self.joining
            );
            return wrong("covolume_ratio", why);
        }
        Ok(())
    }
}

/// An [`EosError`] of GRAY.
pub(super) fn wrong<T>(parameter: &'static str, why: String) -> Result<T, EosError> {
    Err(EosError { name: "GRAY", parameter, why })
}
