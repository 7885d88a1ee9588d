//! The command line: which commands there are, and their exit codes.
use crate::commands::{Stop, explain, plan, run, stages};
use crate::console::warn;
use clap::{Parser, Subcommand};
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
    Run(run::Args),
    /// Show what `run` would compute, and why; computes nothing
    Plan(plan::Args),
    /// Say why results would be computed again, field by field, and what counts in a key
    Explain(explain::Args),
    /// List the stages a step can use
    Stages,
}

/// Runs the program.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Stages => stages::run(),
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
