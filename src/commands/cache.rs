//! `cache`: what the store holds, whether it is whole, and what may go.
use super::{Done, Stop, StoreArgs, columns};
use crate::console::{say, warn};
use crate::forecast;
use crate::history::Last;
use crate::mistake::Mistake;
use crate::{amount, history, plan};
use clap::Subcommand;
use hvi_cache::{Copied, Limits, Second, Shelf};
use hvi_kit::{Digest, Store};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// What `cache` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Count what the store holds
    Stats {
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Read and hash every byte; what is damaged is moved aside, and computed again when it is needed
    Verify {
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Write the index anew, drop records without results and what killed runs left
    Repair {
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Copy every result to another store, which lacks it
    Push {
        #[command(flatten)]
        store: StoreArgs,
        /// The other store: a folder, which is made if it isn't there, or s3://BUCKET/PREFIX
        #[arg(value_name = "PLACE")]
        to: PathBuf,
    },
    /// Copy every result of another store that this one lacks
    Pull {
        #[command(flatten)]
        store: StoreArgs,
        /// The other store: a folder, or s3://BUCKET/PREFIX
        #[arg(value_name = "PLACE")]
        from: PathBuf,
    },
    /// Remove results: by age, by size, all but what pipelines need
    Gc(Gc),
}

#[derive(clap::Args)]
struct Gc {
    #[command(flatten)]
    store: StoreArgs,
    /// Results beyond this size go, oldest first: 500MB, 10GB
    #[arg(long, value_name = "SIZE", value_parser = amount::size)]
    max_size: Option<u64>,
    /// Results older than this go: 12h, 30d
    #[arg(long, value_name = "AGE", value_parser = amount::time)]
    older_than: Option<Duration>,
    /// What the pipelines in this folder need stays, whatever its age and size; without --max-size and --older-than all else goes
    #[arg(long, value_name = "FOLDER")]
    keep: Vec<PathBuf>,
    /// Say what would go; remove nothing
    #[arg(long)]
    dry_run: bool,
}

/// Does what is asked of the store that the current folder leads to.
///
/// # Errors
/// [`Stop`] where the store can't be used, or a run uses what would be removed.
pub fn run(args: &Args) -> Done {
    let here = Path::new(".");
    match &args.what {
        What::Stats { store } => stats(&store.open(here)?),
        What::Verify { store } => verify(&store.open(here)?),
        What::Repair { store } => {
            let done = store.open(here)?.repair()?;
            say(format_args!(
                "{} results in the index; {} records without a result and {} leftovers removed",
                done.indexed, done.records, done.leftovers
            ));
            Ok(ExitCode::SUCCESS)
        }
        What::Push { store, to } => {
            let (store, to) = (store.open(here)?, Second::open(to)?);
            let from = store.folder().display().to_string();
            copied(store.push(&to)?, &from, &to.name())
        }
        What::Pull { store, from } => {
            let second = Second::open(from)?;
            if matches!(second, Second::Folder(_)) && !from.is_dir() {
                return Err(Mistake::new(format!("{}: there is no store there", from.display())).into());
            }
            let store = store.open(here)?;
            copied(store.pull(&second)?, &second.name(), &store.folder().display().to_string())
        }
        What::Gc(gc) => collect(gc, &gc.store.open(here)?),
    }
}

fn stats(store: &Store) -> Done {
    let s = store.stats();
    let row = |what: &str, shelf: Shelf| vec![what.to_string(), shelf.count.to_string(), bytes(shelf.bytes)];
    let rows = [
        vec!["what".to_string(), "files".into(), "size".into()],
        row("results", s.objects),
        row("records", s.results),
        row("recipes", s.recipes),
        row("checkpoints", s.partial),
        row("damaged", s.damaged),
        row("unfinished", s.tmp),
        vec!["index".into(), "1".into(), bytes(s.index)],
    ];
    say(format_args!("{}", store.folder().display()));
    columns(&rows).lines().for_each(|line| say(format_args!("  {line}")));
    let studies = history::studies(store);
    if !studies.is_empty() {
        say(format_args!("studies on record: {}", studies.join(", ")));
    }
    Ok(ExitCode::SUCCESS)
}

/// Exit code 1 where something is damaged, so that a script hears of it.
fn verify(store: &Store) -> Done {
    let found = store.verify();
    for problem in &found.problems {
        warn(format_args!("{}: {}", problem.path.display(), problem.why));
    }
    say(format_args!(
        "{} results ({}) and {} records are whole, {} are not",
        found.objects,
        bytes(found.bytes),
        found.records,
        found.problems.len()
    ));
    Ok(ExitCode::from(u8::from(!found.problems.is_empty())))
}

/// Exit code 1 where something was not whole where it came from, so that a script hears of it.
fn copied(done: Copied, from: &str, to: &str) -> Done {
    say(format_args!(
        "{} results ({}) copied to {to}, {} were there, {} are damaged in {from}",
        done.results,
        bytes(done.bytes),
        done.known,
        done.damaged,
    ));
    Ok(ExitCode::from(u8::from(done.damaged > 0)))
}

fn collect(gc: &Gc, store: &Store) -> Done {
    let pins = pins(&gc.keep, store)?;
    let pinned = pins.len();
    let only_pins = !gc.keep.is_empty() && gc.max_size.is_none() && gc.older_than.is_none();
    let limits = Limits {
        max_bytes: if only_pins { Some(0) } else { gc.max_size },
        older_than: gc.older_than,
        pins,
        dry_run: gc.dry_run,
    };
    let done = store.gc(&limits)?;
    let verb = if gc.dry_run { "would go" } else { "removed" };
    if !gc.keep.is_empty() {
        say(format_args!("{pinned} keys are needed by pipelines"));
    }
    say(format_args!(
        "{} results, {} files, {} {verb}; {} stay",
        done.results,
        done.files,
        bytes(done.bytes),
        bytes(done.left)
    ));
    Ok(ExitCode::SUCCESS)
}

/// Keys of what the pipelines in `folders` need: through the plan where results lead on, and the last keys on record of
/// what they don't lead to.
fn pins(folders: &[PathBuf], store: &Store) -> Result<HashSet<Digest>, Stop> {
    let mut pins = HashSet::new();
    for folder in folders {
        let entries = std::fs::read_dir(folder)
            .map_err(|e| Mistake::new(format!("--keep {}: can't read it: {e}", folder.display())))?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
        if files.is_empty() {
            return Err(Mistake::new(format!("--keep {}: there is no pipeline in it", folder.display())).into());
        }
        for file in files {
            let read = super::settled(&file, &[], || Ok(store))?;
            let plan = plan::plan(&read, &[])?;
            let last = Last::of(store, &read.name);
            for (id, forecast) in forecast::forecast(&plan, store, &last).iter().enumerate() {
                pins.extend(forecast.key);
                if forecast.entry().is_none() {
                    pins.extend(last.key(&plan.label(id)));
                }
            }
        }
    }
    Ok(pins)
}

/// `1.5 GB`.
pub fn bytes(n: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB"];
    let (mut x, mut i) = (n as f64, 0);
    while x >= 1000.0 && i + 1 < units.len() {
        x /= 1000.0;
        i += 1;
    }
    if i == 0 { format!("{n} B") } else { format!("{x:.1} {}", units[i]) }
}
