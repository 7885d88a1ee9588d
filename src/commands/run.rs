//! `run`: computes what a pipeline needs and isn't in the store, and writes its report.
use super::{Done, OutArgs, Stop, StudyArgs};
use crate::console::{self, Console, Mode, duration, warn};
use crate::events::{Line, Listener, RunLine};
use crate::execute::{self, Options, Outcome, Remote, Report};
use crate::history::Last;
use crate::pipeline::{self, Executor, Pipeline};
use crate::plan::Plan;
use crate::watch::Watch;
use crate::{amount, forecast, history, outputs, registry, report, unchanged};
use hvi_kit::{Cancel, Store};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// What `run` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub(super) study: StudyArgs,
    #[command(flatten)]
    pub(super) out: OutArgs,
    /// Only these steps and what they need
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
    /// Threads at work at once [default: one a core]
    #[arg(long, short, value_parser = clap::value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// After a failure, still begin what doesn't need what failed
    #[arg(long, short)]
    keep_going: bool,
    /// Try again so often what failed for a reason that may pass: files, programs outside; never the physics. What a step
    /// says in its own `retry` goes before [default: `retry` in [run], else 0]
    #[arg(long, value_name = "TIMES", value_parser = clap::value_parser!(u32).range(0..=100))]
    retry: Option<u32>,
    /// The longest one node may take, such as 90s, 10min or 2h: it is stopped, and what it kept lets it go on later. What a
    /// step says in its own `timeout` goes before [default: `timeout` in [run], else no limit]
    #[arg(long, value_name = "TIME", value_parser = amount::time)]
    timeout: Option<Duration>,
    /// How long a node goes on before it keeps what it needs to go on from there
    #[arg(long, value_name = "TIME", value_parser = amount::time, default_value = "10s")]
    checkpoint: Duration,
    /// Where nodes are computed [default: `executor` in [run], else local]
    #[arg(long, value_name = "WHERE", value_enum)]
    executor: Option<Executor>,
    /// One JSON object a line on standard output for everything that happens
    #[arg(long)]
    json: bool,
    /// Show failures and the result only
    #[arg(long, short)]
    quiet: bool,
    /// Show the report in a browser while the study runs: says its address, which is this machine's alone
    #[arg(long)]
    watch: bool,
}

impl Args {
    pub(super) fn options<'a>(
        &self,
        pipeline: &'a Pipeline,
        jobs: usize,
        cancel: &'a Cancel,
        listener: &'a dyn Listener,
    ) -> Options<'a> {
        let usual = Options::new(jobs, cancel, listener);
        Options {
            memory: pipeline.settings.memory.unwrap_or(usual.memory),
            keep_going: self.keep_going,
            retry: self.retry.or(pipeline.settings.retry).unwrap_or(0),
            timeout: self.timeout.or(pipeline.settings.timeout),
            checkpoint: self.checkpoint,
            remote: self
                .is_remote(pipeline)
                .then_some(Remote { study: &pipeline.name, profile: &pipeline.settings.slurm }),
            ..usual
        }
    }

    /// Threads at work at once.
    pub(super) fn jobs(&self, pipeline: &Pipeline) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.jobs.map(usize::from).or(pipeline.settings.jobs).unwrap_or_else(cores).max(1)
    }

    /// Whether the run is one of all of the study, on this machine.
    fn is_plain(&self, pipeline: &Pipeline) -> bool {
        self.only.is_empty() && !self.is_remote(pipeline)
    }

    /// What a run says that has nothing to do, where that is known without a plan.
    fn unchanged(&self) -> Option<String> {
        if !self.only.is_empty() || self.executor.is_some() || self.watch {
            return None;
        }
        let (start, name) = (Instant::now(), pipeline::name(&self.study.pipeline));
        let (folder, store) = (self.out.folder_of(&name), self.study.store().ok()?);
        let hits = unchanged::nodes(&self.study.pipeline, &self.study.set, &folder, &store)?;
        let counts = Counts { hits, ..Counts::default() };
        Some(counts.said(&name, start.elapsed().as_secs_f64(), &outputs::page(&folder)))
    }

    fn is_remote(&self, pipeline: &Pipeline) -> bool {
        self.executor.or(pipeline.settings.executor) == Some(Executor::Slurm)
    }
}

