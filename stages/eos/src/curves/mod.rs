//! Stage `eos.curves`: what an equation of state says, as curves with units: Hugoniot, isotherms, isobars, isentropes, releases,
//! melting, critical point, sound speed, and the surface of pressure over volume and energy.
//!
//! `trace.rs` the curves; `text.rs` curves and answers as comma-separated text.
pub mod text;
pub mod trace;
use crate::curve::CurveError;
use crate::landmarks::Landmark;
use crate::{Eos, EosResult};
use hvi_kit::units::{Pressure, Temperature};
use hvi_kit::view::{Scalar, View};
use hvi_kit::{Artifact, Ctx, Invalid, Stage, StageError, inputs};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trace::Sample;

/// Parameters of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Highest pressure of the Hugoniot, the isotherms and the melting curve.
    pub up_to: Pressure,
    /// Temperatures of the isotherms.
    pub isotherms: Vec<Temperature>,
    /// Pressures of the isobars.
    pub isobars: Vec<Pressure>,
    /// Highest temperature of the isobars.
    pub hottest: Temperature,
    /// Temperatures at V0 from which isentropes compress.
    pub isentropes: Vec<Temperature>,
    /// Shock pressures from which releases start.
    pub releases: Vec<Pressure>,
}
impl Default for Params {
    fn default() -> Params {
        Params {
            up_to: Pressure::new(400e9),
            isotherms: [300.0, 1000.0, 2000.0, 4000.0].map(Temperature::new).into(),
            isobars: [0.0, 10e9, 50e9, 100e9].map(Pressure::new).into(),
            hottest: Temperature::new(6000.0),
            isentropes: [300.0, 1000.0].map(Temperature::new).into(),
            releases: [50e9, 100e9, 150e9, 200e9].map(Pressure::new).into(),
        }
    }
}

inputs! {
    /// Inputs of the stage.
    pub struct Inputs {
        /// The equation of state.
        eos: EosResult,
    }
}

/// Which curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Kind {
    Hugoniot,
    Isotherm,
    Isobar,
    Isentrope,
    Release,
    MeltingBegins,
    MeltingEnds,
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Which.
    pub kind: Kind,
    /// Its name, e.g. `"isotherm 300 K"`.
    pub name: String,
    /// Its states.
    pub samples: Vec<Sample>,
}

/// Pressure and temperature over volume and energy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Specific volumes [m3/kg], rising.
    pub volumes: Vec<f64>,
    /// Specific energies [J/kg], rising.
    pub energies: Vec<f64>,
    /// Pressure [Pa] and temperature [K], `[energy][volume]`.
    pub values: Vec<Vec<[f64; 2]>>,
}

/// What the stage leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// The model's name and source.
    pub source: String,
    /// V0 [m3/kg].
    pub reference_volume: f64,
    /// The curves.
    pub curves: Vec<Curve>,
    /// The critical point, where the model has one.
    pub critical: Option<Sample>,
    /// Melting in numbers; empty for a model without.
    pub landmarks: Vec<Landmark>,
    /// Fig 4 of the paper.
    pub surface: Surface,
}

/// The stage.
pub struct CurvesStage;
impl Stage for CurvesStage {
    const NAME: &'static str = "eos.curves";
    const SUMMARY: &'static str =
        "curves of an equation of state: Hugoniot, isotherms, isobars, isentropes, releases, melting, P-E-V surface";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Curves;

    fn check(params: &Params) -> Result<(), Invalid> {
        let positive = |key: &str, all: &[f64], least: f64| match all.iter().all(|x| *x > least && x.is_finite()) {
            true => Ok(()),
            false => Err(Invalid::new(key, format!("must be above {least} in SI units"))),
        };
        let kelvin = |t: &[Temperature]| t.iter().map(|t| t.si()).collect::<Vec<_>>();
        positive("up_to", &[params.up_to.si()], 1e9)?;
        positive("isotherms", &kelvin(&params.isotherms), 0.0)?;
        positive("isentropes", &kelvin(&params.isentropes), 0.0)?;
        positive("hottest", &[params.hottest.si()], 100.0)?;
        positive("releases", &params.releases.iter().map(|p| p.si()).collect::<Vec<_>>(), 0.0)
    }

    fn cost(_: &Params) -> f64 {
        1.0
    }

