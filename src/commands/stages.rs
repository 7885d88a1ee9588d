//! `stages`: what a step can use.
use super::Done;
use crate::console::say;
use crate::registry;
use std::process::ExitCode;

/// Lists the stages.
///
/// # Errors
/// None.
pub fn run() -> Done {
    registry::STAGES.iter().for_each(|s| say(format_args!("{:20} {}", s.name, s.summary)));
    Ok(ExitCode::SUCCESS)
}
