//! `schema`: the pipeline file's JSON schema, for editors.
use super::Done;
use crate::console::say;
use crate::schema;
use std::process::ExitCode;

/// Prints the schema.
///
/// # Errors
/// None.
pub fn run() -> Done {
    say(format_args!("{:#}", schema::pipeline()));
    Ok(ExitCode::SUCCESS)
}
