//! One node on a thread of its own: inputs in, the stage run, what came of it recorded.
use super::clock::Clock;
use crate::events::What;
use crate::plan::NodeId;
use crate::registry;
use hvi_cache::{Claim, Entry, Record};
use hvi_kit::{Cancel, Ctx, Digest, Host, LoadError, Made, Recipe, Slot, StageDef, StageError, Store};
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
    /// What it uses.
    pub stage: &'static StageDef,
    /// Predicted core-seconds.
    pub cost: f64,
    /// What identifies it.
    pub recipe: Recipe,
    /// The recipe's key.
    pub key: Digest,
    /// Threads it may use.
    pub threads: usize,
    /// Memory it asks for [B].
    pub memory: u64,
    /// Core-seconds foretold, from what such nodes took before.
    pub foretold: f64,
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

/// Who a worker works for.
pub struct Desk<'a> {
    /// Where inputs come from and results go.
    pub store: &'a Store,
    /// What counts its CPU time.
    pub clock: &'a Clock,
    /// How long a node goes on before it keeps what it needs to go on from there.
    pub checkpoint: Duration,
    /// Told what happens to the node.
    pub tell: &'a (dyn Fn(What) + Sync),
}

/// Runs one node and records what came of it. A panic in a stage is its failure, not the program's.
pub fn compute(job: Job, desk: &Desk<'_>) -> Came {
    let (stage, store) = (job.stage, desk.store);
    let relay = Relay::new(job.key, desk);
    let ctx = Ctx { host: &relay, cancel: &job.cancel, threads: job.threads };
    let (start, watch) = (Instant::now(), desk.clock.begin(job.threads, job.recipe.engine.is_some()));
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
    let record = record(&made, &job, start.elapsed(), watch.seconds());
    if let Err(e) = store.record(&job.recipe, &record) {
        return Came::Failed { why: e.to_string(), transient: true };
    }
    store.drop_partial(job.key);
    drop(job.claim);
    Came::Made(record.entry())
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

fn record(made: &Made, job: &Job, wall: Duration, cpu_s: f64) -> Record {
    Record {
        output: made.output,
        kind: job.stage.output.into(),
        bytes: made.bytes,
        wall_s: wall.as_secs_f64(),
        cpu_s,
        host: std::fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| String::new(), |h| h.trim().into()),
        program: env!("CARGO_PKG_VERSION").into(),
        compiler: registry::COMPILER.into(),
        threads: job.threads,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        finished: std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_secs()),
        foretold_s: job.cost,
    }
}

/// What a running stage may ask for: passes its progress on a few times a second, keeps its checkpoints in the store.
struct Relay<'a> {
    key: Digest,
    desk: &'a Desk<'a>,
    told: Mutex<Instant>,
    /// When a checkpoint was kept last, and how long to go on without one.
    kept: Mutex<(Instant, Duration)>,
}

impl<'a> Relay<'a> {
    fn new(key: Digest, desk: &'a Desk<'a>) -> Relay<'a> {
        let now = Instant::now();
        Relay { key, desk, told: Mutex::new(now), kept: Mutex::new((now, desk.checkpoint)) }
    }
}

impl Host for Relay<'_> {
    fn advance(&self, done: f64, of: f64, doing: &str) {
        let Ok(mut told) = self.told.try_lock() else { return };
        if told.elapsed().as_millis() >= 100 {
            *told = Instant::now();
            let share = if of > 0.0 { (done / of).clamp(0.0, 1.0) } else { 0.0 };
            (self.desk.tell)(What::Progress { share, doing: doing.into() });
        }
    }

    fn due(&self) -> bool {
        let (last, pause) = *self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        last.elapsed() >= pause
    }

    fn keep(&self, bytes: &[u8]) {
        let start = Instant::now();
        let _ = self.desk.store.keep_partial(self.key, bytes);
        let pause = self.desk.checkpoint.max(KEEPING * start.elapsed());
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = (Instant::now(), pause);
    }

    fn kept(&self) -> Option<Vec<u8>> {
        let kept = self.desk.store.partial(self.key)?;
        (self.desk.tell)(What::Resumed);
        Some(kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::view::Scalar;
    use hvi_kit::{Artifact, Stage};
    use serde::{Deserialize, Serialize};
    use std::collections::BTreeMap;

    #[derive(Serialize, Deserialize)]
    struct Number(f64);
    impl Artifact for Number {
        const KIND: &'static str = "number/1";
        fn scalars(&self) -> Vec<Scalar> {
            Vec::new()
        }
    }

    #[derive(Serialize, Deserialize, schemars::JsonSchema)]
    struct Params {
        does: String,
    }

    /// A stage that breaks down, finds that its physics went wrong, or doesn't.
    struct Doubtful;
    impl Stage for Doubtful {
        const NAME: &'static str = "eos.handbook";
        const SUMMARY: &'static str = "a stage with defects";
        type Params = Params;
        type Inputs = ();
        type Output = Number;
        fn run(params: &Params, (): (), _: &Ctx<'_>) -> Result<Number, StageError> {
            match params.does.as_str() {
                "index" => Ok(Number([1.0, 2.0][params.does.len()])),
                "nan" => Err(StageError::physics("step 3: the pressure is NaN")),
                _ => Ok(Number(1.0)),
            }
        }
    }
    static STAGE: StageDef = StageDef::of::<Doubtful>();

    fn came(store: &Store, does: &str) -> Came {
        let (code, params) = (Digest::of(b"code"), serde_json::json!({ "does": does }));
        let inputs = BTreeMap::new();
        let recipe =
            Recipe { format: Recipe::FORMAT, stage: Doubtful::NAME.into(), code, params, engine: None, inputs };
        let key = recipe.key();
        let (cancel, claim) = (Arc::default(), store.claim(key).unwrap());
        let job =
            Job { id: 0, stage: &STAGE, cost: 0.0, recipe, key, threads: 1, memory: 0, foretold: 0.0, cancel, claim };
        let desk = Desk { store, clock: &Clock::default(), checkpoint: Duration::from_secs(1), tell: &|_| {} };
        compute(job, &desk)
    }

    /// The next node runs as if nothing had been, no result is on record, and what failed is not locked.
    #[test]
    fn a_stage_that_breaks_down_fails_alone() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        for (does, what) in [("index", "broke down, which is a defect of it: index out of bounds"), ("nan", "is NaN")] {
            for _ in 0..2 {
                match came(&store, does) {
                    Came::Failed { why, transient } => assert!(why.contains(what) && !transient, "{why}"),
                    _ => panic!("{does} did not fail"),
                }
            }
            assert_eq!(store.stats().results.count, 0);
        }
        assert!(matches!(came(&store, "well"), Came::Made(_)));
        assert_eq!(store.stats().results.count, 1);
    }
}
