//! The states as the fit sees them: zero-pressure volume and energy found, energies shifted, grouped by isochore.
use super::{FitError, Weights};
use crate::model::gray::{Branch, GAS_CONSTANT};
use hvi_kit::math::{bisect, sqrt};
use hvi_md::{Coexistence, Phase, State};
use serde::{Deserialize, Serialize};

/// One state, energy counted from (V0, T0).
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub volume: f64,
    pub temperature: f64,
    pub pressure: f64,
    pub energy: f64,
    pub branch: Branch,
    /// What the residuals are divided by: 1 GPa and 1 K, or the standard errors [Pa, K].
    pub pressure_scale: f64,
    pub temperature_scale: f64,
    /// Index of its isochore.
    pub isochore: usize,
}

/// Crystal and melt in equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeltingPoint {
    /// Pressure [Pa].
    pub pressure: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Its standard error [K].
    pub error: f64,
    /// Volume of the crystal there [m3/kg].
    pub solid: f64,
    /// Volume of the melt there [m3/kg].
    pub liquid: f64,
}

/// All states, and the reference state found among them.
#[derive(Clone, Debug)]
pub(super) struct Data {
    pub rows: Vec<Row>,
    pub melting: Vec<MeltingPoint>,
    pub isochores: usize,
    /// V0 [m3/kg] and its standard error.
    pub volume: (f64, f64),
    /// -V dP/dV at (V0, T0) [Pa].
    pub bulk_modulus: f64,
    pub molar_mass: f64,
}

/// States this close to T0 [K] make the reference isotherm.
const NEAR: f64 = 30.0;

impl Data {
    /// Finds V0 where the solid isotherm at `reference_temperature` [K] crosses P = 0, and counts energies from there.
    pub fn new(
        states: &[State],
        melting: &[Coexistence],
        reference_temperature: f64,
        weights: Weights,
    ) -> Result<Data, FitError> {
        let refuse = |why: String| Err(FitError(why));
        let Some(first) = states.first() else { return refuse("there are no states to fit".into()) };
        let molar_mass = first.molar_mass;
        if let Some(i) = states.iter().position(|s| s.molar_mass != molar_mass) {
            return refuse(format!("state {i} has another molar mass than the first: one metal a fit"));
        }
        let bad = |s: &State| ![s.volume, s.temperature, s.pressure, s.energy].iter().all(|x| x.is_finite());
        if let Some(i) = states.iter().position(bad) {
            return refuse(format!("state {i} is not finite: {:?}", states[i]));
        }
        if let Some(i) = melting.iter().position(|m| m.molar_mass != molar_mass) {
            return refuse(format!("melting point {i} has another molar mass than the states: one metal a fit"));
        }
        let reference = Reference::find(states, reference_temperature)?;
        let mut isochores: Vec<f64> = states.iter().map(|s| s.volume).collect();
        isochores.sort_by(f64::total_cmp);
        // Volumes of one isochore may differ by rounding only.
        isochores.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * *b);
        let heat = 3.0 * GAS_CONSTANT / molar_mass;
        let row = |s: &State| {
            let (pressure_scale, temperature_scale) = match weights {
                Weights::Uniform => (1e9, 1.0),
                Weights::Errors => {
                    let energy = s.energy_error / heat;
                    (s.pressure_error, sqrt(s.temperature_error * s.temperature_error + energy * energy))
                }
            };
            Row {
                volume: s.volume,
                temperature: s.temperature,
                pressure: s.pressure,
                energy: s.energy - reference.energy,
                branch: if s.phase == Phase::Solid { Branch::Solid } else { Branch::Liquid },
                pressure_scale,
                temperature_scale,
                isochore: isochores.partition_point(|&v| v < s.volume * (1.0 - 1e-6)),
            }
        };
        let rows: Vec<Row> = states.iter().map(row).collect();
        if let Some(i) = rows.iter().position(|r| !(r.pressure_scale > 0.0 && r.temperature_scale > 0.0)) {
            return refuse(format!("state {i} has no standard errors: use weights = \"uniform\""));
        }
        let point = |m: &Coexistence| MeltingPoint {
            pressure: m.pressure,
            temperature: m.temperature,
            error: m.temperature_error,
            solid: m.solid.volume,
            liquid: m.liquid.volume,
        };
        let data = Data {
            rows,
            melting: melting.iter().map(point).collect(),
            isochores: isochores.len(),
            volume: (reference.volume, reference.volume_error),
            bulk_modulus: reference.bulk_modulus,
            molar_mass,
        };
        data.check()?;
        Ok(data)
    }

    pub fn solids(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| r.branch == Branch::Solid)
    }

    /// Refuses states that can't determine the parameters.
    pub fn check(&self) -> Result<(), FitError> {
        let mut volumes: Vec<usize> = self.solids().map(|r| r.isochore).collect();
        volumes.sort_unstable();
        volumes.dedup();
        if volumes.len() < 4 {
            let why = format!("solid states at {} volumes: C and S need 4 or more", volumes.len());
            return Err(FitError(why));
        }
        let extreme = |f: fn(f64, f64) -> f64, start| self.solids().map(|r| r.temperature).fold(start, f);
        let (cold, hot) = (extreme(f64::min, f64::INFINITY), extreme(f64::max, 0.0));
        if hot < 1.5 * cold {
            return Err(FitError(format!(
                "solid states from {cold:.0} K to {hot:.0} K only: gamma0 and a come from how pressure rises with \
                 temperature, one isotherm can't tell them: add solid states at half as hot again or more"
            )));
        }
        if !self.rows.iter().any(|r| r.branch == Branch::Liquid) {
            return Err(FitError(
                "no molten state: Tm0 shows only in molten states' energy: add states above melting".into(),
            ));
        }
        Ok(())
    }
}

