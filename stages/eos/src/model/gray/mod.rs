//! GRAY: Royce's three-phase equation of state of metals, complete and thermodynamically consistent.
//!
//! `parameters.rs` what it takes; `cold.rs` functions of volume; `dense.rs` solid to hot liquid; `vapour.rs` beyond V_J;
//! `batch.rs` eight states at a time; `patches.rs` polynomials in their place, to a stated error.
//!
//! E. B. Royce, UCRL-51121 (1971), after R. Grover, J. Chem. Phys. 55, 3435 (1971) and D. A. Young and B. J. Alder, Phys. Rev.
//! A 3, 364 (1971), as used by Y. Liu, H.-K. Wang and X. Zhang (2013), eqs 21-30. Changes: the electronic coefficient
//! varies as V^gamma_e, the melting band derives from a potential, the cold curve and the melting law are integrated
//! exactly, and F_E has its general form: within every regime dE/dV|_T = T dP/dT|_V - P, and E and P are continuous across borders.
mod batch;
mod cold;
mod dense;
mod parameters;
pub mod patches;
mod vapour;
pub use parameters::{GAS_CONSTANT, Parameters};

pub use dense::Branch;

use crate::lanes::{Plain, Real};
use crate::{EosError, Phase, Point};
use cold::Functions;
use dense::{Local, Regime, Response};
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
    functions: Functions,
    vapour: Vapour,
}

