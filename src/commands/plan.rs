//! `plan`: what `run` would compute, why, and how long it would take; computes nothing.
use super::{Done, Stop, StudyArgs, columns};
use crate::console::{duration, say, warn};
use crate::execute::Graph;
use crate::forecast::{self, Fate, Forecast};
use crate::history::Last;
use crate::pipeline::Pipeline;
use crate::plan::Plan;
use crate::schedule::{self, Cluster, Schedule, Task};
use crate::{amount, figure};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// What `plan` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Only these steps and what they need
    #[arg(long, value_name = "STEP")]
    only: Vec<String>,
    /// One JSON object on standard output: totals, and every node with its state and the fields that changed
    #[arg(long)]
    json: bool,
    /// Also pack what is to run onto so many cores of a cluster, and say how long that would take: --cores 100,1000
    #[arg(long, value_name = "COUNTS", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    cores: Vec<u32>,
    /// Cores of one machine of the cluster
    #[arg(long, value_name = "COUNT", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=4096))]
    machine_cores: u32,
    /// Memory of one machine of the cluster
    #[arg(long, value_name = "SIZE", value_parser = amount::size, default_value = "256GB")]
    machine_memory: u64,
    /// Folder for a figure of each packing: cores at work over time
    #[arg(long, value_name = "FOLDER", requires = "cores")]
    figures: Option<PathBuf>,
}

/// Shows what would run.
///
/// # Errors
/// [`Stop`] where the pipeline is wrong, the store can't be used, or a figure can't be written.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&args.only)?;
    pipeline.remarks.iter().for_each(|text| warn(format_args!("{text}")));
    let store = args.study.store()?;
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    let foretold = forecast::foretell(&plan, &forecasts, &store);
    let totals = Totals::of(&forecasts, &foretold);
    let packings: Vec<Packing> =
        args.cores.iter().map(|&n| args.pack(n as usize, &pipeline, &plan, &foretold)).collect();
    if let Some(folder) = &args.figures {
        std::fs::create_dir_all(folder)
            .and_then(|()| {
                packings.iter().try_for_each(|p| std::fs::write(folder.join(p.file(&pipeline)), p.drawn(&plan)))
            })
            .map_err(|e| Stop::Machine(format!("can't write figures to {}: {e}", folder.display())))?;
    }
    if args.json {
        let nodes: Vec<_> = forecasts.iter().enumerate().map(|(id, f)| forecast::json(&plan, id, f)).collect();
        let stages = stages(&plan, &foretold);
        let whole = json!({
            "study": pipeline.name,
            "known": totals.known, "run": totals.run, "unknown": totals.unknown, "cost_s": totals.cost,
            "stages": stages.iter().map(StageWork::json).collect::<Vec<_>>(),
            "regions": pipeline.regions.iter().map(|r| json!({
                "step": r.step, "kept": r.kept, "written": r.written, "why": r.why,
            })).collect::<Vec<_>>(),
            "packings": packings.iter().map(|p| p.json()).collect::<Vec<_>>(),
            "nodes": nodes,
        });
        say(format_args!("{whole}"));
        return Ok(ExitCode::SUCCESS);
    }
    show(&pipeline, &plan, &forecasts, &totals);
    if totals.cost > 0.0 {
        say(format_args!("foretold, by stage:"));
        print(&StageWork::rows(&stages(&plan, &foretold)));
    }
    if !packings.is_empty() {
        say(format_args!("packed onto machines of {} cores, simulated:", args.machine_cores));
        print(&Packing::rows(&packings));
    }
    Ok(ExitCode::SUCCESS)
}

fn print(rows: &[Vec<String>]) {
    columns(rows).lines().for_each(|line| say(format_args!("  {line}")));
}

struct Totals {
    known: usize,
    run: usize,
    unknown: usize,
    /// Foretold core-seconds of what isn't known.
    cost: f64,
}
impl Totals {
    fn of(forecasts: &[Forecast], foretold: &[f64]) -> Totals {
        let count = |is: fn(&Fate) -> bool| forecasts.iter().filter(|f| is(&f.fate)).count();
        Totals {
            known: count(|f| matches!(f, Fate::Known(_))),
            run: count(|f| matches!(f, Fate::Run(_))),
            unknown: count(|f| matches!(f, Fate::Unknown(_))),
            cost: foretold.iter().sum(),
        }
    }
}

