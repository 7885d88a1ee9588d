//! A run that has nothing to do, known without a plan: all that it would look at is as the last run left it.
//!
//! That is the command, the bytes of every file that was read, the store's index and the mark of each object, the last entry
//! of the history, and the files in `out/NAME/`. Where anything is different, or the notes are damaged or another program's,
//! the run goes the long way. Nothing is noted of studies that depend on more than that (programs outside, `[choose.NAME]`, a
//! cluster), nor of those that have something to say.
use crate::execute::{Outcome, Report};
use crate::outputs::{self, Written, sealed};
use crate::pipeline::{self, Pipeline};
use crate::plan::Plan;
use crate::{history, named_file};
use hvi_cache::{Digest, Standing};
use hvi_kit::Store;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What was asked, and how all that it looked at was left.
#[derive(Serialize, Deserialize)]
struct Notes {
    asked: Asked,
    /// Each file that was read, with the digest of its bytes.
    files: Vec<(PathBuf, [u8; 32])>,
    nodes: usize,
    standing: Standing,
    /// What tells the run apart in the history.
    mark: String,
    /// Digest of everything that is shown.
    study: String,
}

#[derive(PartialEq, Serialize, Deserialize)]
struct Asked {
    /// The pipeline as it was named, which the page shows, and where it lies.
    named: PathBuf,
    place: PathBuf,
    set: Vec<String>,
}

impl Asked {
    fn of(path: &Path, set: &[String]) -> Asked {
        Asked { named: path.into(), place: outputs::full(path), set: set.into() }
    }
}

/// Beside the manifest.
const NAME: &str = ".unchanged";

/// Number of nodes of the study at `path`, where nothing that a run of all of it looks at has changed since [`note`].
pub fn nodes(path: &Path, set: &[String], folder: &Path, store: &Store) -> Option<usize> {
    let notes: Notes = sealed::read(&folder.join(NAME))?;
    let is_same = |(path, digest): &(PathBuf, [u8; 32])| {
        named_file::read(path).is_ok_and(|bytes| Digest::of(&bytes).bytes() == digest)
    };
    let is_unchanged = notes.asked == Asked::of(path, set)
        && notes.files.iter().all(is_same)
        && store.stands(&notes.standing)
        && history::ended_with(store, &pipeline::name(path), &notes.mark)
        && outputs::stand(folder, &notes.study);
    is_unchanged.then_some(notes.nodes)
}

/// Notes a run of all of a study that found every result in the store; any other one is not worth it, or not sound.
pub fn note(
    pipeline: &Pipeline,
    set: &[String],
    plan: &Plan,
    report: &Report,
    store: &Store,
    folder: &Path,
    written: &Written,
) {
    // What `region` left out follows from the files alone, and is on the page.
    let is_silent =
        pipeline.remarks.len() == pipeline.regions.len() && pipeline.choose.0.is_empty() && plan.engines.is_empty();
    if !is_silent || !report.outcomes.iter().all(|outcome| matches!(outcome, Outcome::Hit(_))) {
        return;
    }
    let Some(standing) = store.standing(report.keys.iter().copied().flatten()) else { return };
    let files = pipeline.files.iter().chain(&plan.read);
    let notes = Notes {
        asked: Asked::of(&pipeline.path, set),
        files: files.map(|(path, digest)| (path.clone(), *digest.bytes())).collect(),
        nodes: plan.nodes.len(),
        standing,
        mark: history::mark(report),
        study: written.study.clone(),
    };
    // Where it can't be written the next run goes the long way.
    let _ = sealed::publish(&folder.join(NAME), &notes);
}
