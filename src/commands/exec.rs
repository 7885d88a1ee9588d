//! `exec`: computes nodes by their keys, from the recipes in the store: what a job of a cluster runs.
use super::{Done, Stop, StoreArgs, run};
use crate::amount;
use crate::console::warn;
use crate::execute::slurm::batch::{Batch, Note, Work};
use crate::execute::{self, Came, Clock, Desk, Job};
use crate::registry;
use hvi_cache::Found;
use hvi_kit::{Cancel, Digest, Recipe, StageDef, Store};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What `exec` is told.
#[derive(clap::Args)]
pub struct Args {
    /// Keys of nodes whose recipes are in the store
    #[arg(value_name = "KEY", required_unless_present = "batch", conflicts_with = "batch")]
    keys: Vec<Digest>,
    #[command(flatten)]
    store: StoreArgs,
    /// Compute a task of this batch, as `run --executor slurm` submitted it
    #[arg(long, value_name = "NAME", requires = "task")]
    batch: Option<String>,
    /// Which task of the batch
    #[arg(long, value_name = "NUMBER", requires = "batch")]
    task: Option<usize>,
    /// Threads that each node may use
    #[arg(long, default_value_t = 1, conflicts_with = "batch", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: u16,
    /// The longest one node may take
    #[arg(long, value_name = "TIME", value_parser = amount::time, conflicts_with = "batch")]
    timeout: Option<Duration>,
    /// How long a node goes on before it keeps what it needs to go on from there
    #[arg(long, value_name = "TIME", value_parser = amount::time, default_value = "10s", conflicts_with = "batch")]
    checkpoint: Duration,
}

/// What there is to do.
struct Task {
    works: Vec<Work>,
    threads: usize,
    checkpoint: Duration,
}

/// Computes one node after the other. What fails leaves a note in the store, for the run that waits for it.
///
/// # Errors
/// [`Stop`] where the store can't be used, or there is no such batch.
pub fn run(args: &Args) -> Done {
    let store = args.store.open(Path::new("."))?;
    let task = task(args, &store)?;
    // Where the store has no locks nobody removes anything from it either.
    let _hold = store.hold().ok();
    let cancel = run::stop_on_interrupt();
    run::quiet_workers();
    let mut failed = 0;
    for work in &task.works {
        let start = Instant::now();
        let came = one(work, &task, &store, cancel);
        if let Some(note) = Note::of(&came) {
            // Without a note the run that waits finds out too, only later.
            let _ = note.publish(&store, work.key);
        }
        match &came {
            Came::Made(_) => warn(format_args!("{}: done in {:.1} s", work.key.short(), start.elapsed().as_secs_f64())),
            Came::Failed { why, .. } => warn(format_args!("{}: failed: {why}", work.key.short())),
            Came::Lost(digest) => warn(format_args!("{}: its input {} is lost", work.key.short(), digest.short())),
            Came::Stopped => warn(format_args!("{}: stopped; what it kept lets it go on from there", work.key.short())),
        }
        failed += usize::from(!matches!(came, Came::Made(_)));
        if cancel.is_set() {
            return Ok(ExitCode::from(130));
        }
    }
    Ok(ExitCode::from(u8::from(failed > 0)))
}

fn task(args: &Args, store: &Store) -> Result<Task, Stop> {
    let Some(name) = &args.batch else {
        let timeout_s = args.timeout.map(|t| t.as_secs_f64());
        let works = args.keys.iter().map(|&key| Work { key, cost: 0.0, timeout_s }).collect();
        return Ok(Task { works, threads: args.threads.into(), checkpoint: args.checkpoint });
    };
    let gone = || Stop::Machine(format!("{}: there is no such batch or task", name));
    let batch = Batch::read(store, name).ok_or_else(gone)?;
    let works = batch.tasks.get(args.task.unwrap_or_default()).ok_or_else(gone)?.clone();
    Ok(Task { works, threads: batch.threads, checkpoint: Duration::from_secs_f64(batch.checkpoint_s) })
}

