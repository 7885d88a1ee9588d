//! Plan + Store -> Report: looks each node up, runs what is missing on all cores, contains failures, stops on request.
//!
//! - `slurm.rs` nodes as jobs of a cluster
//! - `coordinator.rs` the state of a run, owned by the calling thread
//! - `graph.rs` who needs whom; `machine.rs` cores, memory and the queue; `times.rs` how long a node will take
//! - `worker.rs` one node on a thread of its own, which exists only while it runs; `clock.rs` the CPU time it takes
use crate::events::{Event, Listener, What};
use crate::pipeline::Profile;
use crate::plan::{Input, NodeId, Plan};
use crate::registry;
use hvi_cache::{Asked, Entry, Found, InUse, Plugged};
use hvi_kit::{Cancel, Digest, Recipe, Slot, StageDef, Store, StoreError};
use std::sync::mpsc;
use std::time::{Duration, Instant};

mod clock;
mod coordinator;
mod graph;
mod machine;
pub mod slurm;
mod times;
mod worker;
pub use clock::Clock;
use coordinator::Coordinator;
pub use graph::Graph;
pub use machine::total_memory;
use slurm::Cluster;
use times::Times;
pub use worker::{Came, Desk, Job, WORKER, compute};

/// How to run. Nothing of it enters a key.
pub struct Options<'a> {
    /// Threads at work at once.
    pub jobs: usize,
    /// Memory that nodes at work may ask for together [B].
    pub memory: u64,
    /// After a failure, still begin what doesn't need what failed.
    pub keep_going: bool,
    /// How often to try again what failed for a reason that may pass (the machine or a program outside, not the physics),
    /// where its step doesn't say.
    pub retry: u32,
    /// The longest that one node may take, where its step doesn't say.
    pub timeout: Option<Duration>,
    /// How long a node goes on before it keeps what it needs to go on from there.
    pub checkpoint: Duration,
    /// The cluster that computes, if one does.
    pub remote: Option<Remote<'a>>,
    /// Set to stop.
    pub cancel: &'a Cancel,
    /// Who listens.
    pub listener: &'a dyn Listener,
}

impl<'a> Options<'a> {
    /// The usual way to run, with `jobs` threads: all memory, no limit of time, an end at the first failure.
    pub fn new(jobs: usize, cancel: &'a Cancel, listener: &'a dyn Listener) -> Options<'a> {
        let (memory, checkpoint) = (total_memory(), Duration::from_secs(10));
        Options { jobs, memory, keep_going: false, retry: 0, timeout: None, checkpoint, remote: None, cancel, listener }
    }
}

/// A Slurm cluster that computes.
#[derive(Clone, Copy)]
pub struct Remote<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// What jobs ask for.
    pub profile: &'a Profile,
}

/// What came of a node.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// The result was in the store.
    Hit(Entry),
    /// It was computed.
    Ran(Entry),
    /// It failed, and why.
    Failed(String),
    /// Something it needs has no result, or something failed before it began.
    Skipped(String),
    /// Stopped by request, or not begun because of it.
    Cancelled,
}

impl Outcome {
    /// What the store has, where there is a result.
    pub fn entry(&self) -> Option<&Entry> {
        match self {
            Outcome::Hit(e) | Outcome::Ran(e) => Some(e),
            _ => None,
        }
    }
}

/// What came of a run: one outcome and, where its inputs were known, one key a node.
pub struct Report {
    /// By node.
    pub outcomes: Vec<Outcome>,
    /// By node.
    pub keys: Vec<Option<Digest>>,
    /// Wall time [s].
    pub seconds: f64,
    /// Keeps the results from being removed while the report is used; none where the store has no locks.
    pub hold: Option<InUse>,
}

impl Report {
    /// This report, of a run that came after `earlier`: what that one computed counts as computed.
    pub fn after(mut self, earlier: &Report) -> Report {
        for (now, then) in self.outcomes.iter_mut().zip(&earlier.outcomes) {
            if let (Outcome::Hit(entry), Outcome::Ran(_)) = (&*now, then) {
                *now = Outcome::Ran(*entry);
            }
        }
        self.seconds += earlier.seconds;
        self
    }
}

/// The recipe of a node, once the outputs of all it needs are known.
pub fn recipe(plan: &Plan, id: NodeId, output: &dyn Fn(NodeId) -> Option<Digest>) -> Option<Recipe> {
    let node = &plan.nodes[id];
    let slots = node.inputs.iter().map(|(name, input)| {
        let slot = match input {
            Input::One(n) => Slot::One(output(*n)?),
            Input::Many(ns) => Slot::Many(ns.iter().map(|n| output(*n)).collect::<Option<_>>()?),
            Input::File(d) => Slot::One(*d),
        };
        Some((name.clone(), slot))
    });
    Some(Recipe {
        format: Recipe::FORMAT,
        stage: node.stage.name.into(),
        code: registry::code(node.stage),
        params: node.params.clone(),
        engine: node.engine.clone(),
        inputs: slots.collect::<Option<_>>()?,
    })
}

