//! What came out of the fit, and how sure it is: parameters, errors, correlations, residuals.
use super::states::{Data, MeltingPoint};
use super::two_stage::{self, Fit};
use super::{Loss, Method, Params, PressureZero, Weights};
use crate::landmarks::{Landmark, landmarks};
use crate::model::gray::{Branch, Gray, Parameters};
use hvi_kit::{Ctx, StageError};
use serde::{Deserialize, Serialize};

/// A fitted parameter, in the paper's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedParameter {
    /// The paper's symbol.
    pub symbol: String,
    /// The paper's unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Standard error from the covariance at the minimum, residuals taken as independent, and from the error of V0, in
    /// quadrature. (Of V0: from the pressure's error.)
    pub error: f64,
    /// Standard error from resampling whole isochores; `None` where it was not asked for, and for V0.
    pub bootstrap_error: Option<f64>,
}
impl FittedParameter {
    /// The larger of the two errors: what to quote.
    pub fn quoted_error(&self) -> f64 {
        self.error.max(self.bootstrap_error.unwrap_or(0.0))
    }
}

/// A state against the model at the same volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// V/V0.
    pub ratio: f64,
    /// Temperature of the state [K].
    pub temperature: f64,
    /// Whether the state was seen solid.
    pub solid: bool,
    /// Pressure of the state [Pa].
    pub pressure: f64,
    /// The model's pressure at the state's (V, T), on its branch [Pa].
    pub model_pressure: f64,
    /// The model's temperature at the state's (V, E), by the method of the fit [K].
    pub model_temperature: f64,
    /// The state's standard errors of pressure and temperature [Pa, K], that of its energy as a temperature included.
    pub errors: [f64; 2],
}
impl Residual {
    /// State minus model in units of the state's standard errors, of pressure and of temperature; `None` where it has none.
    pub fn pulls(&self) -> [Option<f64>; 2] {
        let off = [self.pressure - self.model_pressure, self.temperature - self.model_temperature];
        [0, 1].map(|k| (self.errors[k] > 0.0).then(|| off[k] / self.errors[k]))
    }
}

/// The fit, for people and for later stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// V0, C, S, gamma0, a, g_e, Tm, in the order of the paper's Table 1; and Delta S where it was fitted.
    pub parameters: Vec<FittedParameter>,
    /// Correlations of the logarithms of C, S, gamma0, a: `[4][4]`.
    pub pressure_correlations: Vec<Vec<f64>>,
    /// Correlation of the logarithms of Tm0 and g_e.
    pub temperature_correlation: f64,
    /// Condition number of the pressure fit, columns scaled.
    pub condition: f64,
    /// Every state that is not torn, in the order given.
    pub residuals: Vec<Residual>,
    /// Every melting point with the model's temperature there [K], in the order given.
    pub melting: Vec<(MeltingPoint, f64)>,
    /// Resamplings that could be fitted.
    pub resamplings: u32,
    /// What the fitted model says of melting and release.
    pub landmarks: Vec<Landmark>,
    /// Decisions a reader must know, one sentence each.
    pub notes: Vec<String>,
}

/// Resampling number `number` of `data`. States of one isochore come from one run and one lattice: they err together, so whole
/// isochores are drawn, with replacement; V0 and melting points are drawn within their own errors.
pub(super) fn resampled(data: &Data, number: u32) -> Data {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(2 * u64::from(number) + 1);
    let mut draw = |n: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        ((u128::from(seed) * n as u128) >> 64) as usize
    };
    let mut sample = Data { rows: Vec::new(), ..data.clone() };
    // A sum of twelve uniform numbers is normal enough.
    let mut normal = || (0..12).map(|_| draw(1 << 20) as f64 / (1 << 20) as f64).sum::<f64>() - 6.0;
    sample.volume.0 += normal() * data.volume.1;
    sample.melting.iter_mut().for_each(|m| m.temperature += normal() * m.error);
    for _ in 0..data.isochores {
        let pick = draw(data.isochores);
        sample.rows.extend(data.rows.iter().filter(|r| r.isochore == pick).cloned());
    }
    sample
}

