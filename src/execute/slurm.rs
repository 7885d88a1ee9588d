//! Nodes as jobs of a Slurm cluster: short ones packed into one job, all that are ready at once into one array.
//!
//! - `slurm/batch.rs` what was submitted: one file a submission in the store's `slurm/`, for whoever comes later
//! - `slurm/commands.rs` `sbatch`, `squeue`, `scancel`
//!
//! A job runs `hvi-flow exec` on the same store. Done means that the result is in the store; a failure is a note beside the
//! batches. What `squeue` says is a hint: no answer means "ask again"; a job that it names no longer, three times, and that
//! left no result, is submitted again, and goes on from its checkpoint. A submission has a name of its own, chosen before
//! `sbatch` is called, so that one that was cut off is found again by its name. Ctrl-C leaves jobs alone; a later run finds
//! them in the batches and waits for them.
use super::worker::{Came, Job};
use super::{Options, Remote, put_files, stored};
use crate::events::{Event, What};
use crate::pipeline::Profile;
use crate::plan::{NodeId, Plan};
use hvi_cache::Found;
use hvi_kit::{Digest, Store};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::time::{Duration, Instant};

pub mod batch;
mod commands;
use batch::{Batch, Note, Work};
use commands::{Alive, Submitted};
pub use commands::{cancel, version};

/// Pauses between two looks into the store; the longer nothing came, the longer.
const LOOK: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));

/// Pauses between two questions to `squeue`.
const ASK: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(10));

/// Answers without a job after which it counts as gone.
const UNSEEN: u32 = 3;

/// Jobs that may end without a result and without progress before their node counts as failed.
const MOST_TRIES: u32 = 3;

/// Who waits for what of a cluster.
pub struct Cluster<'a> {
    plan: &'a Plan,
    store: &'a Store,
    options: &'a Options<'a>,
    profile: &'a Profile,
    /// Most cores of a machine there.
    most_cores: usize,
    study: &'a str,
    /// Handed out by the coordinator, not yet submitted.
    begun: RefCell<Vec<Job>>,
    /// By key: what is waited for.
    out: BTreeMap<Digest, Out>,
    /// Tasks that ended without a result: nobody need wait for them.
    gone: HashSet<(String, usize)>,
    look: (Instant, Duration),
    ask: (Instant, Duration),
    /// Whether it was said that Slurm doesn't answer.
    is_silent: bool,
    /// Whether it was said that it starts no job.
    is_stuck: bool,
}

/// A node that a job computes.
struct Out {
    job: Job,
    batch: String,
    task: usize,
    /// Answers since it was last seen.
    unseen: u32,
    /// Jobs that ended without a result while it was their turn, and without progress.
    tries: u32,
    /// What its checkpoint was when it was last submitted.
    kept: Option<i64>,
}

