//! The table of states: pressure and energy interpolated in (V, T), solid and liquid apart, never across the melting belt.
mod check;

use super::monotone::{hermite, interval, slopes};
use super::relax;
use crate::{EosError, Phase, Point};
use check::check;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One state of an isochore.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Node {
    /// Temperature [K].
    pub temperature: f64,
    /// Energy [J/kg].
    pub energy: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Standard errors of energy and pressure [J/kg, Pa]; 0 where none is known.
    #[serde(default)]
    pub errors: [f64; 2],
}

/// States of one volume and one phase, temperature rising.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isochore {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Two or more states.
    pub nodes: Vec<Node>,
}

/// Volumes and temperatures this near, relatively, to the end of the states are within them.
const ROUNDING: f64 = 1e-9;

/// What a [`Tabulated`] is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// V0 [m3/kg].
    pub reference_volume: f64,
    /// T0 [K].
    pub reference_temperature: f64,
    /// Four or more isochores of the solid, or of matter whose phases are not told apart; volume rising.
    pub solid: Vec<Isochore>,
    /// Isochores of the liquid, volume rising; none, or two or more.
    #[serde(default)]
    pub liquid: Vec<Isochore>,
}

/// In T each isochore is a monotone cubic; in V, P is a monotone cubic and E a cubic on the parabola's slopes, both through the four
/// nearest isochores. Where that cubic would let E fall with T (isochores of a table without phases, which melt one at a lower
/// temperature than the next), E goes straight from isochore to isochore. Where an isochore has both phases, melting lies midway between its hottest solid and its coldest liquid
/// state, and in V on a monotone cubic: T = T_m(V) holds from the solid's energy to the liquid's, and everything between is a
/// mixture of both by the lever rule.
///
/// Outside the states E goes straight on in T and is held in V, P goes straight on in both, up to 1.2 times the largest volume; see
/// [`Tabulated::covers`]. A crystal that was heated overshoots melting,
/// so T_m is an upper estimate by half the step between states and the superheating.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Parameters", into = "Parameters")]
pub struct Tabulated {
    parameters: Parameters,
    solid: Sheet,
    liquid: Option<Sheet>,
    /// V [m3/kg] and T_m [K] of the isochores that have both phases, and dT_m/dV.
    melting: [Vec<f64>; 3],
    /// Squared sound speed of the reference state [m2/s2].
    stiffness: f64,
}

/// One phase.
#[derive(Clone, Debug, PartialEq)]
struct Sheet {
    volumes: Vec<f64>,
    lines: Vec<Line>,
    /// By interval of volume: whether E goes straight across it.
    straight: Vec<bool>,
}

/// Least heat capacity between two isochores, over the smaller of theirs: below, E goes straight, whose heat capacity lies between
/// theirs.
const LEAST_HEAT: f64 = 0.2;
/// Least slope of E at the ends of an isochore, over that of the end interval: a cubic that ends level has no heat capacity beyond.
const LEAST_END: f64 = 0.25;

/// One isochore: E and P over T with their slopes, and errors at the nodes.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    t: Vec<f64>,
    /// Energy and pressure: values and slopes.
    y: [[Vec<f64>; 2]; 2],
    /// Standard errors of E and P, interpolation's included.
    errors: [Vec<f64>; 2],
}

/// E [J/kg], P [Pa] and their derivatives at one (V, T).
#[derive(Clone, Copy)]
struct At {
    energy: f64,
    pressure: f64,
    c_v: f64,
    p_t: f64,
    p_v: f64,
}

impl Line {
    fn new(isochore: &Isochore) -> Line {
        let t: Vec<f64> = isochore.nodes.iter().map(|n| n.temperature).collect();
        let column = |of: fn(&Node) -> f64| {
            let y: Vec<f64> = isochore.nodes.iter().map(of).collect();
            let d = slopes(&t, &y);
            [y, d]
        };
        let mut energy = column(|n| n.energy);
        let last = t.len() - 1;
        for (end, i) in [(0, 0), (last, last - 1)] {
            let secant = (energy[0][i + 1] - energy[0][i]) / (t[i + 1] - t[i]);
            energy[1][end] = energy[1][end].max(LEAST_END * secant);
        }
        let errors = [0, 1].map(|k| isochore.nodes.iter().map(|n| n.errors[k]).collect());
        Line { y: [energy, column(|n| n.pressure)], errors, t }
    }