/// Parameters of each resampling, the first being number 1: `[resampling][C, S, gamma0, a, Tm0, G0]`.
pub(super) fn bootstrap(
    data: &Data,
    best: &Parameters,
    params: &Params,
    ctx: &Ctx<'_>,
) -> Result<Vec<[f64; 6]>, StageError> {
    let mut found = Vec::new();
    for i in 0..params.bootstrap {
        ctx.tick(f64::from(i), f64::from(params.bootstrap), "resampling isochores")?;
        let sample = resampled(data, i + 1);
        // A draw that can't determine the parameters says nothing of their spread.
        if sample.check().is_err() {
            continue;
        }
        let start = Parameters { volume: sample.volume.0, ..best.clone() };
        if let Ok(fit) = two_stage::fit(&sample, &start, params.into(), false) {
            found.push(fitted_values(fit.gray.parameters()));
        }
    }
    Ok(found)
}

/// C, S, gamma0, a, Tm0, G0.
fn fitted_values(p: &Parameters) -> [f64; 6] {
    [p.sound_speed, p.slope, p.gruneisen, p.gruneisen_slope, p.melting_temperature, p.electronic]
}

impl FitReport {
    pub(super) fn new(
        data: &Data,
        fit: &Fit,
        gray: &Gray,
        shifted: Option<&Parameters>,
        params: &Params,
        bootstrap: &[[f64; 6]],
    ) -> FitReport {
        let p = fit.gray.parameters();
        let shift: [f64; 6] = shifted.map_or([0.0; 6], |s| {
            let (best, other) = (fitted_values(p), fitted_values(s));
            std::array::from_fn(|k| other[k] / best[k] - 1.0)
        });
        let relative = |covariance: &Option<Vec<Vec<f64>>>, k: usize, column: usize| {
            covariance.as_ref().map_or(f64::INFINITY, |c| (c[k][k] + shift[column] * shift[column]).sqrt())
        };
        let spread = |k: usize| (bootstrap.len() >= 10).then(|| deviation(bootstrap.iter().map(|b| b[k])));
        let fitted = |symbol: &str, unit: &str, scale: f64, value: f64, error: f64, column: usize| FittedParameter {
            symbol: symbol.into(),
            unit: unit.into(),
            value: value * scale,
            error: error * value * scale,
            bootstrap_error: spread(column).map(|s| s * scale),
        };
        let first = |k| relative(&fit.pressure.covariance, k, k);
        // Delta S has no share of V0's error of its own: it follows Tm0
        let second = |k: usize| relative(&fit.temperature.covariance, k, if k == 2 { 4 } else { 4 + k });
        let mut volume = fitted("V0", "cm3/g", 1e3, p.volume, data.volume.1 / p.volume, 0);
        volume.bootstrap_error = None;
        let entropy = (!data.melting.is_empty()).then(|| {
            let of = fitted("Delta S", "R", 1.0, p.melting_entropy, second(2), 0);
            FittedParameter { bootstrap_error: None, ..of }
        });
        let melting = |m: &MeltingPoint| (m.clone(), two_stage::melting_temperature(&fit.gray, m));
        let parameters = vec![
            volume,
            fitted("C", "cm/us", 1e-4, p.sound_speed, first(0), 0),
            fitted("S", "", 1.0, p.slope, first(1), 1),
            fitted("gamma0", "", 1.0, p.gruneisen, first(2), 2),
            fitted("a", "", 1.0, p.gruneisen_slope, first(3), 3),
            fitted("g_e", "kJ/mol/K2", 1e-3 * p.molar_mass, p.electronic, second(1), 5),
            fitted("T_m", "K", 1.0, p.melting_temperature, second(0), 4),
        ];
        FitReport {
            parameters: parameters.into_iter().chain(entropy).collect(),
            melting: data.melting.iter().map(melting).collect(),
            pressure_correlations: correlations(&fit.pressure.covariance),
            temperature_correlation: correlations(&fit.temperature.covariance).first().map_or(0.0, |row| row[1]),
            condition: fit.pressure.condition,
            residuals: residuals(data, fit, params.method),
            resamplings: bootstrap.len() as u32,
            landmarks: landmarks(gray),
            notes: notes(params, data, fit, gray),
        }
    }

