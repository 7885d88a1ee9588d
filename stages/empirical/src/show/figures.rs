//! Figures: the law and its runs, what two resolutions make of them, and the phases.
use super::words;
use crate::eta::{EtaLaw, Full};
use crate::point::{Point, tidy};
use crate::refined::{Pair, Refined};
use hvi_kit::view::{Axis, Figure, Series, Style};

/// Runs of one diameter and thickness, by speed.
struct Family<'a> {
    label: String,
    ratio: f64,
    points: Vec<&'a Point>,
}

fn families(points: &[Point]) -> Vec<Family<'_>> {
    let mut sizes: Vec<(f64, f64)> = points.iter().map(|p| (p.thickness, p.diameter)).collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    sizes.dedup();
    let several = sizes.iter().any(|s| s.0 != sizes[0].0);
    let family = |&(t, d): &(f64, f64)| {
        let mut own: Vec<&Point> = points.iter().filter(|p| (p.thickness, p.diameter) == (t, d)).collect();
        own.sort_by(|a, b| a.velocity.total_cmp(&b.velocity));
        let plate = if several { format!(", t = {} mm", tidy(t * 1e3)) } else { String::new() };
        Family { label: format!("D = {} mm{plate}", tidy(d * 1e3)), ratio: d / t, points: own }
    };
    sizes.iter().map(family).collect()
}

/// The law and the runs it was fitted to, or else those it was checked on.
pub fn comparison(r: &EtaLaw, fitted: bool) -> Figure {
    let (points, title) = match fitted {
        true => (&r.points, "Melted fraction: eq 35 and the runs it was fitted to"),
        false => (&r.check, "Melted fraction: eq 35 and runs it was not fitted to"),
    };
    let mut series = Vec::new();
    let speeds = points.iter().map(|p| p.velocity * 1e-3);
    let (low, high) = speeds.fold((f64::MAX, 0f64), |(a, b), v| (a.min(v), b.max(v)));
    let most = if r.full == Full::Limit { 1.0 } else { f64::INFINITY };
    for family in families(points) {
        let simulated = family.points.iter().map(|p| (p.velocity * 1e-3, p.eta)).collect();
        series.push(Series::new(&family.label, Style::Dots, simulated));
        let curve = (0..=48)
            .map(|k| low + (high - low) * f64::from(k) / 48.0)
            .map(|v| (v, r.fit.law.at(v, family.ratio).min(most)));
        series.push(Series::new("", Style::Line, curve.collect()));
    }
    let thickness = points.first().map_or(0.0, |p| tidy(p.thickness * 1e3));
    let one = points.iter().all(|p| p.thickness == points[0].thickness);
    let plate = if one { format!("Plate {thickness} mm thick. ") } else { String::new() };
    Figure {
        title: title.into(),
        x: Axis::linear("impact speed v", "km/s"),
        y: Axis::linear("melted fraction η", ""),
        series,
        note: format!(
            "{plate}Dots: simulated; lines: eq 35 with the parameters fitted here{}. Raw deviations: {}. {}",
            if most.is_finite() { ", drawn up to 1" } else { "" },
            words::scores(&r.own),
            words::resolution(&r.points)
        ),
    }
}

/// Both resolutions and the extrapolation.
pub fn resolutions(r: &Refined) -> Figure {
    let fine: Vec<Point> = r.pairs.iter().map(|p| p.fine.clone()).collect();
    let mut series = Vec::new();
    for family in families(&fine) {
        let belongs = |p: &&Pair| family.points.iter().any(|f| **f == p.fine);
        let mut pairs: Vec<&Pair> = r.pairs.iter().filter(belongs).collect();
        pairs.sort_by(|a, b| a.fine.velocity.total_cmp(&b.fine.velocity));
        let against = |of: fn(&Pair) -> f64| pairs.iter().map(|p| (p.fine.velocity * 1e-3, of(p))).collect::<Vec<_>>();
        series.push(Series::new(&family.label, Style::Line, against(Pair::limit)));
        series.push(Series {
            errors: pairs.iter().map(|p| p.uncertainty()).collect(),
            ..Series::new("", Style::Triangles, against(Pair::limit))
        });
        series.push(Series::new("", Style::Dots, against(|p| p.fine.eta)));
        series.push(Series::new("", Style::Circles, against(|p| p.coarse.eta)));
    }
    let coarse: Vec<Point> = r.pairs.iter().map(|p| p.coarse.clone()).collect();
    Figure {
        title: "Melted fraction at two resolutions and extrapolated".into(),
        x: Axis::linear("impact speed v", "km/s"),
        y: Axis::linear("melted fraction η", ""),
        series,
        note: format!(
            "Circles: N = {}; dots: N = {}; triangles, joined: extrapolated to N → ∞. {}",
            words::span(&coarse, |p| p.cells),
            words::span(&fine, |p| p.cells),
            words::extrapolation(r)
        ),
    }
}

/// Molten masses of a body by speed: Figs 16 and 17.
pub fn phases(r: &EtaLaw, body: &str, of: fn(&Point) -> [f64; 5]) -> Figure {
    let mut series = Vec::new();
    for family in families(&r.points) {
        let above = |code: usize| {
            family.points.iter().map(|p| (p.velocity * 1e-3, of(p)[code..].iter().sum())).collect::<Vec<(f64, f64)>>()
        };
        series.push(Series::new(&family.label, Style::Line, above(2)));
        series.push(Series::new("", Style::Dots, above(2)));
        series.push(Series::new("", Style::Dashed, above(3)));
    }
    Figure {
        title: format!("Molten mass of the {body}"),
        x: Axis::linear("impact speed v", "km/s"),
        y: Axis::linear("mass over the projectile's", ""),
        series,
        note: "Solid lines: liquid or hotter; dashed: hot liquid or vapour. The rest of the phases is in the table of runs."
            .into(),
    }
}
