//! Tables and error-time figures of a study.
use crate::limit::How;
use crate::{Check, Quantity, Sample, cheapest};
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table, View};

/// Errors that the table of choices is made for.
pub const TARGETS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// Everything to look at: runs, where they lead, what to choose, and a figure a quantity. `along` names what is refined.
pub fn views(along: &str, samples: &[Sample], all: &[Quantity]) -> Vec<View> {
    let mut views = vec![
        View::Table(choices(along, samples, all, 1.0)),
        View::Table(convergence(samples, all)),
        View::Table(runs(along, samples, all)),
    ];
    views.extend(all.iter().filter(|q| !q.front.is_empty()).map(|q| View::Figure(figure(along, samples, q))));
    views
}

/// `cells 6, kernel=quadratic`.
fn label(along: &str, s: &Sample) -> String {
    if s.group.is_empty() { format!("{along} {}", s.setting) } else { format!("{along} {}, {}", s.setting, s.group) }
}

/// For each quantity the cheapest setting within 10, 5, 2 and 1 %, over `margin`.
pub fn choices(along: &str, samples: &[Sample], all: &[Quantity], margin: f64) -> Table {
    let row = |q: &Quantity| -> Vec<Cell> {
        let points = q.points(samples);
        let choice = |target: f64| -> Cell {
            match cheapest(&points, target / margin).filter(|c| c.reached) {
                Some(c) => format!("{} ({})", label(along, &samples[c.index]), seconds(samples[c.index].cost)).into(),
                None => "none of these".into(),
            }
        };
        let knee = q.knee.map_or("".into(), |k| label(along, &samples[k]).into());
        [q.name.into()].into_iter().chain(TARGETS.map(choice)).chain([knee]).collect()
    };
    let within = |t: &f64| (format!("within {} %", 100.0 * t), String::new());
    let columns = [("quantity".into(), String::new())].into_iter().chain(TARGETS.iter().map(within));
    Table {
        title: "What to choose".into(),
        columns: columns.chain([("knee".into(), String::new())]).collect(),
        rows: all.iter().map(row).collect(),
        note: "The cheapest setting whose error is within the target, and its CPU time. Knee: beyond it cost grows faster than the \
               error falls."
            .into(),
    }
}

fn seconds(s: f64) -> String {
    match s {
        _ if s < 0.1 => format!("{:.0} ms", 1e3 * s),
        _ if s < 9.95 => format!("{s:.1} s"),
        _ => format!("{s:.0} s"),
    }
}

/// What came of choices made on the front of the block `made`.
pub fn checked(made: &str, along: &str, checks: &[Check]) -> Table {
    let row = |c: &Check| -> Vec<Cell> {
        vec![
            c.quantity.into(),
            (100.0 * c.target).into(),
            format!("{along} {}", c.setting).into(),
            Cell::Uncertain(100.0 * c.error, 100.0 * c.uncertainty),
            if c.holds() { "yes" } else { "no" }.into(),
            c.predicted.into(),
            c.taken.into(),
        ]
    };
    let columns = [
        ("quantity", ""),
        ("asked", "%"),
        ("chosen", ""),
        ("error here", "%"),
        ("within", ""),
        ("predicted", "s"),
        ("taken", "s"),
    ];
    let held = checks.iter().filter(|c| c.holds()).count();
    let timely = checks.iter().filter(|c| c.factor() <= 1.5).count();
    Table {
        title: "Choices checked".into(),
        columns: columns.map(|(name, unit)| (name.to_string(), unit.to_string())).into(),
        rows: checks.iter().map(row).collect(),
        note: format!(
            "Settings chosen on the front of `{made}`, which these runs are no part of: {held} of {} errors are within what was asked, {timely} \
             of {} times within a factor of 1.5 of what was predicted.",
            checks.len(),
            checks.len()
        ),
    }
}

