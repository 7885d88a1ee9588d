//! The command line: what each command does, in words a user reads with `--help`.
use crate::console::{Console, Mode, duration, say, warn};
use crate::execute::{self, Options, Outcome, Report, Stored};
use crate::mistake::Mistake;
use crate::pipeline::{self, Pipeline};
use crate::plan::{self, NodeId, Plan};
use crate::{outputs, registry};
use clap::{Parser, Subcommand};
use hvi_kit::{Cancel, Store};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Cached multiscale workflows for hypervelocity impact.
#[derive(Parser)]
#[command(name = "hvi-flow", version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 a step failed; 2 the input is wrong; 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    /// Compute what a pipeline needs and isn't in the store, and write its report
    Run {
        #[command(flatten)]
        study: StudyArgs,
        /// Nodes that run at once [default: one a core]
        #[arg(long, short, value_parser = clap::value_parser!(u16).range(1..=4096))]
        jobs: Option<u16>,
        /// One JSON object a line on standard output for everything that happens
        #[arg(long)]
        json: bool,
        /// Show failures and the result only
        #[arg(long, short)]
        quiet: bool,
    },
    /// Show what `run` would compute, and why; computes nothing
    Plan {
        #[command(flatten)]
        study: StudyArgs,
    },
    /// List the stages a step can use
    Stages,
}

#[derive(clap::Args)]
struct StudyArgs {
    /// The pipeline file
    pipeline: PathBuf,
    /// Override a key: --set step.key=value
    #[arg(long = "set", value_name = "STEP.KEY=VALUE")]
    set: Vec<String>,
    /// Only these steps and what they need
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
    /// Folder of the store [default: $HVI_STORE, else cache/store of the project the pipeline lies in, else the user's cache]
    #[arg(long, value_name = "FOLDER")]
    store: Option<PathBuf>,
    /// Folder for results; the study gets one of its own in it
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
}

/// Why a command ends without having done what was asked.
#[derive(Debug)]
enum Stop {
    /// The input is wrong.
    Mistake(Mistake),
    /// The machine did not let us: store, files.
    Machine(String),
}
impl From<Mistake> for Stop {
    fn from(m: Mistake) -> Stop {
        Stop::Mistake(m)
    }
}
impl From<hvi_kit::StoreError> for Stop {
    fn from(e: hvi_kit::StoreError) -> Stop {
        Stop::Machine(e.to_string())
    }
}

/// Runs the program.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run { study, jobs, json, quiet } => {
            let mode = if json {
                Mode::Json
            } else if quiet {
                Mode::Quiet
            } else {
                Mode::detect()
            };
            run(&study, jobs, mode)
        }
        Command::Plan { study } => show_plan(&study),
        Command::Stages => {
            registry::STAGES.iter().for_each(|s| say(format_args!("{:20} {}", s.name, s.summary)));
            Ok(ExitCode::SUCCESS)
        }
    };
    done.unwrap_or_else(|stop| match stop {
        Stop::Mistake(mistake) => {
            warn(format_args!("{mistake}"));
            ExitCode::from(2)
        }
        Stop::Machine(why) => {
            warn(format_args!("error: {why}"));
            ExitCode::from(1)
        }
    })
}

impl StudyArgs {
    fn read(&self) -> Result<(Pipeline, Plan), Mistake> {
        let pipeline = pipeline::read(&self.pipeline, &self.set)?;
        let plan = plan::plan(&pipeline, &self.only)?;
        Ok((pipeline, plan))
    }

    fn folder(&self, pipeline: &Pipeline) -> PathBuf {
        self.out.join(&pipeline.name)
    }

    /// `--store`, then `HVI_STORE`, then `cache/store` of the project the pipeline lies in, else the user's cache folder.
    fn store(&self) -> Result<Store, Stop> {
        let given =
            self.store.clone().or_else(|| std::env::var_os("HVI_STORE").filter(|v| !v.is_empty()).map(PathBuf::from));
        let project = || {
            let pipeline = self.pipeline.canonicalize().ok()?;
            let is_project =
                |folder: &&Path| folder.join("cache/src/store.rs").exists() && folder.join("pipelines").exists();
            pipeline.ancestors().find(is_project).map(|folder| folder.join("cache/store"))
        };
        let user = || {
            let cache = std::env::var_os("XDG_CACHE_HOME").filter(|v| !v.is_empty()).map(PathBuf::from);
            let home = || std::env::var_os("HOME").map(|h| PathBuf::from(h).join(".cache"));
            cache.or_else(home).map(|c| c.join("hvi-flow/store"))
        };
        let folder = given.or_else(project).or_else(user);
        let folder =
            folder.ok_or_else(|| Stop::Machine("there is no folder for the store: give one with --store".into()))?;
        Ok(Store::open(folder)?)
    }
}

