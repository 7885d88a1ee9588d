//! The states as the fit sees them: zero-pressure volume and energy found, energies shifted, grouped by isochore.
use super::{FitError, Weights};
use crate::model::gray::{Branch, GAS_CONSTANT};
use hvi_kit::math::{bisect, sqrt};
use hvi_md::{Coexistence, Phase, State, isochores};
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
    /// Standard errors of pressure and temperature [Pa, K], that of the energy as a temperature included.
    pub errors: [f64; 2],
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
    /// States left out because they have torn.
    pub torn: usize,
    /// V0 [m3/kg] and its standard error.
    pub volume: (f64, f64),
    /// The states' pressure at (V0, T0) [Pa], where the model has none.
    pub reference_pressure: f64,
    /// -V dP/dV at (V0, T0) [Pa].
    pub bulk_modulus: f64,
    pub molar_mass: f64,
}

/// Refuses states of several potentials: each has its own lattice and its own zero of energy.
///
/// # Errors
/// [`FitError`] with the first state that is of another.
pub fn one_potential(states: &[State]) -> Result<(), FitError> {
    let Some(first) = states.first() else { return Ok(()) };
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b;
    let other = |s: &State| !same(s.lattice_volume, first.lattice_volume) || !same(s.molar_mass, first.molar_mass);
    let Some(i) = states.iter().position(other) else { return Ok(()) };
    Err(FitError(format!(
        "state {i} is of another metal or potential than the first: its lattice at 0 K has {:.6} cm3/g, not {:.6}",
        states[i].lattice_volume * 1e3,
        first.lattice_volume * 1e3
    )))
}

/// States this close to T0 [K] make the reference isotherm.
const NEAR: f64 = 30.0;

