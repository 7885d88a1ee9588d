//! Curves of any equation of state, point by point.
use crate::curve::{CurveError, Shock};
use crate::{Eos, Phase};
use hvi_kit::math::bisect;
use serde::{Deserialize, Serialize};

/// One state on a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Specific volume [m3/kg].
    pub volume: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Specific energy [J/kg].
    pub energy: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Regime.
    pub phase: Phase,
    /// Share of liquid, 0..1.
    pub liquid: f64,
    /// Sound speed [m/s]; `None` where matter is softer than the model's least, see [`Eos::least_sound_speed`].
    pub sound_speed: Option<f64>,
    /// On the Hugoniot: particle velocity and shock velocity [m/s].
    pub velocities: Option<[f64; 2]>,
}

/// States a curve has.
pub const COUNT: usize = 200;
/// Volumes a melting curve looks at and isobars search, over V0.
const WIDEST: f64 = 1.45;

impl Eos {
    /// The state at (`volume` [m3/kg], `energy` [J/kg]).
    pub fn sample(&self, volume: f64, energy: f64) -> Sample {
        let at = self.point(volume, energy);
        Sample {
            volume,
            energy,
            temperature: at.temperature,
            pressure: at.pressure,
            phase: at.phase,
            liquid: at.liquid,
            sound_speed: Some(at.sound_speed).filter(|c| self.least_sound_speed().is_none_or(|least| *c > least)),
            velocities: None,
        }
    }

    /// The samples of `curve`, none of which may be where the model only extrapolates.
    fn within(&self, curve: &'static str, samples: Vec<Sample>) -> Result<Vec<Sample>, CurveError> {
        let Some(s) = samples.iter().find(|s| !self.covers(s.volume, s.temperature)) else { return Ok(samples) };
        let v0 = self.reference_volume();
        let range = match self {
            Eos::Table(table) => table.volumes().map(|v| v / v0),
            _ => [0.0, f64::INFINITY],
        };
        let why = format!(
            "at V/V0 = {:.3} and {:.0} K it leaves the states, which have V/V0 from {:.3} to {:.3}: ask for less, or add states",
            s.volume / v0,
            s.temperature,
            range[0],
            range[1]
        );
        Err(CurveError { curve, model: self.name(), why })
    }

    /// The principal Hugoniot up to `pressure` [Pa], [`COUNT`] steps of equal volume.
    ///
    /// # Errors
    /// [`CurveError`] where no shock has that pressure, or only beyond a table's states.
    pub fn hugoniot_curve(&self, pressure: f64) -> Result<Vec<Sample>, CurveError> {
        let (start, end) = (self.reference_volume(), self.hugoniot_at_pressure(pressure)?.volume);
        let samples = (0..=COUNT).map(|i| {
            let s = self.hugoniot(start + (end - start) * i as f64 / COUNT as f64)?;
            let velocities = Some([s.particle_velocity, s.shock_velocity]);
            Ok(Sample { velocities, ..self.sample(s.volume, s.energy) })
        });
        self.within("Hugoniot", samples.collect::<Result<_, CurveError>>()?)
    }

    /// The isotherm of `temperature` [K] between two volumes [m3/kg], in steps of equal volume.
    ///
    /// # Errors
    /// [`CurveError`] where it leaves a table's states.
    pub fn isotherm_curve(&self, temperature: f64, from: f64, to: f64) -> Result<Vec<Sample>, CurveError> {
        let at = |i: usize| from + (to - from) * i as f64 / COUNT as f64;
        let samples = (0..=COUNT).map(|i| self.sample(at(i), self.energy_at(at(i), temperature)));
        self.within("isotherm", samples.collect())
    }

    /// The isobar of `pressure` [Pa] between two temperatures [K], in steps of equal temperature: the densest volume each has it at.
    /// It is where matter below 1.45 V0 has that pressure, and within the states of a table.
    pub fn isobar_curve(&self, pressure: f64, from: f64, to: f64) -> Vec<Sample> {
        let v0 = self.reference_volume();
        let at = |i: usize| from + (to - from) * i as f64 / COUNT as f64;
        let sample = |i: usize| {
            let excess = |v: f64| self.pressure_at(v, at(i)) - pressure;
            let step = 0.01 * v0;
            let first = (0..).map(|k| 0.3 * v0 + step * f64::from(k)).take_while(|v| *v < WIDEST * v0);
            let mut pairs = first.map(|v| (v, v + step));
            let (a, b) = pairs.find(|&(a, b)| excess(a) > 0.0 && excess(b) <= 0.0)?;
            let v = bisect(a, b, 1e-13 * v0, excess)?;
            Some(self.sample(v, self.energy_at(v, at(i))))
        };
        let covered = |s: &Sample| self.covers(s.volume, s.temperature);
        (0..=COUNT).map_while(sample).skip_while(|s| !covered(s)).take_while(covered).collect()
    }

