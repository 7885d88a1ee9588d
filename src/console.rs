//! The only door to the screen while a study runs: bars on a terminal, plain lines elsewhere, JSON lines on request.
use crate::events::{Event, Listener};
use crate::plan::{NodeId, Plan};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::Instant;

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

/// Shows a run.
pub struct Console {
    mode: Mode,
    inner: Mutex<Inner>,
}

struct Inner {
    started: Instant,
    bars: MultiProgress,
    total: ProgressBar,
    running: BTreeMap<NodeId, Running>,
    /// Nodes settled, those from the store, predicted core-seconds not begun, predicted and real seconds of the work done.
    settled: usize,
    hits: usize,
    open_cost: f64,
    worked_cost: f64,
    worked_seconds: f64,
    jobs: usize,
    last_line: Instant,
}

/// A node at work.
struct Running {
    bar: ProgressBar,
    since: Instant,
    share: f64,
    cost: f64,
}

impl Running {
    /// Wall seconds left: by the share done once there is one, else by the prediction.
    fn left(&self, scale: f64) -> f64 {
        let gone = self.since.elapsed().as_secs_f64();
        if self.share > 0.02 { gone * (1.0 - self.share) / self.share } else { (self.cost * scale - gone).max(0.0) }
    }
}

impl Console {
    /// A console for a run of `plan` with `jobs` workers.
    pub fn new(mode: Mode, plan: &Plan, jobs: usize) -> Console {
        let bars = MultiProgress::new();
        if mode != Mode::Bars {
            bars.set_draw_target(indicatif::ProgressDrawTarget::hidden());
        }
        let total = bars.add(ProgressBar::new(plan.nodes.len() as u64));
        total.set_style(style("{bar:32} {pos}/{len} results  {elapsed}  {msg}"));
        let now = Instant::now();
        let inner = Inner {
            started: now,
            bars,
            total,
            running: BTreeMap::new(),
            settled: 0,
            hits: 0,
            open_cost: plan.nodes.iter().map(|n| n.cost).sum(),
            worked_cost: 0.0,
            worked_seconds: 0.0,
            jobs,
            last_line: now,
        };
        Console { mode, inner: Mutex::new(inner) }
    }

    /// Clears the bars.
    pub fn finish(&self) {
        if let Ok(inner) = self.inner.lock() {
            inner.total.finish_and_clear();
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Inner {
    /// Wall seconds left: what runs by its own progress, the rest by prediction, scaled by how predictions did so far.
    fn left(&self) -> f64 {
        let scale = if self.worked_cost > 0.0 { self.worked_seconds / self.worked_cost } else { 1.0 };
        let running: Vec<f64> = self.running.values().map(|r| r.left(scale)).collect();
        let all = self.open_cost.max(0.0) * scale + running.iter().sum::<f64>();
        running.into_iter().fold(all / self.jobs as f64, f64::max)
    }

    fn note(&mut self, plan: &Plan, event: &Event) {
        let id = event.node();
        let cost = plan.nodes[id].cost;
        match event {
            Event::Damaged { .. } => {}
            Event::Started { .. } => {
                let bar = self.bars.add(ProgressBar::new(1000));
                bar.set_style(style("  {bar:20} {msg}"));
                bar.set_message(plan.label(id));
                self.open_cost -= cost;
                self.running.insert(id, Running { bar, since: Instant::now(), share: 0.0, cost });
            }
            Event::Progress { share, doing, .. } => {
                if let Some(running) = self.running.get_mut(&id) {
                    running.bar.set_position((share * 1000.0) as u64);
                    running.bar.set_message(format!("{}: {doing}", plan.label(id)));
                    running.share = *share;
                }
            }
            Event::Hit { .. }
            | Event::Ran { .. }
            | Event::Failed { .. }
            | Event::Skipped { .. }
            | Event::Cancelled { .. } => {
                match self.running.remove(&id) {
                    Some(running) => {
                        running.bar.finish_and_clear();
                        self.bars.remove(&running.bar);
                    }
                    None => self.open_cost -= cost,
                }
                self.settled += 1;
                self.hits += usize::from(matches!(event, Event::Hit { .. }));
                if let Event::Ran { seconds, .. } = event {
                    self.worked_cost += cost;
                    self.worked_seconds += seconds;
                }
                self.total.set_position(self.settled as u64);
            }
        }
        self.total.set_message(format!("about {} left", duration(self.left())));
    }

    fn line(&mut self, plan: &Plan, event: &Event) -> Option<String> {
        let label = plan.label(event.node());
        let text = match event {
            Event::Failed { .. } | Event::Damaged { .. } => return remark(plan, event),
            Event::Ran { seconds, .. } if *seconds >= 1.0 => format!("ran {label} in {}", duration(*seconds)),
            Event::Ran { .. } | Event::Progress { .. } if self.last_line.elapsed().as_secs() >= 5 => match event {
                Event::Progress { share, doing, .. } => format!("{label}: {:.0} %, {doing}", share * 100.0),
                _ => format!("ran {label}"),
            },
            _ => return None,
        };
        self.last_line = Instant::now();
        let (settled, all) = (self.settled, plan.nodes.len());
        Some(format!(
            "[{settled}/{all}, {}, {} left] {text}",
            duration(self.started.elapsed().as_secs_f64()),
            duration(self.left())
        ))
    }
}

impl Listener for Console {
    fn on(&self, plan: &Plan, event: &Event) {
        let Ok(mut inner) = self.inner.lock() else { return };
        inner.note(plan, event);
        match self.mode {
            Mode::Json => {
                let mut json = serde_json::to_value(event).unwrap_or_default();
                json["node"] = plan.label(event.node()).into();
                let _ = writeln!(std::io::stdout(), "{json}");
            }
            Mode::Bars => {
                if let Some(text) = remark(plan, event) {
                    let _ = inner.bars.println(text);
                }
            }
            Mode::Plain => {
                if let Some(line) = inner.line(plan, event) {
                    let _ = writeln!(std::io::stderr(), "{line}");
                }
            }
            Mode::Quiet => {
                if let Some(text) = remark(plan, event) {
                    let _ = writeln!(std::io::stderr(), "{text}");
                }
            }
        }
    }
}

/// What must be said in every mode.
fn remark(plan: &Plan, event: &Event) -> Option<String> {
    let label = plan.label(event.node());
    match event {
        Event::Failed { why, .. } => Some(format!("FAILED {label}: {why}")),
        Event::Damaged { .. } => Some(format!("{label}: its stored result is damaged or gone, computing it again")),
        _ => None,
    }
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
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 10.0 => format!("{seconds:.1} s"),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
