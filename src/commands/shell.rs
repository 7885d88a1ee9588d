//! `completions` and `man`: help for shells and readers, made from the command line's own definition.
use super::Done;
use crate::mistake::Mistake;
use clap_complete::Shell;
use std::io::Write;
use std::process::ExitCode;

/// What `completions` is told.
#[derive(clap::Args)]
#[command(after_help = "bash: hvi-flow completions bash > ~/.local/share/bash-completion/completions/hvi-flow\n\
                        zsh:  hvi-flow completions zsh > a folder of $fpath, as _hvi-flow\n\
                        fish: hvi-flow completions fish > ~/.config/fish/completions/hvi-flow.fish")]
pub struct Completions {
    /// For which shell
    shell: Shell,
}

/// What `man` is told.
#[derive(clap::Args)]
#[command(after_help = "To read it: hvi-flow man | man -l -")]
pub struct Man {
    /// Of which command [default: of the program]
    command: Option<String>,
}

/// Prints a completion script for `program`.
///
/// # Errors
/// None.
pub fn completions(args: &Completions, mut program: clap::Command) -> Done {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "hvi-flow", &mut script);
    print(&script);
    Ok(ExitCode::SUCCESS)
}

/// Prints the manual page of `program`, or of one of its commands.
///
/// # Errors
/// [`Mistake`] where there is no such command.
pub fn man(args: &Man, mut program: clap::Command) -> Done {
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let names: Vec<String> = program.get_subcommands().map(|c| c.get_name().to_string()).collect();
            let found = program.find_subcommand(name).cloned();
            found.ok_or_else(|| {
                Mistake::new(format!("there is no command `{name}`")).nearest(name, names.iter().map(String::as_str))
            })?
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).map_err(|e| super::Stop::Machine(e.to_string()))?;
    print(&text);
    Ok(ExitCode::SUCCESS)
}

/// To standard output; a closed pipe is no failure.
fn print(bytes: &[u8]) {
    let _ = std::io::stdout().write_all(bytes);
}
