//! What a person sees of an impact run: a row of numbers, the ledger, what melted, energy over time.
use crate::result::{At, Decision, Impact, Ledger, PHASES, Passed, Probe, Snapshot, Track};
use hvi_kit::view::{Axis, Cell, Cloud, Field, Figure, Moment, Scalar, Series, Style, Table, View};

pub mod sketch;

/// The run in one row.
pub fn scalars(impact: &Impact) -> Vec<Scalar> {
    let mut row = vec![Scalar::number("velocity", impact.velocity / 1e3, "km/s")];
    if impact.diameter.is_finite() {
        row.push(Scalar::number("D/t", impact.diameter / impact.thickness, ""));
    }
    if let Some(melt) = impact.snapshots.last().and_then(|s| s.melt.first()) {
        row.push(Scalar::number("liquid share of the projectile", melt.liquid, ""));
        row.push(Scalar::number("of it at the contact", melt.contact, ""));
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
        row.push(Scalar::number("unresolved share", end.unresolved / start.kinetic, ""));
        row.push(Scalar::number("viscous heat share", end.viscous / start.kinetic, ""));
    }
    row
}

/// Ledger, melt by body and time, energy over time.
pub fn views(impact: &Impact) -> Vec<View> {
    let mut all = vec![
        View::Table(melt_table(impact)),
        View::Figure(energy_figure(impact)),
        View::Table(ledger_table(impact)),
        View::Table(phase_table(impact)),
    ];
    if !impact.decisions.is_empty() {
        all.push(View::Table(effects_table(impact)));
    }
    all.push(View::Cloud(cloud(impact)));
    all.extend(impact.probes.iter().map(|probe| View::Table(probe_table(probe))));
    all
}

/// The particles of all snapshots in SI units, mirror images not included; in (r, z) y is the radius.
fn cloud(impact: &Impact) -> Cloud {
    let moment = |snapshot: &Snapshot| {
        let p = &snapshot.particles;
        let n = p.mass.len();
        let scalar = |name: &str, values: Vec<f32>| Field { name: name.into(), width: 1, values };
        let bytes = |x: &[u8]| x.iter().map(|&b| f32::from(b)).collect();
        let velocity = (0..n).flat_map(|i| (0..3).map(move |d| p.velocity[d][i])).collect();
        Moment {
            time: snapshot.time,
            points: (0..n).map(|i| std::array::from_fn(|d| p.position[d][i])).collect(),
            fields: vec![
                Field { name: "velocity".into(), width: 3, values: velocity },
                scalar("mass", p.mass.clone()),
                scalar("density", p.density.clone()),
                scalar("pressure", p.pressure.clone()),
                scalar("temperature", p.temperature.clone()),
                scalar("energy", p.energy.clone()),
                scalar("liquid", p.liquid.clone()),
                scalar("phase", bytes(&p.phase)),
                scalar("body", bytes(&p.body)),
                scalar("failed", bytes(&p.failed)),
            ],
        }
    };
    Cloud { title: "Particles".into(), moments: impact.snapshots.iter().map(moment).collect() }
}

/// The decisions made before the run, and what the run had to say to them.
pub fn effects_table(impact: &Impact) -> Table {
    let mut rows: Vec<Vec<Cell>> = impact.decisions.iter().map(decision).collect();
    rows.extend(impact.crossings.iter().map(|c| {
        vec![
            c.effect.name().into(),
            "turned on".into(),
            c.what.as_str().into(),
            known(c.number),
            c.threshold.into(),
            "".into(),
            format!("seen in the run at {:.4} us, which began again", c.time * 1e6).into(),
        ]
    }));
    Table { title: "Effects".into(), columns: decision_columns(), rows, note: String::new() }
}

/// Columns of a table of decisions.
pub fn decision_columns() -> Vec<(String, String)> {
    ["effect", "choice", "what decided", "number", "threshold", "unit", "source"].map(|name| column(name, "")).to_vec()
}

/// A decision as a row.
pub fn decision(d: &Decision) -> Vec<Cell> {
    vec![
        d.effect.as_str().into(),
        d.choice.as_str().into(),
        d.what.as_str().into(),
        known(d.number),
        known(d.threshold),
        d.unit.as_str().into(),
        d.source.as_str().into(),
    ]
}