impl<'a> Cluster<'a> {
    /// A cluster that has no work of this run yet.
    pub fn new(plan: &'a Plan, store: &'a Store, options: &'a Options<'a>, remote: Remote<'a>) -> Cluster<'a> {
        let now = Instant::now();
        Cluster {
            plan,
            store,
            options,
            profile: remote.profile,
            most_cores: commands::most_cores(remote.profile).unwrap_or(usize::MAX),
            study: remote.study,
            begun: RefCell::default(),
            out: BTreeMap::new(),
            gone: HashSet::new(),
            look: (now, LOOK.0),
            ask: (now, ASK.0),
            is_silent: false,
            is_stuck: false,
        }
    }

    /// Takes a node to be computed; it is submitted with all that are taken before the next [`Cluster::wait`].
    pub fn take(&self, job: Job) {
        self.begun.borrow_mut().push(job);
    }

    /// Submits what was taken, then waits for results, `patience` at most.
    pub fn wait(&mut self, patience: Duration) -> Vec<(NodeId, Came)> {
        if self.options.cancel.is_set() {
            let waiting = std::mem::take(&mut self.out).into_values().map(|out| out.job);
            return self.begun.take().into_iter().chain(waiting).map(|job| (job.id, Came::Stopped)).collect();
        }
        let mut came = self.submit();
        if came.is_empty() {
            let due = self.look.0.min(self.ask.0).saturating_duration_since(Instant::now());
            std::thread::sleep(due.min(patience));
            came = self.look();
            self.ask(&mut came);
        }
        came
    }

    // --- Submitting ---

    /// Submits what was taken, but for what a job computes already. What can't be submitted failed.
    fn submit(&mut self) -> Vec<(NodeId, Came)> {
        let (mut ready, mut came) = (Vec::new(), Vec::new());
        for job in self.begun.take() {
            let prepared = put_files(self.plan, job.id, self.store).and_then(|()| self.store.ask(&job.recipe));
            match prepared {
                Ok(()) => ready.push((job, 0)),
                Err(e) => came.push((job.id, Came::Failed { why: e.to_string(), transient: true })),
            }
        }
        came.extend(self.send(ready));
        came
    }

    /// Submits jobs that were submitted in vain so many times.
    fn send(&mut self, jobs: Vec<(Job, u32)>) -> Vec<(NodeId, Came)> {
        if jobs.is_empty() {
            return Vec::new();
        }
        // Two runs that submit at once: the second one finds what the first one did.
        let _turn = self.turn();
        let under_way = self.under_way();
        let mut ready = Vec::new();
        for (job, tries) in jobs {
            match under_way.get(&job.key) {
                Some((batch, task)) => self.expect(job, tries, batch.clone(), *task),
                None => ready.push((job, tries)),
            }
        }
        let mut came = Vec::new();
        for (needs, jobs) in by_needs(ready, self.profile, self.most_cores) {
            for array in pack(jobs, self.profile) {
                came.extend(self.send_array(needs, array));
            }
        }
        let now = Instant::now();
        (self.look, self.ask) = ((now + LOOK.0, LOOK.0), (now + ASK.0, ASK.0));
        came
    }

    /// The right to submit, where the store has locks.
    fn turn(&self) -> Option<hvi_cache::Claim> {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(30) {
            match self.store.claim(Digest::of(b"who submits to Slurm")) {
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                Ok(claim) => return claim,
                Err(_) => return None,
            }
        }
        None
    }

    /// Batch and task of each key that some job may compute.
    fn under_way(&self) -> HashMap<Digest, (String, usize)> {
        let (mut all, notes) = (HashMap::new(), batch::notes(self.store));
        for (name, batch) in batch::all(self.store) {
            for (task, works) in batch.tasks.iter().enumerate() {
                if !self.gone.contains(&(name.clone(), task)) {
                    let open = works.iter().filter(|work| !notes.contains(&work.key));
                    all.extend(open.map(|work| (work.key, (name.clone(), task))));
                }
            }
        }
        all
    }

    fn expect(&mut self, job: Job, tries: u32, batch: String, task: usize) {
        let kept = self.store.partial_mark(job.key);
        self.tell(job.id, What::Queued { job: commands::job_name(&batch, task) });
        self.out.insert(job.key, Out { job, batch, task, unseen: 0, tries, kept });
    }

    fn send_array(&mut self, needs: Needs, array: Vec<Vec<(Job, u32)>>) -> Vec<(NodeId, Came)> {
        let work = |(job, _): &(Job, u32)| {
            let timeout = self.plan.steps[self.plan.nodes[job.id].step].care.timeout.or(self.options.timeout);
            Work { key: job.key, cost: job.cost, timeout_s: timeout.map(|t| t.as_secs_f64()) }
        };
        let batch = Batch {
            study: self.study.into(),
            threads: needs.threads,
            checkpoint_s: self.options.checkpoint.as_secs_f64(),
            tasks: array.iter().map(|task| task.iter().map(work).collect()).collect(),
        };
        for work in batch.tasks.iter().flatten() {
            batch::forget(self.store, work.key);
        }
        let refused = |why: String, transient| {
            let failed = |(job, _): &(Job, u32)| (job.id, Came::Failed { why: why.clone(), transient });
            array.iter().flatten().map(failed).collect()
        };
        let name = match batch.publish(self.store) {
            Ok(name) => name,
            Err(e) => return refused(format!("{}: {e}", self.store.folder().display()), true),
        };
        match commands::submit(self.store, &name, &batch, needs, self.profile) {
            Submitted::Yes => {}
            // It may have arrived: what `squeue` says will tell.
            Submitted::Unsure(why) => self.silent(array[0][0].0.id, why),
            Submitted::No(why) => {
                batch::remove(self.store, &name);
                return refused(why, false);
            }
        }
        for (task, jobs) in array.into_iter().enumerate() {
            jobs.into_iter().for_each(|(job, tries)| self.expect(job, tries, name.clone(), task));
        }
        Vec::new()
    }

    // --- Waiting ---

    /// Results and notes in the store, when it is time to look.
    fn look(&mut self) -> Vec<(NodeId, Came)> {
        if Instant::now() < self.look.0 {
            return Vec::new();
        }
        let notes = batch::notes(self.store);
        let mut came = Vec::new();
        for (key, out) in &self.out {
            if let Found::Whole(entry) = stored(self.store, *key, out.job.stage) {
                came.push((*key, Came::Made(entry)));
            } else if notes.contains(key)
                && let Some(note) = Note::read(self.store, *key)
            {
                came.push((*key, note.came()));
            }
        }
        let pause = if came.is_empty() { (self.look.1 * 2).min(LOOK.1) } else { LOOK.0 };
        self.look = (Instant::now() + pause, pause);
        let taken: Vec<(Out, Came)> =
            came.into_iter().filter_map(|(key, came)| Some((self.out.remove(&key)?, came))).collect();
        let batches: BTreeSet<String> = taken.iter().map(|(out, _)| out.batch.clone()).collect();
        batches.iter().for_each(|name| self.tidy(name));
        taken.into_iter().map(|(out, came)| (out.job.id, came)).collect()
    }

    /// Removes a batch of which nothing is left to wait for.
    fn tidy(&self, name: &str) {
        if self.out.values().any(|out| out.batch == name) {
            return;
        }
        let notes = batch::notes(self.store);
        let is_done = |work: &Work| notes.contains(&work.key) || self.store.lookup(work.key).is_some();
        let Some(batch) = Batch::read(self.store, name) else { return };
        if batch.tasks.iter().flatten().all(is_done) {
            if self.gone.iter().any(|(gone, _)| gone == name) {
                // A job that was taken for lost may only have been slow to be listed: nobody needs it now.
                let _ = commands::cancel(name);
            }
            batch::remove(self.store, name);
        }
    }

    /// Asks `squeue`, when it is time to; sees to what is gone.
    fn ask(&mut self, came: &mut Vec<(NodeId, Came)>) {
        if Instant::now() < self.ask.0 || self.out.is_empty() {
            return;
        }
        let pause = (self.ask.1 * 2).min(ASK.1);
        self.ask = (Instant::now() + pause, pause);
        let alive = match commands::alive() {
            Alive::Jobs(alive, why) => {
                self.waits(why);
                alive
            }
            Alive::Unknown(why) => {
                let first = self.out.values().next().map(|out| out.job.id);
                return first.map_or((), |id| self.silent(id, why));
            }
        };
        self.is_silent = false;
        let mut gone = Vec::new();
        for (key, out) in &mut self.out {
            out.unseen = if alive.contains(&(out.batch.clone(), out.task)) { 0 } else { out.unseen + 1 };
            if out.unseen >= UNSEEN {
                gone.push(*key);
            } else if out.unseen > 0 {
                self.ask = (Instant::now() + ASK.0, ASK.0);
            }
        }
        let mut again = Vec::new();
        // A job computes its keys in order: the first one without a result is the one that it ended with.
        let mut ended_with: HashSet<(String, usize)> = HashSet::new();
        for key in self.in_order(gone) {
            let Some(out) = self.out.remove(&key) else { continue };
            let id = out.job.id;
            if let Found::Whole(entry) = stored(self.store, key, out.job.stage) {
                came.push((id, Came::Made(entry)));
                continue;
            }
            let task = (out.batch.clone(), out.task);
            let was_its_turn = ended_with.insert(task.clone());
            self.gone.insert(task);
            let is_stuck = was_its_turn && self.store.partial_mark(key) == out.kept;
            let tries = if is_stuck { out.tries + 1 } else { out.tries };
            if tries < MOST_TRIES {
                again.push((out.job, tries));
            } else {
                let log = batch::log(self.store, &out.batch, out.task);
                let last = batch::last_line(&log);
                let why = format!(
                    "its Slurm job ended {tries} times without a result: out of time, out of memory, or a broken machine; \
                     {}{last}",
                    log.display()
                );
                let failed = Came::Failed { why, transient: false };
                if let Some(note) = Note::of(&failed) {
                    // Says to other runs that wait for it, and to later ones, that no job computes it.
                    let _ = note.publish(self.store, key);
                }
                self.tidy(&out.batch);
                came.push((id, failed));
            }
        }
        came.extend(self.send(again));
    }

    /// Keys in the order in which their jobs compute them.
    fn in_order(&self, keys: Vec<Digest>) -> Vec<Digest> {
        let wanted: HashSet<Digest> = keys.iter().copied().collect();
        let names: BTreeSet<&String> = keys.iter().filter_map(|key| Some(&self.out.get(key)?.batch)).collect();
        let batches = names.into_iter().filter_map(|name| Batch::read(self.store, name));
        let mut ordered: Vec<Digest> = batches
            .flat_map(|batch| batch.tasks)
            .flatten()
            .map(|work| work.key)
            .filter(|k| wanted.contains(k))
            .collect();
        let known: HashSet<Digest> = ordered.iter().copied().collect();
        ordered.extend(keys.into_iter().filter(|key| !known.contains(key)));
        ordered
    }

    /// Says once why the cluster starts no job: it is for people to see to.
    fn waits(&mut self, why: Option<String>) {
        let was_stuck = std::mem::replace(&mut self.is_stuck, why.is_some());
        if let (false, Some(why), Some(out)) = (was_stuck, why, self.out.values().next()) {
            let why = format!("Slurm starts none of the jobs: {why}; `sinfo --list-reasons` says more");
            self.tell(out.job.id, What::Delayed { why });
        }
    }

    fn silent(&mut self, id: NodeId, why: String) {
        if !std::mem::replace(&mut self.is_silent, true) {
            self.tell(id, What::Delayed { why });
        }
    }

    fn tell(&self, node: NodeId, what: What) {
        self.options.listener.on(self.plan, &Event { node, what });
    }
}

/// What a job asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Needs {
    threads: usize,
    memory: u64,
}

