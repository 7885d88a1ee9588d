//! The states along isochores, with their labels, across the melting curve of the fit.
use crate::fit::{FitReport, Residual};
use crate::model::gray::Gray;
use hvi_kit::view::{Axis, Figure, Series, Style};

/// Isochores drawn at most.
const MOST: usize = 6;

/// Pressure over temperature: crystals to the right of where the fit begins to melt are overheated.
pub(super) fn figure(fit: &FitReport, gray: &Gray) -> Figure {
    let v0 = gray.parameters().volume;
    // states of one isochore differ in volume by rounding only
    let name = |r: &Residual| (r.ratio * 1e4).round() as i64;
    let mut names: Vec<i64> = fit.residuals.iter().map(name).collect();
    names.sort_unstable();
    names.dedup();
    let border = |k: usize| {
        let at = |&n: &i64| {
            let volume = v0 * n as f64 * 1e-4;
            let melts = gray.borders(volume)[k];
            (melts, gray.at(volume, melts).0.pressure / 1e9)
        };
        names.iter().map(at).collect::<Vec<_>>()
    };
    let mut series = vec![
        Series::new("the fit begins to melt", Style::Line, border(0)),
        Series::new("the fit has molten", Style::Dashed, border(1)),
    ];
    for n in names.iter().step_by(names.len().div_ceil(MOST).max(1)) {
        for (solid, label, style) in [(true, "solid", Style::Dots), (false, "liquid", Style::Circles)] {
            let of = fit.residuals.iter().filter(|r| name(r) == *n && r.solid == solid);
            let marks: Vec<_> = of.map(|r| (r.temperature, r.pressure / 1e9)).collect();
            if !marks.is_empty() {
                series.push(Series::new(&format!("{:.3} V0, {label}", *n as f64 * 1e-4), style, marks));
            }
        }
    }
    let overheated = |r: &&Residual| r.solid && r.temperature > gray.borders(v0 * r.ratio)[0];
    let hot: Vec<&Residual> = fit.residuals.iter().filter(overheated).collect();
    let most = hot.iter().map(|r| r.temperature / gray.borders(v0 * r.ratio)[0] - 1.0).fold(0.0, f64::max);
    Figure {
        title: "Isochores and overheating".into(),
        x: Axis::linear("temperature", "K"),
        y: Axis::linear("pressure", "GPa"),
        series,
        note: format!(
            "A perfect crystal that is heated has no surface to melt from: {} of {} solid states are hotter than where the fit begins to \
             melt, by up to {:.0} %.",
            hot.len(),
            fit.residuals.iter().filter(|r| r.solid).count(),
            100.0 * most
        ),
    }
}