fn show(pipeline: &Pipeline, plan: &Plan, forecasts: &[Forecast], totals: &Totals) {
    say(format_args!(
        "{}: {} results: {} known, {} to run, {} unknown until then; about {} of one core",
        pipeline.name,
        plan.nodes.len(),
        totals.known,
        totals.run,
        totals.unknown,
        duration(totals.cost),
    ));
    for step in &plan.steps {
        let mut groups: BTreeMap<String, usize> = BTreeMap::new();
        for id in step.nodes.clone() {
            *groups.entry(forecast::line(plan, id, &forecasts[id])).or_default() += 1;
        }
        for (text, n) in groups {
            say(format_args!("  {:16} {:14} {n:5}  {text}", step.name, step.stage.name));
        }
    }
}

/// What the nodes of a stage that are to run would take.
struct StageWork {
    stage: &'static str,
    nodes: usize,
    /// Core-seconds of all of them, and of the longest.
    all: f64,
    longest: f64,
}

/// What is to run, by stage, in the order of the plan.
fn stages(plan: &Plan, foretold: &[f64]) -> Vec<StageWork> {
    let mut all: Vec<StageWork> = Vec::new();
    for (node, &seconds) in plan.nodes.iter().zip(foretold).filter(|(_, seconds)| **seconds > 0.0) {
        let stage = node.stage.name;
        let place = all.iter().position(|work| work.stage == stage).unwrap_or_else(|| {
            all.push(StageWork { stage, nodes: 0, all: 0.0, longest: 0.0 });
            all.len() - 1
        });
        let work = &mut all[place];
        (work.nodes, work.all, work.longest) = (work.nodes + 1, work.all + seconds, work.longest.max(seconds));
    }
    all
}

impl StageWork {
    fn rows(all: &[StageWork]) -> Vec<Vec<String>> {
        let head = ["stage", "nodes", "core-hours", "longest node on one core"].map(str::to_string).to_vec();
        let row = |w: &StageWork| {
            vec![w.stage.into(), w.nodes.to_string(), figure::number(w.all / 3600.0, 3), duration(w.longest)]
        };
        std::iter::once(head).chain(all.iter().map(row)).collect()
    }

    fn json(&self) -> serde_json::Value {
        json!({ "stage": self.stage, "nodes": self.nodes, "core_s": self.all, "longest_core_s": self.longest })
    }
}

/// What is to run on so many cores.
struct Packing {
    tasks: Vec<Task>,
    schedule: Schedule,
}

impl Args {
    fn pack(&self, cores: usize, pipeline: &Pipeline, plan: &Plan, foretold: &[f64]) -> Packing {
        let cluster = Cluster { cores, machine: self.machine_cores as usize, memory: self.machine_memory };
        let tasks = schedule::tasks(plan, foretold, pipeline.settings.slurm.cores, cluster);
        let schedule = schedule::simulate(Graph::of(plan), &tasks, cluster);
        Packing { tasks, schedule }
    }
}

impl Packing {
    fn rows(all: &[Packing]) -> Vec<Vec<String>> {
        let head = ["cores", "from begin to end", "cores' time used", "longest way"].map(str::to_string).to_vec();
        let row = |p: &Packing| {
            let s = &p.schedule;
            let used = format!("{:.1} %", 100.0 * s.utilisation());
            vec![s.cores.to_string(), duration(s.makespan), used, duration(s.longest_way)]
        };
        std::iter::once(head).chain(all.iter().map(row)).collect()
    }

    fn json(&self) -> serde_json::Value {
        let s = &self.schedule;
        json!({
            "cores": s.cores, "makespan_s": s.makespan, "utilisation": s.utilisation(),
            "longest_way_s": s.longest_way, "core_s": s.work,
        })
    }

    fn file(&self, pipeline: &Pipeline) -> String {
        format!("{}-on-{}-cores.svg", pipeline.name, self.schedule.cores)
    }

    fn drawn(&self, plan: &Plan) -> String {
        figure::svg(&schedule::figure(plan, &self.tasks, &self.schedule))
    }
}
