//! `cancel`: ends the jobs of a cluster that compute a study.
use super::{Done, Stop, StudyArgs};
use crate::console::say;
use crate::execute::slurm::{self, batch};
use std::process::ExitCode;

/// What `cancel` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
}

/// Ends the jobs; what they kept lets a later run go on from there.
///
/// # Errors
/// [`Stop`] where the pipeline is wrong, the store can't be used, or Slurm doesn't do what it is told.
pub fn run(args: &Args) -> Done {
    let (pipeline, _) = args.study.read(&[])?;
    let store = args.study.store()?;
    let batches: Vec<_> = batch::all(&store).into_iter().filter(|(_, batch)| batch.study == pipeline.name).collect();
    for (name, _) in &batches {
        slurm::cancel(name).map_err(|why| Stop::Machine(format!("the jobs of {} go on: {why}", pipeline.name)))?;
        batch::remove(&store, name);
    }
    let tasks: usize = batches.iter().map(|(_, batch)| batch.tasks.len()).sum();
    say(format_args!("{}: {tasks} jobs in {} batches cancelled", pipeline.name, batches.len()));
    Ok(ExitCode::SUCCESS)
}