impl Data {
    /// Finds V0 where the solid isotherm at `reference_temperature` [K] crosses P = 0, unless it is `reference_volume` [m3/kg], and
    /// counts energies from there.
    pub fn new(
        states: &[State],
        melting: &[Coexistence],
        reference_temperature: f64,
        reference_volume: Option<f64>,
        weights: Weights,
    ) -> Result<Data, FitError> {
        let refuse = |why: String| Err(FitError(why));
        let Some(first) = states.first() else { return refuse("there are no states to fit".into()) };
        let molar_mass = first.molar_mass;
        if let Some(i) = states.iter().position(|s| s.molar_mass != molar_mass) {
            return refuse(format!("state {i} has another molar mass than the first: one metal a fit"));
        }
        one_potential(states)?;
        let bad = |s: &State| ![s.volume, s.temperature, s.pressure, s.energy].iter().all(|x| x.is_finite());
        if let Some(i) = states.iter().position(bad) {
            return refuse(format!("state {i} is not finite: {:?}", states[i]));
        }
        if let Some(i) = melting.iter().position(|m| m.molar_mass != molar_mass) {
            return refuse(format!("melting point {i} has another molar mass than the states: one metal a fit"));
        }
        let reference = match reference_volume {
            Some(volume) => Reference::at(states, reference_temperature, volume)?,
            None => Reference::find(states, reference_temperature)?,
        };
        let isochores: Vec<f64> = isochores(states).iter().map(|same| same[0].volume).collect();
        let heat = 3.0 * GAS_CONSTANT / molar_mass;
        let row = |s: &State| {
            let energy = s.energy_error / heat;
            let errors = [s.pressure_error, sqrt(s.temperature_error * s.temperature_error + energy * energy)];
            let [pressure_scale, temperature_scale] = match weights {
                Weights::Uniform => [1e9, 1.0],
                Weights::Errors => errors,
            };
            Row {
                volume: s.volume,
                temperature: s.temperature,
                pressure: s.pressure,
                energy: s.energy - reference.energy,
                branch: if s.phase == Phase::Solid { Branch::Solid } else { Branch::Liquid },
                pressure_scale,
                temperature_scale,
                errors,
                isochore: isochores.partition_point(|&v| v < s.volume * (1.0 - 1e-6)),
            }
        };
        let rows: Vec<Row> = states.iter().filter(|s| !s.is_torn()).map(row).collect();
        let torn = states.len() - rows.len();
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
            torn,
            volume: (reference.volume, reference.volume_error),
            reference_pressure: reference.pressure,
            bulk_modulus: reference.bulk_modulus,
            molar_mass,
        };
        data.check()?;
        Ok(data)
    }

    /// Takes the reference state's pressure off all states'; points of the melting curve keep theirs, which the fit does not use.
    pub fn count_from_reference(&mut self) {
        self.rows.iter_mut().for_each(|r| r.pressure -= self.reference_pressure);
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

/// The solid at V0 and T0, as the states have it: without pressure, unless V0 was given.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// V0 [m3/kg].
    pub volume: f64,
    /// Standard error of V0 [m3/kg].
    pub volume_error: f64,
    /// Pressure there [Pa].
    pub pressure: f64,
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
        let points = isotherm(states, t0);
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
        let (low, high) = (points[crossing][0], points[crossing + 1][0]);
        let volume = bisect(low, high, 1e-14 * low, |v| through(four, 1, v)).unwrap_or(low);
        let found = Reference::of(four, volume, t0)?;
        let error = points[crossing][3].max(points[crossing + 1][3]);
        Ok(Reference { volume_error: volume * error / found.bulk_modulus, pressure: 0.0, ..found })
    }

    /// The same at `volume` [m3/kg], whatever the pressure; up to a hundredth beyond the states.
    ///
    /// # Errors
    /// [`FitError`] where fewer than four solid states lie within 30 K of `t0` [K], or `volume` lies beyond them.
    pub fn at(states: &[State], t0: f64, volume: f64) -> Result<Reference, FitError> {
        let points = isotherm(states, t0);
        let ends = points.first().zip(points.last()).map(|(a, b)| [0.99 * a[0], 1.01 * b[0]]);
        match ends {
            Some([low, high]) if points.len() >= 4 && (low..=high).contains(&volume) => {
                let above = points.partition_point(|p| p[0] < volume);
                let first = above.saturating_sub(2).min(points.len() - 4);
                Reference::of(&points[first..first + 4], volume, t0)
            }
            _ => Err(FitError(format!(
                "reference_volume is {:.5} cm3/g: needs 4 or more solid states within {NEAR:.0} K of {t0:.0} K, on both sides of it; \
                 there are {} of them{}",
                volume * 1e3,
                points.len(),
                ends.map_or(String::new(), |[a, b]| format!(", {:.5} to {:.5} cm3/g", a / 0.99 * 1e3, b / 1.01 * 1e3))
            ))),
        }
    }

    fn of(four: &[[f64; 4]], volume: f64, t0: f64) -> Result<Reference, FitError> {
        let h = 1e-4 * volume;
        let bulk_modulus = -volume * (through(four, 1, volume + h) - through(four, 1, volume - h)) / (2.0 * h);
        if bulk_modulus <= 0.0 {
            return Err(FitError(format!("pressure does not fall with volume along the {t0:.0} K isotherm at V0")));
        }
        let [pressure, energy] = [1, 2].map(|column| through(four, column, volume));
        Ok(Reference { volume, volume_error: 0.0, pressure, energy, bulk_modulus })
    }
}

/// Volume, pressure, energy and error of pressure along the solid isotherm at `t0` [K], volumes rising.
fn isotherm(states: &[State], t0: f64) -> Vec<[f64; 4]> {
    let near = |s: &&State| s.phase == Phase::Solid && !s.is_torn() && (s.temperature - t0).abs() <= NEAR;
    // Brought to T0 with C_V = 3R and gamma = 2: a fraction of a kelvin, a few MPa.
    let brought = |s: &State| {
        let heat = 3.0 * GAS_CONSTANT / s.molar_mass * (t0 - s.temperature);
        [s.volume, s.pressure + 2.0 * heat / s.volume, s.energy + heat, s.pressure_error]
    };
    let mut points: Vec<[f64; 4]> = states.iter().filter(near).map(brought).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// The cubic through `column` of four points, at volume `v`.
fn through(four: &[[f64; 4]], column: usize, v: f64) -> f64 {
    let basis = |i: usize| {
        (0..4).filter(|&j| j != i).fold(four[i][column], |y, j| y * (v - four[j][0]) / (four[i][0] - four[j][0]))
    };
    (0..4).map(basis).sum::<f64>()
}
