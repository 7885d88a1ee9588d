//! Tables and figures of the melted fraction: Table 4 and Figs 14 to 17 of the paper.
use crate::eta::{EtaLaw, Full, Score, Zeros};
use crate::law::TABLE_4;
use crate::point::Point;
use hvi_impact::result::PHASES;
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table, View};

/// Everything there is to see.
pub fn views(r: &EtaLaw) -> Vec<View> {
    let mut views = vec![
        View::Table(parameters(r)),
        View::Figure(comparison(r, &r.points, "Melted fraction: eq 35 and the runs it was fitted to", 0)),
    ];
    if !r.check.is_empty() {
        views.push(View::Figure(comparison(r, &r.check, "Melted fraction: eq 35 and runs it was not fitted to", 1)));
    }
    views.push(View::Figure(phases(r, "projectile", |p| p.projectile)));
    views.push(View::Figure(phases(r, "plate", |p| p.plate)));
    views.push(View::Table(runs(r, &r.points, "Runs fitted")));
    if !r.check.is_empty() {
        views.push(View::Table(runs(r, &r.check, "Runs checked")));
    }
    views
}

fn parameters(r: &EtaLaw) -> Table {
    let columns =
        [("parameter", ""), ("unit", ""), ("fitted", ""), ("95 % from", ""), ("95 % to", ""), ("paper's Table 4", "")];
    let edge = |k: usize, i: usize| r.range.map_or(Cell::Empty, |e| Cell::Number(e[k].values()[i]));
    let row = |(i, (name, unit)): (usize, (&str, &str))| {
        vec![
            name.into(),
            unit.into(),
            Cell::Uncertain(r.law.values()[i], r.error.values()[i]),
            edge(0, i),
            edge(1, i),
            TABLE_4.values()[i].into(),
        ]
    };
    Table {
        title: "Melted fraction: parameters of eq 35".into(),
        columns: columns.map(|(a, b)| (a.to_string(), b.to_string())).to_vec(),
        rows: [("α", "s²/km²"), ("β", "s/km"), ("γ", "")].into_iter().enumerate().map(row).collect(),
        note: method(r),
    }
}

/// What was fitted to what, and how well.
fn method(r: &EtaLaw) -> String {
    let count = |keep: fn(&Point) -> bool| r.points.iter().filter(|p| keep(p)).count();
    let zeros = match r.zeros {
        Zeros::Keep => "count like any other",
        Zeros::Drop => "are left out",
    };
    let full = match r.full {
        Full::Limit => "count as exact where the law is above them",
        Full::Keep => "count like any other",
        Full::Drop => "are left out",
    };
    let say = |s: &Score| format!("rms {:.3}, worst {:.3} on {} runs", s.rms, s.worst, s.runs);
    let [own, own_check, paper, paper_check] = &r.scores;
    let checked = |s: &Score| if s.runs > 0 { format!("; {} it was not fitted to", say(s)) } else { String::new() };
    format!(
        "η = (α v² + β v)(D/t)^γ, v in km/s, by unweighted least squares (Levenberg-Marquardt). η is the {}. ± is one standard \
         error from the covariance; the 95 % range is from runs drawn with replacement. {} runs with η = 0 {zeros}; {} with η of \
         0.999 or more {full}. The fitted law: {}{}. The paper's law on the same runs: {}{}. {} The paper's values were fitted to \
         other runs, of an unstated resolution: agreement is not to be expected.",
        r.measure.describe(),
        count(|p| p.eta == 0.0),
        count(Point::is_full),
        say(own),
        checked(own_check),
        say(paper),
        checked(paper_check),
        resolution(&r.points),
    )
}

/// At which resolution the fractions are meant.
fn resolution(points: &[Point]) -> String {
    let (low, high) = points.iter().fold((f64::MAX, 0f64), |(a, b), p| (a.min(p.cells), b.max(p.cells)));
    let cells = if high - low < 0.05 { format!("{low:.1}") } else { format!("{low:.1} to {high:.1}") };
    format!(
        "η depends on the grid, because the few cells at the contact are overheated: it is meant here at N = {cells} cells \
         through the thinner of plate and projectile."
    )
}

fn runs(r: &EtaLaw, points: &[Point], title: &str) -> Table {
    let mut columns: Vec<(String, String)> =
        [("v", "km/s"), ("D", "mm"), ("t", "mm"), ("D/t", ""), ("N", "cells"), ("time", "µs")]
            .map(|(name, unit)| (name.to_string(), unit.to_string()))
            .to_vec();
    for body in ["projectile", "plate"] {
        columns.extend(PHASES.iter().map(|phase| (format!("{body}: {phase}"), String::new())));
    }
    columns.extend(["η", "eq 35", "eq 35 − η", "fitted"].map(|name| (name.to_string(), String::new())));
    let row = |p: &Point| {
        let sample = p.sample(r.full == Full::Limit);
        let place = [p.velocity * 1e-3, p.diameter * 1e3, p.thickness * 1e3, sample.ratio, p.cells, p.time * 1e6];
        let law = [p.eta, r.law.at(sample.v, sample.ratio), sample.deviation(&r.law)];
        let numbers = place.iter().chain(&p.projectile).chain(&p.plate).chain(&law);
        let used = if title == "Runs checked" || !p.used { "no" } else { "yes" };
        numbers.map(|&x| Cell::Number(tidy(x))).chain([used.into()]).collect()
    };
    Table {
        title: title.into(),
        columns,
        rows: points.iter().map(row).collect(),
        note: "Masses by phase are shares of the projectile's mass, also the plate's.".into(),
    }
}

/// Without the last digits that unit conversion leaves (1.6000000000000001 mm).
fn tidy(x: f64) -> f64 {
    format!("{x:.10e}").parse().unwrap_or(x)
}

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

fn comparison(r: &EtaLaw, points: &[Point], title: &str, score: usize) -> Figure {
    let mut series = Vec::new();
    let speeds = points.iter().map(|p| p.velocity * 1e-3);
    let (low, high) = speeds.fold((f64::MAX, 0f64), |(a, b), v| (a.min(v), b.max(v)));
    let most = if r.full == Full::Limit { 1.0 } else { f64::INFINITY };
    for family in families(points) {
        let simulated = family.points.iter().map(|p| (p.velocity * 1e-3, p.eta)).collect();
        series.push(Series::new(&family.label, Style::Dots, simulated));
        let curve = (0..=48)
            .map(|k| low + (high - low) * f64::from(k) / 48.0)
            .map(|v| (v, r.law.at(v, family.ratio).min(most)));
        series.push(Series::new("", Style::Line, curve.collect()));
    }
    let thickness = points.first().map_or(0.0, |p| tidy(p.thickness * 1e3));
    let one = points.iter().all(|p| p.thickness == points[0].thickness);
    let plate = if one { format!("Plate {thickness} mm thick. ") } else { String::new() };
    let s = &r.scores[score];
    Figure {
        title: title.into(),
        x: Axis::linear("impact speed v", "km/s"),
        y: Axis::linear("melted fraction η", ""),
        series,
        note: format!(
            "{plate}Dots: simulated; lines: eq 35 with the parameters fitted here{}. rms {:.3}, worst {:.3}. {}",
            if most.is_finite() { ", drawn up to 1" } else { "" },
            s.rms,
            s.worst,
            resolution(points)
        ),
    }
}

fn phases(r: &EtaLaw, body: &str, of: fn(&Point) -> [f64; 5]) -> Figure {
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
