//! Tillotson: the classic equation of state of impacts, from compressed solid to expanded vapour.
use super::table::{Jet, Table};
use crate::{EosError, Phase, Point};
use hvi_kit::math::exp;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of [`Tillotson`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// rho0 [kg/m3].
    pub density: f64,
    /// a, the thermal coefficient that hot and thin matter keeps.
    pub a: f64,
    /// b; a + b is the Grueneisen coefficient of the cold solid.
    pub b: f64,
    /// A: bulk modulus [Pa].
    pub bulk: f64,
    /// B [Pa].
    pub bulk_slope: f64,
    /// E0 [J/kg].
    pub energy: f64,
    /// E_iv: energy at which vapour begins to form in expansion [J/kg].
    pub incipient: f64,
    /// E_cv: energy at which expanded matter is all vapour [J/kg].
    pub complete: f64,
    /// alpha: how fast b and A fade in expansion.
    pub alpha: f64,
    /// beta: how fast A fades in expansion.
    pub beta: f64,
    /// Heat capacity [J/kg/K], for the temperature.
    pub heat_capacity: f64,
    /// Temperature of the reference state [K], where E = 0.
    pub reference_temperature: f64,
}

/// With `eta = V0/V`, `mu = eta - 1`, `omega = 1 + E/(E0 eta^2)`. Compressed (V <= V0), or expanded with E <= E_iv:
/// `P = (a + b/omega) E/V + A mu + B mu^2`. Expanded with E >= E_cv:
/// `P = a E/V + (b E/(V omega) + A mu exp(-beta (V/V0 - 1))) exp(-alpha (V/V0 - 1)^2)`. Between: linear in E.
///
/// Source: J. H. Tillotson, General Atomic report GA-3216 (1962), in the form of H. J. Melosh, Impact Cratering (1989), app. II. It
/// knows no temperature: here `T = T_s(V) + (E - e_s(V))/c_v`, e_s and T_s energy and temperature on the isentrope through the
/// reference state, held beyond V = 1.2 V0; `d ln T_s = -gamma d ln V` with gamma = V (dP/dE)_V. Energies below -E0 eta^2/2 count as that in omega, whose pole lies at -E0 eta^2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Parameters", into = "Parameters")]
pub struct Tillotson {
    parameters: Parameters,
    /// e_s and ln(T_s/T0) over V/V0.
    isentrope: Table<2>,
}

/// P [Pa], dP/dE at constant V [kg/m3] and dP/drho at constant E [m2/s2].
#[derive(Clone, Copy)]
struct Slopes {
    p: f64,
    p_e: f64,
    p_rho: f64,
}

/// V/V0 between which the isentrope is tabulated, and intervals a unit.
const RANGE: (f64, f64) = (0.2, 1.2);
const NODES: usize = 400;

impl Tillotson {
    /// # Errors
    /// [`EosError`] where a parameter is not positive (`bulk_slope` and `a` may be zero), or `complete <= incipient`.
    pub fn new(parameters: Parameters) -> Result<Self, EosError> {
        let p = &parameters;
        let wrong = |parameter, why| Err(EosError { name: "Tillotson", parameter, why });
        for (parameter, value) in [
            ("density", p.density),
            ("b", p.b),
            ("bulk", p.bulk),
            ("energy", p.energy),
            ("incipient", p.incipient),
            ("alpha", p.alpha),
            ("beta", p.beta),
            ("heat_capacity", p.heat_capacity),
            ("reference_temperature", p.reference_temperature),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must be positive"));
            }
        }
        for (parameter, value) in [("a", p.a), ("bulk_slope", p.bulk_slope)] {
            if !(value >= 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must not be negative"));
            }
        }
        if !(p.complete > p.incipient && p.complete.is_finite()) {
            let why = format!("is {} J/kg, must be above `incipient`, {} J/kg", p.complete, p.incipient);
            return wrong("complete", why);
        }
        let isentrope = isentrope(p);
        Ok(Self { parameters, isentrope })
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
    pub(crate) fn least_sound_speed(&self) -> f64 {
        (0.01 * self.parameters.bulk / self.parameters.density).sqrt()
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        1.0 / self.parameters.density
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.parameters.reference_temperature
    }

    pub(crate) fn point(&self, volume: f64, energy: f64) -> Point {
        let p = &self.parameters;
        let at = slopes(p, volume, energy);
        let c2 = at.p_rho + at.p * at.p_e * volume * volume;
        let vapour = volume * p.density > 1.0 && energy >= p.complete;
        Point {
            pressure: at.p,
            temperature: self.temperature(volume, energy).max(0.0),
            sound_speed: c2.max(0.01 * p.bulk / p.density).sqrt(),
            phase: if vapour { Phase::Vapour } else { Phase::Solid },
            liquid: if vapour { 1.0 } else { 0.0 },
        }
    }

    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        let (energy, own) = self.adiabat(volume);
        energy + self.parameters.heat_capacity * (temperature - own)
    }

    fn temperature(&self, volume: f64, energy: f64) -> f64 {
        let (adiabat, own) = self.adiabat(volume);
        own + (energy - adiabat) / self.parameters.heat_capacity
    }

    /// e_s [J/kg] and T_s [K].
    fn adiabat(&self, volume: f64) -> (f64, f64) {
        let [[energy, ..], [warmth, ..]] = self.isentrope.at(volume * self.parameters.density);
        (energy, self.parameters.reference_temperature * exp(warmth))
    }
}

