//! `diff`: two runs side by side: which results differ, in which parameters, and what came of it.
use super::compare::cell;
use super::{Done, Stop, StoreArgs, columns};
use crate::console::{say, warn};
use crate::forecast;
use crate::history::{self, Last};
use crate::mistake::Mistake;
use crate::{outputs, plan, registry};
use hvi_kit::view::{Cell, Scalar};
use hvi_kit::{Digest, Recipe, Store};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::ExitCode;

/// What `diff` is told.
#[derive(clap::Args)]
#[command(after_help = "A run is NAME (the last run of that study), NAME~2 (the second before it, as `status` counts \
                        them), a pipeline file (what of it is in the store), or a folder of results.")]
pub struct Args {
    /// The one run
    #[arg(value_name = "RUN_A")]
    a: String,
    /// The other
    #[arg(value_name = "RUN_B")]
    b: String,
    /// Every result that differs, not only the first ones of each step
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    store: StoreArgs,
}

/// Results of a step that are shown unless all are asked for.
const SHOWN: usize = 3;

/// Shows the differences.
///
/// # Errors
/// [`Stop`] where a run is not known, or the store can't be used.
pub fn run(args: &Args) -> Done {
    let near = [&args.a, &args.b].into_iter().map(Path::new).find(|p| p.exists()).unwrap_or(Path::new("."));
    let store = args.store.open(near)?;
    let (a, b) = (keys(&args.a, &store)?, keys(&args.b, &store)?);
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    say(format_args!("A: {} ({} results)\nB: {} ({} results)", args.a, a.len(), args.b, b.len()));
    let labels: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let mut shown: BTreeMap<&str, usize> = BTreeMap::new();
    let mut counts = [0; 4];
    for label in labels {
        match (a.get(label), b.get(label)) {
            (Some(a), Some(b)) if a == b => counts[0] += 1,
            (Some(a), Some(b)) => {
                counts[1] += 1;
                let step = label.split('[').next().unwrap_or(label);
                let count = shown.entry(step).or_default();
                *count += 1;
                if args.all || *count <= SHOWN {
                    differing(label, *a, *b, &store);
                }
            }
            (Some(_), None) => {
                counts[2] += 1;
                say(format_args!("{label}: only in A"));
            }
            (None, _) => {
                counts[3] += 1;
                say(format_args!("{label}: only in B"));
            }
        }
    }
    let hidden: usize = shown.values().map(|n| if args.all { 0 } else { n.saturating_sub(SHOWN) }).sum();
    if hidden > 0 {
        say(format_args!("{hidden} more differ: --all shows them"));
    }
    let [same, differ, only_a, only_b] = counts;
    say(format_args!("{same} the same, {differ} differ, {only_a} only in A, {only_b} only in B"));
    Ok(ExitCode::SUCCESS)
}

/// The keys of a run by label.
fn keys(run: &str, store: &Store) -> Result<BTreeMap<String, Digest>, Stop> {
    let path = Path::new(run);
    if path.is_file() {
        let pipeline = super::settled(path, &[], || Ok(store))?;
        let plan = plan::plan(&pipeline, &[])?;
        let forecasts = forecast::forecast(&plan, store, &Last::of(store, &pipeline.name));
        let known = forecasts.iter().enumerate().filter(|(_, f)| f.entry().is_some());
        return Ok(known.filter_map(|(id, f)| Some((plan.label(id), f.key?))).collect());
    }
    if path.is_dir() {
        let keys = outputs::last_keys(path);
        if !keys.is_empty() {
            return Ok(keys);
        }
    }
    let (study, back) = run.rsplit_once('~').unwrap_or((run, "0"));
    let studies = history::studies(store);
    if !studies.iter().any(|s| s == study) {
        let mistake = Mistake::new(format!("`{run}` is no run: no pipeline, no folder of results, no study on record"));
        return Err(mistake.nearest(study, studies.iter().map(String::as_str)).into());
    }
    let back: usize = back.parse().map_err(|_| Mistake::new(format!("`{run}`: write NAME~COUNT, as in {study}~1")))?;
    let found = history::runs(store, study).nth(back);
    let found =
        found.ok_or_else(|| Mistake::new(format!("`{run}`: there are not so many runs of {study} on record")))?;
    Ok(found.nodes.into_iter().filter_map(|n| Some((n.label, n.key?))).collect())
}

fn differing(label: &str, a: Digest, b: Digest, store: &Store) {
    say(format_args!("{label}:"));
    let (old, new) = (store.recipe(a), store.recipe(b));
    match (&old, &new) {
        (Some(old), Some(new)) => {
            let mut rows = vec![["parameter", "A", "B"].map(String::from).to_vec()];
            for change in new.changes_since(old) {
                let text = |v: Option<String>| v.map_or_else(|| "nothing".into(), |v| forecast::short(&v));
                rows.push(vec![change.field, text(change.old), text(change.new)]);
            }
            columns(&rows).lines().for_each(|line| say(format_args!("  {line}")));
        }
        _ => say(format_args!("  a recipe is no longer in the store")),
    }
    let output = |key| store.lookup(key).map(|r| r.output);
    if let (Some(a), Some(b)) = (output(a), output(b))
        && a == b
    {
        return say(format_args!("  the results are the same bytes"));
    }
    let (Some(a), Some(b)) = (scalars(old, a, store), scalars(new, b, store)) else {
        return say(format_args!("  a result is no longer in the store"));
    };
    let mut rows = vec![["result", "unit", "A", "B", "B - A"].map(String::from).to_vec()];
    let names: Vec<&Scalar> = a.iter().chain(b.iter().filter(|s| !a.iter().any(|o| o.name == s.name))).collect();
    for named in names {
        let of = |all: &[Scalar]| all.iter().find(|s| s.name == named.name).map(|s| s.value.clone());
        let (a, b) = (of(&a), of(&b));
        let difference = match (a.as_ref().and_then(number), b.as_ref().and_then(number)) {
            (Some(a), Some(b)) => cell(&Cell::Number(b - a)),
            _ => String::new(),
        };
        let text = |c: Option<Cell>| c.as_ref().map_or_else(String::new, cell);
        rows.push(vec![named.name.clone(), named.unit.clone(), text(a), text(b), difference]);
    }
    columns(&rows).lines().for_each(|line| say(format_args!("  {line}")));
}

fn number(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Number(x) | Cell::Uncertain(x, _) => Some(*x),
        Cell::Text(_) | Cell::Empty => None,
    }
}

/// The numbers that sum a result up.
fn scalars(recipe: Option<Recipe>, key: Digest, store: &Store) -> Option<Vec<Scalar>> {
    let stage = registry::stage(&recipe?.stage)?;
    Some(registry::show(stage, store.lookup(key)?.output, store).ok()?.scalars)
}