    fn run(params: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<Curves, StageError> {
        trace_all(params, &inputs.eos, ctx)
    }
}

/// All curves of `result`.
///
/// # Errors
/// [`StageError::Physics`] where the model has no such shock or release, or a curve leaves a table's states;
/// [`StageError::Cancelled`].
pub fn trace_all(params: &Params, result: &EosResult, ctx: &Ctx<'_>) -> Result<Curves, StageError> {
    let (eos, v0) = (&result.eos, result.eos.reference_volume());
    let mut curves = Vec::new();
    let mut add = |kind, name: String, samples| curves.push(Curve { kind, name, samples });
    ctx.tick(0.0, 3.0, "Hugoniot and releases")?;
    add(Kind::Hugoniot, "Hugoniot".into(), eos.hugoniot_curve(params.up_to.si()).map_err(StageError::physics)?);
    for p in &params.releases {
        let shock = eos.hugoniot_at_pressure(p.si()).map_err(StageError::physics)?;
        let samples = eos.release_curve(&shock).map_err(StageError::physics)?;
        add(Kind::Release, format!("release from {} GPa", p.si() / 1e9), samples);
    }
    ctx.tick(1.0, 3.0, "isotherms, isobars, isentropes")?;
    for t in &params.isotherms {
        let end = densest(eos, t.si(), params.up_to.si()).map_err(StageError::physics)?;
        let samples = eos.isotherm_curve(t.si(), widest(eos, t.si()), end).map_err(StageError::physics)?;
        add(Kind::Isotherm, format!("isotherm {} K", t.si()), samples);
    }
    for p in &params.isobars {
        let samples = eos.isobar_curve(p.si(), 100.0, params.hottest.si());
        add(Kind::Isobar, format!("isobar {} GPa", p.si() / 1e9), samples);
    }
    for t in &params.isentropes {
        let end = densest_adiabat(eos, t.si(), params.up_to.si()).map_err(StageError::physics)?;
        let samples = eos.isentrope_curve(v0, t.si(), end).map_err(StageError::physics)?;
        add(Kind::Isentrope, format!("isentrope from {} K at V0", t.si()), samples);
    }
    ctx.tick(2.0, 3.0, "melting")?;
    let [begins, ends] = eos.melting_curves(params.up_to.si());
    if !begins.is_empty() {
        add(Kind::MeltingBegins, "melting begins".into(), begins);
        add(Kind::MeltingEnds, "melting ends".into(), ends);
    }
    let landmarks = match eos {
        Eos::Gray(gray) => crate::landmarks::landmarks(gray),
        Eos::Patches(patches) => crate::landmarks::landmarks(patches.gray()),
        _ => Vec::new(),
    };
    Ok(Curves {
        source: format!("{}: {}", eos.name(), result.source),
        reference_volume: v0,
        curves,
        critical: eos.critical_point(),
        landmarks,
        surface: surface(eos),
    })
}

/// Where isotherms begin [m3/kg]: 1.15 V0, or the widest volume at which a table has states of `temperature` [K].
fn widest(eos: &Eos, temperature: f64) -> f64 {
    let ratios = (0..=60).map(|i| 1.15 - 0.005 * f64::from(i));
    let mut covered = ratios.map(|r| r * eos.reference_volume()).filter(|v| eos.covers(*v, temperature));
    covered.next().unwrap_or(1.15 * eos.reference_volume())
}

/// The volume [m3/kg] at which the isotherm of `temperature` [K] reaches `pressure` [Pa], 0.4 V0 at least.
///
/// # Errors
/// [`CurveError`] where its pressure at V0 is higher already.
pub fn densest(eos: &Eos, temperature: f64, pressure: f64) -> Result<f64, CurveError> {
    end(eos, "isotherm", pressure, |v| eos.pressure_at(v, temperature))
}

/// The same of the isentrope through (V0, `temperature` [K]).
///
/// # Errors
/// As [`densest`].
pub fn densest_adiabat(eos: &Eos, temperature: f64, pressure: f64) -> Result<f64, CurveError> {
    let v0 = eos.reference_volume();
    let start = eos.energy_at(v0, temperature);
    end(eos, "isentrope", pressure, |v| eos.point(v, eos.isentrope(v0, start, v, 400)).pressure)
}

/// Where between V0 and 0.4 V0 the curve with `pressure_at` reaches `pressure` [Pa].
fn end(eos: &Eos, curve: &'static str, pressure: f64, pressure_at: impl Fn(f64) -> f64) -> Result<f64, CurveError> {
    let v0 = eos.reference_volume();
    let first = pressure_at(v0);
    if !(first < pressure) {
        let why =
            format!("it has {:.4} GPa at V0, no less than the {:.4} GPa it is to end at", first / 1e9, pressure / 1e9);
        return Err(CurveError { curve, model: eos.name(), why });
    }
    Ok(hvi_kit::math::bisect(0.4 * v0, v0, 1e-9 * v0, |v| pressure_at(v) - pressure).unwrap_or(0.4 * v0))
}

/// From 0.6 to 1.1 V0, and from the coldest energy there to the heat of 9000 K at V0: the range of Fig 4. Where a table has no
/// states pressure and temperature are 0.
fn surface(eos: &Eos) -> Surface {
    const N: usize = 120;
    let v0 = eos.reference_volume();
    let volumes: Vec<f64> = (0..=N).map(|i| v0 * (0.6 + 0.5 * i as f64 / N as f64)).collect();
    let bottom = eos.energy_at(v0, 0.0);
    let top = eos.energy_at(v0, 9000.0);
    let energies: Vec<f64> = (0..=N).map(|i| bottom + (top - bottom) * i as f64 / N as f64).collect();
    let at = |v: f64, e: f64| {
        let p = eos.point(v, e);
        if eos.covers(v, p.temperature) { [p.pressure, p.temperature] } else { [0.0; 2] }
    };
    let values = energies.iter().map(|&e| volumes.iter().map(|&v| at(v, e)).collect()).collect();
    Surface { volumes, energies, values }
}

impl Artifact for Curves {
    const KIND: &'static str = "eos-curves/2";

    fn scalars(&self) -> Vec<Scalar> {
        let mut all = vec![Scalar::text("equation of state", self.source.as_str())];
        if let Some(c) = &self.critical {
            all.push(Scalar::number("critical temperature", c.temperature, "K"));
            all.push(Scalar::number("critical pressure", c.pressure / 1e9, "GPa"));
            all.push(Scalar::number("critical density", 1.0 / c.volume, "kg/m3"));
        }
        all.extend(self.landmarks.iter().filter_map(|l| Some(Scalar::number(&l.name, l.value?, &l.unit))));
        all
    }

    fn views(&self) -> Vec<View> {
        crate::show::curves::views(self)
    }
}
