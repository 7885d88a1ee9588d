//! The commands, one file each, and what they share: the study they look at, its store, and how they end.
pub mod cache;
pub mod cancel;
pub mod compare;
pub mod diff;
pub mod effects;
pub mod eos;
pub mod exec;
pub mod explain;
pub mod export;
pub mod graph;
pub mod init;
pub mod plan;
pub mod report;
pub mod run;
pub mod schema;
pub mod shell;
pub mod stages;
pub mod status;
pub mod tradeoff;
use crate::choose;
use crate::mistake::Mistake;
use crate::pipeline::{self, Pipeline};
use crate::plan::Plan;
use crate::region;
use hvi_cache::Second;
use hvi_kit::Store;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// How a command ends: the exit code, or why it could not do what was asked.
pub type Done = Result<ExitCode, Stop>;

/// Why a command ends without having done what was asked.
#[derive(Debug)]
pub enum Stop {
    /// The input is wrong.
    Mistake(Mistake),
    /// The machine did not let us: store, files.
    Machine(String),
}
impl From<Mistake> for Stop {
    fn from(m: Mistake) -> Stop {
        Stop::Mistake(m)
    }
}
impl From<hvi_kit::StoreError> for Stop {
    fn from(e: hvi_kit::StoreError) -> Stop {
        Stop::Machine(e.to_string())
    }
}

/// The pipeline at `path` as it is run: with its `[choose.NAME]`, which look into the store, and its `region = "auto"` settled.
///
/// # Errors
/// [`Mistake`] where it can't be used.
fn settled<S: std::borrow::Borrow<Store>>(
    path: &Path,
    set: &[String],
    store: impl FnOnce() -> Result<S, Mistake>,
) -> Result<Pipeline, Mistake> {
    let mut pipeline = pipeline::read(path, set)?;
    if !pipeline.choose.0.is_empty() {
        pipeline = choose::settled(pipeline, set, store()?.borrow())?;
    }
    region::settled(pipeline)
}

/// Which pipeline, with which keys changed, and its store.
#[derive(clap::Args)]
pub struct StudyArgs {
    /// The pipeline file
    pub pipeline: PathBuf,
    /// Override a key: --set step.key=value
    #[arg(long = "set", value_name = "STEP.KEY=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    store: StoreArgs,
}

impl StudyArgs {
    /// Reads the pipeline and plans it: all of it, or `only` these steps and what they need.
    ///
    /// # Errors
    /// [`Mistake`] where the pipeline can't be used.
    pub fn read(&self, only: &[String]) -> Result<(Pipeline, Plan), Mistake> {
        let store = || {
            self.store().map_err(|stop| match stop {
                Stop::Mistake(mistake) => mistake,
                Stop::Machine(why) => Mistake::new(why),
            })
        };
        let pipeline = settled(&self.pipeline, &self.set, store)?;
        let plan = crate::plan::plan(&pipeline, only)?;
        Ok((pipeline, plan))
    }

    /// Opens the study's store.
    ///
    /// # Errors
    /// [`Stop`] where there is none, or it can't be used.
    pub fn store(&self) -> Result<Store, Stop> {
        self.store.open(&self.pipeline)
    }
}

/// Which store.
#[derive(clap::Args)]
pub struct StoreArgs {
    /// Folder of the store [default: $HVI_STORE, else cache/store of the project the pipeline lies in, else the user's cache]
    #[arg(long, value_name = "FOLDER")]
    store: Option<PathBuf>,
    /// A second store, which serves what the first one lacks and is only read: a folder, or s3://BUCKET/PREFIX with endpoint
    /// and credentials from the usual AWS_* variables [default: $HVI_SECOND_STORE]
    #[arg(long, value_name = "PLACE")]
    second_store: Option<PathBuf>,
}

impl StoreArgs {
    /// `--store`, then `HVI_STORE`, then `cache/store` of the project that `near` lies in, else the user's cache folder.
    ///
    /// # Errors
    /// [`Stop`] where there is none, or it can't be used.
    pub fn open(&self, near: &Path) -> Result<Store, Stop> {
        let given =
            self.store.clone().or_else(|| std::env::var_os("HVI_STORE").filter(|v| !v.is_empty()).map(PathBuf::from));
        let project = || {
            let near = near.canonicalize().ok()?;
            let is_project =
                |folder: &&Path| folder.join("cache/src/store.rs").exists() && folder.join("pipelines").exists();
            near.ancestors().find(is_project).map(|folder| folder.join("cache/store"))
        };
        let user = || {
            let cache = std::env::var_os("XDG_CACHE_HOME").filter(|v| !v.is_empty()).map(PathBuf::from);
            let home = || std::env::var_os("HOME").map(|h| PathBuf::from(h).join(".cache"));
            cache.or_else(home).map(|c| c.join("hvi-flow/store"))
        };
        let folder = given.or_else(project).or_else(user);
        let folder =
            folder.ok_or_else(|| Stop::Machine("there is no folder for the store: give one with --store".into()))?;
        let second = self.second_store.clone();
        let second =
            second.or_else(|| std::env::var_os("HVI_SECOND_STORE").filter(|v| !v.is_empty()).map(PathBuf::from));
        let store = Store::open(folder)?;
        Ok(match second {
            Some(second) => store.with_second(Second::open(&second)?),
            None => store,
        })
    }
}

/// Rows in aligned columns, the first one the heading; columns of numbers stand to the right.
pub fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cells = |i: usize| rows.iter().filter_map(move |row| row.get(i));
    let width: Vec<usize> = (0..count).map(|i| cells(i).map(|c| c.chars().count()).max().unwrap_or(0)).collect();
    let is_number = |c: &String| c.is_empty() || c.parse::<f64>().is_ok();
    let right: Vec<bool> = (0..count).map(|i| cells(i).skip(1).all(is_number)).collect();
    let line = |row: &Vec<String>| {
        let cell = |(i, c): (usize, &String)| {
            let space = " ".repeat(width[i] - c.chars().count());
            if right[i] { format!("{space}{c}") } else { format!("{c}{space}") }
        };
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Where results for people go.
#[derive(clap::Args)]
pub struct OutArgs {
    /// Folder for results; the study gets one of its own in it
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
}

impl OutArgs {
    /// The folder of this pipeline's results.
    pub fn folder(&self, pipeline: &Pipeline) -> PathBuf {
        self.folder_of(&pipeline.name)
    }

    /// The folder of the results of the study called `name`.
    pub fn folder_of(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }
}
