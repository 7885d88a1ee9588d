//! Mie-Grueneisen on the linear Us-up Hugoniot, with gamma rho constant.
use super::table::Table;
use crate::lanes::{Eight, Real, Work};
use crate::{EosError, Instructions, Phase, Point, Points};
use hvi_kit::math::exp;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of [`MieGruneisen`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parameters {
    /// Reference density rho0 [kg/m3].
    pub density: f64,
    /// Intercept c0 of Us = c0 + s up [m/s].
    pub sound_speed: f64,
    /// Slope s of Us = c0 + s up.
    pub slope: f64,
    /// Grueneisen coefficient G0 at rho0.
    pub gruneisen: f64,
    /// Heat capacity [J/kg/K].
    pub heat_capacity: f64,
    /// Temperature of the reference state [K].
    pub reference_temperature: f64,
}

/// With `x = 1 - V/V0`: `P_H = rho0 c0^2 x / (1 - s x)^2`, `P = P_H + G0 rho0 (E - P_H V0 x / 2)`; in expansion
/// `P = rho0 c0^2 x + G0 rho0 E`. `T = Tr exp(G0 x) + (E - e_c) / c_p`, with e_c the energy on the isentrope through the
/// reference state.
///
/// Beyond the cap `x = min(0.6, 0.92 / s)` the reference is no longer the Hugoniot but a line P_r(x), with dE_r/dx = V0 P_r:
/// P stays continuously differentiable, meets no pole, and rises along every isentrope above the line. The temperature takes
/// x no lower than -0.2: matter so far apart has separated, see [`crate::Eos::relaxed_volume`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Parameters", into = "Parameters")]
pub struct MieGruneisen {
    parameters: Parameters,
    cap: Cap,
    /// Tr exp(G0 x) and e_c over x.
    isentrope: Table<2>,
}

/// Where the Hugoniot ends as the reference curve.
#[derive(Clone, Debug, PartialEq)]
struct Cap {
    /// x of the cap.
    end: f64,
    /// P_r there [Pa].
    pressure: f64,
    /// dP_r/dx beyond it [Pa].
    slope: f64,
}

impl Cap {
    fn new(p: &Parameters) -> Result<Cap, EosError> {
        let wrong = |parameter, why| Err(EosError { name: "Mie-Grueneisen", parameter, why });
        for (parameter, value) in [
            ("density", p.density),
            ("sound_speed", p.sound_speed),
            ("gruneisen", p.gruneisen),
            ("heat_capacity", p.heat_capacity),
            ("reference_temperature", p.reference_temperature),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(parameter, format!("is {value}, must be positive"));
            }
        }
        if !(p.slope >= 0.0 && p.slope.is_finite()) {
            return wrong("slope", format!("is {}, must not be negative", p.slope));
        }
        let end = if p.slope > 0.0 { (0.92 / p.slope).min(0.6) } else { 0.6 };
        let (pressure, slope) = hugoniot(p, end);
        // The slope that makes dP/dx at fixed E the same on both sides.
        let slope = slope * (1.0 - 0.5 * p.gruneisen * end) + 0.5 * p.gruneisen * pressure;
        if slope <= 0.0 {
            return wrong("gruneisen", format!("is {}: matter would soften under compression", p.gruneisen));
        }
        Ok(Cap { end, pressure, slope })
    }
}

/// The temperature follows x down to here.
const OPEN: f64 = -0.2;
/// Nodes of the isentrope a unit of x.
const NODES: usize = 256;

impl MieGruneisen {
    /// # Errors
    /// [`EosError`] where a parameter is not positive (the slope may be zero).
    pub fn new(parameters: Parameters) -> Result<Self, EosError> {
        let cap = Cap::new(&parameters)?;
        let isentrope = isentrope(&parameters, &cap);
        Ok(Self { parameters, cap, isentrope })
    }

    /// Whether [`MieGruneisen::new`] takes these parameters, at a small part of its cost.
    ///
    /// # Errors
    /// As there.
    pub fn check(parameters: &Parameters) -> Result<(), EosError> {
        Cap::new(parameters).map(drop)
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        1.0 / self.parameters.density
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.parameters.reference_temperature
    }

    #[inline]
    pub(crate) fn point(&self, volume: f64, energy: f64) -> Point {
        let p = &self.parameters;
        let ratio = volume * p.density;
        let x = 1.0 - ratio;
        let (cold, slope) = cold(p, &self.cap, x);
        let pressure = cold + p.gruneisen * p.density * energy;
        // c^2 = V^2 (P P_E - P_V), with P_E = G0 rho0 and P_V = -rho0 dP/dx.
        let c2 = ratio * ratio * (slope + p.gruneisen * pressure) / p.density;
        let [hot, isentrope] = self.isentrope.at(x);
        Point {
            pressure,
            temperature: (hot[0] + (energy - isentrope[0]) / p.heat_capacity).max(0.0),
            sound_speed: c2.sqrt().max(self.least_sound_speed()),
            phase: Phase::Solid,
            liquid: 0.0,
        }
    }

