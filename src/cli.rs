//! The command line: which commands there are, and their exit codes.
use crate::commands::{
    Stop, cache, cancel, compare, diff, effects, eos, exec, explain, export, graph, init, plan, report, run, schema,
    shell, stages, status, tradeoff,
};
use crate::console::warn;
use clap::{CommandFactory, Parser, Subcommand};
use std::process::ExitCode;

/// Cached multiscale workflows for hypervelocity impact.
#[derive(Parser)]
#[command(name = "hvi-flow", version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "To begin: hvi-flow init, then hvi-flow run first.toml\n\
    Exit codes: 0 done; 1 a step failed; 2 the input is wrong; 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    /// Compute what a pipeline needs and isn't in the store, and write its report
    Run(run::Args),
    /// Show what `run` would compute, and why; computes nothing
    Plan(plan::Args),
    /// Say why results would be computed again, field by field, and what counts in a key
    Explain(explain::Args),
    /// Write the page of a study from what is in the store, or print a step as Markdown
    Report(report::Args),
    /// Show what of a study is in the store, what is at work, the last runs and their failures
    Status(status::Args),
    /// Show a step's results side by side: what the sweep sets and what came of it
    Compare(compare::Args),
    /// Run a study at several settings and show what accuracy costs in time
    Tradeoff(tradeoff::Args),
    /// Show two runs side by side: parameters and results
    Diff(diff::Args),
    /// Write results as files, with where each comes from (RO-Crate)
    Export(export::Args),
    /// Draw the steps of a pipeline as DOT or Mermaid
    Graph(graph::Args),
    /// Look after the store: count, verify, repair, remove
    Cache(cache::Args),
    /// End the jobs of a cluster that compute a study
    Cancel(cancel::Args),
    /// Compute nodes by their keys, as a job of a cluster does
    Exec(exec::Args),
    /// Write a small commented pipeline to begin with
    Init(init::Args),
    /// Show which effects each impact's scene calls for, and the numbers that decide
    Effects(effects::Args),
    /// Ask an equation of state for states and curves
    Eos(eos::Args),
    /// List the stages a step can use, or all their keys
    Stages(stages::Args),
    /// Print the JSON schema of pipeline files, for editors, or of the lines of `run --json`
    Schema(schema::Args),
    /// Print a script that completes commands in a shell
    Completions(shell::Completions),
    /// Print the manual page
    Man(shell::Man),
}

/// Runs the program.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Status(args) => status::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Diff(args) => diff::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Cache(args) => cache::run(&args),
        Command::Cancel(args) => cancel::run(&args),
        Command::Exec(args) => exec::run(&args),
        Command::Init(args) => init::run(&args),
        Command::Effects(args) => effects::run(&args),
        Command::Eos(args) => eos::run(&args),
        Command::Stages(args) => stages::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Completions(args) => shell::completions(&args, Cli::command()),
        Command::Man(args) => shell::man(&args, Cli::command()),
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
