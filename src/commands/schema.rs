//! `schema`: JSON schemas of the pipeline file, for editors, and of the lines of `run --json`, for programs.
use super::Done;
use crate::console::say;
use crate::{events, schema};
use std::process::ExitCode;

/// What `schema` is told.
#[derive(clap::Args)]
#[command(
    after_help = "An editor with TOML support takes it by a first line in the pipeline file: #:schema pipeline.schema.json"
)]
pub struct Args {
    /// Of the lines that `run --json` prints, instead of pipeline files
    #[arg(long)]
    events: bool,
}

/// Prints the schema.
///
/// # Errors
/// None.
pub fn run(args: &Args) -> Done {
    let schema = if args.events { events::schema().into() } else { schema::pipeline() };
    say(format_args!("{schema:#}"));
    Ok(ExitCode::SUCCESS)
}