/// Jobs that ask for the same.
fn by_needs(jobs: Vec<(Job, u32)>, profile: &Profile, most_cores: usize) -> BTreeMap<Needs, Vec<(Job, u32)>> {
    let mut all: BTreeMap<Needs, Vec<(Job, u32)>> = BTreeMap::new();
    for (job, tries) in jobs {
        // What the program itself takes, and a quarter more than was foretold: a job that asks for too little is killed.
        let memory = (job.memory + job.memory / 4 + (128 << 20)).max(profile.memory);
        all.entry(Needs { threads: job.threads.min(most_cores), memory }).or_default().push((job, tries));
    }
    all
}

/// Jobs in arrays of tasks of nodes, no task foretold to take longer than the profile says, but for single nodes.
fn pack(jobs: Vec<(Job, u32)>, profile: &Profile) -> Vec<Vec<Vec<(Job, u32)>>> {
    let most = profile.pack.as_secs_f64();
    let (mut arrays, mut tasks, mut task) = (Vec::new(), Vec::new(), Vec::new());
    let mut sum = 0.0;
    for (job, tries) in jobs {
        let seconds = job.foretold / job.threads as f64;
        if !task.is_empty() && sum + seconds > most {
            tasks.push(std::mem::take(&mut task));
            sum = 0.0;
        }
        if tasks.len() == profile.array {
            arrays.push(std::mem::take(&mut tasks));
        }
        sum += seconds;
        task.push((job, tries));
    }
    if !task.is_empty() {
        tasks.push(task);
    }
    if !tasks.is_empty() {
        arrays.push(tasks);
    }
    arrays
}
