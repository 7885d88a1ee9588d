//! Tables and figures of an equation of state; `curves.rs` of its curves, `overheating.rs` of the states beside melting,
//! `surface.rs` Fig 4.
pub(crate) mod curves;
mod overheating;
mod surface;
use crate::definition::Definition;
use crate::fit::{FitReport, Residual};
use crate::handbook::{COPPER_MOLAR_MASS, Set};
use crate::model::gray::{Gray, Parameters};
use crate::{Eos, EosResult, Patches};
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table, Text, View};

/// Everything to look at.
pub(crate) fn views(result: &EosResult) -> Vec<View> {
    let mut views = Vec::new();
    if let Eos::Gray(gray) = &result.eos {
        views.push(View::Table(parameters(gray, result)));
    }
    if let Some(fit) = &result.fit {
        views.push(View::Table(quality(fit)));
        views.push(View::Table(correlations(fit)));
        views.push(View::Table(worst(fit)));
        views.push(View::Table(implied(fit, is_copper(&result.eos))));
        if !fit.melting.is_empty() {
            views.push(View::Table(melting_points(fit, &result.eos)));
        }
        views.push(View::Figure(isotherms(fit)));
        views.push(View::Figure(misfit(fit)));
        views.extend(pulls(fit).map(View::Figure));
    }
    views.push(View::Figure(compression(&result.eos)));
    if let Eos::Gray(gray) = &result.eos {
        if let Some(fit) = &result.fit {
            views.push(View::Figure(overheating::figure(fit, gray)));
        }
        views.push(View::Figure(melting(gray, result)));
    }
    if let Eos::Patches(patches) = &result.eos {
        views.push(View::Table(errors(patches)));
    }
    views.extend(file(result).map(View::Text));
    views
}

/// What `hvi-flow eos` reads; `None` for a table of states.
fn file(result: &EosResult) -> Option<Text> {
    let text = toml::to_string(&Definition::describe(result)?).ok()?;
    Some(Text { title: "equation of state".into(), extension: "toml".into(), text })
}

/// How far the patches are from the formulas.
fn errors(patches: &Patches) -> Table {
    let (e, (count, bytes)) = (patches.errors(), patches.size());
    let row = |what: &str, of: &str, x: f64| -> Vec<Cell> { vec![what.into(), of.into(), x.into()] };
    Table {
        title: "Errors of the patches".into(),
        columns: ["error", "relative to", "largest"].map(|c| (c.to_string(), String::new())).into(),
        rows: vec![
            row("pressure", "the larger of |P| and rho0 C^2/100", e.pressure),
            row("temperature", "the larger of T and T0", e.temperature),
            row("sound speed", "the larger of c and C/4", e.sound_speed),
            row("share of liquid", "1", e.liquid),
            row("energies at the borders of phases", "the solid's from T = 0 to melting", e.border),
        ],
        note: format!(
            "{count} patches, {:.2} MB, built to {:e}: each the largest found between the nodes of every patch.",
            bytes as f64 / 1e6,
            patches.accuracy()
        ),
    }
}

/// Pulls of the states over V/V0; `None` where the states have no errors.
fn pulls(fit: &FitReport) -> Option<Figure> {
    let of = |solid: bool, k: usize| -> Vec<(f64, f64)> {
        let shown = fit.residuals.iter().filter(|r| r.solid == solid);
        shown.filter_map(|r| Some((r.ratio, r.pulls()[k]?))).collect()
    };
    let all: Vec<f64> = fit.residuals.iter().filter(|r| r.solid).filter_map(|r| r.pulls()[0]).collect();
    let within = |n: f64| all.iter().filter(|p| p.abs() <= n).count();
    let series = vec![
        Series::new("pressure, solid (fitted)", Style::Dots, of(true, 0)),
        Series::new("pressure, liquid (predicted)", Style::Circles, of(false, 0)),
        Series::new("temperature", Style::Crosses, [of(true, 1), of(false, 1)].concat()),
    ];
    (!all.is_empty()).then(|| Figure {
        title: "Pulls of the states".into(),
        x: Axis::linear("V/V0", ""),
        y: Axis::linear("state minus fit, in standard errors of the state", ""),
        series,
        note: format!(
            "Of {} pressures of the solid {} lie within one standard error of the state and {} within two; were the model exact, 68 % and \
             95 % would. What is beyond is the model's own misfit, which outweighs the statistics.",
            all.len(),
            within(1.0),
            within(2.0)
        ),
    })
}

