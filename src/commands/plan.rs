//! `plan`: what `run` would compute, and why; computes nothing.
use super::{Done, StudyArgs};
use crate::console::{duration, say, warn};
use crate::forecast::{self, Fate, Forecast};
use crate::history::Last;
use crate::pipeline::Pipeline;
use crate::plan::Plan;
use serde_json::json;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// What `plan` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Only these steps and what they need
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
    /// One JSON object on standard output: totals, and every node with its state and the fields that changed
    #[arg(long)]
    json: bool,
}

/// Shows what would run.
///
/// # Errors
/// [`super::Stop`] where the pipeline is wrong, or the store can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&args.only)?;
    pipeline.remarks.iter().for_each(|text| warn(format_args!("{text}")));
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    if args.json {
        let nodes: Vec<_> = forecasts.iter().enumerate().map(|(id, f)| forecast::json(&plan, id, f)).collect();
        let totals = Totals::of(&plan, &forecasts);
        let whole = json!({
            "study": pipeline.name,
            "known": totals.known, "run": totals.run, "unknown": totals.unknown, "cost_s": totals.cost,
            "nodes": nodes,
        });
        say(format_args!("{whole}"));
    } else {
        show(&pipeline, &plan, &forecasts);
    }
    Ok(ExitCode::SUCCESS)
}

struct Totals {
    known: usize,
    run: usize,
    unknown: usize,
    /// Predicted core-seconds of what isn't known.
    cost: f64,
}
impl Totals {
    fn of(plan: &Plan, forecasts: &[Forecast]) -> Totals {
        let mut totals = Totals { known: 0, run: 0, unknown: 0, cost: 0.0 };
        for (forecast, node) in forecasts.iter().zip(&plan.nodes) {
            let (count, cost) = match forecast.fate {
                Fate::Known(_) => (&mut totals.known, 0.0),
                Fate::Run(_) => (&mut totals.run, node.cost),
                Fate::Unknown(_) => (&mut totals.unknown, node.cost),
            };
            *count += 1;
            totals.cost += cost;
        }
        totals
    }
}

fn show(pipeline: &Pipeline, plan: &Plan, forecasts: &[Forecast]) {
    let totals = Totals::of(plan, forecasts);
    say(format_args!(
        "{}: {} results: {} known, {} to run, {} unknown until then; about {} of one core",
        pipeline.name,
        plan.nodes.len(),
        totals.known,
        totals.run,
        totals.unknown,
        duration(totals.cost.max(0.0)),
    ));
    for step in &plan.steps {
        let mut groups: BTreeMap<String, usize> = BTreeMap::new();
        for id in step.nodes.clone() {
            *groups.entry(forecast::line(plan, id, &forecasts[id])).or_default() += 1;
        }
        for (text, n) in groups {
            say(format_args!("  {:16} {:14} {n:5}  {text}", step.name, step.stage.name));
        }
    }
}