    /// Quantity `k` (0 energy, 1 pressure) and its derivative; straight on outside.
    fn at(&self, k: usize, t: f64) -> (f64, f64) {
        let (x, [y, d]) = (&self.t, &self.y[k]);
        let last = x.len() - 1;
        for end in [0, last] {
            if if end == 0 { t < x[0] } else { t > x[last] } {
                return (y[end] + d[end] * (t - x[end]), d[end]);
            }
        }
        let i = interval(x, t);
        hermite(t, [x[i], x[i + 1]], [y[i], y[i + 1]], [d[i], d[i + 1]])
    }

    /// How far the isochore without a node misses it, for E and P; zero where there are fewer than four nodes.
    fn missed(&self) -> [Vec<f64>; 2] {
        let n = self.t.len();
        [0, 1].map(|k| {
            let y = &self.y[k][0];
            let off = |j: usize| {
                let without = |x: &[f64]| [&x[..j], &x[j + 1..]].concat();
                let (t, rest) = (without(&self.t), without(y));
                let d = slopes(&t, &rest);
                cubic(&t, &rest, &d, self.t[j]).0 - y[j]
            };
            (0..n).map(|j| if n < 4 { 0.0 } else { off(j.clamp(1, n - 2)) }).collect()
        })
    }

    /// Error of quantity `k`, linear between nodes.
    fn error(&self, k: usize, t: f64) -> f64 {
        let i = interval(&self.t, t);
        let share = ((t - self.t[i]) / (self.t[i + 1] - self.t[i])).clamp(0.0, 1.0);
        (1.0 - share) * self.errors[k][i] + share * self.errors[k][i + 1]
    }
}

impl Sheet {
    fn new(isochores: &[Isochore]) -> Sheet {
        let mut sheet = Sheet {
            volumes: isochores.iter().map(|i| i.volume).collect(),
            lines: isochores.iter().map(Line::new).collect(),
            straight: vec![false; isochores.len() - 1],
        };
        sheet.straight = (0..isochores.len() - 1).map(|i| !sheet.rises(i)).collect();
        sheet.add_interpolation_error();
        sheet
    }

