//! `stages`: what a step can use, in a line each or as the whole reference.
use super::Done;
use crate::console::say;
use crate::reference_page;
use crate::registry;
use std::process::ExitCode;

/// What `stages` is told.
#[derive(clap::Args)]
pub struct Args {
    /// The whole reference: every stage, key, unit and default, as `docs/stages.md`
    #[arg(long)]
    markdown: bool,
}

/// Lists the stages.
///
/// # Errors
/// None.
pub fn run(args: &Args) -> Done {
    if args.markdown {
        say(format_args!("{}", reference_page::markdown().trim_end()));
    } else {
        registry::STAGES.iter().for_each(|s| say(format_args!("{:20} {}", s.name, s.summary)));
    }
    Ok(ExitCode::SUCCESS)
}
