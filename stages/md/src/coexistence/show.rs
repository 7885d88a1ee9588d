//! How a run with two phases looks: temperature and solid share over time, and the order along the cell.
use super::result::Coexistence;
use crate::local_order::LEAST;
use hvi_kit::view::{Axis, Figure, Series, Style, View};

/// Two figures.
pub fn views(of: &Coexistence) -> Vec<View> {
    let time = |f: fn(&super::result::Look) -> f64| of.looks.iter().map(|l| (l.time * 1e12, f(l))).collect::<Vec<_>>();
    let end = of.looks.last().map_or(0.0, |l| l.time * 1e12);
    let begin = end - of.averaged * 1e12;
    let mean = |label: String, value: f64| Series::new(&label, Style::Line, vec![(begin, value), (end, value)]);
    let note = format!(
        "{} atoms at {:.3} GPa, half crystal and half melt at the start; walls and heat are free. The line is the time averaged over.",
        of.atoms,
        of.pressure / 1e9
    );
    let history = Figure {
        title: "Temperature of crystal and melt together".into(),
        x: Axis::linear("time", "ps"),
        y: Axis::linear("temperature", "K"),
        series: vec![
            Series::new("between two looks", Style::Dots, time(|l| l.temperature)),
            mean(format!("melting temperature {:.0} +- {:.0} K", of.temperature, of.temperature_error), of.temperature),
        ],
        note: note.clone(),
    };
    let share = Figure {
        title: "Solid share".into(),
        x: Axis::linear("time", "ps"),
        y: Axis::linear("share of crystalline atoms", ""),
        series: vec![Series::new("", Style::Line, time(|l| l.solid))],
        note,
    };
    let bins = of.profile.len().max(1) as f64;
    let along = of.profile.iter().enumerate().map(|(k, o)| ((k as f64 + 0.5) / bins, *o)).collect();
    let profile = Figure {
        title: "Order along the cell".into(),
        x: Axis::linear("place along the cell", ""),
        y: Axis::linear("local order", ""),
        series: vec![
            Series::new("at the end", Style::Line, along),
            Series::new("least of a crystal", Style::Dashed, vec![(0.0, LEAST), (1.0, LEAST)]),
        ],
        note: "Order parameter of Morris and Song (2002), 1 in a crystal at rest.".into(),
    };
    [history, share, profile].into_iter().map(View::Figure).collect()
}
