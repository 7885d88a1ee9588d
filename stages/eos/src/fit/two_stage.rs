//! The paper's two fits: pressure of the solid by (C, S, gamma0, a), temperature of all states by (Tm0, g_e).
//!
//! Liu, Wang, Zhang (2013), eqs 31-34. The constraints (all parameters positive) hold by fitting logarithms.
use super::least_squares::{Minimum, minimise};
use super::states::{Data, MeltingPoint, Row};
use super::{FitError, Loss, Method, Params, Rule};
use crate::model::gray::{Branch, Gray, Parameters};

/// Both minima and the parameters they make.
pub(super) struct Fit {
    pub gray: Gray,
    /// C, S, gamma0, a.
    pub pressure: Minimum,
    /// Tm0, G0, and Delta S in units of R where melting points are known. Its covariance holds, in the first fit from a scan, the error of the pressure parameters too.
    pub temperature: Minimum,
    /// The constraint g_e > 0 is active: the states would have it negative, and it is held at its bound.
    pub bounded: bool,
    /// The states would have a so large that gamma falls below 1/3: it is held at its bound, which follows gamma0.
    pub steepest: bool,
}

/// Rounds of the two fits: the first needs G0 for the electrons' small pressure, the second needs the cold curve.
const ROUNDS: usize = 3;

/// Lower bound of g_e [J/mol/K2]: a hundredth of the free-electron value.
const LEAST_ELECTRONIC: f64 = 7e-6;

/// Fits `data` from `start`; `scan` looks for Tm0 over its whole range before the search.
pub(super) fn fit(data: &Data, start: &Parameters, rule: Rule, scan: bool) -> Result<Fit, FitError> {
    let solids: Vec<&Row> = data.rows.iter().filter(|r| r.branch == Branch::Solid).collect();
    let mut p = start.clone();
    let rounds = if scan { ROUNDS } else { 1 };
    for round in 1..=rounds {
        // The first round from a scan may start far off: every state is needed to find the way.
        let loss = if scan && round == 1 { Loss::Square } else { rule.loss };
        let (pressure, steepest) = fit_pressure(&solids, &p, loss);
        settled(&pressure, "pressure of the solid states by C, S, gamma0, a")?;
        p = with_pressure(&p, &pressure.parameters);
        let second = if scan && round == 1 {
            scan_melting(data, &p, rule.method)?
        } else {
            [p.melting_temperature, p.electronic]
        };
        let (mut temperature, bounded) = fit_temperature(data, &p, second, Rule { loss, ..rule });
        settled(&temperature, "temperature of all states by Tm0, g_e")?;
        p = with_temperature(&p, &temperature.parameters);
        if round == rounds {
            if scan {
                add_pressure_errors(data, &p, rule, &pressure, &mut temperature);
            }
            let gray = Gray::dense(p).map_err(|e| FitError(e.to_string()))?;
            return Ok(Fit { gray, pressure, temperature, bounded, steepest });
        }
    }
    unreachable!("the last round returns")
}

/// Where the search starts: C from the bulk modulus, S and gamma0 typical of close-packed metals, a = gamma0 - 1/2,
/// free-electron heat; `cohesion` [J/kg] is the energy of the dilute gas.
pub(super) fn start(data: &Data, params: &Params, cohesion: f64) -> Parameters {
    let (v0, c) = (data.volume.0, (data.bulk_modulus * data.volume.0).sqrt());
    let mut p = Parameters::metal(v0, c, 1.4, 2.0, 1.5, 7e-4, 2000.0, data.molar_mass, 1.0);
    p.cohesive_energy = cohesion;
    p.reference_temperature = params.reference_temperature.si();
    p.melting_entropy = params.melting_entropy;
    p
}

/// The first fit. Where it drives a to where gamma falls below 1/3, a is held there, a hair off, and the others fitted; it then has
/// no error of its own.
fn fit_pressure(solids: &[&Row], p: &Parameters, loss: Loss) -> (Minimum, bool) {
    let first = [p.sound_speed, p.slope, p.gruneisen, p.gruneisen_slope];
    let residuals = |x: &[f64]| pressure_residuals(solids, &with_pressure(p, x));
    let cut = soft_bound(loss, residuals(&first));
    let free = |x: &[f64]| softened(residuals(x), cut);
    let found = minimise(&first, solids.len(), free);
    let steepest = |x: &[f64]| with_pressure(p, &[x[0], x[1], x[2], 1.0]).steepest_gruneisen();
    if found.parameters[3] < 0.999 * steepest(&found.parameters) {
        return (found, false);
    }
    let with_bound = |x: &[f64]| [x, &[0.999 * steepest(x)]].concat();
    let held = minimise(&found.parameters[..3], solids.len(), |x| free(&with_bound(x)));
    // a ten-thousandth: small beside any error, and steps of it stay within the bound
    let covariance = held.covariance.as_ref().map(|c| {
        let rows = c.iter().map(|row| [&row[..], &[0.0]].concat());
        rows.chain([vec![0.0, 0.0, 0.0, 1e-8]]).collect::<Vec<_>>()
    });
    (Minimum { parameters: with_bound(&held.parameters), covariance, ..held }, true)
}