/// Runs the study.
///
/// # Errors
/// [`Stop`] where the pipeline is wrong, or the store or the results can't be written.
pub fn run(args: &Args) -> Done {
    let mode = match (args.json, args.quiet) {
        (true, _) => Mode::Json,
        (false, true) => Mode::Quiet,
        (false, false) => Mode::detect(),
    };
    if mode != Mode::Json
        && let Some(said) = args.unchanged()
    {
        warn(format_args!("{said}"));
        return Ok(ExitCode::SUCCESS);
    }
    let (pipeline, plan) = args.study.read(&args.only)?;
    pipeline.remarks.iter().for_each(|text| warn(format_args!("{text}")));
    let folder = args.out.folder(&pipeline);
    outputs::claim(&pipeline, &folder)?;
    let store = args.study.store()?;
    if args.is_remote(&pipeline) {
        execute::slurm::version().map_err(Stop::Machine)?;
    }
    let jobs = args.jobs(&pipeline);
    let cancel = stop_on_interrupt();
    quiet_workers();
    let console = Console::new(mode, &plan, jobs);
    if mode == Mode::Json {
        console::json(&Line::Run(RunLine::Began { study: &pipeline.name, nodes: plan.nodes.len(), jobs }));
    }
    let watch = args.watch.then(|| Watch::open(&console)).transpose();
    let watch = watch.map_err(|e| Stop::Machine(format!("can't open an address for --watch: {e}")))?;
    let listener: &dyn Listener = watch.as_ref().map_or(&console, |w| w);
    let options = args.options(&pipeline, jobs, cancel, listener);
    let write = |report: &Report| {
        console.finish();
        store.notices().iter().for_each(|text| warn(format_args!("{text}")));
        outputs::write(&pipeline, &plan, report, &store, &folder)
            .map_err(|e| Stop::Machine(format!("can't write results to {}: {e}", folder.display())))
    };
    let title = outputs::Title::of(&pipeline);
    let page = || {
        let last = Last::of(&store, &title.name);
        let found = forecast::report(&forecast::forecast(&plan, &store, &last));
        report::render_live(&outputs::study(&title, &plan, &found, &store).0)
    };
    let mut report = std::thread::scope(|scope| {
        if let Some(watch) = &watch {
            warn(format_args!("watch it at {}", watch.url()));
            scope.spawn(|| watch.serve(&plan, &page));
        }
        let report = execute::execute(&plan, &store, &options);
        watch.iter().for_each(Watch::end);
        report
    })?;
    let mut written = write(&report)?;
    if !written.unreadable.is_empty() {
        // What was damaged has been moved aside by now: the same run makes it again.
        report = execute::execute(&plan, &store, &options)?.after(&report);
        written = write(&report)?;
    }
    note(&store, &pipeline, &plan, &report);
    pipeline.chosen.iter().for_each(|choice| warn(format_args!("{}", choice.compared(&plan, &report))));
    let counts = Counts::of(&report);
    match mode {
        Mode::Json => console::json(&Line::Run(counts.line(report.seconds))),
        _ => warn(format_args!("{}", counts.said(&pipeline.name, report.seconds, &written.page))),
    }
    if args.is_plain(&pipeline) {
        unchanged::note(&pipeline, &args.study.set, &plan, &report, &store, &folder, &written);
    }
    if counts.cancelled > 0 {
        warn(format_args!("stopped: what was finished is kept, the same command goes on from there"));
        if args.is_remote(&pipeline) {
            let path = pipeline.path.display();
            warn(format_args!(
                "jobs go on: the same command waits for them again; to end them: hvi-flow cancel {path}"
            ));
        }
        return Ok(ExitCode::from(130));
    }
    for unreadable in &written.unreadable {
        warn(format_args!("{unreadable}"));
    }
    // The program ends here: to take a great plan apart piece by piece would only cost time.
    std::mem::forget((pipeline, plan));
    Ok(ExitCode::from(u8::from(counts.failed > 0 || !written.unreadable.is_empty())))
}

/// Appends to the history; a run that made nothing new works on a store that can't be written, and says nothing.
fn note(store: &Store, pipeline: &Pipeline, plan: &Plan, report: &Report) {
    if let Err(e) = history::append(store, pipeline, plan, report)
        && report.outcomes.iter().any(|o| matches!(o, Outcome::Ran(_)))
    {
        warn(format_args!("the run is not in the history, {} can't be written: {e}", store.folder().display()));
    }
}

/// The flag that Ctrl-C sets; a second Ctrl-C ends the program at once.
pub fn stop_on_interrupt() -> &'static Cancel {
    static CANCEL: std::sync::OnceLock<Cancel> = std::sync::OnceLock::new();
    let cancel = CANCEL.get_or_init(Cancel::default);
    let _ = ctrlc::set_handler(|| {
        let cancel = CANCEL.get_or_init(Cancel::default);
        if cancel.is_set() {
            std::process::exit(130);
        }
        warn(format_args!("stopping at the next step of what is running; again to stop at once"));
        cancel.set();
    });
    cancel
}

/// A panic on a worker is reported as its node's failure, one over a result that is shown as that result's: nothing is printed for it.
pub fn quiet_workers() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some(execute::WORKER) && !registry::shows() {
            usual(info);
        }
    }));
}

#[derive(Default)]
struct Counts {
    hits: usize,
    ran: usize,
    failed: usize,
    skipped: usize,
    cancelled: usize,
}
impl Counts {
    fn of(report: &Report) -> Counts {
        let mut c = Counts::default();
        for outcome in &report.outcomes {
            *match outcome {
                Outcome::Hit(_) => &mut c.hits,
                Outcome::Ran(_) => &mut c.ran,
                Outcome::Failed(_) => &mut c.failed,
                Outcome::Skipped(_) => &mut c.skipped,
                Outcome::Cancelled => &mut c.cancelled,
            } += 1;
        }
        c
    }

    fn said(&self, study: &str, seconds: f64, page: &Path) -> String {
        format!("{study}: {self} in {}; {}", duration(seconds), page.display())
    }

    fn line(&self, time: f64) -> RunLine<'static> {
        let Counts { hits, ran, failed, skipped, cancelled } = *self;
        RunLine::Ended { time, hits, ran, failed, skipped, cancelled }
    }
}
impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} from the store, {} computed", self.hits, self.ran)?;
        let rest = [("failed", self.failed), ("skipped", self.skipped), ("stopped", self.cancelled)];
        rest.iter().filter(|(_, n)| *n > 0).try_for_each(|(what, n)| write!(f, ", {n} {what}"))
    }
}
