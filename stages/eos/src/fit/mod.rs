//! Stage `eos.gray`: GRAY from the states of molecular dynamics.
//!
//! `states.rs` what the fit sees; `two_stage.rs` the paper's two fits; `least_squares.rs` the minimiser; `report.rs` what came
//! out and how sure it is.
mod least_squares;
mod report;
mod states;
#[cfg(test)]
mod synthetic;
mod two_stage;
pub use report::{FitReport, FittedParameter, Residual};
pub use states::{MeltingPoint, Reference, one_potential};

use crate::handbook::{COPPER_COHESION, COPPER_MOLAR_MASS};
use crate::model::gray::{Gray, Parameters};
use crate::{Eos, EosError, EosResult};
use hvi_kit::units::{SpecificEnergy, SpecificVolume, Temperature};
use hvi_kit::{Any, Ctx, Invalid, Stage, StageError, inputs};
use hvi_md::{Coexistence, State};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Why states give no equation of state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("fit of GRAY: {0}")]
pub struct FitError(pub String);

/// Which temperature a state is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// T(V, E) of the equilibrium model, as published (eq 33): a superheated crystal counts as molten, which biases Tm0 high.
    Published,
    /// T(V, E) on the branch the state was seen in: a superheated crystal stays solid, Tm0 comes from the liquid's energy.
    Labelled,
}

/// What the residuals are divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Weights {
    /// The same for all states, as published. Right where the model's own misfit (GPa) outweighs the states' errors.
    Uniform,
    /// Each state's standard error.
    Errors,
}

/// How a residual counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Loss {
    /// Its square, as published.
    Square,
    /// Its square while it is small, its size beyond three times the median (soft L1): a few mislabelled states then decide nothing.
    Soft,
}

/// From where pressures count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PressureZero {
    /// From zero, as they are.
    Absolute,
    /// From that of the reference state: Liu, Wang and Zhang (2013), sec. 6.2, call it P_0 and go up from there. The model has no
    /// pressure there either, but states whose pressure is counted so have energies that do not belong to it.
    Reference,
}

/// Parameters of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Which temperature a state is held against.
    pub method: Method,
    /// What the residuals are divided by.
    pub weights: Weights,
    /// How a residual counts.
    pub loss: Loss,
    /// Temperature of the reference state.
    pub reference_temperature: Temperature,
    /// V0, where the model has neither pressure nor energy at that temperature; by default where the states have no pressure. The
    /// paper's is that of a lattice of 0.3615 nm, 0.1119 cm3/g, where they have about 2 GPa.
    pub reference_volume: Option<SpecificVolume>,
    /// From where the states' pressures count, which matters with `reference_volume` only.
    pub pressure_zero: PressureZero,
    /// Energy of the dilute gas at T -> 0 above the reference state; sets the vapour only. Default: copper's, for copper; other
    /// metals need theirs.
    pub cohesive_energy: Option<SpecificEnergy>,
    /// Entropy of melting at constant volume plus the liquid's softening, in units of R: GRAY's Delta S, which T_m hangs on. With
    /// melting points among the inputs it is fitted, and this is where the search starts.
    pub melting_entropy: f64,
    /// Resamplings of the isochores for the errors; 0: covariance only.
    pub bootstrap: u32,
    /// Fits this resampling, from 1 on, in place of the states as they are: one of many that are as likely, to see what the states'
    /// errors do to what is computed with the fit.
    pub resampling: Option<u32>,
}
impl Default for Params {
    fn default() -> Params {
        Params {
            method: Method::Labelled,
            weights: Weights::Uniform,
            loss: Loss::Square,
            reference_temperature: Temperature::new(300.0),
            reference_volume: None,
            pressure_zero: PressureZero::Absolute,
            cohesive_energy: None,
            melting_entropy: 1.16,
            bootstrap: 100,
            resampling: None,
        }
    }
}

impl Params {
    /// Energy of the dilute gas of the metal of `molar_mass` [kg/mol] above the reference state [J/kg].
    fn cohesion(&self, molar_mass: f64) -> Result<f64, FitError> {
        match self.cohesive_energy {
            Some(energy) => Ok(energy.si()),
            None if (molar_mass / COPPER_MOLAR_MASS - 1.0).abs() < 1e-3 => Ok(COPPER_COHESION / COPPER_MOLAR_MASS),
            None => Err(FitError(format!(
                "`cohesive_energy` is known for copper only: give that of this metal of {:.3} g/mol, e.g. \"12.0 MJ/kg\" for aluminium",
                molar_mass * 1e3
            ))),
        }
    }
}

/// What the two fits need to know.
#[derive(Clone, Copy, Debug)]
struct Rule {
    method: Method,
    loss: Loss,
}
impl From<&Params> for Rule {
    fn from(params: &Params) -> Rule {
        Rule { method: params.method, loss: params.loss }
    }
}

