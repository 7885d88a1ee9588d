//! The state of a run: which nodes wait, which are at work, what came of each. One thread owns it; it never blocks.
use super::graph::Graph;
use super::machine::{Machine, Share, Waiting};
use super::worker::{Came, Job};
use super::{Options, Outcome, Report, foretell, recipe, stored};
use crate::events::{Event, What};
use crate::pipeline::Care;
use crate::plan::{NodeId, Plan};
use hvi_cache::{Claim, Found, InUse};
use hvi_kit::{Cancel, Digest, Recipe, Store};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often a request to stop, a node's time and other runs' locks are looked at.
const GLANCE: Duration = Duration::from_millis(100);

/// The first pauses before another run's lock is tried again, and before a failed node is; each next one is twice as long.
const LOCKED: Duration = Duration::from_millis(20);
const FAILED: Duration = Duration::from_millis(500);

/// The state of a run.
pub struct Coordinator<'a> {
    plan: &'a Plan,
    store: &'a Store,
    options: &'a Options<'a>,
    graph: Graph,
    outcomes: Vec<Option<Outcome>>,
    keys: Vec<Option<Digest>>,
    /// Nodes whose needs are settled, to be looked up in the store, first in first out; `looked_up` of them are done.
    known: Vec<NodeId>,
    looked_up: usize,
    /// Nodes that the store has no result for, not yet queued for work.
    missed: Vec<NodeId>,
    /// Core-seconds foretold for each node, and its rank in the queue; made when the first node has to run.
    foretold: Vec<f64>,
    ways: Vec<f64>,
    waiting: Waiting,
    machine: Machine,
    running: HashMap<NodeId, Running>,
    /// Nodes that wait for another run's lock, or for another try, and until when.
    later: Vec<(NodeId, Instant)>,
    /// How often a node found its key locked by another run.
    locked: HashMap<NodeId, u32>,
    /// By key of a node that has no result yet: others with the same key.
    twins: HashMap<Digest, Vec<NodeId>>,
    /// By node whose stored result turned out to be lost: those that need it again.
    lost: HashMap<NodeId, Vec<NodeId>>,
    failures: HashMap<NodeId, u32>,
    /// The first node that failed, where that ends the run.
    halted_by: Option<NodeId>,
}

struct Running {
    share: Share,
    cancel: Arc<Cancel>,
    since: Instant,
    /// The longest it may take.
    timeout: Option<Duration>,
    out_of_time: bool,
}

/// Whether a node's key is ours to compute.
enum Turn {
    Ours(Option<Claim>),
    Elsewhere,
}