    /// Root mean square and largest of the solid states' pressure residuals [Pa].
    pub fn pressure_misfit(&self) -> (f64, f64) {
        misfit(self.residuals.iter().filter(|r| r.solid).map(|r| r.model_pressure - r.pressure))
    }
    /// Root mean square and largest of all states' temperature residuals [K].
    pub fn temperature_misfit(&self) -> (f64, f64) {
        misfit(self.residuals.iter().map(|r| r.model_temperature - r.temperature))
    }
}

fn residuals(data: &Data, fit: &Fit, method: Method) -> Vec<Residual> {
    let of = |r: &super::states::Row| Residual {
        ratio: r.volume / data.volume.0,
        temperature: r.temperature,
        solid: r.branch == Branch::Solid,
        pressure: r.pressure,
        model_pressure: fit.gray.branch_at(r.volume, r.temperature, r.branch).pressure,
        model_temperature: two_stage::temperature(&fit.gray, r, method),
        errors: r.errors,
    };
    data.rows.iter().map(of).collect()
}

fn notes(params: &Params, data: &Data, fit: &Fit, gray: &Gray) -> Vec<String> {
    let method = match params.method {
        Method::Published => {
            "T is that of the equilibrium model at (V, E), as published: superheated crystals count as molten, so T_m is \
             biased high."
        }
        Method::Labelled => {
            "T is that of the branch (solid or liquid) each state was seen in: superheating of the crystal does not enter, \
             T_m comes from the liquid's energy."
        }
    };
    let weights = match params.weights {
        Weights::Uniform => {
            "All states weigh alike, as published: the model's own misfit outweighs the statistical errors of the states."
        }
        Weights::Errors => "States weigh by their standard errors.",
    };
    let loss = match params.loss {
        Loss::Square => "Residuals count by their squares, as published.",
        Loss::Soft => "Residuals beyond three times the median count by their size only (soft L1).",
    };
    let classical = "The states are classical and without electrons: g_e absorbs the anharmonicity of the lattice, it is no \
                     electronic heat, and the heat capacity at 300 K is 3R rather than the measured 2.94 R.";
    let mut notes: Vec<String> = [method, weights, loss, classical].map(String::from).into();
    if !data.melting.is_empty() {
        notes.push(
            "T_m and its dependence on volume come from crystal and melt in one cell, without overheating; the melt's energy then \
             gives the entropy of melting."
                .into(),
        );
    }
    if data.torn > 0 {
        notes.push(format!("{} torn states, matter beside voids, are left out.", data.torn));
    }
    if params.reference_volume.is_some() {
        notes.push(format!(
            "V0 was given: the states have {:.2} GPa there at the reference temperature, the model has none.",
            data.reference_pressure / 1e9
        ));
    }
    if params.pressure_zero == PressureZero::Reference {
        notes.push(
            "Pressures count from that of the reference state, whose energies are those of the absolute ones.".into(),
        );
    }
    if fit.steepest {
        notes.push(
            "The states would have a so large that gamma falls below 1/3 within the model's range: a is held at its bound and has no \
             error of its own."
                .into(),
        );
    }
    if fit.bounded {
        notes.push(
            "The states would have g_e negative: it is held at its bound (eq 34), its error is its own size.".into(),
        );
    }
    let covolume = gray.parameters().covolume_ratio;
    if covolume < 0.499 {
        notes.push(format!(
            "V_b was lowered from 0.5 V0 to {covolume:.2} V0, for the vapour's pressure to fall with volume at this g_e."
        ));
    }
    notes
}

fn misfit(residuals: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut sum, mut worst, mut n) = (0.0, 0.0f64, 0usize);
    for r in residuals {
        sum += r * r;
        worst = worst.max(r.abs());
        n += 1;
    }
    ((sum / n.max(1) as f64).sqrt(), worst)
}

fn deviation(x: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = x.clone().count() as f64;
    let mean = x.clone().sum::<f64>() / n;
    (x.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0)).sqrt()
}

fn correlations(covariance: &Option<Vec<Vec<f64>>>) -> Vec<Vec<f64>> {
    let Some(c) = covariance else { return Vec::new() };
    (0..c.len()).map(|a| (0..c.len()).map(|b| c[a][b] / (c[a][a] * c[b][b]).sqrt()).collect()).collect()
}