/// Numbers that depend on the parameters alone; heat capacities and entropies per kilogram [J/kg/K].
#[derive(Clone, Debug, PartialEq)]
struct Constants {
    /// V0 [m3/kg] and 1 / V0.
    volume: f64,
    per_volume: f64,
    /// gamma0, a, a / V0 and gamma_e.
    gruneisen: f64,
    gruneisen_slope: f64,
    gruneisen_step: f64,
    electronic_gruneisen: f64,
    /// theta of the vapour.
    joining: f64,
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
        gray.check_cold()?;
        gray.check_join()?;
        Ok(gray)
    }

    /// Whether the cold pressure rises with compression all over the range of the Hugoniot.
    fn check_cold(&self) -> Result<(), EosError> {
        let (p, k) = (&self.parameters, &self.constants);
        for i in 0..=50 {
            let x = p.cap() * f64::from(i) / 50.0;
            let slope = Local::at(k, 1.0 - x, self.functions.at::<Plain>(1.0 - x)).solid(k, 0.0).p_v;
            if !(slope < 0.0) {
                let why = format!(
                    "is {}: the cold pressure would fall with compression at V/V0 = {:.3}; metals have 1 to 3",
                    p.gruneisen,
                    1.0 - x
                );
                return parameters::wrong("gruneisen", why);
            }
        }
        Ok(())
    }

    /// As [`Gray::new`], but the vapour's join is left unchecked: what a fit to solid and liquid states may pass through.
    pub(crate) fn dense(parameters: Parameters) -> Result<Gray, EosError> {
        parameters.check()?;
        let p = &parameters;
        let mut constants = Constants::new(p);
        let functions = Functions::new(p, constants.band_entropy);
        constants.densest = functions.densest();
        let local = |u: f64| Local::at(&constants, u, functions.at::<Plain>(u));
        let stiffness = -local(constants.densest).solid(&constants, 0.0).p_v * p.volume;
        let vapour = Vapour::new(p, &constants, &join(p, &constants, &local(constants.join)));
        constants.stiffness = stiffness;
        Ok(Gray { parameters, constants, functions, vapour })
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
        local.answer(&self.constants, temperature, regime)
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
        self.vapour.joins(self.constants.joining, volume)
    }

    /// V/V0, not below the smallest tabulated, and how far it was below.
    #[inline]
    fn ratio(&self, volume: f64) -> (f64, f64) {
        let u = volume * self.constants.per_volume;
        let held = u.max(self.constants.densest);
        (held, held - u)
    }
    #[inline]
    fn local(&self, u: f64) -> Local<f64> {
        Local::at(&self.constants, u, self.functions.at::<Plain>(u))
    }

    /// Pressure, temperature, sound speed and phase at `volume` [m3/kg] and `energy` [J/kg].
    #[inline]
    pub fn point(&self, volume: f64, energy: f64) -> Point {
        let k = &self.constants;
        let (u, under) = self.ratio(volume);
        let ((temperature, response), phase) = if u > k.join {
            (self.vapour_state(volume, energy), Phase::Vapour)
        } else {
            let local = self.local(u);
            let regime = local.regime_of(k, energy);
            let state = match regime {
                Regime::Solid => solid_state(k, &local, energy),
                Regime::Melting => melting_state(k, &local, energy),
                Regime::Liquid => liquid_state(k, &local, energy),
                Regime::HotLiquid => hot_state(k, &local, energy),
            };
            (state, regime.phase())
        };
        Point {
            pressure: response.pressure + under * k.stiffness,
            temperature,
            sound_speed: sound_speed(k, u * k.volume, temperature, &response),
            phase,
            liquid: response.liquid,
        }
    }

    /// Temperature and response of the vapour.
    #[inline(always)]
    fn vapour_state<R: Real>(&self, volume: R, energy: R) -> (R, Response<R>) {
        let t = self.vapour.temperature(&self.constants, volume, energy);
        (t, self.vapour.response(&self.constants, volume, t))
    }

    pub(crate) fn least_volume(&self) -> f64 {
        self.parameters.volume * (1.0 - self.parameters.cap())
    }
    pub(crate) fn least_sound_speed(&self) -> f64 {
        self.constants.floor.sqrt()
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
        let k = &self.constants;
        let (u, under) = self.ratio(volume);
        let t = temperature.max(0.0);
        if u > k.join {
            let r = self.vapour.response(k, volume, t);
            let energy = self.vapour.energy(k, volume, t);
            let Response { pressure, p_t, c_v, p_v, liquid } = r;
            return (Answer { energy, pressure, p_t, c_v, p_v, liquid }, Phase::Vapour);
        }
        let local = self.local(u);
        let regime = local.regime(k, t);
        let mut answer = local.answer(k, t, regime);
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
        let [start, end] = local.melting_range(&self.constants);
        [start, end, self.constants.hot_ratio * local.tm]
    }

    /// See [`crate::Eos::relaxed_volume`].
    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        super::relax(self.parameters.volume, volume, |v| self.point(v, energy).pressure)
    }

    /// Refuses parameters whose liquid and vapour do not join: see the caveats in `vapour.rs`' source.
    fn check_join(&self) -> Result<(), EosError> {
        let (p, k) = (&self.parameters, &self.constants);
        let vj = p.join_ratio * p.volume;
        let local = self.local(k.join);
        // Colder matter than the hot liquid is discontinuous at V_J: it must be in tension there, where it is cut anyway.
        let border = k.hot_ratio * local.tm;
        let pressure = local.answer(k, border, Regime::HotLiquid).pressure;
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
        // Above the critical point, which what joins vapour and liquid raises by a seventh, the pressure must fall with volume.
        let critical = self.vapour.critical_temperature(k);
        for t in [1.3 * critical, 1.7 * critical, 2.5 * critical, 5e4, 1e5] {
            for i in 0..40 {
                let v = vj * (1.0 + 1e-9) * (1.0 + 0.05 * i as f64);
                if self.vapour.response(k, v, t).p_v >= 0.0 {
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

/// Temperature and response of the solid at `energy`; its kin below for the other regimes.
#[inline(always)]
fn solid_state<R: Real>(k: &Constants, local: &Local<R>, energy: R) -> (R, Response<R>) {
    let t = local.solid_temperature(k, energy);
    (t, local.solid(k, t))
}
#[inline(always)]
fn melting_state<R: Real>(k: &Constants, local: &Local<R>, energy: R) -> (R, Response<R>) {
    let t = local.melting_temperature(k, energy);
    (t, local.melting(k, t))
}
#[inline(always)]
fn liquid_state<R: Real>(k: &Constants, local: &Local<R>, energy: R) -> (R, Response<R>) {
    let t = local.liquid_temperature(k, energy);
    (t, local.liquid(k, t))
}
#[inline(always)]
fn hot_state<R: Real>(k: &Constants, local: &Local<R>, energy: R) -> (R, Response<R>) {
    let t = local.hot_temperature(k, energy);
    (t, local.hot(k, t))
}

/// Adiabatic sound speed [m/s], floored.
#[inline(always)]
fn sound_speed<R: Real>(k: &Constants, volume: R, t: R, r: &Response<R>) -> R {
    let c2 = volume * volume * (t * r.p_t * r.p_t / r.c_v - r.p_v);
    c2.at_least(k.floor).root()
}

impl Constants {
    fn new(p: &Parameters) -> Constants {
        let gas = p.specific_gas_constant();
        let (entropy, alpha) = (p.melting_entropy * gas, p.liquid_softening * gas);
        let hot_ratio = 1.5 * gas / alpha;
        // The band's relative width is at most 1/2 (see `cold.rs`), so its ends can't lie further from 1 than this.
        let (square, widest) = ((entropy - alpha) * (entropy - alpha), 0.51 * alpha * (entropy - alpha));
        Constants {
            volume: p.volume,
            per_volume: 1.0 / p.volume,
            gruneisen: p.gruneisen,
            gruneisen_slope: p.gruneisen_slope,
            gruneisen_step: p.gruneisen_slope / p.volume,
            electronic_gruneisen: p.electronic_gruneisen,
            joining: p.joining,
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
            densest: 0.0,
            stiffness: 0.0,
            join: p.join_ratio,
            floor: 0.01 * p.sound_speed * p.sound_speed,
        }
    }
}

/// The hot liquid at V_J as polynomials in temperature, read off at three temperatures' worth of exact coefficients.
fn join(p: &Parameters, k: &Constants, local: &Local<f64>) -> Join {
    let cold = local.answer(k, 0.0, Regime::HotLiquid);
    let warm = local.answer(k, 1.0, Regime::HotLiquid);
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
