//! `tradeoff`: runs a study at several settings and shows what accuracy costs in time.
use super::compare::cell;
use super::{Done, Stop, run};
use crate::choose;
use crate::console::{Console, Mode, say, warn};
use crate::history::Last;
use crate::mistake::Mistake;
use crate::pipeline::Pipeline;
use crate::plan::Plan;
use crate::report::{self, Point, State, Step, Study, Unread};
use crate::tradeoff::{self, Outcome};
use crate::{amount, figure, forecast, repeat};
use hvi_kit::Store;
use hvi_kit::view::{Table, View};
use hvi_tradeoff::{Chosen, Pace, Quantity};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `tradeoff` is told.
#[derive(clap::Args)]
#[group(id = "tradeoff")]
pub struct Args {
    #[command(flatten)]
    run: run::Args,
    /// Write what to choose to a Markdown page too
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// The cheapest setting with at most this error, such as "2 %", of --quantity
    #[arg(long, value_name = "ERROR", requires = "quantity", conflicts_with = "budget")]
    accuracy: Option<String>,
    /// The most accurate setting within this CPU time, such as 10min, for --quantity
    #[arg(long, value_name = "TIME", requires = "quantity", value_parser = amount::time)]
    budget: Option<std::time::Duration>,
    /// Compute the study so often in all, each time in an empty store: the times on record become medians, and the bits must agree
    #[arg(long, value_name = "TIMES", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=100))]
    repeat: u32,
    /// The quantity that --accuracy and --budget are of: QUANTITY, or BLOCK.QUANTITY
    #[arg(long, value_name = "QUANTITY")]
    quantity: Option<String>,
}

/// Runs what is missing, then shows errors against costs.
///
/// # Errors
/// [`Stop`] where the pipeline or the question is wrong, or results can't be written.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.run.study.read(&[])?;
    let blocks = tradeoff::blocks(&pipeline, &plan)?;
    let target = args.accuracy.as_deref().map(percent).transpose()?;
    if args.quantity.is_some() && args.accuracy.is_none() && args.budget.is_none() {
        let mistake = Mistake::new("--quantity asks for nothing yet");
        return Err(mistake.help("add --accuracy \"2 %\" or --budget 10min").into());
    }
    args.quantity.as_deref().map_or(Ok(()), |wanted| tradeoff::knows(&blocks, &plan, wanted))?;
    let ended = run::run(&args.run)?;
    if ended != ExitCode::SUCCESS {
        return Ok(ended);
    }
    let store = args.run.study.store()?;
    if args.repeat > 1 && !repeated(args, &pipeline, &plan, &store)? {
        return Ok(ExitCode::from(130));
    }
    let forecasts = forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name));
    // Results are read and measured side by side: most of a warm run's time.
    let mut outcomes: Vec<Outcome<'_>> = std::thread::scope(|scope| {
        let outcome = |b| tradeoff::outcome(b, &plan, &forecasts, &store);
        let started: Vec<_> = blocks.iter().map(|b| scope.spawn(move || outcome(b))).collect();
        started
            .into_iter()
            .map(|s| s.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect::<Result<_, _>>()
    })?;
    tradeoff::check(&mut outcomes);
    let folder = args.run.out.folder(&pipeline);
    let command = format!("hvi-flow tradeoff {}", pipeline.path.display());
    let cannot = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| Stop::Machine(format!("can't write {path}: {e}"))
    };
    write(&folder, &command, &pipeline.question, &outcomes).map_err(cannot(&folder))?;
    if let Some(path) = &args.page {
        let command = format!("{command} --page {}", path.display());
        fs::write(path, page(&command, &pipeline.question, &outcomes, &tradeoff::paces(&plan, &forecasts)))
            .map_err(cannot(path))?;
    }
    for o in &outcomes {
        let table = match o.block.spread {
            true => hvi_tradeoff::spread_table(&o.block.along, &o.spreads),
            false => hvi_tradeoff::choices(&o.block.along, &o.samples, &o.quantities, 1.0),
        };
        say(format_args!("{}: {}\n\n{}", o.block.name, o.block.about, markdown(&table)));
    }
    warn(format_args!("{}", folder.join("tradeoff.html").display()));
    match &args.quantity {
        None => Ok(ExitCode::SUCCESS),
        Some(wanted) => choose(&outcomes, wanted, target, args.budget.map(|b| b.as_secs_f64())),
    }
}

