//! Plan + Store -> Report: looks each node up, runs what is missing on all cores, contains failures, stops on request.
//!
//! The coordinator (the calling thread) owns all state; workers compute one node at a time and send back what came of it.
use crate::events::{Event, Listener};
use crate::plan::{Input, NodeId, Plan};
use crate::registry;
use hvi_cache::{Entry, Found, Record};
use hvi_kit::{Cancel, Ctx, Digest, Made, Recipe, Slot, StageDef, StageError, Store};
use std::collections::{BTreeMap, BinaryHeap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, mpsc};
use std::time::Instant;

/// Name of the threads that compute: a panic there is reported as the node's failure.
pub const WORKER: &str = "worker";

/// How to run.
pub struct Options<'a> {
    /// Nodes that run at once.
    pub jobs: usize,
    /// Set to stop.
    pub cancel: &'a Cancel,
    /// Who listens.
    pub listener: &'a dyn Listener,
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
    /// Something it needs has no result.
    Skipped(String),
    /// Stopped by request, or not begun because of it.
    Cancelled,
}

impl Outcome {
    /// What the store has, where there is a result.
    pub fn entry(&self) -> Option<&Entry> {
        match self {
            Outcome::Hit(r) | Outcome::Ran(r) => Some(r),
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

/// Looks a node's result up; a result of another kind is none.
pub fn stored(store: &Store, key: Digest, stage: &StageDef) -> Found {
    match store.find(key) {
        Found::Whole(entry) if entry.kind() != stage.output => Found::Nothing,
        found => found,
    }
}

/// Runs a plan: every node whose result isn't in the store, independent ones at once, those on the longest way first.
///
/// A failure skips what needs it and nothing else.
///
/// # Errors
/// Only where the store can't take the input files; whatever happens to a node is in the report.
pub fn execute(plan: &Plan, store: &Store, options: &Options<'_>) -> Result<Report, hvi_kit::StoreError> {
    let start = Instant::now();
    for bytes in plan.files.values() {
        store.put(bytes)?;
    }
    let mut run = Coordinator::new(plan, store, options);
    let (jobs, queue) = mpsc::channel::<(NodeId, Recipe)>();
    let queue = Mutex::new(queue);
    let (results, finished) = mpsc::channel::<(NodeId, Outcome)>();
    std::thread::scope(|scope| {
        for _ in 0..options.jobs.max(1) {
            let (queue, results) = (&queue, results.clone());
            let worker = std::thread::Builder::new().name(WORKER.into());
            let spawned = worker.spawn_scoped(scope, move || {
                loop {
                    let job = queue.lock().map(|q| q.recv());
                    let Ok(Ok((id, recipe))) = job else { return };
                    let outcome = compute(plan, id, &recipe, store, options);
                    if results.send((id, outcome)).is_err() {
                        return;
                    }
                }
            });
            if spawned.is_err() {
                break; // fewer workers: the first always comes, or nothing runs on this machine
            }
        }
        drop(results);
        loop {
            run.advance(&jobs);
            if run.running.is_empty() {
                break;
            }
            let Ok((id, outcome)) = finished.recv() else { break };
            run.finish(id, outcome);
        }
        drop(jobs);
    });
    Ok(run.report(start.elapsed().as_secs_f64()))
}

struct Coordinator<'a> {
    plan: &'a Plan,
    store: &'a Store,
    options: &'a Options<'a>,
    outcomes: Vec<Option<Outcome>>,
    keys: Vec<Option<Digest>>,
    /// Number of needs that have no outcome yet, by node.
    open: Vec<usize>,
    /// Nodes that need a node.
    needed_by: Vec<Vec<NodeId>>,
    /// Longest way to the end, in predicted core-seconds, by node.
    way: Vec<f64>,
    ready: BinaryHeap<Ready>,
    /// Nodes at work, with their keys.
    running: BTreeMap<NodeId, Digest>,
    /// Nodes with the same key as one at work.
    same: HashMap<Digest, Vec<NodeId>>,
}

struct Ready(f64, NodeId);
impl PartialEq for Ready {
    fn eq(&self, other: &Ready) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ready {}
impl PartialOrd for Ready {
    fn partial_cmp(&self, other: &Ready) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ready {
    fn cmp(&self, other: &Ready) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

impl<'a> Coordinator<'a> {
    fn new(plan: &'a Plan, store: &'a Store, options: &'a Options<'a>) -> Coordinator<'a> {
        let n = plan.nodes.len();
        let (mut needed_by, mut open, mut way) = (vec![Vec::new(); n], vec![0; n], vec![0.0; n]);
        for id in 0..n {
            let mut needs: Vec<_> = plan.needs(id).collect();
            needs.sort_unstable();
            needs.dedup();
            open[id] = needs.len();
            needs.into_iter().for_each(|need| needed_by[need].push(id));
        }
        for id in (0..n).rev() {
            let longest = needed_by[id].iter().map(|&j| way[j]).fold(0.0, f64::max);
            way[id] = plan.nodes[id].cost + longest;
        }
        let ready = (0..n).filter(|&id| open[id] == 0).map(|id| Ready(way[id], id)).collect();
        Coordinator {
            plan,
            store,
            options,
            outcomes: vec![None; n],
            keys: vec![None; n],
            open,
            needed_by,
            way,
            ready,
            running: BTreeMap::new(),
            same: HashMap::new(),
        }
    }

    /// Settles hits and hands work out until every worker has some, or nothing is ready.
    fn advance(&mut self, jobs: &mpsc::Sender<(NodeId, Recipe)>) {
        while self.running.len() < self.options.jobs.max(1) {
            let Some(Ready(_, id)) = self.ready.pop() else { return };
            if self.options.cancel.is_set() {
                self.settle(id, Outcome::Cancelled);
                continue;
            }
            if let Some(blocked) = self.blocked(id) {
                self.settle(id, blocked);
                continue;
            }
            let output = |n: NodeId| self.outcomes[n].as_ref()?.entry().map(|e| e.output);
            let recipe = recipe(self.plan, id, &output).expect("every need has a result");
            let key = recipe.key();
            self.keys[id] = Some(key);
            match stored(self.store, key, self.plan.nodes[id].stage) {
                Found::Whole(entry) => {
                    self.settle(id, Outcome::Hit(entry));
                    continue;
                }
                Found::Damaged(output) => {
                    // Reading it moves what is left of it aside.
                    let _ = self.store.get(output);
                    self.options.listener.on(self.plan, &Event::Damaged { node: id });
                }
                Found::Nothing => {}
            }
            if self.running.values().any(|k| *k == key) {
                self.same.entry(key).or_default().push(id);
            } else {
                self.running.insert(id, key);
                self.options.listener.on(self.plan, &Event::Started { node: id });
                jobs.send((id, recipe)).expect("workers outlive the coordinator");
            }
        }
    }

    /// Why `id` can't run: something it needs has no result.
    fn blocked(&self, id: NodeId) -> Option<Outcome> {
        let without = |n: &NodeId| self.outcomes[*n].as_ref().is_none_or(|o| o.entry().is_none());
        let need = self.plan.needs(id).find(without)?;
        Some(match &self.outcomes[need] {
            Some(Outcome::Cancelled) | None => Outcome::Cancelled,
            Some(Outcome::Skipped(why)) => Outcome::Skipped(why.clone()),
            _ => Outcome::Skipped(format!("it needs {}, which failed", self.plan.label(need))),
        })
    }

    fn finish(&mut self, id: NodeId, outcome: Outcome) {
        let key = self.running.remove(&id);
        for twin in key.and_then(|k| self.same.remove(&k)).unwrap_or_default() {
            let shared = match &outcome {
                Outcome::Ran(entry) => Outcome::Hit(*entry),
                other => other.clone(),
            };
            self.settle(twin, shared);
        }
        self.settle(id, outcome);
    }

    fn settle(&mut self, id: NodeId, outcome: Outcome) {
        let event = match &outcome {
            Outcome::Hit(_) => Event::Hit { node: id },
            Outcome::Ran(entry) => Event::Ran { node: id, seconds: f64::from(entry.wall_s) },
            Outcome::Failed(why) => Event::Failed { node: id, why: why.clone() },
            Outcome::Skipped(why) => Event::Skipped { node: id, why: why.clone() },
            Outcome::Cancelled => Event::Cancelled { node: id },
        };
        self.options.listener.on(self.plan, &event);
        self.outcomes[id] = Some(outcome);
        for next in self.needed_by[id].clone() {
            self.open[next] -= 1;
            if self.open[next] == 0 {
                self.ready.push(Ready(self.way[next], next));
            }
        }
    }

    fn report(self, seconds: f64) -> Report {
        let outcomes = self.outcomes.into_iter().map(|o| o.unwrap_or(Outcome::Cancelled)).collect();
        Report { outcomes, keys: self.keys, seconds }
    }
}

/// Runs one node on a worker and records what came of it. A panic in a stage is its failure, not the program's.
fn compute(plan: &Plan, id: NodeId, recipe: &Recipe, store: &Store, options: &Options<'_>) -> Outcome {
    let listen = Relay { plan, id, options, last: Mutex::new(Instant::now()) };
    let ctx = Ctx { host: &listen, cancel: options.cancel, threads: 1 };
    let stage = plan.nodes[id].stage;
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let made = catch_unwind(AssertUnwindSafe(|| (stage.run)(recipe, store, &ctx)));
    let made: Made = match made {
        Ok(Ok(made)) => made,
        Ok(Err(StageError::Cancelled(_))) => return Outcome::Cancelled,
        Ok(Err(e)) => return Outcome::Failed(e.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            return Outcome::Failed(format!("the stage `{}` broke down, which is a defect of it: {text}", stage.name));
        }
    };
    let record = Record {
        output: made.output,
        kind: stage.output.into(),
        bytes: made.bytes,
        wall_s: start.elapsed().as_secs_f64(),
        cpu_s: cpu_seconds() - cpu,
        host: std::fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| String::new(), |h| h.trim().into()),
        program: env!("CARGO_PKG_VERSION").into(),
        compiler: registry::COMPILER.into(),
        threads: ctx.threads,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        finished: std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_secs()),
    };
    match store.record(recipe, &record) {
        Ok(()) => Outcome::Ran(record.entry()),
        Err(e) => Outcome::Failed(e.to_string()),
    }
}

/// CPU time of this thread [s], as the kernel counts it; 0 where it doesn't say.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(0.0, |ns| ns * 1e-9)
}

/// Passes a stage's progress on, a few times a second.
struct Relay<'a> {
    plan: &'a Plan,
    id: NodeId,
    options: &'a Options<'a>,
    last: Mutex<Instant>,
}
impl hvi_kit::Host for Relay<'_> {
    fn advance(&self, done: f64, of: f64, doing: &str) {
        let Ok(mut last) = self.last.try_lock() else { return };
        if last.elapsed().as_millis() >= 100 {
            *last = Instant::now();
            let share = if of > 0.0 { (done / of).clamp(0.0, 1.0) } else { 0.0 };
            let event = Event::Progress { node: self.id, share, doing: doing.into() };
            self.options.listener.on(self.plan, &event);
        }
    }
}