/// The second fit. Where it drives g_e to zero (eq 34 active), g_e is held at its bound and Tm0 fitted alone; g_e's error is
/// then its own size.
fn fit_temperature(data: &Data, p: &Parameters, start: [f64; 2], rule: Rule) -> (Minimum, bool) {
    let residuals = |x: &[f64]| temperature_residuals(data, &with_temperature(p, x), rule.method);
    let cut = soft_bound(rule.loss, residuals(&start).map(|r| r[..data.rows.len()].to_vec()));
    let free = |x: &[f64]| softened_states(residuals(x), data, cut);
    let (bound, count) = (LEAST_ELECTRONIC / p.molar_mass, data.rows.len() + data.melting.len());
    let mut start = start.to_vec();
    // where melting is known the liquid's energy tells the entropy
    start.extend((!data.melting.is_empty()).then_some(p.melting_entropy));
    let found = minimise(&start, count, free);
    if found.parameters[1] > bound {
        return (found, false);
    }
    let with_bound = |x: &[f64]| [&x[..1], &[bound], &x[1..]].concat();
    start.remove(1);
    let held = minimise(&start, count, |x| free(&with_bound(x)));
    let full = |c: &Vec<Vec<f64>>| {
        let mut rows: Vec<Vec<f64>> = c.iter().map(|row| [&row[..1], &[0.0], &row[1..]].concat()).collect();
        let mut own = vec![0.0; c.len() + 1];
        own[1] = 1.0;
        rows.insert(1, own);
        rows
    };
    let covariance = held.covariance.as_ref().map(full);
    (Minimum { parameters: with_bound(&held.parameters), covariance, ..held }, true)
}

/// Adds to the covariance of (Tm0, G0) what the errors of (C, S, gamma0, a) do to them through the cold curve: D C D', with
/// D the change of the second fit's logarithms by the first's, from refits one standard error away.
fn add_pressure_errors(data: &Data, p: &Parameters, rule: Rule, pressure: &Minimum, temperature: &mut Minimum) {
    let (Some(first), Some(second)) = (&pressure.covariance, &mut temperature.covariance) else { return };
    let best = temperature.parameters.clone();
    let count = data.rows.len() + data.melting.len();
    let slopes: Vec<Vec<f64>> = (0..4)
        .map(|j| {
            let mut x = pressure.parameters.clone();
            let step = first[j][j].sqrt();
            x[j] *= 1.0 + step;
            let other = with_pressure(p, &x);
            let residuals = |x: &[f64]| temperature_residuals(data, &with_temperature(&other, x), rule.method);
            let cut = soft_bound(rule.loss, residuals(&best).map(|r| r[..data.rows.len()].to_vec()));
            let refit = minimise(&best, count, |x| softened_states(residuals(x), data, cut));
            refit.parameters.iter().zip(&best).map(|(x, best)| (x / best - 1.0) / step).collect()
        })
        .collect();
    let n = best.len();
    for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            second[k][l] += slopes[i][k] * first[i][j] * slopes[j][l];
        }
    }
}

/// The fitted parameters if V0 were one standard error larger: what its error does to the others.
pub(super) fn with_other_volume(data: &Data, best: &Parameters, rule: Rule) -> Option<Parameters> {
    let start = Parameters { volume: data.volume.0 + data.volume.1, ..best.clone() };
    fit(data, &start, rule, false).ok().map(|fit| fit.gray.parameters().clone())
}

fn with_pressure(p: &Parameters, x: &[f64]) -> Parameters {
    Parameters { sound_speed: x[0], slope: x[1], gruneisen: x[2], gruneisen_slope: x[3], ..p.clone() }
}
fn with_temperature(p: &Parameters, x: &[f64]) -> Parameters {
    let melting_entropy = x.get(2).copied().unwrap_or(p.melting_entropy);
    Parameters { melting_temperature: x[0], electronic: x[1], melting_entropy, ..p.clone() }
}

/// P(V, T) of the solid minus the states', over their scales.
fn pressure_residuals(solids: &[&Row], p: &Parameters) -> Option<Vec<f64>> {
    let gray = Gray::dense(p.clone()).ok()?;
    let residual =
        |r: &&Row| (gray.branch_at(r.volume, r.temperature, Branch::Solid).pressure - r.pressure) / r.pressure_scale;
    Some(solids.iter().map(residual).collect())
}