inputs! {
    /// Inputs of the stage.
    pub struct Inputs {
        /// States of one metal, solid and liquid.
        states: Vec<State>,
        /// Points of its melting curve, from crystal and melt in one cell; or none.
        melting: Any<Coexistence>,
    }
}

/// The stage.
pub struct Fitting;
impl Stage for Fitting {
    const NAME: &'static str = "eos.gray";
    const SUMMARY: &'static str =
        "GRAY equation of state, fitted to molecular dynamics (two constrained least-squares fits)";
    type Params = Params;
    type Inputs = Inputs;
    type Output = EosResult;

    fn check(params: &Params) -> Result<(), Invalid> {
        let positive = |key: &str, value: f64, unit: &str| match value > 0.0 {
            true => Ok(()),
            false => Err(Invalid::new(key, format!("is {value} {unit}, must be positive"))),
        };
        positive("reference_temperature", params.reference_temperature.si(), "K")?;
        positive("reference_volume", params.reference_volume.map_or(1.0, |v| v.si()), "m3/kg")?;
        positive("cohesive_energy", params.cohesive_energy.map_or(1.0, |e| e.si()), "J/kg")?;
        // Below, the liquid's softening of 0.16 R makes the model invalid; metals have 0.8 to 1.7.
        if !(0.3..=5.0).contains(&params.melting_entropy) {
            return Err(Invalid::new(
                "melting_entropy",
                format!("is {} R, must be 0.3 to 5 R", params.melting_entropy),
            ));
        }
        if params.resampling == Some(0) {
            return Err(Invalid::new("resampling", "is 0, must be 1 or more"));
        }
        match params.bootstrap <= 10_000 {
            true => Ok(()),
            false => Err(Invalid::new("bootstrap", format!("is {}, at most 10000", params.bootstrap))),
        }
    }

    fn cost(params: &Params) -> f64 {
        0.3 + 0.03 * f64::from(params.bootstrap)
    }

    fn run(params: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<EosResult, StageError> {
        fit(params, &inputs.states, &inputs.melting.0, ctx)
    }
}

/// Fits GRAY to `states`, and its melting curve to `melting` where there are any.
///
/// # Errors
/// [`StageError::Physics`] with a [`FitError`]'s text where the states can't determine a parameter, or the fitted model fails its
/// own checks; [`StageError::Cancelled`].
pub fn fit(params: &Params, states: &[State], melting: &[Coexistence], ctx: &Ctx<'_>) -> Result<EosResult, StageError> {
    let (t0, v0) = (params.reference_temperature.si(), params.reference_volume.map(|v| v.si()));
    let mut data = states::Data::new(states, melting, t0, v0, params.weights).map_err(StageError::physics)?;
    if params.pressure_zero == PressureZero::Reference {
        data.count_from_reference();
    }
    if let Some(number) = params.resampling {
        data = report::resampled(&data, number);
        let other =
            |e: FitError| StageError::physics(format!("resampling {number} can't be fitted, take another: {e}"));
        data.check().map_err(other)?;
    }
    let cohesion = params.cohesion(data.molar_mass).map_err(StageError::physics)?;
    let start = two_stage::start(&data, params, cohesion);
    let fit = two_stage::fit(&data, &start, params.into(), true).map_err(StageError::physics)?;
    let p = fit.gray.parameters().clone();
    let densest = data.rows.iter().map(|r| 1.0 - r.volume / p.volume).fold(0.0, f64::max);
    if p.slope * densest > 0.92 {
        return Err(StageError::physics(FitError(format!(
            "S = {:.3} puts the pole of the Hugoniot at x = {:.3}, next to the densest state at x = {densest:.3} (S x at \
             most 0.92): leave out the densest states",
            p.slope,
            1.0 / p.slope
        ))));
    }
    let gray = with_vapour(p).map_err(StageError::physics)?;
    let shifted = two_stage::with_other_volume(&data, gray.parameters(), params.into());
    let bootstrap = report::bootstrap(&data, gray.parameters(), params, ctx)?;
    let report = FitReport::new(&data, &fit, &gray, shifted.as_ref(), params, &bootstrap);
    let points = match melting.len() {
        0 => String::new(),
        n => format!(" and {n} melting points of two-phase cells"),
    };
    let of = params.resampling.map_or(String::new(), |number| format!("resampling {number} of "));
    let source = format!("fitted to {of}{} states of molecular dynamics{points}", data.rows.len());
    Ok(EosResult { eos: Eos::Gray(gray), source, fit: Some(report) })
}

/// The model with the largest V_b of 0.5 V0 and below whose vapour joins: with a small g_e the joining functions would let the
/// vapour's pressure rise with volume at very high temperature. The fit knows nothing of V_b.
fn with_vapour(mut p: Parameters) -> Result<Gray, EosError> {
    loop {
        match Gray::new(p.clone()) {
            Err(e) if e.parameter == "covolume_ratio" && p.covolume_ratio > 0.2 => p.covolume_ratio -= 0.05,
            other => return other,
        }
    }
}
