//! GRAY: Royce's three-phase equation of state of metals, complete and thermodynamically consistent.
//!
//! `parameters.rs` what it takes; `cold.rs` functions of volume; `dense.rs` solid to hot liquid; `vapour.rs` beyond V_J.
//!
//! E. B. Royce, UCRL-51121 (1971), after R. Grover, J. Chem. Phys. 55, 3435 (1971) and D. A. Young and B. J. Alder, Phys. Rev.
//! A 3, 364 (1971), as used by Y. Liu, H.-K. Wang and X. Zhang (2013), eqs 21-30. Changes: the electronic coefficient
//! varies as V^gamma_e, the melting band derives from a potential, the cold curve and the melting law are integrated
//! exactly, and F_E has its general form: within every regime dE/dV|_T = T dP/dT|_V - P, and E and P are continuous across borders.
mod cold;
mod dense;
mod parameters;
mod vapour;
pub use parameters::{GAS_CONSTANT, Parameters};

pub use dense::Branch;

use super::table::Table;
use crate::{EosError, Phase, Point};
use dense::{Local, Regime};
use parameters::wrong;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vapour::{Join, Vapour};

/// The equation of state; made from [`Parameters`], its tables follow from them.
///
/// Range: the cold curve follows the Hugoniot up to x = [`Parameters::cap`] (0.6, or 0.92/S), and its tangent beyond; below the
/// smallest tabulated volume pressure goes on rising linearly. Loops of the van der Waals kind are kept in the vapour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Parameters", into = "Parameters")]
pub struct Gray {
    parameters: Parameters,
    constants: Constants,
    table: Table<3>,
    vapour: Vapour,
}

/// Numbers that depend on the parameters alone; heat capacities and entropies per kilogram [J/kg/K].
#[derive(Clone, Debug, PartialEq)]
struct Constants {
    /// 1 / V0 [kg/m3].
    per_volume: f64,
    /// R'.
    gas: f64,
    /// 3 R'.
    heat: f64,
    /// Delta S.
    entropy: f64,
    /// alpha.
    alpha: f64,
    /// Delta S - alpha: the isochoric entropy of melting at T_m.
    band_entropy: f64,
    /// T/T_m at which the hot liquid begins.
    hot_ratio: f64,
    /// alpha theta_h.
    hot_slope: f64,
    /// c0: the hot liquid's constant excess energy over T_m.
    hot_offset: f64,
    /// Below this T/T_m all is solid, above the other all is liquid, at any volume.
    surely_solid: f64,
    surely_liquid: f64,
    /// Compression at the cap.
    cap: f64,
    /// Smallest tabulated V/V0, and dP/du below it [Pa].
    densest: f64,
    stiffness: f64,
    /// V_J / V0.
    join: f64,
    /// Least squared sound speed [m2/s2].
    floor: f64,
}

/// Everything at one (V, T).
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Energy [J/kg].
    pub energy: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// dP/dT at constant V [Pa/K].
    pub p_t: f64,
    /// Heat capacity at constant V [J/kg/K].
    pub c_v: f64,
    /// dP/dV at constant T [Pa kg/m3].
    pub p_v: f64,
    /// Share of liquid, 0..1.
    pub liquid: f64,
}

impl Answer {
    /// Squared adiabatic sound speed [m2/s2], negative where matter is mechanically unstable.
    pub fn sound_speed_squared(&self, volume: f64, temperature: f64) -> f64 {
        volume * volume * (temperature * self.p_t * self.p_t / self.c_v - self.p_v)
    }
}

impl Gray {
    /// Builds the tables and checks the domain.
    ///
    /// # Errors
    /// [`EosError`] where a parameter is not positive, the Grueneisen coefficient falls below 1/3 in range, liquid and
    /// vapour can't be joined at V_J, or the vapour's pressure would rise with volume at high temperature.
    pub fn new(parameters: Parameters) -> Result<Gray, EosError> {
        let gray = Gray::dense(parameters)?;
        gray.check_join()?;
        Ok(gray)
    }

    /// As [`Gray::new`], but the vapour's join is left unchecked: what a fit to solid and liquid states may pass through.
    pub(crate) fn dense(parameters: Parameters) -> Result<Gray, EosError> {
        parameters.check()?;
        let p = &parameters;
        let table = cold::table(p);
        let mut constants = Constants::new(p, table.range().0);
        let end = Local::at(p, &constants, &table, constants.densest).answer(p, &constants, 0.0, &Regime::Solid);
        constants.stiffness = -end.p_v * p.volume;
        let join = join(p, &constants, &table);
        let vapour = Vapour::new(p, &constants, &join);
        Ok(Gray { parameters, constants, table, vapour })
    }