/// The zero-pressure solid at T0, as the states have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// V0 [m3/kg].
    pub volume: f64,
    /// Standard error of V0 [m3/kg].
    pub volume_error: f64,
    /// Energy there, in the states' own zero [J/kg].
    pub energy: f64,
    /// -V dP/dV along the isotherm there [Pa].
    pub bulk_modulus: f64,
}

impl Reference {
    /// Cubic interpolation of the solid isotherm at `t0` [K] through the four states nearest to zero pressure.
    ///
    /// # Errors
    /// [`FitError`] where fewer than four solid states lie within 30 K of it, or none on one side of zero pressure.
    pub fn find(states: &[State], t0: f64) -> Result<Reference, FitError> {
        let near = |s: &&State| s.phase == Phase::Solid && (s.temperature - t0).abs() <= NEAR;
        // Brought to T0 with C_V = 3R and gamma = 2: a fraction of a kelvin, a few MPa.
        let mut points: Vec<[f64; 4]> = states
            .iter()
            .filter(near)
            .map(|s| {
                let heat = 3.0 * GAS_CONSTANT / s.molar_mass * (t0 - s.temperature);
                [s.volume, s.pressure + 2.0 * heat / s.volume, s.energy + heat, s.pressure_error]
            })
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let crossing = points.windows(2).position(|w| w[0][1] >= 0.0 && w[1][1] < 0.0);
        let (Some(crossing), true) = (crossing, points.len() >= 4) else {
            return Err(FitError(format!(
                "V0 is where the solid isotherm at {t0:.0} K crosses zero pressure: needs 4 or more solid states within \
                 {NEAR:.0} K of it, on both sides of zero pressure; there are {} of them",
                points.len()
            )));
        };
        let first = crossing.saturating_sub(1).min(points.len() - 4);
        let four = &points[first..first + 4];
        let through = |column: usize, v: f64| {
            (0..4)
                .map(|i| {
                    (0..4)
                        .filter(|&j| j != i)
                        .fold(four[i][column], |y, j| y * (v - four[j][0]) / (four[i][0] - four[j][0]))
                })
                .sum::<f64>()
        };
        let (low, high) = (points[crossing][0], points[crossing + 1][0]);
        let volume = bisect(low, high, 1e-14 * low, |v| through(1, v)).unwrap_or(low);
        let h = 1e-4 * volume;
        let bulk_modulus = -volume * (through(1, volume + h) - through(1, volume - h)) / (2.0 * h);
        if bulk_modulus <= 0.0 {
            return Err(FitError(format!("pressure does not fall with volume along the {t0:.0} K isotherm at P = 0")));
        }
        let error = points[crossing][3].max(points[crossing + 1][3]);
        let volume_error = volume * error / bulk_modulus;
        Ok(Reference { volume, volume_error, energy: through(2, volume), bulk_modulus })
    }
}