/// Computes the study again as often as asked; false where it was stopped.
fn repeated(args: &Args, pipeline: &Pipeline, plan: &Plan, store: &Store) -> Result<bool, Stop> {
    let jobs = args.run.jobs(pipeline);
    let console = Console::new(Mode::detect(), plan, jobs);
    let options = args.run.options(pipeline, jobs, run::stop_on_interrupt(), &console);
    let ended = repeat::medians(plan, store, &options, args.repeat as usize - 1);
    console.finish();
    ended.map_err(Stop::Machine)
}

/// `2 %` as 0.02.
fn percent(text: &str) -> Result<f64, Mistake> {
    choose::percent(text).ok_or_else(|| Mistake::new(format!("--accuracy {text}: expected a share, as in \"2 %\"")))
}

/// Says which setting reaches what was asked of the quantity `wanted`; exit code 2 where none does.
fn choose(outcomes: &[Outcome<'_>], wanted: &str, target: Option<f64>, budget: Option<f64>) -> Done {
    let all = || outcomes.iter().flat_map(|o| o.quantities.iter().map(move |q| (o, q)));
    let full = |o: &Outcome<'_>, q: &Quantity| format!("{}.{}", o.block.name, q.name);
    let found: Vec<_> = all().filter(|(o, q)| q.name == wanted || full(o, q) == wanted).collect();
    if found.is_empty() {
        let names: Vec<String> = all().map(|(o, q)| full(o, q)).collect();
        let mistake = Mistake::new(format!("none of these runs errs in `{wanted}`"));
        return Err(mistake.help(format!("they err in: {}", names.join(", "))).into());
    }
    let mut reached = false;
    for (o, q) in found {
        let points = q.points(&o.samples);
        let chosen = match (target, budget) {
            (_, Some(budget)) => hvi_tradeoff::most_accurate(&points, budget),
            (target, None) => hvi_tradeoff::cheapest(&points, target.unwrap_or(0.0)),
        };
        let Some(Chosen { index, reached: here }) = chosen else { continue };
        reached |= here;
        let (sample, (cost, error)) = (&o.samples[index], points[index]);
        let group = if sample.group.is_empty() { String::new() } else { format!(", {}", sample.group) };
        let how = if here { "take" } else { "none reaches it; the nearest is" };
        say(format_args!(
            "{}: {how} {} {}{group}: {:.2} % off (the reference is known to {:.2} %), {cost:.1} s of CPU time",
            full(o, q),
            o.block.along,
            sample.setting,
            100.0 * error,
            100.0 * q.blur()
        ));
    }
    Ok(ExitCode::from(if reached { 0 } else { 2 }))
}

/// The page with figures, and every table and figure as a file.
fn write(folder: &Path, command: &str, question: &str, outcomes: &[Outcome<'_>]) -> std::io::Result<()> {
    let mut steps = Vec::new();
    for o in outcomes {
        let inner = folder.join("tradeoff").join(&o.block.name);
        fs::create_dir_all(&inner)?;
        let views = o.views();
        for view in &views {
            let file = |title: &str, extension: &str| {
                inner.join(format!("{}.{extension}", title.to_lowercase().replace(' ', "-")))
            };
            match view {
                View::Table(t) => fs::write(file(&t.title, "csv"), figure::csv(t))?,
                View::Figure(f) => {
                    let (svg, drawn, png) = (figure::svg(f), file(&f.title, "svg"), file(&f.title, "png"));
                    // To draw the same pixels again takes longer than all the rest; the figure is written after them.
                    if !png.exists() || fs::read(&drawn).is_ok_and(|old| old != svg.as_bytes()) || !drawn.exists() {
                        fs::write(png, figure::raster(&svg))?;
                        fs::write(drawn, svg)?;
                    }
                }
                _ => {}
            }
        }
        let point = Point {
            label: String::new(),
            state: State::Hit,
            seconds: o.samples.iter().map(|s| s.cost).sum(),
            key: String::new(),
            params: [].into(),
            swept: Vec::new(),
            scalars: [].into(),
            views,
            unread: Unread::default(),
        };
        let (name, summary) = (o.block.name.clone(), o.block.about.clone());
        steps.push(Step {
            name,
            stage: "tradeoff".into(),
            summary,
            needs: Vec::new(),
            sketches: Vec::new(),
            points: vec![point],
        });
    }
    let (question, command) = (question.to_string(), command.to_string());
    let study = Study { name: "What accuracy costs".into(), question, steps, seconds: 0.0, command };
    fs::write(folder.join("tradeoff.html"), report::render(&study))
}

/// The Markdown page: what to choose, and how sure that is.
fn page(command: &str, question: &str, outcomes: &[Outcome<'_>], paces: &[(&str, Pace)]) -> String {
    let mut text = format!("# What accuracy costs\n\nMade by `{command}`.\n\n{}\n{question}\n", in_short(outcomes));
    for o in outcomes {
        let _ = write!(text, "\n## {}\n\n{}\n", o.block.name, o.block.about);
        for view in o.views() {
            if let View::Table(t) = view
                && t.title != "Runs"
            {
                let _ = write!(text, "\n**{}.** {}\n\n{}", t.title, t.note, markdown(&t));
            }
        }
    }
    text += "\n## Predicted times\n\nCore-seconds that a stage predicts, against those that the runs above took on this machine: \
             predictions are multiplied by the median; the worst is by which factor one was still off.\n\n\
             | stage | runs | taken over predicted | worst factor |\n|---|---|---|---|\n";
    for (stage, p) in paces {
        let _ = writeln!(text, "| `{stage}` | {} | {:.2} | {:.1} |", p.runs, p.median, p.worst);
    }
    text
}

/// One screen: the cheapest settings of the blocks that say `first`, and how choices held elsewhere.
fn in_short(outcomes: &[Outcome<'_>]) -> String {
    let mut text = String::new();
    for o in outcomes.iter().filter(|o| o.block.first) {
        for row in hvi_tradeoff::choices(&o.block.along, &o.samples, &o.quantities, hvi_tradeoff::MARGIN).rows {
            let cells: Vec<String> = row[..5].iter().map(short).collect();
            let _ = writeln!(text, "| {} | {} |", o.block.name, cells.join(" | "));
        }
    }
    if !text.is_empty() {
        let head = "## In short\n\nFor a scene of one's own: the cheapest setting whose error on the scenes below is half of what is asked, as \
                    `[choose]` takes it, and its CPU time here.\n\n\
                    | what | quantity | within 10 % | within 5 % | within 2 % | within 1 % |\n|---|---|---|---|---|---|\n";
        text.insert_str(0, head);
    }
    let checks = || outcomes.iter().filter_map(|o| o.checks.as_ref()).flat_map(|(_, checks)| checks);
    let (held, timely) = (checks().filter(|c| c.holds()).count(), checks().filter(|c| c.factor() <= 1.5).count());
    if checks().next().is_some() {
        let _ = write!(
            text,
            "\nChosen so for 5, 2 and 1 % on scenes that the choice was not made on, {held} of {all} errors were within what was asked and \
             {timely} of {all} times within a factor of 1.5 of what was predicted. Where it says \"none of these\", nothing is chosen and \
             `[choose]` refuses: such targets are not among the {all}.\n",
            all = checks().count()
        );
    }
    text
}

fn markdown(table: &Table) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let head =
        |(name, unit): &(String, String)| if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") };
    let mut text = line(table.columns.iter().map(head).collect());
    text += &format!("|{}\n", "---|".repeat(table.columns.len()));
    table.rows.iter().for_each(|row| text += &line(row.iter().map(short).collect()));
    text
}

/// A cell with three digits: what errors and costs are good to.
fn short(of: &hvi_kit::view::Cell) -> String {
    use hvi_kit::view::Cell;
    let three = |x: f64| format!("{x:.2e}").parse::<f64>().unwrap_or(x);
    match of {
        Cell::Number(x) => cell(&Cell::Number(three(*x))),
        Cell::Uncertain(x, error) => figure::uncertain(*x, *error),
        other => cell(other),
    }
}