    /// The isentrope from (`volume` [m3/kg], `temperature` [K]) to the volume `to`.
    ///
    /// # Errors
    /// [`CurveError`] where it leaves a table's states.
    pub fn isentrope_curve(&self, volume: f64, temperature: f64, to: f64) -> Result<Vec<Sample>, CurveError> {
        let at = |i: usize| volume + (to - volume) * i as f64 / COUNT as f64;
        let mut energy = self.energy_at(volume, temperature);
        let mut all = vec![self.sample(volume, energy)];
        for i in 0..COUNT {
            energy = self.isentrope(at(i), energy, at(i + 1), 10);
            all.push(self.sample(at(i + 1), energy));
        }
        self.within("isentrope", all)
    }

    /// The release of `shock` along its isentrope to zero pressure.
    ///
    /// # Errors
    /// [`CurveError`] where the pressure never vanishes, or the curve leaves a table's states.
    pub fn release_curve(&self, shock: &Shock) -> Result<Vec<Sample>, CurveError> {
        let end = self.release(shock)?.volume;
        let at = |i: usize| shock.volume + (end - shock.volume) * i as f64 / COUNT as f64;
        let mut energy = shock.energy;
        let mut all = vec![self.sample(shock.volume, energy)];
        for i in 0..COUNT {
            energy = self.isentrope(at(i), energy, at(i + 1), 20);
            all.push(self.sample(at(i + 1), energy));
        }
        self.within("release", all)
    }

    /// Where melting begins and where it ends, from the expanded to the dense side, where P lies between 0 and `pressure` [Pa];
    /// empty for a model without melting, and without what lies beyond a table's states.
    pub fn melting_curves(&self, pressure: f64) -> [Vec<Sample>; 2] {
        let v0 = self.reference_volume();
        let at = |i: usize| v0 * (WIDEST - (WIDEST - 0.4) * i as f64 / (4 * COUNT) as f64);
        [0.0, 1.0].map(|liquid| {
            let border = |v: f64| self.melting_border(v, liquid);
            let mut curve: Vec<Sample> = Vec::new();
            let mut wider = None;
            for v in (0..=4 * COUNT).map(at) {
                let Some(sample) = border(v) else { continue };
                // The end without pressure lies between two volumes looked at.
                if let Some(from) = wider.filter(|_| curve.is_empty() && sample.pressure > 0.0) {
                    let pressure = |v: f64| border(v).map_or(f64::NAN, |s| s.pressure);
                    curve.extend(bisect(v, from, 1e-13 * v0, pressure).and_then(border));
                }
                match sample.pressure {
                    p if p < 0.0 => wider = Some(v),
                    p if p <= pressure => curve.push(sample),
                    _ => {}
                }
            }
            curve.retain(|s| self.covers(s.volume, s.temperature));
            curve
        })
    }

    /// Where at `volume` [m3/kg] melting begins (`liquid` 0) or ends (1), if it does.
    fn melting_border(&self, volume: f64, liquid: f64) -> Option<Sample> {
        let tm = self.melting_temperature(volume)?;
        let (low, high) = (self.energy_at(volume, 0.3 * tm), self.energy_at(volume, 3.0 * tm));
        let level = liquid.clamp(1e-12, 1.0 - 1e-12);
        let energy = bisect(low, high, 1e-12 * high.abs(), |e| self.point(volume, e).liquid - level)?;
        // To rounding it lies on one side or the other.
        Some(Sample { phase: Phase::Melting, liquid, ..self.sample(volume, energy) })
    }

    /// The critical point: the hottest isotherm on which the pressure, beyond 1.1 V0, does not fall with volume somewhere. `None` for
    /// models without a vapour of their own.
    pub fn critical_point(&self) -> Option<Sample> {
        let gray = match self {
            Eos::Gray(gray) => gray,
            Eos::Patches(patches) => patches.gray(),
            _ => return None,
        };
        let v0 = self.reference_volume();
        // (dP/dV)_T at its largest, and where: on a grid of V, then closed in on by thirds.
        let steepest = |t: f64| {
            let slope = |x: f64| gray.at(v0 * hvi_kit::math::exp(x), t).0.p_v;
            let (from, step) = (0.1, 0.01);
            let best = (0..400).map(|i| from + step * f64::from(i)).max_by(|a, b| slope(*a).total_cmp(&slope(*b)))?;
            let (mut low, mut high) = (best - step, best + step);
            for _ in 0..60 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if slope(a) > slope(b) { high = b } else { low = a }
            }
            Some((slope(0.5 * (low + high)), v0 * hvi_kit::math::exp(0.5 * (low + high))))
        };
        let t = bisect(1e3, 1e5, 1e-6, |t| steepest(t).map_or(f64::NAN, |s| s.0))?;
        let v = steepest(t)?.1;
        Some(self.sample(v, self.energy_at(v, t)))
    }
}