    /// Whether E rises with T all over the interval `i` of volume.
    fn rises(&self, i: usize) -> bool {
        let (a, b) = (self.volumes[i], self.volumes[i + 1]);
        let (first, count) = self.window(a);
        let temperatures = self.lines[first..first + count]
            .iter()
            .flat_map(|line| line.t.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]).chain(line.t.last().copied()));
        temperatures.into_iter().all(|t| {
            let least = self.lines[i].at(0, t).1.min(self.lines[i + 1].at(0, t).1);
            (1..8).all(|k| self.energy(a + 0.125 * f64::from(k) * (b - a), t).1 >= LEAST_HEAT * least)
        })
    }

    /// A quantity that goes as E does, at `v`, from its values `y` on the isochores of the window from `first` on.
    fn across(&self, first: usize, y: &[f64], v: f64) -> f64 {
        let x = &self.volumes[first..first + y.len()];
        let held = v.clamp(x[0], x[x.len() - 1]);
        let i = interval(x, held);
        if !self.straight[first + i] {
            return cubic(x, y, &parabolic(x, y), held).0;
        }
        let share = (held - x[i]) / (x[i + 1] - x[i]);
        (1.0 - share) * y[i] + share * y[i + 1]
    }

    /// Adds in quadrature to every node's error an eighth of how far the table without its isochore misses it, and of how far its
    /// isochore without the node does: at half the distance a third-order error is an eighth. Ends take their neighbour's.
    fn add_interpolation_error(&mut self) {
        let n = self.lines.len();
        let across = |i: usize| -> [Vec<f64>; 2] {
            let mut rest = self.clone();
            rest.volumes.remove(i);
            let own = rest.lines.remove(i);
            let near = rest.straight.remove(i);
            rest.straight[i - 1] |= near;
            let at: Vec<At> = own.t.iter().map(|&t| rest.at(self.volumes[i], t)).collect();
            let off = |k: usize, of: fn(&At) -> f64| at.iter().zip(&own.y[k][0]).map(|(a, y)| of(a) - y).collect();
            [off(0, |a| a.energy), off(1, |a| a.pressure)]
        };
        let missed: Vec<[Vec<f64>; 2]> = if n < 5 { Vec::new() } else { (1..n - 1).map(across).collect() };
        for (i, line) in self.lines.iter_mut().enumerate() {
            let along = line.missed();
            for k in 0..2 {
                for j in 0..line.t.len() {
                    let near = missed.get(i.max(1) - 1).or(missed.last()).map_or(0.0, |m| m[k][j.min(m[k].len() - 1)]);
                    let own = &mut line.errors[k][j];
                    *own = (*own * *own + (near * near + along[k][j] * along[k][j]) / 64.0).sqrt();
                }
            }
        }
    }

    /// The first of the isochores used at `v`, and how many.
    fn window(&self, v: f64) -> (usize, usize) {
        let count = self.volumes.len().min(4);
        (interval(&self.volumes, v).saturating_sub(1).min(self.volumes.len() - count), count)
    }

    fn at(&self, v: f64, t: f64) -> At {
        let (first, count) = self.window(v);
        let x = &self.volumes[first..first + count];
        let lines = &self.lines[first..first + count];
        let column = |k: usize| lines.iter().map(|l| l.at(k, t)).unzip::<f64, f64, Vec<f64>, Vec<f64>>();
        let ((e, e_t), (p, p_t)) = (column(0), column(1));
        let (held, open) = (v.clamp(x[0], x[count - 1]), v.min(1.2 * x[count - 1]));
        let [energy, c_v] = [e, e_t].map(|y| self.across(first, &y, v));
        let (pressure, p_v) = cubic(x, &p, &slopes(x, &p), open);
        let (p_t, _) = cubic(x, &p_t, &slopes(x, &p_t), held);
        At { energy, pressure, c_v, p_t, p_v }
    }

    /// E alone and C_V.
    fn energy(&self, v: f64, t: f64) -> (f64, f64) {
        let (first, count) = self.window(v);
        let (e, e_t): (Vec<f64>, Vec<f64>) = self.lines[first..first + count].iter().map(|l| l.at(0, t)).unzip();
        (self.across(first, &e, v), self.across(first, &e_t, v))
    }

    /// T at `energy`: Newton in a shrinking bracket; E rises with T, which the constructor has checked.
    fn temperature(&self, v: f64, energy: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1000.0);
        if self.energy(v, low).0 >= energy {
            return 0.0;
        }
        while self.energy(v, high).0 < energy {
            low = high;
            high *= 2.0;
            if high > 1e12 {
                return low;
            }
        }
        let mut t = 0.5 * (low + high);
        for _ in 0..200 {
            let (e, heat) = self.energy(v, t);
            if e > energy {
                high = t
            } else {
                low = t
            }
            let newton = t - (e - energy) / heat;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - t).abs() <= 1e-14 * t {
                return next;
            }
            t = next;
        }
        t
    }

    fn errors(&self, v: f64, t: f64) -> [f64; 2] {
        let i = interval(&self.volumes, v);
        let share = ((v - self.volumes[i]) / (self.volumes[i + 1] - self.volumes[i])).clamp(0.0, 1.0);
        [0, 1].map(|k| (1.0 - share) * self.lines[i].error(k, t) + share * self.lines[i + 1].error(k, t))
    }
}

/// Slopes of the parabolas through three neighbours each; at the ends the end parabola's.
fn parabolic(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let secant = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    if n == 2 {
        return vec![secant(0); 2];
    }
    let bent = |i: usize, at: f64| {
        let curvature = (secant(i + 1) - secant(i)) / (x[i + 2] - x[i]);
        secant(i) + curvature * (2.0 * at - x[i] - x[i + 1])
    };
    (0..n).map(|i| bent(i.saturating_sub(1).min(n - 3), x[i])).collect()
}

/// Hermite's cubic through `(x, y)` with slopes `d`, straight on outside.
fn cubic(x: &[f64], y: &[f64], d: &[f64], at: f64) -> (f64, f64) {
    let last = x.len() - 1;
    if at <= x[0] {
        return (y[0] + d[0] * (at - x[0]), d[0]);
    }
    if at >= x[last] {
        return (y[last] + d[last] * (at - x[last]), d[last]);
    }
    let i = interval(x, at);
    hermite(at, [x[i], x[i + 1]], [y[i], y[i + 1]], [d[i], d[i + 1]])
}

