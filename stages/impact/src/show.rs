//! What a person sees of an impact run: a row of numbers, the ledger, what melted, energy over time.
use crate::result::{Impact, Ledger, PHASES};
use hvi_kit::view::{Axis, Cell, Figure, Scalar, Series, Style, Table, View};

/// The run in one row.
pub fn scalars(impact: &Impact) -> Vec<Scalar> {
    let mut row = vec![Scalar::number("velocity", impact.velocity / 1e3, "km/s")];
    if impact.diameter.is_finite() {
        row.push(Scalar::number("D/t", impact.diameter / impact.thickness, ""));
    }
    if let Some(melt) = impact.snapshots.last().and_then(|s| s.melt.first()) {
        row.push(Scalar::number("liquid share of the projectile", melt.liquid, ""));
        row.push(Scalar::number("completely melted", melt.by_phase[2..].iter().sum(), ""));
    }
    row.push(Scalar::number("leading 1 %", impact.leading[1], "m/s"));
    if let (Some(end), Some(snapshot)) = (impact.ledger.last(), impact.snapshots.last()) {
        row.push(Scalar::number("energy drift", end.drift, ""));
        row.push(Scalar::number("steps", end.step as f64, ""));
        row.push(Scalar::number("particles", snapshot.particles.mass.len() as f64, ""));
    }
    row.push(Scalar::number("cells through", impact.cells_through, ""));
    if impact.diameter.is_finite() {
        row.push(Scalar::number("cells across the projectile", impact.diameter / impact.cell, ""));
    }
    if let (Some(start), Some(end)) = (impact.ledger.first(), impact.ledger.last()) {
        row.push(Scalar::number("transfer heat share", end.transfer / start.kinetic, ""));
        row.push(Scalar::number("viscous heat share", end.viscous / start.kinetic, ""));
    }
    row
}

/// Ledger, melt by body and time, energy over time.
pub fn views(impact: &Impact) -> Vec<View> {
    vec![View::Table(melt_table(impact)), View::Figure(energy_figure(impact)), View::Table(ledger_table(impact))]
}

fn column(name: &str, unit: &str) -> (String, String) {
    (name.into(), unit.into())
}

/// Phases of each body at each snapshot, as shares of the projectile's mass.
fn melt_table(impact: &Impact) -> Table {
    let mut columns = vec![column("time", "us"), column("body", ""), column("liquid", "")];
    columns.extend(PHASES.iter().map(|phase| column(phase, "")));
    columns.extend(PHASES[1..].iter().map(|phase| column(&format!("{phase}, own volume"), "")));
    let mut rows = Vec::new();
    for snapshot in &impact.snapshots {
        for (body, melt) in impact.bodies.iter().zip(&snapshot.melt) {
            let mut row: Vec<Cell> = vec![(snapshot.time * 1e6).into(), body.name.as_str().into(), melt.liquid.into()];
            row.extend(melt.by_phase.iter().map(|&x| Cell::Number(x)));
            row.extend(melt.by_phase_own_volume[1..].iter().map(|&x| Cell::Number(x)));
            rows.push(row);
        }
    }
    Table { title: "Phases, as shares of the projectile's mass".into(), columns, rows, note: impact.notes.join(" ") }
}

/// Every tenth entry of the ledger, and the last.
fn ledger_table(impact: &Impact) -> Table {
    let columns = vec![
        column("time", "us"),
        column("step", ""),
        column("mass", "kg"),
        column("momentum", "kg m/s"),
        column("kinetic", "J"),
        column("internal", "J"),
        column("of it viscous", "J"),
        column("of it transfer", "J"),
        column("floored", "J"),
        column("drift", ""),
        column("highest pressure", "GPa"),
        column("highest compression", ""),
        column("time step", "ns"),
    ];
    let last = impact.ledger.len().saturating_sub(1);
    let row = |l: &Ledger| {
        let numbers = [
            l.time * 1e6,
            l.step as f64,
            l.mass,
            l.momentum,
            l.kinetic,
            l.internal.iter().sum(),
            l.viscous,
            l.transfer,
            l.floored,
            l.drift,
            l.highest_pressure / 1e9,
            l.highest_compression,
            l.time_step * 1e9,
        ];
        numbers.into_iter().map(|x| if x.is_finite() { Cell::Number(x) } else { Cell::Empty }).collect()
    };
    let kept = impact.ledger.iter().enumerate().filter(|(i, _)| i % 10 == 0 || *i == last);
    Table {
        title: "Ledger".into(),
        columns,
        rows: kept.map(|(_, l)| row(l)).collect(),
        note: "Whole scene, mirror images included. The drift is that of kinetic + internal - floored.".into(),
    }
}

fn energy_figure(impact: &Impact) -> Figure {
    let series = |label: &str, style, value: &dyn Fn(&Ledger) -> f64| {
        Series::new(label, style, impact.ledger.iter().map(|l| (l.time * 1e6, value(l))).collect())
    };
    let mut all = vec![
        series("kinetic", Style::Line, &|l| l.kinetic),
        series("kinetic + internal", Style::Line, &|l| l.kinetic + l.internal.iter().sum::<f64>()),
    ];
    for (b, body) in impact.bodies.iter().enumerate() {
        all.push(series(&format!("internal, {}", body.name), Style::Line, &|l| l.internal[b]));
    }
    all.push(series("of it viscous", Style::Dashed, &|l| l.viscous));
    all.push(series("of it from the transfer", Style::Dashed, &|l| l.transfer));
    Figure {
        title: "Energy".into(),
        x: Axis::linear("time", "us"),
        y: Axis::linear("energy", "J"),
        series: all,
        note: String::new(),
    }
}
