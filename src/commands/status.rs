//! `status`: what of a study is in the store, what is being computed, what the last runs did, and what failed.
use super::{Done, StudyArgs, columns};
use crate::console::{duration, say, warn};
use crate::forecast::{self, Fate, Forecast};
use crate::history::{self, Came, Last, Run};
use crate::plan::Plan;
use hvi_kit::Store;
use std::process::ExitCode;

/// What `status` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
}

/// Runs that are listed.
const RUNS: usize = 5;

/// Shows the state of a study.
///
/// # Errors
/// [`super::Stop`] where the pipeline is wrong, or the store can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    say(format_args!("{}, store {}", pipeline.path.display(), store.folder().display()));
    steps(&plan, &store, &forecasts);
    at_work(&plan, &store, &forecasts);
    let runs: Vec<Run> = history::runs(&store, &pipeline.name).take(RUNS).collect();
    past(&runs);
    Ok(ExitCode::SUCCESS)
}

fn steps(plan: &Plan, store: &Store, forecasts: &[Forecast]) {
    let head = ["step", "stage", "points", "in the store", "to run", "unknown", "begun", "computing took"];
    let mut rows = vec![head.map(str::to_string).to_vec()];
    for step in &plan.steps {
        let own = &forecasts[step.nodes.clone()];
        let count = |is: fn(&Fate) -> bool| own.iter().filter(|f| is(&f.fate)).count().to_string();
        let begun = own.iter().filter(|f| f.entry().is_none()).filter_map(|f| store.partial(f.key?)).count();
        let took: f64 = own.iter().filter_map(|f| Some(f64::from(f.entry()?.wall_s))).sum();
        rows.push(vec![
            step.name.clone(),
            step.stage.name.into(),
            own.len().to_string(),
            count(|f| matches!(f, Fate::Known(_))),
            count(|f| matches!(f, Fate::Run(_))),
            count(|f| matches!(f, Fate::Unknown(_))),
            begun.to_string(),
            duration(took),
        ]);
    }
    columns(&rows).lines().for_each(|line| say(format_args!("  {line}")));
}

/// What other processes compute on this store just now.
fn at_work(plan: &Plan, store: &Store, forecasts: &[Forecast]) {
    let claimed = store.claimed();
    if claimed.is_empty() {
        return say(format_args!("nothing is being computed on this store"));
    }
    let own = |key| forecasts.iter().position(|f| f.key == Some(key)).map(|id| plan.label(id));
    let (own, others): (Vec<_>, Vec<_>) = claimed.into_iter().map(own).partition(Option::is_some);
    own.into_iter().flatten().for_each(|label| say(format_args!("at work: {label}")));
    if !others.is_empty() {
        say(format_args!("at work for other pipelines: {}", others.len()));
    }
}

fn past(runs: &[Run]) {
    let Some(last) = runs.first() else { return say(format_args!("no run is on record")) };
    say(format_args!("last runs:"));
    for (back, run) in runs.iter().enumerate() {
        let counted = [(Came::Failed, "failed"), (Came::Skipped, "skipped"), (Came::Cancelled, "stopped")];
        let rest = counted.map(|(came, word)| (run.count(came), word));
        let rest: String = rest.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!(", {n} {word}")).collect();
        say(format_args!(
            "  ~{back}  {}  {} from the store, {} computed{rest} in {}: {}",
            history::time(run.began),
            run.count(Came::Hit),
            run.count(Came::Ran),
            duration(run.seconds),
            run.command.get(1..).unwrap_or_default().join(" ")
        ));
    }
    for node in last.nodes.iter().filter(|n| n.came == Came::Failed) {
        say(format_args!("failed: {}: {}", node.label, node.why));
    }
}
