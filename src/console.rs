//! The only door to the screen while a study runs: bars on a terminal, plain lines elsewhere, JSON lines on request.
use crate::events::{Event, Line, Listener, NodeLine, What};
use crate::plan::{NodeId, Plan};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How to show a run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Bars that move.
    Bars,
    /// A line where something happens.
    Plain,
    /// A JSON object a line on standard output.
    Json,
    /// Failures and damage only.
    Quiet,
}

impl Mode {
    /// Bars where standard error is a terminal, else lines.
    pub fn detect() -> Mode {
        if std::io::stderr().is_terminal() { Mode::Bars } else { Mode::Plain }
    }
}

/// Plain lines about progress come no closer than this.
const QUIET_TIME: Duration = Duration::from_secs(5);

/// The words beside the bars are renewed no faster than this.
const REDRAW: Duration = Duration::from_millis(100);

/// Shows a run.
pub struct Console {
    mode: Mode,
    started: Instant,
    inner: Mutex<Inner>,
}

struct Inner {
    tally: Tally,
    bars: Option<Bars>,
    last_line: Instant,
}

impl Console {
    /// A console for a run of `plan` with `jobs` threads.
    pub fn new(mode: Mode, plan: &Plan, jobs: usize) -> Console {
        let now = Instant::now();
        let bars = (mode == Mode::Bars).then(|| Bars::new(plan.nodes.len()));
        let inner = Inner { tally: Tally::new(plan.nodes.len(), jobs), bars, last_line: now };
        Console { mode, started: now, inner: Mutex::new(inner) }
    }