/// The seven parameters in the paper's units and order.
fn in_paper_units(p: &Parameters) -> [(&'static str, &'static str, f64); 7] {
    [
        ("V0", "cm3/g", p.volume * 1e3),
        ("C", "cm/us", p.sound_speed * 1e-4),
        ("S", "", p.slope),
        ("gamma0", "", p.gruneisen),
        ("a", "", p.gruneisen_slope),
        ("g_e", "kJ/mol/K2", p.electronic * p.molar_mass * 1e-3),
        ("T_m", "K", p.melting_temperature),
    ]
}

fn is_copper(eos: &Eos) -> bool {
    matches!(eos, Eos::Gray(gray) if (gray.parameters().molar_mass / COPPER_MOLAR_MASS - 1.0).abs() < 1e-3)
}

/// Table 1 of the paper: both of its columns where the metal is copper, then ours.
fn parameters(gray: &Gray, result: &EosResult) -> Table {
    let p = gray.parameters();
    let copper = is_copper(&result.eos);
    let (royce, paper) = (Set::CopperRoyce.parameters(), Set::CopperPaperMd.parameters());
    let (royce, paper) = (in_paper_units(&royce), in_paper_units(&paper));
    let mut columns = vec![("parameter", ""), ("unit", "")];
    if copper {
        columns.extend([("paper, experiment", ""), ("paper, molecular dynamics", "")]);
    }
    columns.push(("here", ""));
    let row = |(i, (symbol, unit, value)): (usize, &(&str, &str, f64))| {
        let mut cells: Vec<Cell> = vec![(*symbol).into(), (*unit).into()];
        if copper {
            cells.extend([royce[i].2.into(), paper[i].2.into()]);
        }
        cells.push(match &result.fit {
            Some(fit) => Cell::Uncertain(*value, fit.parameters[i].quoted_error()),
            None => (*value).into(),
        });
        cells
    };
    let mut note = format!("{}. T_m is the melting temperature at V0, not at zero pressure.", sentence(&result.source));
    if let Some(fit) = &result.fit {
        note += " Errors: the larger of covariance and resampling of whole isochores. ";
        note += &fit.notes.join(" ");
    }
    Table {
        title: "GRAY parameters".into(),
        columns: columns.into_iter().map(|(name, unit)| (name.into(), unit.into())).collect(),
        rows: in_paper_units(p).iter().enumerate().map(row).collect(),
        note,
    }
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn quality(fit: &FitReport) -> Table {
    let (pressure, temperature) = (fit.pressure_misfit(), fit.temperature_misfit());
    let solids = fit.residuals.iter().filter(|r| r.solid).count();
    let row = |name: &str, unit: &str, n: usize, (rms, largest): (f64, f64), scale: f64| -> Vec<Cell> {
        vec![name.into(), unit.into(), (n as f64).into(), (rms * scale).into(), (largest * scale).into()]
    };
    Table {
        title: "Quality of the fit".into(),
        columns: ["residual", "unit", "states", "rms", "largest"].map(|c| (c.to_string(), String::new())).into(),
        rows: vec![
            row("pressure of the solid", "GPa", solids, pressure, 1e-9),
            row("temperature of all states", "K", fit.residuals.len(), temperature, 1.0),
        ],
        note: format!(
            "Condition number of the pressure fit, columns scaled: {:.1}. Resamplings fitted: {}.",
            fit.condition, fit.resamplings
        ),
    }
}

fn correlations(fit: &FitReport) -> Table {
    let names = ["C", "S", "gamma0", "a"];
    let row = |(i, row): (usize, &Vec<f64>)| {
        std::iter::once(names[i].into()).chain(row.iter().map(|&c| c.into())).collect::<Vec<Cell>>()
    };
    Table {
        title: "Correlations of the pressure parameters".into(),
        columns: ["", "C", "S", "gamma0", "a"].map(|c| (c.to_string(), String::new())).into(),
        rows: fit.pressure_correlations.iter().enumerate().map(row).collect(),
        note: format!("Of the logarithms. T_m with g_e, in the temperature fit: {:.2}.", fit.temperature_correlation),
    }
}

/// What copper does, landmark by landmark: measured with its error, and by the potential of Mishin et al. at equilibrium.
///
/// Melting at P = 0: ITS-90, and the coexistence temperature of the potential EAM1 of Y. Mishin et al., Phys. Rev. B 63,
/// 224106 (2001). Heat of fusion: NIST-JANAF. Hugoniot: X-ray absorption, arXiv:2503.01939.
fn copper_reference(landmark: &str) -> (Cell, Cell) {
    let measured = match landmark {
        "melting at P = 0 begins" | "melting at P = 0 ends" => Cell::Number(1358.0),
        "latent heat at P = 0" => Cell::Number(13.26),
        "Hugoniot enters melting" => Cell::Uncertain(237.0, 40.0),
        "Hugoniot leaves melting" => Cell::Uncertain(261.0, 27.0),
        _ => Cell::Empty,
    };
    let potential = if landmark.starts_with("melting at P = 0") { Cell::Number(1327.0) } else { Cell::Empty };
    (measured, potential)
}

/// What the fitted model says of melting; beside copper, what copper does.
fn implied(fit: &FitReport, copper: bool) -> Table {
    let row = |m: &crate::landmarks::Landmark| -> Vec<Cell> {
        let mut cells = vec![m.name.as_str().into(), m.unit.as_str().into(), m.value.map_or(Cell::Empty, Cell::Number)];
        if copper {
            let (measured, potential) = copper_reference(&m.name);
            cells.extend([measured, potential]);
        }
        cells
    };
    let mut columns = vec!["", "unit", "here"];
    let mut note = String::from(if fit.melting.is_empty() {
        "T_m comes mainly from the liquid's energy at a fixed entropy of melting (`melting_entropy`, 1.16 R unless set), so it stands for \
         the latent heat, and need not put melting where the states' own metal melts. Its +- is statistical, at that entropy; the \
         model's own error is what the reference columns show, and is larger."
    } else {
        "T_m and the entropy of melting are fitted to crystal and melt in one cell and to the melt's energy: see the melting points."
    });
    if copper {
        columns.extend(["experiment", "potential of Mishin et al."]);
        note += " Experiment: 1358 K by ITS-90, 13.26 kJ/mol by NIST-JANAF, the Hugoniot by X-ray absorption (arXiv:2503.01939). \
                 Potential: coexistence of crystal and liquid by EAM1 of Y. Mishin et al., Phys. Rev. B 63, 224106 (2001). Royce's \
                 copper: 1323-1335 K, 14.9 kJ/mol, 224-284 GPa, release melting from 136 to 191 GPa, 4.28 to 5.38 km/s.";
    }
    Table {
        title: "Melting by the fitted GRAY".into(),
        columns: columns.into_iter().map(|c| (c.to_string(), String::new())).collect(),
        rows: fit.landmarks.iter().map(row).collect(),
        note,
    }
}

/// The melting points, beside what the model says at their volumes.
fn melting_points(fit: &FitReport, eos: &Eos) -> Table {
    let v0 = eos.reference_volume();
    let row = |(m, model): &(crate::fit::MeltingPoint, f64)| -> Vec<Cell> {
        let known = Cell::Uncertain(m.temperature, m.error);
        vec![(m.pressure / 1e9).into(), (m.solid / v0).into(), (m.liquid / v0).into(), known, (*model).into()]
    };
    let columns = [("pressure", "GPa"), ("V/V0 crystal", ""), ("V/V0 melt", ""), ("two phases", "K"), ("model", "K")];
    let entropy = fit.parameters.iter().find(|p| p.symbol == "Delta S");
    let entropy =
        entropy.map_or_else(String::new, |p| format!(" Delta S {:.2} +- {:.2} R.", p.value, p.quoted_error()));
    Table {
        title: "Melting points".into(),
        columns: columns.map(|(name, unit)| (name.into(), unit.into())).into(),
        rows: fit.melting.iter().map(row).collect(),
        note: format!(
            "Model: mean of where it begins to melt at the crystal's volume and has molten at the melt's. The shape of T_m(V) is \
             Lindemann's law with gamma0 and a of the pressure fit; only its height is fitted.{entropy}"
        ),
    }
}

/// The six states furthest from the model in pressure, and the six in temperature.
fn worst(fit: &FitReport) -> Table {
    let mut rows = Vec::new();
    let mut pick = |measure: fn(&Residual) -> f64, what: &str, all: Vec<&Residual>| {
        let mut sorted = all;
        sorted.sort_by(|a, b| measure(b).total_cmp(&measure(a)));
        for r in sorted.into_iter().take(6) {
            let phase = if r.solid { "solid" } else { "liquid" };
            rows.push(vec![
                what.into(),
                r.ratio.into(),
                r.temperature.into(),
                phase.into(),
                (r.pressure / 1e9).into(),
                (r.model_pressure / 1e9).into(),
                r.model_temperature.into(),
            ]);
        }
    };
    let solid: Vec<_> = fit.residuals.iter().filter(|r| r.solid).collect();
    pick(|r| (r.model_pressure - r.pressure).abs(), "pressure", solid);
    pick(|r| (r.model_temperature - r.temperature).abs(), "temperature", fit.residuals.iter().collect());
    let columns = [
        ("worst in", ""),
        ("V/V0", ""),
        ("T", "K"),
        ("seen", ""),
        ("P", "GPa"),
        ("P of the model", "GPa"),
        ("T of the model", "K"),
    ];
    Table {
        title: "States furthest from the fit".into(),
        columns: columns.map(|(name, unit)| (name.to_string(), unit.to_string())).into(),
        rows,
        note: "The model's P is at the state's (V, T), its T at the state's (V, E).".into(),
    }
}

/// P-V isotherms: states as marks, the model as lines; up to six temperatures.
fn isotherms(fit: &FitReport) -> Figure {
    // Isotherms are named by the nearest 50 K: mean temperatures scatter by a kelvin.
    let mut names: Vec<i64> = fit.residuals.iter().map(isotherm).collect();
    names.sort_unstable();
    names.dedup();
    let every = names.len().div_ceil(6).max(1);
    let mut series = Vec::new();
    for name in names.iter().step_by(every) {
        let mut at: Vec<_> = fit.residuals.iter().filter(|r| isotherm(r) == *name).collect();
        at.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let line = at.iter().map(|r| (r.ratio, r.model_pressure / 1e9)).collect();
        series.push(Series::new(&format!("GRAY {name} K"), Style::Line, line));
        for (solid, label, style) in [(true, "solid", Style::Dots), (false, "liquid", Style::Circles)] {
            let marks: Vec<_> = at.iter().filter(|r| r.solid == solid).map(|r| (r.ratio, r.pressure / 1e9)).collect();
            if !marks.is_empty() {
                series.push(Series::new(&format!("{name} K, {label}"), style, marks));
            }
        }
    }
    Figure {
        title: "Isotherms of the states and of the fit".into(),
        x: Axis::linear("V/V0", ""),
        y: Axis::linear("pressure", "GPa"),
        series,
        note: "The model follows the branch (solid or liquid) each state was seen in.".into(),
    }
}

fn isotherm(r: &Residual) -> i64 {
    (r.temperature / 50.0).round() as i64 * 50
}

fn misfit(fit: &FitReport) -> Figure {
    let points = |solid: bool| {
        fit.residuals
            .iter()
            .filter(|r| r.solid == solid)
            .map(|r| (r.ratio, (r.pressure - r.model_pressure) / 1e9))
            .collect::<Vec<_>>()
    };
    Figure {
        title: "Pressure of the states minus that of the fit".into(),
        x: Axis::linear("V/V0", ""),
        y: Axis::linear("pressure difference", "GPa"),
        series: vec![
            Series::new("solid (fitted)", Style::Dots, points(true)),
            Series::new("liquid (predicted)", Style::Circles, points(false)),
        ],
        note: "Only the solid states' pressures enter the fit.".into(),
    }
}

/// V/V0 from 1 down to where the Hugoniot passes 400 GPa or x = 0.45.
fn compressions() -> impl Iterator<Item = f64> {
    (0..=90).map(|i| 1.0 - 0.005 * f64::from(i))
}

fn compression(eos: &Eos) -> Figure {
    let v0 = eos.reference_volume();
    let t0 = eos.reference_temperature();
    let shown = |points: Vec<(f64, f64)>| points.into_iter().take_while(|p| p.1 <= 400.0).collect::<Vec<_>>();
    let hugoniot = compressions().filter_map(|u| Some((u, eos.hugoniot(u * v0).ok()?.pressure / 1e9))).collect();
    let isotherm = compressions().map(|u| (u, eos.pressure_at(u * v0, t0) / 1e9)).collect();
    Figure {
        title: "Compression curves".into(),
        x: Axis::linear("V/V0", ""),
        y: Axis::linear("pressure", "GPa"),
        series: vec![
            Series::new("Hugoniot", Style::Line, shown(hugoniot)),
            Series::new(&format!("isotherm {t0:.0} K"), Style::Dashed, shown(isotherm)),
        ],
        note: String::new(),
    }
}

/// Melting band and Hugoniot in the pressure-temperature plane.
fn melting(gray: &Gray, result: &EosResult) -> Figure {
    let eos = &result.eos;
    let v0 = eos.reference_volume();
    let border = |k: usize| {
        (0..=120)
            .map(|i| v0 * (1.12 - 0.005 * f64::from(i)))
            .map(|v| (gray.at(v, gray.borders(v)[k]).0.pressure / 1e9, gray.borders(v)[k]))
            .filter(|p| (0.0..=400.0).contains(&p.0))
            .collect::<Vec<_>>()
    };
    let hugoniot = compressions()
        .filter_map(|u| eos.hugoniot(u * v0).ok())
        .map(|s| (s.pressure / 1e9, s.temperature))
        .take_while(|p| p.0 <= 400.0)
        .collect();
    let known = result.fit.as_ref().filter(|f| !f.melting.is_empty()).map(|f| Series {
        label: "crystal and melt in one cell".into(),
        style: Style::Dots,
        points: f.melting.iter().map(|(m, _)| (m.pressure / 1e9, m.temperature)).collect(),
        errors: f.melting.iter().map(|(m, _)| m.error).collect(),
    });
    Figure {
        title: "Melting and Hugoniot".into(),
        x: Axis::linear("pressure", "GPa"),
        y: Axis::linear("temperature", "K"),
        series: vec![
            Series::new("melting begins", Style::Line, border(0)),
            Series::new("melting ends", Style::Dashed, border(1)),
            Series::new("Hugoniot", Style::Line, hugoniot),
        ]
        .into_iter()
        .chain(known)
        .collect(),
        note: "The melting band has a width in GRAY: an isochore melts over a range of temperature.".into(),
    }
}
