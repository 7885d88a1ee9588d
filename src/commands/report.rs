//! `report`: the page of a study from what is in the store, without computing anything; or one step as Markdown.
use super::{Done, OutArgs, Stop, StudyArgs};
use crate::console::{say, warn};
use crate::history::Last;
use crate::mistake::Mistake;
use crate::{forecast, outputs, report};
use std::io::Write;
use std::process::ExitCode;

/// What `report` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    #[command(flatten)]
    out: OutArgs,
    /// Print the tables of this step as Markdown instead
    #[arg(long, value_name = "STEP")]
    markdown: Option<String>,
}

/// Writes the page, or prints the step.
///
/// # Errors
/// [`Stop`] where the pipeline is wrong, the step is not there or has no result, or the page can't be written.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let store = args.study.store()?;
    let found = forecast::report(&forecast::forecast(&plan, &store, &Last::of(&store, &pipeline.name)));
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    if let Some(step) = &args.markdown {
        if !plan.steps.iter().any(|s| s.name == *step) {
            let names = plan.steps.iter().map(|s| s.name.as_str());
            return Err(Mistake::new(format!("there is no step `{step}`")).nearest(step, names).into());
        }
        let (study, unreadable) = outputs::study(&outputs::Title::of(&pipeline), &plan, &found, &store);
        unreadable.iter().for_each(|text| warn(format_args!("{text}")));
        let shown =
            study.steps.iter().find(|s| s.name == *step).filter(|s| s.points.iter().any(|p| !p.views.is_empty()));
        let Some(shown) = shown else {
            let run = format!("hvi-flow run {} --only {step}", pipeline.path.display());
            return Err(Stop::Machine(format!("no result of `{step}` is in the store: {run}")));
        };
        // A closed pipe is no failure.
        let _ = std::io::stdout().write_all(report::markdown(&study, shown).as_bytes());
        return Ok(ExitCode::SUCCESS);
    }
    let folder = args.out.folder(&pipeline);
    outputs::claim(&pipeline, &folder)?;
    let written = outputs::write(&pipeline, &plan, &found, &store, &folder)
        .map_err(|e| Stop::Machine(format!("can't write results to {}: {e}", folder.display())))?;
    written.unreadable.iter().for_each(|text| warn(format_args!("{text}")));
    say(format_args!("{}", written.page.display()));
    Ok(ExitCode::from(u8::from(!written.unreadable.is_empty())))
}
