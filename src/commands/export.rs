//! `export`: results as files for people and other programs, with where each comes from (RO-Crate).
use super::{Done, Stop, StudyArgs};
use crate::console::{say, warn};
use crate::forecast::{self, Forecast};
use crate::history::Last;
use crate::mistake::Mistake;
use crate::plan::{NodeId, Plan};
use crate::ro_crate::{self, Action, Part};
use crate::{outputs, reference};
use hvi_cache::Digest;
use hvi_kit::Store;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `export` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Which results: STEP, or 'STEP[key=value, ...]'
    #[arg(value_name = "STEP[POINT]")]
    of: String,
    /// Where they go: a folder that is empty or not there
    #[arg(long, value_name = "FOLDER")]
    to: PathBuf,
}

/// Writes the results' tables, figures and pictures, their recipes, and `ro-crate-metadata.json`.
///
/// # Errors
/// [`Stop`] where the pipeline or the reference is wrong, no result is in the store, or the folder can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let nodes = reference::nodes(&plan, &args.of)?;
    if std::fs::read_dir(&args.to).is_ok_and(|mut entries| entries.next().is_some()) {
        let mistake = Mistake::new(format!("--to {}: there are files in it", args.to.display()));
        return Err(mistake.help("give a folder that is empty or not there").into());
    }
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    let step = &plan.steps[plan.nodes[nodes[0]].step].name;
    let there: Vec<NodeId> = nodes.iter().copied().filter(|&id| forecasts[id].entry().is_some()).collect();
    if there.is_empty() {
        let run = format!("hvi-flow run {} --only {step}", pipeline.path.display());
        return Err(Stop::Machine(format!("no result of `{}` is in the store: {run}", args.of)));
    }
    let cannot = |e: std::io::Error| Stop::Machine(format!("can't write to {}: {e}", args.to.display()));
    let mut unreadable = Vec::new();
    let report = forecast::report(&forecasts);
    let points: Vec<_> = there.iter().map(|&id| outputs::point(&plan, &report, &store, id, &mut unreadable)).collect();
    let exported = outputs::export(&args.to, step, &points).map_err(cannot)?;
    let mut actions = Vec::new();
    for (&id, files) in there.iter().zip(exported.of_points) {
        actions.extend(action(&plan, id, &forecasts[id], &store, &args.to, files).map_err(cannot)?);
    }
    let mut parts = BTreeMap::new();
    for path in exported.shared.iter().chain(actions.iter().flat_map(|a| &a.files)) {
        let bytes = std::fs::read(args.to.join(path)).map_err(cannot)?;
        parts.insert(path.clone(), Part { digest: Digest::of(&bytes), bytes: bytes.len() as u64 });
    }
    let about =
        if pipeline.question.is_empty() { format!("Results of step {step}.") } else { pipeline.question.clone() };
    let name = format!("{}: {step}", pipeline.name);
    let metadata = ro_crate::metadata(&name, &about, &parts, &exported.shared, &actions);
    std::fs::write(args.to.join("ro-crate-metadata.json"), format!("{metadata:#}\n")).map_err(cannot)?;
    unreadable.iter().for_each(|text| warn(format_args!("{text}")));
    if there.len() < nodes.len() {
        warn(format_args!("{} of {} results are not in the store", nodes.len() - there.len(), nodes.len()));
    }
    let results = if there.len() == 1 { "result" } else { "results" };
    say(format_args!("{} {results} in {} files: {}", there.len(), parts.len(), args.to.display()));
    Ok(ExitCode::from(u8::from(!unreadable.is_empty())))
}

/// A node's action, with its recipe written beside the results; nothing where the store has lost one of both.
fn action(
    plan: &Plan,
    id: NodeId,
    forecast: &Forecast,
    store: &Store,
    folder: &Path,
    mut files: Vec<String>,
) -> std::io::Result<Option<Action>> {
    let Some(key) = forecast.key else { return Ok(None) };
    let (Some(recipe), Some(record)) = (store.recipe(key), store.lookup(key)) else { return Ok(None) };
    let path = format!("recipes/{key}.json");
    std::fs::create_dir_all(folder.join("recipes"))?;
    std::fs::write(folder.join(&path), serde_json::to_vec_pretty(&recipe)?)?;
    files.insert(0, path);
    Ok(Some(Action { label: plan.label(id), swept: plan.nodes[id].swept.clone(), key, recipe, record, files }))
}