/// The key of a node, once the outputs of all it needs are known: that of its [`recipe`], without making one.
pub fn key(plan: &Plan, id: NodeId, output: &dyn Fn(NodeId) -> Option<Digest>) -> Option<Digest> {
    let node = &plan.nodes[id];
    let plugged = |input: &Input| {
        Some(match input {
            Input::One(n) => Plugged::One(output(*n)?),
            Input::Many(ns) => Plugged::Many(ns.iter().map(|n| output(*n)).collect::<Option<_>>()?),
            Input::File(d) => Plugged::One(*d),
        })
    };
    let inputs = node.inputs.iter().map(|(name, input)| Some((name.as_str(), plugged(input)?)));
    let asked = Asked {
        format: Recipe::FORMAT,
        stage: node.stage.name,
        code: registry::code(node.stage),
        params: &node.params,
        engine: node.engine.as_deref(),
        inputs: inputs.collect::<Option<_>>()?,
    };
    Some(asked.key())
}

/// Looks a node's result up; a result of another kind is none.
pub fn stored(store: &Store, key: Digest, stage: &StageDef) -> Found {
    match store.find(key) {
        Found::Whole(entry) if entry.kind() != stage.output => Found::Nothing,
        found => found,
    }
}

/// Runs a plan: every node whose result isn't in the store, packed into the machine's cores and memory, those on the
/// longest way first.
///
/// A failure skips what needs it; unless the run is to keep going, nothing else is begun either, what is at work is
/// finished, and results that are in the store are still served. Of two runs that need the same result at once one
/// computes it; the other waits for it, or takes over if the first one dies.
///
/// # Errors
/// Only where somebody removes things from the store and doesn't come to an end; whatever happens to a node is in the
/// report.
pub fn execute(plan: &Plan, store: &Store, options: &Options<'_>) -> Result<Report, StoreError> {
    let start = Instant::now();
    let hold = hold(store)?;
    let mut run = Coordinator::new(plan, store, options);
    match options.remote {
        Some(remote) => on_cluster(&mut run, &mut Cluster::new(plan, store, options, remote)),
        None => on_this_machine(&mut run, plan, store, options),
    }
    Ok(run.report(start.elapsed().as_secs_f64(), hold))
}

fn on_cluster(run: &mut Coordinator<'_>, cluster: &mut Cluster<'_>) {
    loop {
        run.advance(&|job| cluster.take(job));
        if run.is_done() {
            return;
        }
        for (id, came) in cluster.wait(run.patience()) {
            run.finish(id, came);
        }
        run.watch();
    }
}

fn on_this_machine(run: &mut Coordinator<'_>, plan: &Plan, store: &Store, options: &Options<'_>) {
    let (results, finished) = mpsc::channel::<(NodeId, Came)>();
    let clock = Clock::default();
    let work = |job: Job| {
        let id = job.id;
        let tell = |what: What| options.listener.on(plan, &Event { node: id, what });
        match put_files(plan, id, store) {
            Ok(()) => worker::compute(job, &Desk { store, clock: &clock, checkpoint: options.checkpoint, tell: &tell }),
            Err(e) => Came::Failed { why: e.to_string(), transient: true },
        }
    };
    std::thread::scope(|scope| {
        let begin = |job: Job| {
            let (id, done, own, work) = (job.id, results.clone(), results.clone(), &work);
            let worker = std::thread::Builder::new().name(WORKER.into());
            let spawned = worker.spawn_scoped(scope, move || {
                let _ = done.send((id, work(job)));
            });
            if let Err(e) = spawned {
                let why = format!("there is no thread to run it: {e}");
                let _ = own.send((id, Came::Failed { why, transient: true }));
            }
        };
        loop {
            run.advance(&begin);
            if run.is_done() {
                break;
            }
            if let Ok((id, came)) = finished.recv_timeout(run.patience()) {
                run.finish(id, came);
                finished.try_iter().for_each(|(id, came)| run.finish(id, came));
            }
            run.watch();
        }
    });
}

/// Core-seconds foretold for each node without a result, from what such nodes took before; 0 for the others.
pub fn foretell(plan: &Plan, outcomes: &[Option<Outcome>], store: &Store) -> Vec<f64> {
    let times = Times::of(plan, outcomes, store);
    let nodes = plan.nodes.iter().zip(outcomes);
    nodes.map(|(node, o)| if o.is_some() { 0.0 } else { times.predict(node.stage.name, node.cost) }).collect()
}

/// Why a node failed that was stopped after `limit`.
pub fn out_of_time(limit: Duration) -> String {
    let limit = crate::console::duration(limit.as_secs_f64());
    format!("stopped after {limit}, its timeout; what it kept lets it go on from there: run again, with a longer one")
}

/// Puts the files that a node reads into the store, where its stage finds them.
fn put_files(plan: &Plan, id: NodeId, store: &Store) -> Result<(), StoreError> {
    for input in plan.nodes[id].inputs.values() {
        if let Input::File(digest) = input
            && let Some(bytes) = plan.files.get(digest)
        {
            store.put(bytes)?;
        }
    }
    Ok(())
}

/// Keeps what is in the store from being removed; waits for somebody who removes things just now.
fn hold(store: &Store) -> Result<Option<InUse>, StoreError> {
    const PATIENCE: Duration = Duration::from_secs(60);
    let start = Instant::now();
    loop {
        match store.hold() {
            Ok(hold) => return Ok(Some(hold)),
            Err(StoreError::Busy { .. }) if start.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(50)),
            Err(busy @ StoreError::Busy { .. }) => return Err(busy),
            // A store that can't be written: nobody removes anything from it either.
            Err(_) => return Ok(None),
        }
    }
}