    pub(crate) fn least_volume(&self) -> f64 {
        (1.0 - self.cap.end) / self.parameters.density
    }

    /// See [`crate::Eos::evaluate_with`].
    pub(crate) fn evaluate(&self, set: Instructions, volume: &[f64], energy: &[f64], out: &mut Points) {
        out.phase.fill(Phase::Solid);
        out.liquid.fill(0.0);
        out.melting.fill(f64::INFINITY);
        set.run(Many { of: self, volume, energy, out });
    }

    pub(crate) fn least_sound_speed(&self) -> f64 {
        0.1 * self.parameters.sound_speed
    }

    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        let [hot, cold] = self.isentrope.at(1.0 - volume * self.parameters.density);
        cold[0] + self.parameters.heat_capacity * (temperature - hot[0])
    }

    /// In expansion P = 0 at `x = -G0 E / c0^2`.
    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        let p = &self.parameters;
        let open = 1.0 + p.gruneisen * energy.max(0.0) / (p.sound_speed * p.sound_speed);
        volume.min(open / p.density)
    }
}

/// Many states, eight side by side by the formulas of [`MieGruneisen::point`], to the bit.
struct Many<'a> {
    of: &'a MieGruneisen,
    volume: &'a [f64],
    energy: &'a [f64],
    out: &'a mut Points,
}

impl Work for Many<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let Many { of, volume, energy, out } = self;
        for start in (0..volume.len()).step_by(8) {
            let live = (volume.len() - start).min(8);
            let [pressure, temperature, sound_speed] = of.eight::<R>(eight(&volume[start..]), eight(&energy[start..]));
            put(pressure, &mut out.pressure[start..start + live]);
            put(temperature, &mut out.temperature[start..start + live]);
            put(sound_speed, &mut out.sound_speed[start..start + live]);
        }
    }
}

/// The first eight; where there are fewer, ones after them.
#[inline(always)]
fn eight<R: Eight>(from: &[f64]) -> R {
    if let Some(all) = from.first_chunk() {
        return R::load(all);
    }
    let mut lanes = [1.0; 8];
    lanes[..from.len()].copy_from_slice(from);
    R::load(&lanes)
}

/// As many as there is room for.
#[inline(always)]
fn put<R: Eight>(from: R, to: &mut [f64]) {
    let mut lanes = [0.0; 8];
    from.store(&mut lanes);
    to.copy_from_slice(&lanes[..to.len()]);
}

impl MieGruneisen {
    /// Pressure, temperature and sound speed.
    #[inline(always)]
    fn eight<R: Eight>(&self, volume: R, energy: R) -> [R; 3] {
        let p = &self.parameters;
        let ratio = volume.times(p.density);
        let x = R::of(1.0) - ratio;
        let (cold, slope) = cold_eight(p, &self.cap, x);
        let pressure = cold + energy.times(p.gruneisen * p.density);
        let c2 = ratio * ratio * (slope + pressure.times(p.gruneisen)) / R::of(p.density);
        let [hot, isentrope] = self.isentrope.values(x);
        let temperature = hot + (energy - isentrope) / R::of(p.heat_capacity);
        [pressure, temperature.at_least(0.0), c2.root().at_least(self.least_sound_speed())]
    }
}

/// As [`cold`].
#[inline(always)]
fn cold_eight<R: Real>(p: &Parameters, cap: &Cap, x: R) -> (R, R) {
    let (g, one) = (p.gruneisen, R::of(1.0));
    let stiffness = R::of(p.density * p.sound_speed * p.sound_speed);
    let gap = one / (one - x.times(p.slope));
    let h = stiffness * x * gap * gap;
    let dh = stiffness * x.times(p.slope).plus(1.0) * gap * gap * gap;
    let (within, steep) = (h * (one - x.times(0.5 * g)), dh - (dh * x + h).times(0.5 * g));
    let d = x.plus(-cap.end);
    let reference = d.times(cap.slope).plus(cap.pressure);
    let energy = (d * d.times(0.5 * cap.slope).plus(cap.pressure)).plus(0.5 * cap.pressure * cap.end);
    let (beyond, line) = (reference - energy.times(g), R::of(cap.slope) - reference.times(g));
    let (end, zero) = (R::of(cap.end), R::of(0.0));
    let pressure = (stiffness * x).where_less(x, zero, beyond.where_less(end, x, within));
    (pressure, stiffness.where_less(x, zero, line.where_less(end, x, steep)))
}

