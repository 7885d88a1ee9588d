//! `init`: a small commented pipeline to begin with, that runs in seconds.
use super::{Done, Stop};
use crate::console::say;
use crate::mistake::Mistake;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `init` is told.
#[derive(clap::Args)]
pub struct Args {
    /// Where it goes; made if it isn't there
    #[arg(default_value = ".")]
    folder: PathBuf,
}

const NAME: &str = "first.toml";
const PIPELINE: &str = include_str!("first.toml");

/// Writes the pipeline; never over a file that is there.
///
/// # Errors
/// [`Stop`] where it is there already, or can't be written.
pub fn run(args: &Args) -> Done {
    let path = args.folder.join(NAME);
    if path.exists() {
        let mistake = Mistake::new(format!("{} is there already", path.display()));
        return Err(mistake.help("remove it, or give another folder: hvi-flow init FOLDER").into());
    }
    let written = std::fs::create_dir_all(&args.folder).and_then(|()| std::fs::write(&path, PIPELINE));
    written.map_err(|e| Stop::Machine(format!("can't write {}: {e}", path.display())))?;
    let prefix =
        if args.folder == Path::new(".") { String::new() } else { format!("cd {} && ", args.folder.display()) };
    say(format_args!("{} is written. Next:", path.display()));
    say(format_args!("  {prefix}hvi-flow plan {NAME}    # what would run, and why"));
    say(format_args!("  {prefix}hvi-flow run {NAME}     # then open out/first/report.html"));
    Ok(ExitCode::SUCCESS)
}