    /// Clears the bars.
    pub fn finish(&self) {
        if let Some(bars) = &self.inner().bars {
            bars.total.finish_and_clear();
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn json(&self, plan: &Plan, event: &Event) {
        let (time, node) = (self.started.elapsed().as_secs_f64(), plan.label(event.node));
        json(&Line::Node(NodeLine { time, node: &node, what: &event.what }));
    }
}

/// Writes one line of `run --json`; whoever reads it may have gone.
pub fn json(line: &Line<'_>) {
    let text = serde_json::to_string(line).expect("events are plain data");
    say(format_args!("{text}"));
}

impl Listener for Console {
    fn on(&self, plan: &Plan, event: &Event) {
        match self.mode {
            Mode::Json => return self.json(plan, event),
            Mode::Quiet => {
                if let Some(text) = remark(plan, event) {
                    warn(format_args!("{text}"));
                }
                return;
            }
            Mode::Bars | Mode::Plain => {}
        }
        let mut inner = self.inner();
        let Inner { tally, bars, last_line } = &mut *inner;
        tally.note(plan, event);
        match bars {
            Some(bars) => {
                bars.note(plan, event, tally);
                if let Some(text) = remark(plan, event) {
                    let _ = bars.all.println(text);
                }
            }
            None => {
                if let Some(text) = line(plan, event, last_line.elapsed() >= QUIET_TIME) {
                    *last_line = Instant::now();
                    let elapsed = duration(self.started.elapsed().as_secs_f64());
                    let (settled, all, left) = (tally.settled, tally.is_settled.len(), duration(tally.left()));
                    warn(format_args!("[{settled}/{all}, {elapsed}, about {left} left] {text}"));
                }
            }
        }
    }

    fn outlook(&self, plan: &Plan, seconds: &[f64]) {
        self.inner().tally.outlook(plan, seconds);
    }
}

/// What must be said in every mode.
fn remark(plan: &Plan, event: &Event) -> Option<String> {
    let label = || plan.label(event.node);
    match &event.what {
        What::Failed { why } => Some(format!("FAILED {}: {why}", label())),
        What::Retrying { why, .. } => Some(format!("{} failed and will be tried again: {why}", label())),
        What::Delayed { why } => Some(format!("{why}; asking again, jobs go on")),
        What::Damaged => Some(format!("{}: its stored result is damaged or gone, computing it again", label())),
        _ => None,
    }
}

/// The plain line about an event, if it is worth one: short steps and progress only where nothing was said for long.
fn line(plan: &Plan, event: &Event, long_silent: bool) -> Option<String> {
    let label = || plan.label(event.node);
    match &event.what {
        What::Ran { seconds } if *seconds >= 1.0 => Some(format!("ran {} in {}", label(), duration(*seconds))),
        What::Ran { .. } if long_silent => Some(format!("ran {}", label())),
        What::Progress { share, doing } if long_silent => Some(format!("{}: {:.0} %, {doing}", label(), share * 100.0)),
        What::Queued { job } if long_silent => Some(format!("{}: queued as {job}", label())),
        What::Waiting => Some(format!("{}: waiting for another run, which computes it", label())),
        What::Resumed => Some(format!("{}: goes on from what was kept", label())),
        _ => remark(plan, event),
    }
}

/// What is done and what is left.
struct Tally {
    jobs: usize,
    /// By node.
    is_settled: Vec<bool>,
    settled: usize,
    /// Core-seconds foretold, by node; empty while nothing had to run.
    foretold: Vec<f64>,
    /// By stage: how far off one's foresight was says nothing of another's.
    stages: BTreeMap<&'static str, OfStage>,
    running: BTreeMap<NodeId, Running>,
}

/// Core-seconds of one stage.
#[derive(Default)]
struct OfStage {
    /// Foretold for nodes neither settled nor at work.
    open: f64,
    /// Foretold for nodes that ran.
    foretold: f64,
    /// What those took.
    took: f64,
}

impl OfStage {
    /// What was over what was foretold.
    fn scale(&self) -> f64 {
        if self.foretold > 0.0 { self.took / self.foretold } else { 1.0 }
    }
}

/// A node at work.
struct Running {
    since: Instant,
    stage: &'static str,
    threads: usize,
    foretold: f64,
    /// When it told of its progress first and last, and the shares done then.
    told: Option<[(Instant, f64); 2]>,
}

impl Running {
    /// Wall seconds left: by its progress so far once there is some, else by what was foretold.
    fn left(&self, scale: f64) -> f64 {
        if let Some([(first, from), (last, to)]) = self.told
            && to - from > 0.02
        {
            let pace = (last - first).as_secs_f64() / (to - from);
            return (pace * (1.0 - to) - last.elapsed().as_secs_f64()).max(0.0);
        }
        (self.foretold * scale / self.threads as f64 - self.since.elapsed().as_secs_f64()).max(0.0)
    }
}

impl Tally {
    fn new(nodes: usize, jobs: usize) -> Tally {
        let is_settled = vec![false; nodes];
        Tally { jobs, is_settled, settled: 0, foretold: Vec::new(), stages: BTreeMap::new(), running: BTreeMap::new() }
    }

    fn outlook(&mut self, plan: &Plan, seconds: &[f64]) {
        self.foretold = seconds.to_vec();
        for (node, seconds) in plan.nodes.iter().zip(seconds) {
            self.stages.entry(node.stage.name).or_default().open += seconds;
        }
    }

    fn foretold(&self, id: NodeId) -> f64 {
        self.foretold.get(id).copied().unwrap_or(0.0)
    }

    fn of_stage(&mut self, plan: &Plan, id: NodeId) -> &mut OfStage {
        self.stages.entry(plan.nodes[id].stage.name).or_default()
    }

    fn note(&mut self, plan: &Plan, event: &Event) {
        let id = event.node;
        let foretold = self.foretold(id);
        match &event.what {
            What::Started { threads, .. } => {
                self.of_stage(plan, id).open -= foretold;
                let (since, stage) = (Instant::now(), plan.nodes[id].stage.name);
                self.running.insert(id, Running { since, stage, threads: *threads, foretold, told: None });
            }
            What::Progress { share, .. } => {
                if let Some(running) = self.running.get_mut(&id) {
                    let now = (Instant::now(), *share);
                    running.told = Some([running.told.map_or(now, |[first, _]| first), now]);
                }
            }
            What::Retrying { .. } => {
                self.running.remove(&id);
                self.of_stage(plan, id).open += foretold;
            }
            What::Hit | What::Ran { .. } | What::Failed { .. } | What::Skipped { .. } | What::Cancelled => {
                self.settle(plan, event, foretold);
            }
            What::Damaged | What::Waiting | What::Resumed | What::Queued { .. } | What::Delayed { .. } => {}
        }
    }

    fn settle(&mut self, plan: &Plan, event: &Event, foretold: f64) {
        let id = event.node;
        match (self.running.remove(&id), &event.what) {
            (Some(running), What::Ran { seconds }) => {
                let stage = self.of_stage(plan, id);
                stage.foretold += foretold;
                stage.took += seconds * running.threads as f64;
            }
            (None, _) if foretold > 0.0 => self.of_stage(plan, id).open -= foretold,
            _ => {}
        }
        // A result that was lost in the store is settled twice.
        if !std::mem::replace(&mut self.is_settled[id], true) {
            self.settled += 1;
        }
    }

    /// Wall seconds left: what runs by its own progress, the rest as foretold, scaled by how that did so far.
    fn left(&self) -> f64 {
        let scale = |stage: &str| self.stages.get(stage).map_or(1.0, OfStage::scale);
        let running = || self.running.values().map(|r| (r.left(scale(r.stage)), r.threads as f64));
        let open: f64 = self.stages.values().map(|stage| stage.open.max(0.0) * stage.scale()).sum();
        let core_seconds = open + running().map(|(left, threads)| left * threads).sum::<f64>();
        running().map(|(left, _)| left).fold(core_seconds / self.jobs as f64, f64::max)
    }
}

/// The bars on a terminal: one for the run, one for each node at work.
struct Bars {
    all: MultiProgress,
    total: ProgressBar,
    running: BTreeMap<NodeId, ProgressBar>,
    drawn: Option<Instant>,
}

impl Bars {
    fn new(nodes: usize) -> Bars {
        let all = MultiProgress::new();
        let total = all.add(ProgressBar::new(nodes as u64));
        total.set_style(style("{bar:32} {pos}/{len} results  {elapsed}  {msg}"));
        Bars { all, total, running: BTreeMap::new(), drawn: None }
    }

    fn note(&mut self, plan: &Plan, event: &Event, tally: &Tally) {
        match &event.what {
            What::Started { .. } => {
                let bar = self.all.add(ProgressBar::new(1000));
                bar.set_style(style("  {bar:20} {msg}"));
                bar.set_message(plan.label(event.node));
                self.running.insert(event.node, bar);
            }
            What::Progress { share, doing } => {
                if let Some(bar) = self.running.get(&event.node) {
                    bar.set_position((share * 1000.0) as u64);
                    bar.set_message(format!("{}: {doing}", plan.label(event.node)));
                }
            }
            What::Waiting => self.total.println(line(plan, event, true).unwrap_or_default()),
            What::Resumed | What::Damaged | What::Queued { .. } | What::Delayed { .. } => {}
            _ => {
                if let Some(bar) = self.running.remove(&event.node) {
                    bar.finish_and_clear();
                    self.all.remove(&bar);
                }
            }
        }
        if self.drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW) {
            self.drawn = Some(Instant::now());
            self.total.set_position(tally.settled as u64);
            self.total.set_message(format!("about {} left", duration(tally.left())));
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Writes a line to standard output; whoever reads it may have gone.
pub fn say(text: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Writes a line to standard error; whoever reads it may have gone.
pub fn warn(text: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// `4.2 s`, `3 min 12 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    // The sum of no times is -0, and would be shown as such.
    let seconds = seconds.max(0.0) + 0.0;
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 10.0 => format!("{seconds:.1} s"),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