impl Tabulated {
    /// # Errors
    /// [`EosError`] where there are fewer than four isochores or two states on one, numbers that are not finite, volumes or
    /// temperatures out of order, a temperature or volume that isn't positive, energy that does not rise with temperature, or
    /// matter that is not stiff at the reference state.
    pub fn new(parameters: Parameters) -> Result<Tabulated, EosError> {
        check(&parameters)?;
        let p = &parameters;
        let solid = Sheet::new(&p.solid);
        let liquid = (!p.liquid.is_empty()).then(|| Sheet::new(&p.liquid));
        let [volumes, temperatures] = liquid.as_ref().map_or_else(Default::default, |l| belt(&solid, l));
        let d = slopes(&volumes, &temperatures);
        let mut table = Tabulated { solid, liquid, melting: [volumes, temperatures, d], stiffness: 0.0, parameters };
        if table.liquid.is_some() && table.melting[0].len() < 2 {
            let why = "states of both phases are needed on two isochores or more, for the melting belt".into();
            return Err(EosError { name: "table", parameter: "liquid", why });
        }
        let p = &table.parameters;
        let c2 = table.sound_speed_squared(
            &table.solid.at(p.reference_volume, p.reference_temperature),
            p.reference_volume,
            p.reference_temperature,
        );
        if !(c2 > 0.0) {
            let why =
                format!("is {:e} m3/kg: the table's pressure does not fall with volume there", p.reference_volume);
            return Err(EosError { name: "table", parameter: "reference_volume", why });
        }
        table.stiffness = c2;
        table.check_rise()?;
        Ok(table)
    }

    /// E must rise with T everywhere in the table, also between isochores; and melting must take heat.
    fn check_rise(&self) -> Result<(), EosError> {
        let wrong = |parameter, why| Err(EosError { name: "table", parameter, why });
        for (parameter, sheet) in [("solid", Some(&self.solid)), ("liquid", self.liquid.as_ref())] {
            let Some(sheet) = sheet else { continue };
            for (w, line) in sheet.volumes.windows(2).zip(&sheet.lines) {
                for (v, t) in
                    (0..8).flat_map(|i| line.t.iter().map(move |t| (w[0] + 0.125 * f64::from(i) * (w[1] - w[0]), t)))
                {
                    if !(sheet.energy(v, *t).1 > 0.0) {
                        return wrong(
                            parameter,
                            format!("at {v:e} m3/kg and {t} K the energy does not rise with temperature"),
                        );
                    }
                }
            }
        }
        for (v, t) in self.melting[0].iter().zip(&self.melting[1]) {
            let liquid = self.liquid.as_ref().expect("there is a belt");
            if !(liquid.energy(*v, *t).0 > self.solid.energy(*v, *t).0) {
                return wrong("liquid", format!("at {v:e} m3/kg and {t} K melting takes no heat"));
            }
        }
        Ok(())
    }

    /// What it is made of.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
    pub(crate) fn least_sound_speed(&self) -> f64 {
        (0.01 * self.stiffness).sqrt()
    }
    /// The smallest and the largest volume of its states [m3/kg].
    pub fn volumes(&self) -> [f64; 2] {
        let mut ends = [f64::INFINITY, 0.0f64];
        for v in [Some(&self.solid), self.liquid.as_ref()].into_iter().flatten().flat_map(|s| &s.volumes) {
            ends = [ends[0].min(*v), ends[1].max(*v)];
        }
        ends
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        self.parameters.reference_volume
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.parameters.reference_temperature
    }

    /// Melting temperature [K] at `volume` [m3/kg]: the last one known beyond the expanded end of the belt, `None` beyond its dense end.
    pub fn melting_temperature(&self, volume: f64) -> Option<f64> {
        let [v, t, d] = &self.melting;
        if v.is_empty() || volume < v[0] {
            return None;
        }
        Some(cubic(v, t, d, volume.min(v[v.len() - 1])).0)
    }

    /// Whether (`volume` [m3/kg], `temperature` [K]) lies between states of its own phase, where [`Tabulated::errors`] hold.
    pub fn covers(&self, volume: f64, temperature: f64) -> bool {
        self.lies_within(volume, temperature, None)
    }

    /// Whether it lies between the coldest and the hottest states, those on both sides of the melting belt's gap counted.
    pub fn encloses(&self, volume: f64, temperature: f64) -> bool {
        self.lies_within(volume, temperature, self.melting_temperature(volume))
    }

