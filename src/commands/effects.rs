//! `effects`: what an impact's scene calls for and what it may leave out, with the numbers that decide.
use super::compare::cell;
use super::{Done, Stop, StudyArgs, columns};
use crate::console::{say, warn};
use crate::forecast::{self, Forecast};
use crate::history::Last;
use crate::plan::{Input, NodeId, Plan};
use hvi_eos::{Eos, EosResult};
use hvi_impact::scene::Layout;
use hvi_impact::{ImpactStage, Params, bodies, effects};
use hvi_kit::{Artifact, File, Stage, Store};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// What `effects` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
}

/// Shows the decisions for every impact of the pipeline.
///
/// # Errors
/// [`Stop`] where the pipeline is wrong or the store can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    let mut count = 0;
    for id in (0..plan.nodes.len()).filter(|&id| plan.nodes[id].stage.name == ImpactStage::NAME) {
        count += 1;
        say(format_args!("{}", scene(&plan, &store, &forecasts, id)?));
    }
    if count == 0 {
        warn(format_args!("{} has no step that uses `{}`", pipeline.path.display(), ImpactStage::NAME));
    }
    Ok(ExitCode::SUCCESS)
}

/// The table of one scene.
fn scene(plan: &Plan, store: &Store, forecasts: &[Forecast], id: NodeId) -> Result<String, Stop> {
    let params = params(plan, id)?;
    let asked = params.is_auto();
    let auto = Params { effects: Some(effects::Choice::Auto), ..params.clone() };
    let mut head = plan.label(id);
    if !asked {
        head += ": as its keys say; effects = \"auto\" would decide";
    }
    let settled = auto.settled();
    let pieces = bodies::pieces(&settled, &Layout::of(&settled));
    let mut eos: Vec<Eos> = Vec::new();
    for piece in &pieces {
        match plan.nodes[id].inputs.get(&format!("{}.eos", piece.key)) {
            Some(Input::One(node)) => match forecasts[*node].entry() {
                Some(entry) => {
                    let found = hvi_kit::load::<EosResult>(store, entry.output);
                    eos.push(found.map_err(|e| Stop::Machine(format!("{}: {e}", plan.label(*node))))?.eos);
                }
                None => return Ok(format!("{head}\n  unknown until `{}` is computed", plan.label(*node))),
            },
            _ => eos.push(piece.material.eos.clone()),
        }
    }
    let decided = effects::plan(&auto, &eos);
    let name = |(name, _): (String, String)| name;
    let mut rows = vec![hvi_impact::decision_columns().into_iter().map(name).collect::<Vec<_>>()];
    rows.extend(decided.decisions.iter().map(|d| hvi_impact::decision(d).iter().map(cell).collect()));
    let costs = [&decided.params, &params.everything_on()].map(ImpactStage::cost);
    Ok(format!(
        "{head}\n{}\nestimated core time: {:.3e} s as decided, {:.3e} s with everything on",
        columns(&rows),
        costs[0],
        costs[1]
    ))
}

/// A node's parameters, with the surfaces of its files.
fn params(plan: &Plan, id: NodeId) -> Result<Params, Stop> {
    let node = &plan.nodes[id];
    let wrong = |why: String| Stop::Machine(format!("{}: {why}", plan.label(id)));
    let params = Params::deserialize(&node.params).map_err(|e| wrong(e.to_string()))?;
    let file = |(key, input): (&String, &Input)| match input {
        Input::File(digest) => File::decode(plan.files.get(digest)?).ok().map(|file| (key.clone(), file)),
        Input::One(_) | Input::Many(_) => None,
    };
    let files: BTreeMap<String, File> = node.inputs.iter().filter_map(file).collect();
    params.with_meshes(&files).map_err(|e| wrong(format!("{}: {}", e.key, e.why)))
}