/// Computes one node, unless its result is there or another process computes it just now.
fn one(work: &Work, task: &Task, store: &Store, cancel: &'static Cancel) -> Came {
    let key = work.key;
    let (recipe, stage) = match asked(store, key) {
        Ok(asked) => asked,
        Err(why) => return Came::Failed { why, transient: false },
    };
    let claim = loop {
        if let Found::Whole(entry) = execute::stored(store, key, stage) {
            return Came::Made(entry);
        }
        match store.claim(key) {
            Ok(None) if cancel.is_set() => return Came::Stopped,
            Ok(None) => std::thread::sleep(Duration::from_millis(200)),
            Ok(claim) => break claim,
            // No locks here: at worst two do the same.
            Err(_) => break None,
        }
    };
    // It may have come between the look and the claim.
    if let Found::Whole(entry) = execute::stored(store, key, stage) {
        return Came::Made(entry);
    }
    let (stop, clock) = (Arc::new(Cancel::default()), Clock::default());
    let cost = if work.cost > 0.0 { work.cost } else { predicted(stage, &recipe) };
    let job = Job {
        id: 0,
        stage,
        cost,
        recipe,
        key,
        threads: task.threads,
        memory: 0,
        foretold: cost,
        cancel: stop.clone(),
        claim,
    };
    let desk = Desk { store, clock: &clock, checkpoint: task.checkpoint, tell: &|_| {} };
    let limit = work.timeout_s.map(Duration::from_secs_f64);
    let (came, is_late) = watched(&stop, cancel, limit, || execute::compute(job, &desk));
    match came {
        Came::Stopped if is_late && !cancel.is_set() => {
            Came::Failed { why: execute::out_of_time(limit.unwrap_or_default()), transient: false }
        }
        came => came,
    }
}

/// Runs `work` on a thread of its own; sets `stop` when `cancel` is set or the time is over. Returns what came of it, and
/// whether the time was over.
fn watched(
    stop: &Cancel,
    cancel: &Cancel,
    limit: Option<Duration>,
    work: impl FnOnce() -> Came + Send,
) -> (Came, bool) {
    let start = Instant::now();
    std::thread::scope(|scope| {
        let worker = std::thread::Builder::new().name(execute::WORKER.into()).spawn_scoped(scope, work);
        let worker = match worker {
            Ok(worker) => worker,
            Err(e) => {
                return (Came::Failed { why: format!("there is no thread to run it: {e}"), transient: true }, false);
            }
        };
        let mut is_late = false;
        while !worker.is_finished() {
            is_late |= limit.is_some_and(|limit| start.elapsed() > limit);
            if is_late || cancel.is_set() {
                stop.set();
            }
            // Short nodes come in packs: what is short itself is waited for closely.
            std::thread::sleep((start.elapsed() / 20).clamp(Duration::from_micros(50), Duration::from_millis(100)));
        }
        let broken = || Came::Failed { why: "the worker broke down".into(), transient: false };
        (worker.join().unwrap_or_else(|_| broken()), is_late)
    })
}

/// The recipe of `key`, and the stage that it asks for, if this program has it.
fn asked(store: &Store, key: Digest) -> Result<(Recipe, &'static StageDef), String> {
    let recipe = store.recipe(key).ok_or_else(|| format!("the recipe of {} is not in the store", key.short()))?;
    let known = registry::stage(&recipe.stage).filter(|stage| registry::code(stage) == recipe.code);
    let Some(stage) = known else {
        return Err(format!("the recipe asks for other code of the stage `{}` than this program has", recipe.stage));
    };
    let checked = (stage.check)(&recipe.params, &BTreeMap::new());
    let engine = checked.ok().and_then(|checked| checked.engine);
    match (&recipe.engine, engine) {
        (Some(wanted), Some(engine)) => {
            let found = engine.version().map_err(|e| e.to_string())?;
            let other = format!("the recipe asks for {wanted}; here is {found}");
            (found == *wanted).then_some((recipe.clone(), stage)).ok_or(other)
        }
        _ => Ok((recipe, stage)),
    }
}

/// Core-seconds that the stage predicts.
fn predicted(stage: &StageDef, recipe: &Recipe) -> f64 {
    (stage.check)(&recipe.params, &BTreeMap::new()).map_or(0.0, |checked| checked.cost)
}