    /// On the sheet of its phase; where `belt` [K] is given the sheets end there.
    fn lies_within(&self, volume: f64, temperature: f64, belt: Option<f64>) -> bool {
        let sheet = self.sheet(volume, temperature);
        let (i, last) = (interval(&sheet.volumes, volume), sheet.volumes.len() - 1);
        let inside = |line: &Line| {
            let cold = if belt.is_some_and(|tm| temperature > tm) { 0.0 } else { line.t[0] };
            let hot = if belt.is_some_and(|tm| temperature <= tm) { f64::INFINITY } else { line.t[line.t.len() - 1] };
            (cold * (1.0 - ROUNDING)..=hot * (1.0 + ROUNDING)).contains(&temperature)
        };
        let range = sheet.volumes[0] * (1.0 - ROUNDING)..=sheet.volumes[last] * (1.0 + ROUNDING);
        range.contains(&volume) && inside(&sheet.lines[i]) && inside(&sheet.lines[i + 1])
    }

    /// Standard errors of E [J/kg] and P [Pa] at (`volume`, `temperature`): the states' own, and the interpolation's as it shows when
    /// an isochore is left out. Outside the states' range they are those of its edge, and mean nothing.
    pub fn errors(&self, volume: f64, temperature: f64) -> [f64; 2] {
        self.sheet(volume, temperature).errors(volume, temperature)
    }

    fn sheet(&self, volume: f64, temperature: f64) -> &Sheet {
        match (&self.liquid, self.melting_temperature(volume)) {
            (Some(liquid), Some(melting)) if temperature > melting => liquid,
            _ => &self.solid,
        }
    }

    fn sound_speed_squared(&self, at: &At, v: f64, t: f64) -> f64 {
        v * v * (t * at.p_t * at.p_t / at.c_v - at.p_v)
    }

    pub(crate) fn point(&self, volume: f64, energy: f64) -> Point {
        let one = |sheet: &Sheet, t: f64, phase: Phase| {
            let at = sheet.at(volume, t);
            let c2 = self.sound_speed_squared(&at, volume, t).max(0.01 * self.stiffness);
            let liquid = if phase == Phase::Liquid { 1.0 } else { 0.0 };
            Point { pressure: at.pressure, temperature: t, sound_speed: c2.sqrt(), phase, liquid }
        };
        let (Some(liquid), Some(melting)) = (&self.liquid, self.melting_temperature(volume)) else {
            return one(&self.solid, self.solid.temperature(volume, energy), Phase::Solid);
        };
        let (start, end) = (self.solid.energy(volume, melting).0, liquid.energy(volume, melting).0);
        if energy <= start {
            // Rounding of the root must not pass the belt.
            return one(&self.solid, self.solid.temperature(volume, energy).min(melting), Phase::Solid);
        }
        if energy >= end {
            return one(liquid, liquid.temperature(volume, energy).max(melting), Phase::Liquid);
        }
        let share = (energy - start) / (end - start);
        let (a, b) = (one(&self.solid, melting, Phase::Solid), one(liquid, melting, Phase::Liquid));
        let mix = |x: f64, y: f64| (1.0 - share) * x + share * y;
        Point {
            pressure: mix(a.pressure, b.pressure),
            temperature: melting,
            sound_speed: mix(a.sound_speed, b.sound_speed),
            phase: Phase::Melting,
            liquid: share,
        }
    }

    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        self.sheet(volume, temperature).energy(volume, temperature).0
    }

    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        relax(self.reference_volume(), volume, |v| self.point(v, energy).pressure)
    }
}

/// Volumes and temperatures of melting, on the isochores that have both phases: midway between the hottest solid and the coldest
/// liquid state.
fn belt(solid: &Sheet, liquid: &Sheet) -> [Vec<f64>; 2] {
    let mut both = [Vec::new(), Vec::new()];
    for (v, s) in solid.volumes.iter().zip(&solid.lines) {
        let l = liquid.volumes.iter().position(|x| (x / v - 1.0).abs() < 1e-6);
        if let Some(l) = l {
            both[0].push(*v);
            both[1].push(0.5 * (s.t[s.t.len() - 1] + liquid.lines[l].t[0]));
        }
    }
    both
}

impl TryFrom<Parameters> for Tabulated {
    type Error = EosError;
    fn try_from(parameters: Parameters) -> Result<Self, EosError> {
        Self::new(parameters)
    }
}
impl From<Tabulated> for Parameters {
    fn from(eos: Tabulated) -> Parameters {
        eos.parameters
    }
}
