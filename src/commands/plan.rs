//! `plan`: what `run` would compute, and why; computes nothing.
use super::{Done, OutArgs, StudyArgs};
use crate::console::{duration, say, warn};
use crate::execute;
use crate::outputs;
use crate::plan::{NodeId, Plan};
use hvi_cache::Found;
use hvi_kit::Store;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// What `plan` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    #[command(flatten)]
    out: OutArgs,
    /// Only these steps and what they need
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
}

/// What `run` would do with a node.
enum Forecast {
    Known,
    Run(String),
    Unknown(String),
}

/// Shows what would run.
///
/// # Errors
/// [`super::Stop`] where the pipeline is wrong, or the store can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&args.only)?;
    let store = args.study.store()?;
    let last = outputs::last_keys(&args.out.folder(&pipeline));
    let forecasts = forecast(&plan, &store, &last);
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    let count = |f: fn(&Forecast) -> bool| forecasts.iter().filter(|x| f(x)).count();
    let cost: f64 =
        forecasts.iter().zip(&plan.nodes).filter(|(f, _)| !matches!(f, Forecast::Known)).map(|(_, n)| n.cost).sum();
    say(format_args!(
        "{}: {} results: {} known, {} to run, {} unknown until then; about {} of one core",
        pipeline.name,
        plan.nodes.len(),
        count(|f| matches!(f, Forecast::Known)),
        count(|f| matches!(f, Forecast::Run(_))),
        count(|f| matches!(f, Forecast::Unknown(_))),
        duration(cost.max(0.0)),
    ));
    for step in &plan.steps {
        let mut groups: BTreeMap<String, usize> = BTreeMap::new();
        for id in step.nodes.clone() {
            let text = match &forecasts[id] {
                Forecast::Known => "known".to_string(),
                Forecast::Run(why) => format!("to run: {why}"),
                Forecast::Unknown(until) => format!("unknown until {until}"),
            };
            *groups.entry(text).or_default() += 1;
        }
        for (text, n) in groups {
            say(format_args!("  {:16} {:14} {n:5}  {text}", step.name, step.stage.name));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Follows the plan through the store without running anything.
fn forecast(plan: &Plan, store: &Store, last: &BTreeMap<String, hvi_kit::Digest>) -> Vec<Forecast> {
    let mut outputs: Vec<Option<hvi_kit::Digest>> = vec![None; plan.nodes.len()];
    let mut all = Vec::with_capacity(plan.nodes.len());
    for id in 0..plan.nodes.len() {
        let forecast = match execute::recipe(plan, id, &|n: NodeId| outputs[n]) {
            None => {
                let missing = plan.needs(id).find(|&n| outputs[n].is_none());
                Forecast::Unknown(missing.map_or_else(String::new, |n| plan.steps[plan.nodes[n].step].name.clone()))
            }
            Some(recipe) => match execute::stored(store, recipe.key(), plan.nodes[id].stage) {
                Found::Whole(entry) => {
                    outputs[id] = Some(entry.output);
                    Forecast::Known
                }
                Found::Damaged(_) => Forecast::Run("its stored result is damaged or gone".into()),
                Found::Nothing => Forecast::Run(reason(&recipe, store, last.get(&plan.label(id)))),
            },
        };
        all.push(forecast);
    }
    all
}

/// Why a node has to run: what differs from its last run, field by field.
fn reason(recipe: &hvi_kit::Recipe, store: &Store, last: Option<&hvi_kit::Digest>) -> String {
    let Some(key) = last else { return "it has no result yet".into() };
    if *key == recipe.key() {
        return "its result is no longer in the store".into();
    }
    let Some(old) = store.recipe(*key) else {
        return "it changed, and the old recipe is no longer in the store".into();
    };
    let short = |text: Option<String>| {
        let text = text.unwrap_or_else(|| "nothing".into());
        if text.len() == 64 && text.chars().all(|c| c.is_ascii_hexdigit()) { text[..12].to_string() } else { text }
    };
    let changes = recipe.changes_since(&old);
    let mut texts: Vec<_> =
        changes.into_iter().map(|c| format!("{}: {} -> {}", c.field, short(c.old), short(c.new))).collect();
    if texts.len() > 4 {
        let more = texts.len() - 4;
        texts.truncate(4);
        texts.push(format!("and {more} more"));
    }
    texts.join("; ")
}