/// P_H and dP_H/dx on the Hugoniot's own formula.
fn hugoniot(p: &Parameters, x: f64) -> (f64, f64) {
    let stiffness = p.density * p.sound_speed * p.sound_speed;
    let gap = 1.0 / (1.0 - p.slope * x);
    (stiffness * x * gap * gap, stiffness * (1.0 + p.slope * x) * gap * gap * gap)
}

/// P at E = 0 and its derivative by x.
#[inline]
fn cold(p: &Parameters, cap: &Cap, x: f64) -> (f64, f64) {
    let g = p.gruneisen;
    if x < 0.0 {
        let stiffness = p.density * p.sound_speed * p.sound_speed;
        (stiffness * x, stiffness)
    } else if x <= cap.end {
        let (h, dh) = hugoniot(p, x);
        (h * (1.0 - 0.5 * g * x), dh - 0.5 * g * (dh * x + h))
    } else {
        let d = x - cap.end;
        let reference = cap.pressure + cap.slope * d;
        let energy = 0.5 * cap.pressure * cap.end + d * (cap.pressure + 0.5 * cap.slope * d);
        (reference - g * energy, cap.slope - g * reference)
    }
}

/// Tr exp(G0 x) and e_c(x) over [`OPEN`]..1: `de/dx = V0 P(x, e)`, by Gauss-Legendre (3 points) over each interval.
fn isentrope(p: &Parameters, cap: &Cap) -> Table<2> {
    let step = 1.0 / NODES as f64;
    let below = (-OPEN * NODES as f64).ceil() as usize;
    let g = p.gruneisen;
    // V0 (P - G0 rho0 e) and its derivative.
    let source = |x: f64| {
        let (pressure, slope) = cold(p, cap, x);
        (pressure / p.density, slope / p.density)
    };
    let across = |from: f64, to: f64, energy: f64| {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let term = |s: f64, weight: f64| weight * exp(g * (to - s)) * source(s).0;
        let offset = half * 0.6f64.sqrt();
        let sum = term(middle - offset, 5.0 / 9.0) + term(middle, 8.0 / 9.0) + term(middle + offset, 5.0 / 9.0);
        exp(g * (to - from)) * energy + half * sum
    };
    let node = |x: f64, e: f64| {
        let hot = p.reference_temperature * exp(g * x);
        let (q, dq) = source(x);
        let slope = q + g * e;
        [[hot, g * hot, g * g * hot], [e, slope, dq + g * slope]]
    };
    let at = |i: isize| i as f64 * step;
    let mut nodes = vec![node(0.0, 0.0)];
    for i in 0..NODES as isize {
        let e = across(at(i), at(i + 1), nodes.last().expect("begun")[1][0]);
        nodes.push(node(at(i + 1), e));
    }
    let mut e = 0.0;
    for i in 0..below as isize {
        e = across(at(-i), at(-i - 1), e);
        nodes.insert(0, node(at(-i - 1), e));
    }
    Table::new(at(-(below as isize)), step, &nodes)
}

impl TryFrom<Parameters> for MieGruneisen {
    type Error = EosError;
    fn try_from(parameters: Parameters) -> Result<Self, EosError> {
        Self::new(parameters)
    }
}
impl From<MieGruneisen> for Parameters {
    fn from(eos: MieGruneisen) -> Parameters {
        eos.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From a tenth of V0 to dust, below the cold curve and far above it: many states at once have the bits of one at a time, on every
    /// instruction set and for any number of them.
    #[test]
    fn many_states_are_single_ones() {
        let copper = Parameters {
            density: 8930.0,
            sound_speed: 3940.0,
            slope: 1.489,
            gruneisen: 2.02,
            heat_capacity: 385.0,
            reference_temperature: 293.0,
        };
        let eos = MieGruneisen::new(copper).expect("copper");
        let volume: Vec<f64> = (0..4003).map(|i| (0.1 + 1e-3 * f64::from(i)) / 8930.0).chain([1e3]).collect();
        let energy: Vec<f64> = (0..volume.len()).map(|i| -1e6 + 7919.0 * (i * i % 4001) as f64).collect();
        for set in Instructions::all() {
            for n in [volume.len(), 13] {
                let mut all = Points::default();
                all.resize(n);
                eos.evaluate(set, &volume[..n], &energy[..n], &mut all);
                for i in 0..n {
                    assert_eq!(all.get(i), eos.point(volume[i], energy[i]), "{i} on {}", set.name());
                }
            }
        }
    }
}