    /// Temperature [K] at `volume` [m3/kg] and `energy` [J/kg] on one branch, stable or not; as at V_J beyond it.
    pub fn branch_temperature(&self, volume: f64, energy: f64, branch: Branch) -> f64 {
        self.local(self.ratio(volume).0).branch_temperature(&self.constants, energy, branch)
    }

    /// Everything at `volume` [m3/kg] and `temperature` [K] on one branch, stable or not; as at V_J beyond it.
    pub fn branch_at(&self, volume: f64, temperature: f64, branch: Branch) -> Answer {
        let local = self.local(self.ratio(volume).0);
        let regime = match branch {
            Branch::Solid => Regime::Solid,
            Branch::Liquid if temperature > self.constants.hot_ratio * local.tm => Regime::HotLiquid,
            Branch::Liquid => Regime::Liquid,
        };
        local.answer(&self.parameters, &self.constants, temperature, &regime)
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
    /// Attraction a_y of the vapour [J m3/kg2].
    pub fn attraction(&self) -> f64 {
        self.vapour.attraction
    }
    /// Joining functions F_p and F_E [m3/kg] of the vapour at specific `volume` [m3/kg].
    pub fn joining(&self, volume: f64) -> (f64, f64) {
        self.vapour.joining(self.parameters.joining, volume)
    }

    /// V/V0, not below the smallest tabulated, and how far it was below.
    #[inline]
    fn ratio(&self, volume: f64) -> (f64, f64) {
        let u = volume * self.constants.per_volume;
        let held = u.max(self.constants.densest);
        (held, held - u)
    }
    #[inline]
    fn local(&self, u: f64) -> Local {
        Local::at(&self.parameters, &self.constants, &self.table, u)
    }

    /// Pressure, temperature, sound speed and phase at `volume` [m3/kg] and `energy` [J/kg].
    #[inline]
    pub fn point(&self, volume: f64, energy: f64) -> Point {
        let (p, k) = (&self.parameters, &self.constants);
        let (u, under) = self.ratio(volume);
        let (answer, temperature, phase) = if u > k.join {
            let t = self.vapour.temperature(p, k, volume, energy);
            (self.vapour.answer(p, k, volume, t), t, Phase::Vapour)
        } else {
            let local = self.local(u);
            let (t, regime) = local.temperature(p, k, energy);
            (local.answer(p, k, t, &regime), t, regime.phase())
        };
        let held = u * p.volume;
        let c2 = answer.sound_speed_squared(held, temperature);
        Point {
            pressure: answer.pressure + under * k.stiffness,
            temperature,
            sound_speed: c2.max(k.floor).sqrt(),
            phase,
            liquid: answer.liquid,
        }
    }

    pub(crate) fn reference_volume(&self) -> f64 {
        self.parameters.volume
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.parameters.reference_temperature
    }
    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        self.at(volume, temperature).0.energy
    }

    /// Everything at `volume` [m3/kg] and `temperature` [K], and the regime.
    pub fn at(&self, volume: f64, temperature: f64) -> (Answer, Phase) {
        let (p, k) = (&self.parameters, &self.constants);
        let (u, under) = self.ratio(volume);
        let t = temperature.max(0.0);
        if u > k.join {
            return (self.vapour.answer(p, k, volume, t), Phase::Vapour);
        }
        let local = self.local(u);
        let regime = local.regime(p, k, t);
        let mut answer = local.answer(p, k, t, &regime);
        answer.pressure += under * k.stiffness;
        (answer, regime.phase())
    }

    /// Melting temperature T_m [K] at `volume` [m3/kg], by the Lindemann law; held at its value at V_J beyond.
    pub fn melting_temperature(&self, volume: f64) -> f64 {
        self.local(self.ratio(volume).0.min(self.constants.join)).tm
    }

    /// Where melting begins and ends [K] at `volume` [m3/kg], and where the hot liquid begins; as at V_J beyond it.
    pub fn borders(&self, volume: f64) -> [f64; 3] {
        let local = self.local(self.ratio(volume).0.min(self.constants.join));
        let (start, end) = local.melting_range(&self.parameters, &self.constants);
        [start, end, self.constants.hot_ratio * local.tm]
    }