fn run(args: &StudyArgs, jobs: Option<u16>, mode: Mode) -> Result<ExitCode, Stop> {
    let (pipeline, plan) = args.read()?;
    let folder = args.folder(&pipeline);
    outputs::claim(&pipeline, &folder)?;
    let store = args.store()?;
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = jobs.map(usize::from).or(pipeline.settings.jobs).unwrap_or_else(cores).max(1);
    let cancel = stop_on_interrupt();
    quiet_workers();
    let console = Console::new(mode, &plan, jobs);
    let report = execute::execute(&plan, &store, &Options { jobs, cancel, listener: &console })?;
    console.finish();
    let written = outputs::write(&pipeline, &plan, &report, &store, &folder)
        .map_err(|e| Stop::Machine(format!("can't write results to {}: {e}", folder.display())))?;
    let counts = Counts::of(&report);
    if mode != Mode::Json {
        warn(format_args!("{}: {counts} in {}; {}", pipeline.name, duration(report.seconds), written.page.display()));
    }
    if counts.cancelled > 0 {
        warn(format_args!("stopped: what was finished is kept, the same command goes on from there"));
        return Ok(ExitCode::from(130));
    }
    for unreadable in &written.unreadable {
        warn(format_args!("{unreadable}"));
    }
    Ok(ExitCode::from(u8::from(counts.failed > 0 || !written.unreadable.is_empty())))
}

/// The flag that Ctrl-C sets; a second Ctrl-C ends the program at once.
fn stop_on_interrupt() -> &'static Cancel {
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

/// A panic on a worker is reported as its node's failure: nothing is printed for it.
fn quiet_workers() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some(execute::WORKER) {
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
}
impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} from the store, {} computed", self.hits, self.ran)?;
        let rest = [("failed", self.failed), ("skipped", self.skipped), ("stopped", self.cancelled)];
        rest.iter().filter(|(_, n)| *n > 0).try_for_each(|(what, n)| write!(f, ", {n} {what}"))
    }
}

/// What `run` would do with a node.
enum Forecast {
    Known,
    Run(String),
    Unknown(String),
}

fn show_plan(args: &StudyArgs) -> Result<ExitCode, Stop> {
    let (pipeline, plan) = args.read()?;
    let store = args.store()?;
    let last = outputs::last_keys(&args.folder(&pipeline));
    let forecasts = forecast(&plan, &store, &last);
    let count = |f: fn(&Forecast) -> bool| forecasts.iter().filter(|x| f(x)).count();
    let cost: f64 =
        forecasts.iter().zip(&plan.nodes).filter(|(f, _)| !matches!(f, Forecast::Known)).map(|(_, n)| n.cost).sum();
    say(format_args!(
        "{}: {} results: {} known, {} to run, {} unknown until then; about {} of one core",
        pipeline.name,
        plan.nodes.len(),
        count(|f| matches!(f, Forecast::Known)),
        count(|f| matches!(f, Forecast::Run(_))),
        count(|f| matches!(f, Forecast::Unknown(_))),
        duration(cost.max(0.0)),
    ));
    for step in &plan.steps {
        let mut groups: BTreeMap<String, usize> = BTreeMap::new();
        for id in step.nodes.clone() {
            let text = match &forecasts[id] {
                Forecast::Known => "known".to_string(),
                Forecast::Run(why) => format!("to run: {why}"),
                Forecast::Unknown(until) => format!("unknown until {until}"),
            };
            *groups.entry(text).or_default() += 1;
        }
        for (text, n) in groups {
            say(format_args!("  {:16} {:14} {n:5}  {text}", step.name, step.stage.name));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Follows the plan through the store without running anything.
fn forecast(plan: &Plan, store: &Store, last: &BTreeMap<String, hvi_kit::Digest>) -> Vec<Forecast> {
    let mut outputs: Vec<Option<hvi_kit::Digest>> = vec![None; plan.nodes.len()];
    let mut all = Vec::with_capacity(plan.nodes.len());
    for id in 0..plan.nodes.len() {
        let forecast = match execute::recipe(plan, id, &|n: NodeId| outputs[n]) {
            None => {
                let missing = plan.needs(id).find(|&n| outputs[n].is_none());
                Forecast::Unknown(missing.map_or_else(String::new, |n| plan.steps[plan.nodes[n].step].name.clone()))
            }
            Some(recipe) => match execute::stored(store, recipe.key(), plan.nodes[id].stage) {
                Stored::Whole(record) => {
                    outputs[id] = Some(record.output);
                    Forecast::Known
                }
                Stored::Damaged(_) => Forecast::Run("its stored result is damaged or gone".into()),
                Stored::Nothing => Forecast::Run(reason(&recipe, store, last.get(&plan.label(id)))),
            },
        };
        all.push(forecast);
    }
    all
}

/// Why a node has to run: what differs from its last run, field by field.
fn reason(recipe: &hvi_kit::Recipe, store: &Store, last: Option<&hvi_kit::Digest>) -> String {
    let Some(key) = last else { return "it has no result yet".into() };
    if *key == recipe.key() {
        return "its result is no longer in the store".into();
    }
    let Some(old) = store.recipe(*key) else {
        return "it changed, and the old recipe is no longer in the store".into();
    };
    let short = |text: Option<String>| {
        let text = text.unwrap_or_else(|| "nothing".into());
        if text.len() == 64 && text.chars().all(|c| c.is_ascii_hexdigit()) { text[..12].to_string() } else { text }
    };
    let changes = recipe.changes_since(&old);
    let mut texts: Vec<_> =
        changes.into_iter().map(|c| format!("{}: {} -> {}", c.field, short(c.old), short(c.new))).collect();
    if texts.len() > 4 {
        let more = texts.len() - 4;
        texts.truncate(4);
        texts.push(format!("and {more} more"));
    }
    texts.join("; ")
}