fn slopes(p: &Parameters, volume: f64, energy: f64) -> Slopes {
    let ratio = volume * p.density;
    if ratio <= 1.0 || energy <= p.incipient {
        return condensed(p, volume, energy);
    }
    let hot = expanded(p, volume, energy);
    if energy >= p.complete {
        return hot;
    }
    let cold = condensed(p, volume, energy);
    let span = p.complete - p.incipient;
    let share = (energy - p.incipient) / span;
    let mix = |hot: f64, cold: f64| share * hot + (1.0 - share) * cold;
    Slopes {
        p: mix(hot.p, cold.p),
        p_e: mix(hot.p_e, cold.p_e) + (hot.p - cold.p) / span,
        p_rho: mix(hot.p_rho, cold.p_rho),
    }
}

/// E held where 1/omega is harmless, and b/omega, b (omega - 1)/omega^2.
fn thermal(p: &Parameters, eta: f64, energy: f64) -> (f64, f64, f64) {
    let square = p.energy * eta * eta;
    let held = energy.max(-0.5 * square);
    let omega = 1.0 + held / square;
    (held, p.b / omega, p.b * (omega - 1.0) / (omega * omega))
}

fn condensed(p: &Parameters, volume: f64, energy: f64) -> Slopes {
    let eta = 1.0 / (volume * p.density);
    let mu = eta - 1.0;
    let (energy, part, bend) = thermal(p, eta, energy);
    let gamma = p.a + part;
    Slopes {
        p: gamma * energy / volume + mu * (p.bulk + p.bulk_slope * mu),
        p_e: (gamma - bend) / volume,
        p_rho: energy * (gamma + 2.0 * bend) + (p.bulk + 2.0 * p.bulk_slope * mu) / p.density,
    }
}

fn expanded(p: &Parameters, volume: f64, energy: f64) -> Slopes {
    let eta = 1.0 / (volume * p.density);
    let (mu, x) = (eta - 1.0, 1.0 / eta - 1.0);
    let (energy, part, bend) = thermal(p, eta, energy);
    let (fade, pull) = (exp(-p.alpha * x * x), p.bulk * exp(-p.beta * x));
    let fading = part * energy / volume + mu * pull;
    let own = energy * (part + 2.0 * bend) + pull * (1.0 + mu * p.beta / (eta * eta)) / p.density;
    Slopes {
        p: p.a * energy / volume + fading * fade,
        p_e: (p.a + fade * (part - bend)) / volume,
        p_rho: p.a * energy + fade * (own + fading * 2.0 * p.alpha * x / (eta * eta * p.density)),
    }
}

/// e_s and ln(T_s/T0): dE/dV = -P from the reference state both ways, by Runge-Kutta of order four over each interval, and
/// -gamma/u beside it by the corrected trapezoidal rule, of order four too.
fn isentrope(p: &Parameters) -> Table<2> {
    let (v0, step) = (1.0 / p.density, 1.0 / NODES as f64);
    let at = |i: usize| RANGE.0 + i as f64 * step;
    let count = ((RANGE.1 - RANGE.0) * NODES as f64).round() as usize;
    let first = ((1.0 - RANGE.0) * NODES as f64).round() as usize;
    // -V0 P: dE/du.
    let slope = |u: f64, e: f64| -v0 * slopes(p, u * v0, e).p;
    let across = |u: f64, e: f64, h: f64| {
        let k1 = slope(u, e);
        let k2 = slope(u + 0.5 * h, e + 0.5 * h * k1);
        let k3 = slope(u + 0.5 * h, e + 0.5 * h * k2);
        let k4 = slope(u + h, e + h * k3);
        e + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    };
    let mut energies = vec![0.0; count + 1];
    for i in (0..first).rev() {
        energies[i] = across(at(i + 1), energies[i + 1], -step);
    }
    for i in first..count {
        energies[i + 1] = across(at(i), energies[i], step);
    }
    // -gamma/u, gamma = V dP/dE, and its slope by central differences
    let warming: Vec<f64> = (0..=count).map(|i| -v0 * slopes(p, at(i) * v0, energies[i]).p_e).collect();
    let bend = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(count));
        (warming[b] - warming[a]) / ((b - a) as f64 * step)
    };
    let rise = |i: usize| 0.5 * step * (warming[i] + warming[i + 1]) - step * step / 12.0 * (bend(i + 1) - bend(i));
    let mut warmth = vec![0.0; count + 1];
    for i in (0..first).rev() {
        warmth[i] = warmth[i + 1] - rise(i);
    }
    for i in first..count {
        warmth[i + 1] = warmth[i] + rise(i);
    }
    let jet = |i: usize| -> [Jet; 2] {
        let (v, e) = (at(i) * v0, energies[i]);
        let s = slopes(p, v, e);
        // d2E/du2 = -V0^2 dP/dV along the isentrope = V0^2 c^2 / V^2.
        let energy = [e, -v0 * s.p, (s.p_rho + s.p * s.p_e * v * v) * (v0 / v) * (v0 / v)];
        [energy, [warmth[i], warming[i], bend(i)]]
    };
    Table::new(RANGE.0, step, &(0..=count).map(jet).collect::<Vec<_>>())
}

impl TryFrom<Parameters> for Tillotson {
    type Error = EosError;
    fn try_from(parameters: Parameters) -> Result<Self, EosError> {
        Self::new(parameters)
    }
}
impl From<Tillotson> for Parameters {
    fn from(eos: Tillotson) -> Parameters {
        eos.parameters
    }
}