/// Where each quantity leads, how sure that is, and how fast.
fn convergence(samples: &[Sample], all: &[Quantity]) -> Table {
    let row = |q: &Quantity| -> Vec<Cell> {
        let how = match q.reference.how {
            How::Exact => "closed form",
            How::Extrapolated => "extrapolated",
            How::Finest if q.rows.iter().flatten().any(|r| r.uncertainty > q.blur()) => "longest average",
            How::Finest => "finest run, not converged at one order",
            How::Last => "last run",
        };
        let order = |(group, order): &(String, Option<crate::Order>)| {
            let p = match order {
                Some(o) => o.uncertainty.map_or(format!("{:.1}", o.value), |u| format!("{:.1} +- {u:.1}", o.value)),
                None => "none".into(),
            };
            if group.is_empty() { p } else { format!("{group}: {p}") }
        };
        let orders = q.orders.iter().map(order).collect::<Vec<_>>().join("; ");
        let value = if matches!(q.reference.how, How::Exact | How::Last) {
            Cell::Number(q.reference.value)
        } else {
            Cell::Uncertain(q.reference.value, q.reference.uncertainty)
        };
        let best = q.front.last().and_then(|&i| q.rows[i]);
        let index = match q.reference.how {
            How::Exact | How::Last => Cell::Empty,
            _ => Cell::Number(100.0 * q.blur()),
        };
        vec![
            q.name.into(),
            q.unit.into(),
            value,
            how.into(),
            orders.into(),
            index,
            best.map_or(Cell::Empty, |r| Cell::Number(100.0 * r.error)),
        ]
    };
    let columns = [
        ("quantity", ""),
        ("unit", ""),
        ("leads to", ""),
        ("known by", ""),
        ("observed order", ""),
        ("convergence index", "%"),
        ("least error", "%"),
    ];
    Table {
        title: "Convergence".into(),
        columns: columns.map(|(name, unit)| (name.to_string(), unit.to_string())).into(),
        rows: all.iter().map(row).collect(),
        note: format!(
            "{} runs. Limits by Richardson's extrapolation over all runs of a group, the finer ones weighing more; convergence index: that \
             of the finest run (P. J. Roache, J. Fluids Eng. 116, 405 (1994), factor of safety 1.25), or what leaving out a run changes, if \
             that is more; it is part of every error. What errs by rounding alone is left out.",
            samples.len()
        ),
    }
}

/// Every run: cost, work, values and errors.
fn runs(along: &str, samples: &[Sample], all: &[Quantity]) -> Table {
    let unit = samples.first().map_or("", |s| s.measures.unit);
    let mut columns: Vec<(String, String)> = vec![
        (along.into(), String::new()),
        ("other settings".into(), String::new()),
        ("CPU time".into(), "s".into()),
        ("work".into(), unit.into()),
    ];
    for q in all {
        columns.push((q.name.into(), q.unit.into()));
        columns.push((format!("error of {}", q.name), "%".into()));
    }
    columns.push(("recipe".into(), String::new()));
    let row = |(i, s): (usize, &Sample)| -> Vec<Cell> {
        let mut cells: Vec<Cell> =
            vec![s.setting.as_str().into(), s.group.as_str().into(), s.cost.into(), s.measures.work.into()];
        for q in all {
            match q.rows[i] {
                Some(r) => {
                    cells.extend([Cell::Number(r.value), Cell::Uncertain(100.0 * r.error, 100.0 * r.uncertainty)])
                }
                None => cells.extend([Cell::Empty, Cell::Empty]),
            }
        }
        cells.push(s.short_key().into());
        cells
    };
    Table {
        title: "Runs".into(),
        columns,
        rows: samples.iter().enumerate().map(row).collect(),
        note: "CPU time as it was taken when each result was made; the recipe's key names the result in the store."
            .into(),
    }
}

/// Error over CPU time, the front and its knee marked.
fn figure(along: &str, samples: &[Sample], q: &Quantity) -> Figure {
    let styles = [Style::Dots, Style::Circles, Style::Crosses];
    let point = |i: usize| q.rows[i].filter(|r| r.error > 0.0).map(|r| (samples[i].cost, 100.0 * r.error));
    // The front counts the largest error of a run and the finer ones.
    let points = q.points(samples);
    let worst = |i: usize| Some(points[i]).filter(|p| p.1 > 0.0).map(|(cost, error)| (cost, 100.0 * error));
    let mut series = vec![Series::new("front", Style::Dashed, q.front.iter().filter_map(|&i| worst(i)).collect())];
    for (k, (group, _)) in q.orders.iter().enumerate() {
        let own = (0..samples.len()).filter(|&i| samples[i].group == *group);
        let points: Vec<_> = own.filter_map(point).collect();
        let label = if group.is_empty() { along } else { group };
        series.push(Series::new(label, styles[k % styles.len()], points));
    }
    series.extend(q.knee.and_then(worst).map(|p| Series::new("knee", Style::Triangles, vec![p])));
    let log = |label: &str, unit: &str| Axis { label: label.into(), unit: unit.into(), log: true };
    let blur = match q.reference.how {
        How::Exact => "The reference is the closed form.".to_string(),
        How::Last => "The reference is the last run.".to_string(),
        _ => format!("The reference is known to {:.2} %: errors below that say no more.", 100.0 * q.blur()),
    };
    Figure {
        title: format!("Error of the {} against time", q.name),
        x: log("CPU time", "s"),
        y: log("error", "%"),
        series,
        note: format!(
            "{} runs along `{along}`; the front counts a run's error as the largest of its own and the finer ones': the coarse may be right by \
             chance. {blur}",
            samples.len()
        ),
    }
}
