//! Figures and tables of curves.
use super::surface::picture;
use crate::curves::text::phase_name;
use crate::curves::trace::Sample;
use crate::curves::{Curve, Curves, Kind};
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table, View};

/// Everything to look at.
pub(crate) fn views(c: &Curves) -> Vec<View> {
    let mut views = vec![View::Picture(picture(&c.surface, &c.source))];
    let of = |kinds: &[Kind]| -> Vec<&Curve> { c.curves.iter().filter(|x| kinds.contains(&x.kind)).collect() };
    let volume = || Axis::linear("specific volume", "cm3/g");
    let pressure = || Axis::linear("pressure", "GPa");
    let temperature = || Axis::linear("temperature", "K");
    let speed = || Axis::linear("sound speed", "km/s");
    let mut draw = |title: &str, x: Axis, y: Axis, kinds: &[Kind], at: fn(&Sample) -> (f64, f64), note: &str| {
        let series: Vec<Series> = of(kinds).iter().filter(|c| !c.samples.is_empty()).map(|c| line(c, at)).collect();
        if !series.is_empty() {
            views.push(View::Figure(Figure {
                title: title.into(),
                x,
                y,
                series,
                note: format!("{note} {}.", c.source),
            }));
        }
    };
    let pv = |s: &Sample| (s.volume * 1e3, s.pressure / 1e9);
    let pt = |s: &Sample| (s.pressure / 1e9, s.temperature);
    draw(
        "Hugoniot and releases",
        volume(),
        pressure(),
        &[Kind::Hugoniot, Kind::Release],
        pv,
        "Fig 5 of the paper has the Hugoniot.",
    );
    draw("Isotherms", volume(), pressure(), &[Kind::Isotherm], pv, "Fig 6 of the paper has the room-temperature one.");
    draw(
        "Isobars",
        temperature(),
        volume(),
        &[Kind::Isobar],
        |s| (s.temperature, s.volume * 1e3),
        "Melting is the steep part.",
    );
    draw(
        "Adiabatic compression",
        volume(),
        pressure(),
        &[Kind::Isentrope, Kind::Hugoniot],
        pv,
        "Isentropes from V0, and the Hugoniot.",
    );
    draw(
        "Temperature of adiabatic compression",
        pressure(),
        temperature(),
        &[Kind::Isentrope],
        pt,
        "Isentropes from V0.",
    );
    let melting = [Kind::MeltingBegins, Kind::MeltingEnds, Kind::Hugoniot, Kind::Release];
    draw(
        "Melting, Hugoniot and releases",
        pressure(),
        temperature(),
        &melting,
        pt,
        "An isochore melts over a range of temperature.",
    );
    draw(
        "Sound speed",
        pressure(),
        speed(),
        &[Kind::Hugoniot, Kind::Isotherm],
        |s| (s.pressure / 1e9, s.sound_speed.map_or(f64::NAN, |c| c / 1e3)),
        "It drops where melting begins.",
    );
    if c.critical.is_some() || !c.landmarks.is_empty() {
        views.push(View::Table(marks(c)));
    }
    views.extend(c.curves.iter().filter(|c| !c.samples.is_empty()).map(|c| View::Table(table(c))));
    views
}

fn line(c: &Curve, at: fn(&Sample) -> (f64, f64)) -> Series {
    let style = if matches!(c.kind, Kind::Release | Kind::MeltingEnds) { Style::Dashed } else { Style::Line };
    Series::new(&c.name, style, c.samples.iter().map(at).filter(|p| p.1.is_finite()).collect())
}

/// Melting in numbers and the critical point.
fn marks(c: &Curves) -> Table {
    let row = |name: &str, unit: &str, value: Option<f64>| {
        vec![name.into(), unit.into(), value.map_or(Cell::Empty, Cell::Number)]
    };
    let mut rows: Vec<Vec<Cell>> = c.landmarks.iter().map(|l| row(&l.name, &l.unit, l.value)).collect();
    if let Some(k) = &c.critical {
        rows.push(row("critical temperature", "K", Some(k.temperature)));
        rows.push(row("critical pressure", "GPa", Some(k.pressure / 1e9)));
        rows.push(row("critical density", "kg/m3", Some(1.0 / k.volume)));
    }
    Table {
        title: "Melting and critical point".into(),
        columns: ["", "unit", "value"].map(|c| (c.to_string(), String::new())).into(),
        rows,
        note: "GRAY's critical temperature lies well above accepted estimates (about 8000 K for copper): its vapour comes late.".into(),
    }
}

fn table(c: &Curve) -> Table {
    let mut columns = vec![
        ("V", "cm3/g"),
        ("T", "K"),
        ("E", "kJ/kg"),
        ("P", "GPa"),
        ("phase", ""),
        ("liquid fraction", ""),
        ("c", "km/s"),
    ];
    let shocks = c.kind == Kind::Hugoniot;
    if shocks {
        columns.extend([("up", "km/s"), ("Us", "km/s")]);
    }
    let row = |s: &Sample| -> Vec<Cell> {
        let mut cells: Vec<Cell> = vec![
            (s.volume * 1e3).into(),
            s.temperature.into(),
            (s.energy / 1e3).into(),
            (s.pressure / 1e9).into(),
            phase_name(s.phase).into(),
            s.liquid.into(),
            s.sound_speed.map_or(Cell::Empty, |c| Cell::Number(c / 1e3)),
        ];
        if shocks {
            cells.extend(s.velocities.map_or([Cell::Empty, Cell::Empty], |v| v.map(|u| Cell::Number(u / 1e3))));
        }
        cells
    };
    Table {
        title: c.name.clone(),
        columns: columns.into_iter().map(|(a, b)| (a.into(), b.into())).collect(),
        rows: c.samples.iter().map(row).collect(),
        note: String::new(),
    }
}