impl<'a> Coordinator<'a> {
    /// A run of `plan` that has not begun.
    pub fn new(plan: &'a Plan, store: &'a Store, options: &'a Options<'a>) -> Coordinator<'a> {
        let graph = Graph::of(plan);
        let n = plan.nodes.len();
        let mut known = graph.roots();
        known.reserve(n - known.len());
        Coordinator {
            plan,
            store,
            options,
            graph,
            outcomes: vec![None; n],
            keys: vec![None; n],
            known,
            looked_up: 0,
            missed: Vec::new(),
            foretold: Vec::new(),
            ways: Vec::new(),
            waiting: Waiting::default(),
            machine: match options.remote {
                // A cluster has queues of its own.
                Some(_) => Machine::new(usize::MAX, u64::MAX),
                None => Machine::new(options.jobs, options.memory),
            },
            running: HashMap::new(),
            later: Vec::new(),
            locked: HashMap::new(),
            twins: HashMap::new(),
            lost: HashMap::new(),
            failures: HashMap::new(),
            halted_by: None,
        }
    }

    /// Settles every hit that can be known, and hands out work until nothing that is ready fits the machine.
    pub fn advance(&mut self, begin: &dyn Fn(Job)) {
        loop {
            self.look_up();
            self.queue();
            self.hand_out(begin);
            if self.looked_up == self.known.len() && self.missed.is_empty() {
                return;
            }
        }
    }

    /// Whether everything is settled.
    pub fn is_done(&self) -> bool {
        self.running.is_empty() && self.later.is_empty() && self.waiting.is_empty()
    }

    /// How long to wait for a worker before [`Coordinator::watch`] is called again.
    pub fn patience(&self) -> Duration {
        let now = Instant::now();
        self.later.iter().map(|(_, at)| at.saturating_duration_since(now)).fold(GLANCE, Duration::min)
    }

    fn look_up(&mut self) {
        while let Some(&id) = self.known.get(self.looked_up) {
            self.looked_up += 1;
            if self.options.cancel.is_set() {
                self.settle(id, Outcome::Cancelled);
            } else if let Some(blocked) = self.blocked(id) {
                self.settle(id, blocked);
            } else {
                let key = super::key(self.plan, id, &|n| self.output(n)).expect("every need has a result");
                self.keys[id] = Some(key);
                match self.found(id, key) {
                    Some(hit) => self.settle(id, hit),
                    None => self.miss(id, key),
                }
            }
        }
    }

    fn recipe(&self, id: NodeId) -> Recipe {
        recipe(self.plan, id, &|n| self.output(n)).expect("every need has a result")
    }

    fn output(&self, id: NodeId) -> Option<Digest> {
        self.outcomes[id].as_ref()?.entry().map(|e| e.output)
    }

    /// The result of a node, if the store has it whole.
    fn found(&self, id: NodeId, key: Digest) -> Option<Outcome> {
        match stored(self.store, key, self.plan.nodes[id].stage) {
            Found::Whole(entry) => Some(Outcome::Hit(entry)),
            Found::Damaged(output) => {
                // Reading it moves what is left of it aside.
                let _ = self.store.get(output);
                self.tell(id, What::Damaged);
                None
            }
            Found::Nothing => None,
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

    fn miss(&mut self, id: NodeId, key: Digest) {
        match self.twins.get_mut(&key) {
            Some(others) => others.push(id),
            None => {
                self.twins.insert(key, Vec::new());
                self.missed.push(id);
            }
        }
    }

    /// Queues what has to run, ranked by the longest way to the end.
    fn queue(&mut self) {
        if self.ways.is_empty() && !self.missed.is_empty() {
            self.foretold = foretell(self.plan, &self.outcomes, self.store);
            self.options.listener.outlook(self.plan, &self.foretold);
            self.ways = self.graph.longest_ways(&self.foretold);
        }
        for id in std::mem::take(&mut self.missed) {
            self.enqueue(id);
        }
    }

    fn enqueue(&mut self, id: NodeId) {
        let node = &self.plan.nodes[id];
        let needs = (node.stage.needs)(&node.params);
        let threads = self.options.remote.map_or(needs.threads, |remote| needs.threads.min(remote.profile.cores));
        self.waiting.push(id, self.ways[id], threads, self.machine.asked(needs.memory));
    }

    fn hand_out(&mut self, begin: &dyn Fn(Job)) {
        if self.is_over() {
            for id in self.waiting.drain() {
                self.abandon(id);
            }
        }
        while let Some((id, share)) = self.waiting.pop(&mut self.machine) {
            let key = self.keys[id].expect("it was looked up");
            let Turn::Ours(claim) = self.claim(key) else {
                self.machine.release(share);
                self.wait_for_other_run(id);
                continue;
            };
            // Another run may have made it since it was looked up.
            if let Some(hit) = self.found(id, key) {
                self.machine.release(share);
                self.resolve(id, hit);
                continue;
            }
            let cancel = Arc::new(Cancel::default());
            let (stage, cost) = (self.plan.nodes[id].stage, self.plan.nodes[id].cost);
            let (recipe, threads) = (self.recipe(id), share.threads);
            let (memory, foretold) = (share.memory, self.foretold[id]);
            let job = Job { id, stage, cost, recipe, key, threads, memory, foretold, cancel: cancel.clone(), claim };
            // A job sees to its own time, which begins when it does.
            let timeout = self.care(id).timeout.or(self.options.timeout).filter(|_| self.options.remote.is_none());
            self.running.insert(id, Running { share, cancel, since: Instant::now(), timeout, out_of_time: false });
            if self.options.remote.is_none() {
                self.tell(id, What::Started { threads, foretold });
            }
            begin(job);
        }
    }

    /// What the step of a node says of how it is run.
    fn care(&self, id: NodeId) -> Care {
        self.plan.steps[self.plan.nodes[id].step].care
    }

    fn is_over(&self) -> bool {
        self.options.cancel.is_set() || self.halted_by.is_some()
    }

    /// Settles a node that will not be begun.
    fn abandon(&mut self, id: NodeId) {
        let outcome = match self.halted_by {
            Some(first) if !self.options.cancel.is_set() => {
                let first = self.plan.label(first);
                Outcome::Skipped(format!("not begun, because {first} failed; --keep-going would go on"))
            }
            _ => Outcome::Cancelled,
        };
        self.resolve(id, outcome);
    }

    fn claim(&self, key: Digest) -> Turn {
        if self.options.remote.is_some() {
            // The job claims it.
            return Turn::Ours(None);
        }
        match self.store.claim(key) {
            Ok(Some(claim)) => Turn::Ours(Some(claim)),
            Ok(None) => Turn::Elsewhere,
            // No locks here: at worst two runs do the same.
            Err(_) => Turn::Ours(None),
        }
    }

    fn wait_for_other_run(&mut self, id: NodeId) {
        let times = self.locked.entry(id).or_insert(0);
        *times += 1;
        let pause = LOCKED * 2_u32.pow((*times - 1).min(5));
        if *times == 1 {
            self.tell(id, What::Waiting);
        }
        self.later.push((id, Instant::now() + pause));
    }

    /// Passes a request to stop on, ends what is out of time, and takes up again what was put off.
    pub fn watch(&mut self) {
        let stop = self.options.cancel.is_set();
        for running in self.running.values_mut() {
            let late = running.timeout.is_some_and(|limit| running.since.elapsed() > limit);
            if stop || late {
                running.out_of_time |= late && !running.cancel.is_set();
                running.cancel.set();
            }
        }
        let now = Instant::now();
        let over = self.is_over();
        for (id, at) in std::mem::take(&mut self.later) {
            if over {
                self.abandon(id);
            } else if at <= now {
                self.enqueue(id);
            } else {
                self.later.push((id, at));
            }
        }
    }

    /// Takes in what came of a job.
    pub fn finish(&mut self, id: NodeId, came: Came) {
        let Some(running) = self.running.remove(&id) else { return };
        self.machine.release(running.share);
        match came {
            Came::Made(entry) => self.resolve(id, Outcome::Ran(entry)),
            Came::Stopped if running.out_of_time => {
                let why = super::out_of_time(running.timeout.unwrap_or_default());
                self.fail(id, why);
            }
            Came::Stopped => self.resolve(id, Outcome::Cancelled),
            Came::Lost(digest) => self.remake(id, digest),
            Came::Failed { why, transient } => {
                let failed = self.failures.entry(id).or_insert(0);
                *failed += 1;
                let failed = *failed;
                let retry = self.care(id).retry.unwrap_or(self.options.retry);
                if transient && failed <= retry && !self.is_over() {
                    self.tell(id, What::Retrying { why, failed });
                    self.later.push((id, Instant::now() + FAILED * 2_u32.pow((failed - 1).min(6))));
                } else if retry > 0 && !transient {
                    self.fail(id, format!("{why} (not tried again: the same would come of it)"));
                } else {
                    self.fail(id, why);
                }
            }
        }
    }

    /// Has the need whose stored result was lost made again, and `id` after it.
    fn remake(&mut self, id: NodeId, digest: Digest) {
        let made_it = |need: &NodeId| {
            matches!(&self.outcomes[*need], Some(Outcome::Hit(entry)) if entry.output == digest)
                || self.lost.contains_key(need)
        };
        let Some(need) = self.plan.needs(id).find(made_it) else {
            self.fail(id, format!("its input {} was lost in the store, again", digest.short()));
            return;
        };
        let waiting = self.lost.entry(need).or_default();
        waiting.push(id);
        if waiting.len() == 1 {
            self.outcomes[need] = None;
            self.known.push(need);
        }
    }

    fn fail(&mut self, id: NodeId, why: String) {
        if !self.options.keep_going {
            self.halted_by.get_or_insert(id);
        }
        self.resolve(id, Outcome::Failed(why));
    }

    /// Settles a node that had no result, and those with the same key.
    fn resolve(&mut self, id: NodeId, outcome: Outcome) {
        let twins = self.keys[id].and_then(|key| self.twins.remove(&key)).unwrap_or_default();
        for twin in twins {
            let shared = match &outcome {
                Outcome::Ran(entry) => Outcome::Hit(*entry),
                other => other.clone(),
            };
            self.settle(twin, shared);
        }
        self.settle(id, outcome);
    }

    fn settle(&mut self, id: NodeId, outcome: Outcome) {
        self.tell(
            id,
            match &outcome {
                Outcome::Hit(_) => What::Hit,
                Outcome::Ran(entry) => What::Ran { seconds: (f64::from(entry.wall_s) * 1e6).round() * 1e-6 },
                Outcome::Failed(why) => What::Failed { why: why.clone() },
                Outcome::Skipped(why) => What::Skipped { why: why.clone() },
                Outcome::Cancelled => What::Cancelled,
            },
        );
        let whole = outcome.entry().is_some();
        self.outcomes[id] = Some(outcome);
        match self.lost.remove(&id) {
            Some(again) if whole => self.missed.extend(again),
            Some(again) => {
                for next in again {
                    let blocked = self.blocked(next).unwrap_or(Outcome::Cancelled);
                    self.resolve(next, blocked);
                }
            }
            None => self.graph.settle(id, |next| self.known.push(next)),
        }
    }

    fn tell(&self, node: NodeId, what: What) {
        self.options.listener.on(self.plan, &Event { node, what });
    }

    /// What came of the run. `hold` keeps the results in the store while the report is used.
    pub fn report(self, seconds: f64, hold: Option<InUse>) -> Report {
        let outcomes = self.outcomes.into_iter().map(|o| o.unwrap_or(Outcome::Cancelled)).collect();
        Report { outcomes, keys: self.keys, seconds, hold }
    }
}