/// T(V, E) minus the states', over their scales; and the melting temperatures minus those of the points, in kelvin, each with the
/// weight of all states together: it knows T_m itself, where states tell of it only by their energy.
fn temperature_residuals(data: &Data, p: &Parameters, method: Method) -> Option<Vec<f64>> {
    let gray = Gray::dense(p.clone()).ok()?;
    let state = |r: &Row| (temperature(&gray, r, method) - r.temperature) / r.temperature_scale;
    let weight = data.rows.iter().map(|r| 1.0 / (r.temperature_scale * r.temperature_scale)).sum::<f64>().sqrt();
    let point = |m: &MeltingPoint| (melting_temperature(&gray, m) - m.temperature) * weight;
    Some(data.rows.iter().map(state).chain(data.melting.iter().map(point)).collect())
}

/// Where the model melts at a point's volumes [K]: the mean of where the crystal's volume begins to and the melt's has.
pub(super) fn melting_temperature(gray: &Gray, point: &MeltingPoint) -> f64 {
    0.5 * (gray.borders(point.solid)[0] + gray.borders(point.liquid)[1])
}

/// Three times the median size of `residuals`, beyond which the soft loss is linear; `None` for plain squares.
fn soft_bound(loss: Loss, residuals: Option<Vec<f64>>) -> Option<f64> {
    if loss == Loss::Square {
        return None;
    }
    let mut sizes: Vec<f64> = residuals?.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map(|m| 3.0 * m).filter(|b| *b > 0.0)
}

/// Residuals whose squares are the soft L1 loss `2 b^2 (sqrt(1 + (r/b)^2) - 1)` of the plain ones.
fn softened(residuals: Option<Vec<f64>>, bound: Option<f64>) -> Option<Vec<f64>> {
    let Some(b) = bound else { return residuals };
    let soft = |r: f64| {
        // (sqrt(1 + z) - 1) without cancellation.
        let z = (r / b) * (r / b);
        let size = b * (2.0 * z / ((1.0 + z).sqrt() + 1.0)).sqrt();
        if r < 0.0 { -size } else { size }
    };
    residuals.map(|all| all.into_iter().map(soft).collect())
}

/// [`softened`] for the residuals of states; those of melting points after them stay.
fn softened_states(residuals: Option<Vec<f64>>, data: &Data, bound: Option<f64>) -> Option<Vec<f64>> {
    let mut states = residuals?;
    let points = states.split_off(data.rows.len());
    let mut all = softened(Some(states), bound)?;
    all.extend(points);
    Some(all)
}

/// The model's temperature at a state's volume and energy.
pub(super) fn temperature(gray: &Gray, row: &Row, method: Method) -> f64 {
    match method {
        Method::Published => gray.point(row.volume, row.energy).temperature,
        Method::Labelled => gray.branch_temperature(row.volume, row.energy, row.branch),
    }
}

/// Tm0 and G0 of the least sum of squares on a coarse grid: from too high a Tm0 nothing is molten, and the search is blind.
fn scan_melting(data: &Data, p: &Parameters, method: Method) -> Result<[f64; 2], FitError> {
    let mut best = (f64::INFINITY, [p.melting_temperature, p.electronic]);
    for step in 0..40 {
        // 500 K to 8000 K.
        let tm = 500.0 * hvi_kit::math::pow(16.0, f64::from(step) / 39.0);
        for share in [0.3, 1.0, 2.0] {
            let x = [tm, share * p.electronic];
            let Some(residuals) = temperature_residuals(data, &with_temperature(p, &x), method) else { continue };
            let sum: f64 = residuals.iter().map(|r| r * r).sum();
            if sum < best.0 {
                best = (sum, x);
            }
        }
    }
    if best.0.is_finite() {
        Ok(best.1)
    } else {
        Err(FitError("no Tm0 between 500 K and 8000 K makes a valid model".into()))
    }
}

/// Refuses a search that did not end, or whose data do not tell its parameters apart.
fn settled(minimum: &Minimum, what: &str) -> Result<(), FitError> {
    if !minimum.converged {
        return Err(FitError(format!("the fit of the {what} did not converge from {:?}", minimum.parameters)));
    }
    if minimum.condition > 1e4 {
        return Err(FitError(format!(
            "the states do not determine the parameters in the fit of the {what}: condition number {:.1e} (1e4 at most) at {:?} \
             (SI)",
            minimum.condition, minimum.parameters
        )));
    }
    Ok(())
}