    /// The smaller of `volume` and the smallest volume at which P = 0 at `energy` (both per kilogram).
    ///
    /// Marches from 0.9 V0, where the cold pressure alone is positive, to the first negative pressure, then closes in.
    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        let v0 = self.parameters.volume;
        let pressure = |u: f64| self.point(u * v0, energy).pressure;
        let end = volume / v0;
        let mut low = 0.9;
        while low < end {
            // Below V_J in steps of V0/20; the vapour varies on the scale of its own volume.
            let high = (low * 1.05).max(low + 0.05).min(end);
            if pressure(high) < 0.0 {
                let root = hvi_kit::math::bisect(low, high, 1e-12, pressure);
                return root.unwrap_or(low) * v0;
            }
            low = high;
        }
        volume
    }

    /// Refuses parameters whose liquid and vapour do not join: see the caveats in `vapour.rs`' source.
    fn check_join(&self) -> Result<(), EosError> {
        let (p, k) = (&self.parameters, &self.constants);
        let vj = p.join_ratio * p.volume;
        let local = self.local(k.join);
        // Colder matter than the hot liquid is discontinuous at V_J: it must be in tension there, where it is cut anyway.
        let border = k.hot_ratio * local.tm;
        let pressure = local.answer(p, k, border, &Regime::HotLiquid).pressure;
        if pressure > 0.0 {
            let why = format!(
                "is {}: at V_J the hot liquid begins at {border:.0} K with {:.3} GPa; it must still be in tension there: \
                 take a larger V_J",
                p.join_ratio,
                pressure / 1e9
            );
            return wrong("join_ratio", why);
        }
        if self.vapour.attraction <= 0.0 {
            return wrong("cohesive_energy", format!("is {} J/kg: the vapour would not attract", p.cohesive_energy));
        }
        // Far above any critical point the pressure must fall with volume.
        for t in [5e4, 1e5] {
            for i in 0..40 {
                let v = vj * (1.0 + 1e-9) * (1.0 + 0.05 * i as f64);
                if self.vapour.answer(p, k, v, t).p_v >= 0.0 {
                    let why = format!(
                        "is {}: at {t:.0} K the vapour's pressure rises with volume at {:.2} V0; take a smaller V_b or a larger \
                         V_J",
                        p.covolume_ratio,
                        v / p.volume
                    );
                    return wrong("covolume_ratio", why);
                }
            }
        }
        Ok(())
    }
}

impl Constants {
    fn new(p: &Parameters, densest: f64) -> Constants {
        let gas = p.specific_gas_constant();
        let (entropy, alpha) = (p.melting_entropy * gas, p.liquid_softening * gas);
        let hot_ratio = 1.5 * gas / alpha;
        // The band's relative width is at most 1/2 (see `dense.rs`), so its ends can't lie further from 1 than this.
        let (square, widest) = ((entropy - alpha) * (entropy - alpha), 0.5 * alpha * (entropy - alpha));
        Constants {
            per_volume: 1.0 / p.volume,
            gas,
            heat: 3.0 * gas,
            entropy,
            alpha,
            band_entropy: entropy - alpha,
            hot_ratio,
            hot_slope: alpha * hot_ratio,
            hot_offset: entropy - 0.5 * alpha * (1.0 - hot_ratio * hot_ratio),
            surely_solid: (entropy - (square + widest).sqrt()) / alpha,
            surely_liquid: (entropy - (square - widest).sqrt()) / alpha,
            cap: p.cap(),
            densest,
            stiffness: 0.0,
            join: p.join_ratio,
            floor: 0.01 * p.sound_speed * p.sound_speed,
        }
    }
}

/// The hot liquid at V_J as polynomials in temperature, read off at three temperatures' worth of exact coefficients.
fn join(p: &Parameters, k: &Constants, table: &Table<3>) -> Join {
    let local = Local::at(p, k, table, k.join);
    let cold = local.answer(p, k, 0.0, &Regime::HotLiquid);
    let warm = local.answer(p, k, 1.0, &Regime::HotLiquid);
    Join {
        volume: p.join_ratio * p.volume,
        energy: [cold.energy, cold.c_v, 0.5 * (warm.c_v - cold.c_v)],
        pressure: [cold.pressure, cold.p_t, 0.5 * (warm.p_t - cold.p_t)],
    }
}

impl TryFrom<Parameters> for Gray {
    type Error = EosError;
    fn try_from(parameters: Parameters) -> Result<Gray, EosError> {
        Gray::new(parameters)
    }
}
impl From<Gray> for Parameters {
    fn from(gray: Gray) -> Parameters {
        gray.parameters
    }
}
