//! One node on a thread of its own: inputs in, the stage run, what came of it recorded.
use super::Options;
use crate::events::{Event, What};
use crate::plan::{Input, Node, NodeId, Plan};
use crate::registry;
use hvi_cache::{Claim, Entry, Record};
use hvi_kit::{Cancel, Ctx, Digest, Host, LoadError, Made, Recipe, Slot, StageError, Store};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Name of the threads that compute: a panic there is reported as the node's failure.
pub const WORKER: &str = "worker";

/// Keeping a checkpoint may take this part of a node's time at most.
const KEEPING: u32 = 50;

/// What a worker is to do.
pub struct Job {
    /// Which node.
    pub id: NodeId,
    /// What identifies it.
    pub recipe: Recipe,
    /// The recipe's key.
    pub key: Digest,
    /// Threads it may use.
    pub threads: usize,
    /// Set to stop it.
    pub cancel: Arc<Cancel>,
    /// Keeps other runs from computing the same; none where the store has no locks.
    pub claim: Option<Claim>,
}

/// What came of a job.
pub enum Came {
    /// A result, now in the store.
    Made(Entry),
    /// An input that the store had is damaged or gone: its digest.
    Lost(Digest),
    /// A failure.
    Failed {
        /// Why.
        why: String,
        /// Whether another try may do better: the machine failed, not the physics.
        transient: bool,
    },
    /// It was asked to stop.
    Stopped,
}

/// Runs one node and records what came of it. A panic in a stage is its failure, not the program's.
pub fn compute(plan: &Plan, job: Job, store: &Store, options: &Options<'_>) -> Came {
    let stage = plan.nodes[job.id].stage;
    if let Err(e) = put_files(plan, job.id, store) {
        return Came::Failed { why: e.to_string(), transient: true };
    }
    let relay = Relay::new(plan, &job, store, options);
    let ctx = Ctx { host: &relay, cancel: &job.cancel, threads: job.threads };
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let made = match catch_unwind(AssertUnwindSafe(|| (stage.run)(&job.recipe, store, &ctx))) {
        Ok(Ok(made)) => made,
        Ok(Err(e)) => return failed(&e, &job.recipe, store),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            let why = format!("the stage `{}` broke down, which is a defect of it: {text}", stage.name);
            return Came::Failed { why, transient: false };
        }
    };
    let record = record(&made, &plan.nodes[job.id], start.elapsed(), cpu_seconds() - cpu, job.threads);
    if let Err(e) = store.record(&job.recipe, &record) {
        return Came::Failed { why: e.to_string(), transient: true };
    }
    store.drop_partial(job.key);
    drop(job.claim);
    Came::Made(record.entry())
}

/// Puts the files that a node reads into the store, where its stage finds them.
fn put_files(plan: &Plan, id: NodeId, store: &Store) -> Result<(), hvi_kit::StoreError> {
    for input in plan.nodes[id].inputs.values() {
        if let Input::File(digest) = input
            && let Some(bytes) = plan.files.get(digest)
        {
            store.put(bytes)?;
        }
    }
    Ok(())
}

fn failed(error: &StageError, recipe: &Recipe, store: &Store) -> Came {
    if let StageError::Cancelled(_) = error {
        return Came::Stopped;
    }
    if let StageError::Load(LoadError::Store(_)) = error {
        let digests = recipe.inputs.values().flat_map(|slot| match slot {
            Slot::One(d) => std::slice::from_ref(d),
            Slot::Many(ds) => ds,
        });
        if let Some(lost) = digests.copied().find(|d| !store.holds(*d)) {
            return Came::Lost(lost);
        }
    }
    let transient =
        matches!(error, StageError::Load(LoadError::Store(_)) | StageError::Store(_) | StageError::Engine(_));
    Came::Failed { why: error.to_string(), transient }
}

fn record(made: &Made, node: &Node, wall: Duration, cpu_s: f64, threads: usize) -> Record {
    Record {
        output: made.output,
        kind: node.stage.output.into(),
        bytes: made.bytes,
        wall_s: wall.as_secs_f64(),
        cpu_s,
        host: std::fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| String::new(), |h| h.trim().into()),
        program: env!("CARGO_PKG_VERSION").into(),
        compiler: registry::COMPILER.into(),
        threads,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        finished: std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_secs()),
        foretold_s: node.cost,
    }
}

/// CPU time of this thread [s], as the kernel counts it; 0 where it doesn't say.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(0.0, |ns| ns * 1e-9)
}

/// What a running stage may ask for: passes its progress on a few times a second, keeps its checkpoints in the store.
struct Relay<'a> {
    plan: &'a Plan,
    id: NodeId,
    key: Digest,
    store: &'a Store,
    options: &'a Options<'a>,
    told: Mutex<Instant>,
    /// When a checkpoint was kept last, and how long to go on without one.
    kept: Mutex<(Instant, Duration)>,
}

impl<'a> Relay<'a> {
    fn new(plan: &'a Plan, job: &Job, store: &'a Store, options: &'a Options<'a>) -> Relay<'a> {
        let now = Instant::now();
        let kept = Mutex::new((now, options.checkpoint));
        Relay { plan, id: job.id, key: job.key, store, options, told: Mutex::new(now), kept }
    }
}

impl Host for Relay<'_> {
    fn advance(&self, done: f64, of: f64, doing: &str) {
        let Ok(mut told) = self.told.try_lock() else { return };
        if told.elapsed().as_millis() >= 100 {
            *told = Instant::now();
            let share = if of > 0.0 { (done / of).clamp(0.0, 1.0) } else { 0.0 };
            let what = What::Progress { share, doing: doing.into() };
            self.options.listener.on(self.plan, &Event { node: self.id, what });
        }
    }

    fn due(&self) -> bool {
        let (last, pause) = *self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        last.elapsed() >= pause
    }

    fn keep(&self, bytes: &[u8]) {
        let start = Instant::now();
        let _ = self.store.keep_partial(self.key, bytes);
        let pause = self.options.checkpoint.max(KEEPING * start.elapsed());
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = (Instant::now(), pause);
    }

    fn kept(&self) -> Option<Vec<u8>> {
        let kept = self.store.partial(self.key)?;
        self.options.listener.on(self.plan, &Event { node: self.id, what: What::Resumed });
        Some(kept)
    }
}