/// What a probe has shown.
fn probe_table(probe: &Probe) -> Table {
    let matter = [
        ("time", "us"),
        ("x", "mm"),
        ("y", "mm"),
        ("z", "mm"),
        ("vx", "m/s"),
        ("vy", "m/s"),
        ("vz", "m/s"),
        ("density", "kg/m3"),
        ("pressure", "GPa"),
        ("temperature", "K"),
        ("energy", "kJ/kg"),
        ("plastic strain", ""),
        ("failed", ""),
    ];
    let of = |a: &At| {
        let [x, y, z] = a.position.map(|x| x * 1e3);
        let [u, v, w] = a.velocity;
        let rest = [a.density, a.pressure / 1e9, a.temperature, a.energy / 1e3, a.plastic_strain, a.failed];
        [&[a.time * 1e6, x, y, z, u, v, w][..], &rest].concat()
    };
    let amounts =
        [("time", "us"), ("mass", "kg"), ("momentum", "kg m/s"), ("kinetic energy", "J"), ("internal energy", "J")];
    let passed = |p: &Passed| vec![p.time * 1e6, p.mass, p.momentum, p.kinetic, p.internal];
    let (kind, columns, rows): (_, &[(&str, &str)], Vec<Vec<f64>>) = match &probe.track {
        Track::Point(all) => {
            ("the matter within a cell of the place, NaN as nothing", &matter, all.iter().map(of).collect())
        }
        Track::Particle(all) => {
            ("the particle that was nearest to the place at the start", &matter, all.iter().map(of).collect())
        }
        Track::Plane(all) => {
            ("what has passed the plane along x, less what came back", &amounts, all.iter().map(passed).collect())
        }
    };
    let [x, y, z] = probe.place.map(|x| x * 1e3);
    Table {
        title: format!("Probe {}", probe.name),
        columns: columns.iter().map(|(name, unit)| column(name, unit)).collect(),
        rows: rows.into_iter().map(|row| row.into_iter().map(known).collect()).collect(),
        note: format!("Place ({x}, {y}, {z}) mm: {kind}."),
    }
}

fn known(x: f64) -> Cell {
    if x.is_finite() { Cell::Number(x) } else { Cell::Empty }
}

/// Internal energy by body, material and phase.
fn phase_table(impact: &Impact) -> Table {
    let mut columns = vec![column("time", "us"), column("body", ""), column("material", "")];
    columns.extend(PHASES.iter().map(|phase| column(phase, "J")));
    let mut rows = Vec::new();
    for entry in every_tenth(&impact.ledger) {
        for (body, by_phase) in impact.bodies.iter().zip(&entry.by_phase) {
            let mut row: Vec<Cell> =
                vec![(entry.time * 1e6).into(), body.name.as_str().into(), body.material.as_str().into()];
            row.extend(by_phase.iter().map(|&x| known(x)));
            rows.push(row);
        }
    }
    let note = "Phases at the volume of the intact matter. The columns of a body add up to its internal energy.";
    Table { title: "Internal energy by material and phase".into(), columns, rows, note: note.into() }
}

/// Every tenth entry, and the last.
fn every_tenth(ledger: &[Ledger]) -> impl Iterator<Item = &Ledger> {
    let last = ledger.len().saturating_sub(1);
    ledger.iter().enumerate().filter(move |(i, _)| i % 10 == 0 || *i == last).map(|(_, l)| l)
}

fn column(name: &str, unit: &str) -> (String, String) {
    (name.into(), unit.into())
}

/// Phases of each body at each snapshot, as shares of the projectile's mass.
fn melt_table(impact: &Impact) -> Table {
    let mut columns =
        vec![column("time", "us"), column("body", ""), column("liquid", ""), column("of it at the contact", "")];
    columns.extend(PHASES.iter().map(|phase| column(phase, "")));
    columns.extend(PHASES[1..].iter().map(|phase| column(&format!("{phase}, own volume"), "")));
    let mut rows = Vec::new();
    for snapshot in &impact.snapshots {
        for (body, melt) in impact.bodies.iter().zip(&snapshot.melt) {
            let mut row: Vec<Cell> =
                vec![(snapshot.time * 1e6).into(), body.name.as_str().into(), melt.liquid.into(), melt.contact.into()];
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
        column("unresolved", "J"),
        column("floored", "J"),
        column("flying alone", "J"),
        column("drift", ""),
        column("highest pressure", "GPa"),
        column("highest compression", ""),
        column("time step", "ns"),
    ];
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
            l.unresolved,
            l.floored,
            l.flying,
            l.drift,
            l.highest_pressure / 1e9,
            l.highest_compression,
            l.time_step * 1e9,
        ];
        numbers.into_iter().map(known).collect()
    };
    Table {
        title: "Ledger".into(),
        columns,
        rows: every_tenth(&impact.ledger).map(row).collect(),
        note: "Whole scene, mirror images included. The drift is that of kinetic + unresolved + internal - floored. Nothing leaves a grid \
               without borders: \"flying alone\" is the energy of particles that share no node with any other, part of kinetic and \
               internal."
            .into(),
    }
}

fn energy_figure(impact: &Impact) -> Figure {
    let series = |label: &str, style, value: &dyn Fn(&Ledger) -> f64| {
        Series::new(label, style, impact.ledger.iter().map(|l| (l.time * 1e6, value(l))).collect())
    };
    let mut all = vec![
        series("kinetic", Style::Line, &|l| l.kinetic),
        series("kinetic + unresolved + internal", Style::Line, &|l| {
            l.kinetic + l.unresolved + l.internal.iter().sum::<f64>()
        }),
    ];
    for (b, body) in impact.bodies.iter().enumerate() {
        all.push(series(&format!("internal, {}", body.name), Style::Line, &|l| l.internal[b]));
    }
    all.push(series("of it viscous", Style::Dashed, &|l| l.viscous));
    if impact.ledger.iter().any(|l| l.unresolved != 0.0) {
        all.push(series("unresolved motion", Style::Dashed, &|l| l.unresolved));
    }
    all.push(series("of it from the transfer", Style::Dashed, &|l| l.transfer));
    Figure {
        title: "Energy".into(),
        x: Axis::linear("time", "us"),
        y: Axis::linear("energy", "J"),
        series: all,
        note: String::new(),
    }
}
