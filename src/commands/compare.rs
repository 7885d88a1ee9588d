//! `compare`: a step's points side by side: what the sweep sets, and the numbers that sum the results up.
use super::{Done, Stop, StudyArgs, columns};
use crate::console::{say, warn};
use crate::history::Last;
use crate::{figure, forecast, outputs, reference};
use hvi_kit::view::{Cell, Table};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// What `compare` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Which results: STEP, or 'STEP[key=value, ...]'
    #[arg(value_name = "STEP[POINT]")]
    of: String,
    /// As CSV, to a file or, without one, to standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    csv: Option<Option<PathBuf>>,
}

/// Shows the table.
///
/// # Errors
/// [`Stop`] where the pipeline or the reference is wrong, or none of the results is in the store.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let nodes = reference::nodes(&plan, &args.of)?;
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    let report = forecast::report(&forecasts);
    let mut unreadable = Vec::new();
    let points: Vec<_> = nodes.iter().map(|&id| outputs::point(&plan, &report, &store, id, &mut unreadable)).collect();
    unreadable.iter().for_each(|text| warn(format_args!("{text}")));
    let step = &plan.steps[plan.nodes[nodes[0]].step].name;
    let Some(table) = outputs::compare(step, &points) else {
        let run = format!("hvi-flow run {} --only {step}", pipeline.path.display());
        return Err(Stop::Machine(format!("no result of `{}` is in the store: {run}", args.of)));
    };
    match &args.csv {
        None => say(format_args!("{}", text(&table))),
        Some(None) => {
            // A closed pipe is no failure.
            let _ = std::io::stdout().write_all(figure::csv(&table).as_bytes());
        }
        Some(Some(path)) => std::fs::write(path, figure::csv(&table))
            .map_err(|e| Stop::Machine(format!("can't write {}: {e}", path.display())))?,
    }
    let missing = nodes.iter().filter(|&&id| forecasts[id].entry().is_none()).count();
    if missing > 0 {
        warn(format_args!("{missing} of {} results are not in the store", nodes.len()));
    }
    Ok(ExitCode::SUCCESS)
}

/// A table in aligned columns.
fn text(table: &Table) -> String {
    let head =
        |(name, unit): &(String, String)| if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") };
    let mut rows = vec![table.columns.iter().map(head).collect::<Vec<_>>()];
    rows.extend(table.rows.iter().map(|row| row.iter().map(cell).collect()));
    columns(&rows)
}

/// A cell as people read it.
pub fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Number(x) => number(*x),
        Cell::Uncertain(x, error) => format!("{} +- {}", number(*x), number(*error)),
        Cell::Text(text) => text.clone(),
        Cell::Empty => String::new(),
    }
}

/// Six digits, without needless zeros.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}
