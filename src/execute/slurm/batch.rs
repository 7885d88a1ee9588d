//! What was submitted to Slurm, as files in the store's `slurm/`: batches, notes of failures, logs.
use super::super::worker::Came;
use hvi_cache::Digest;
use hvi_kit::Store;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// One submission: an array of tasks that ask for the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// Name of the study that it was submitted for.
    pub study: String,
    /// Threads of each task.
    pub threads: usize,
    /// How long a node goes on before it keeps what it needs to go on from there [s].
    pub checkpoint_s: f64,
    /// What each task computes, one after the other.
    pub tasks: Vec<Vec<Work>>,
}

/// One node of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// Its key: the recipe is in the store.
    pub key: Digest,
    /// Core-seconds that its stage predicts.
    pub cost: f64,
    /// The longest it may take [s].
    pub timeout_s: Option<f64>,
}

impl Batch {
    /// Writes the batch under a name that no other has; returns the name.
    ///
    /// # Errors
    /// Where it can't be written.
    pub fn publish(&self, store: &Store) -> io::Result<String> {
        let body = serde_json::to_vec(self)?;
        let since = std::time::UNIX_EPOCH.elapsed().unwrap_or_default().as_nanos();
        let mark = Digest::of_all(&[&body, &since.to_le_bytes(), &std::process::id().to_le_bytes()]).short();
        // In the order of their names later ones come later.
        let name = format!("{:08x}{mark}", since / 1_000_000_000);
        fs::create_dir_all(folder(store).join("logs"))?;
        publish(&path(store, &name), &body)?;
        Ok(name)
    }

    /// The batch called `name`.
    pub fn read(store: &Store, name: &str) -> Option<Batch> {
        is_name(name).then(|| read(&path(store, name)))?
    }
}

/// Whether a batch can have this name: it becomes one of a file, and of jobs. A store may come from others, and Slurm takes lists
/// where it takes names.
pub fn is_name(name: &str) -> bool {
    name.len() == 20 && name.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

fn read(path: &Path) -> Option<Batch> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// Where all of it lies.
pub fn folder(store: &Store) -> PathBuf {
    store.folder().join("slurm")
}

/// The file of a batch.
pub fn path(store: &Store, name: &str) -> PathBuf {
    folder(store).join(format!("{name}.json"))
}

/// What a task printed.
pub fn log(store: &Store, name: &str, task: usize) -> PathBuf {
    folder(store).join("logs").join(format!("{name}_{task}.log"))
}

/// `: LINE`, the last line of a log that says something, cut short.
pub fn last_line(log: &Path) -> String {
    let text = fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    let last = text.lines().rev().map(str::trim).find(|line| !line.is_empty());
    last.map_or_else(String::new, |line| format!(": {}", line.chars().take(200).collect::<String>()))
}

/// Every batch, by name: the oldest first.
pub fn all(store: &Store) -> Vec<(String, Batch)> {
    let entries = fs::read_dir(folder(store)).into_iter().flatten().flatten();
    let named = entries.filter_map(|e| {
        let path = e.path();
        let name = path.file_name()?.to_str()?.strip_suffix(".json")?.to_string();
        if is_name(&name) { Some((name, read(&path)?)) } else { None }
    });
    let mut all: Vec<_> = named.collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// Removes a batch and its logs, but for those of tasks in which something failed.
pub fn remove(store: &Store, name: &str) {
    if let Some(batch) = Batch::read(store, name) {
        let notes = notes(store);
        for (task, works) in batch.tasks.iter().enumerate() {
            if !works.iter().any(|work| notes.contains(&work.key)) {
                let _ = fs::remove_file(log(store, name, task));
            }
        }
    }
    let _ = fs::remove_file(path(store, name));
}

/// Why a job has no result for a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// Why, in words.
    pub why: String,
    /// Whether another try may do better.
    pub transient: bool,
    /// An input that the store had is damaged or gone.
    pub lost: Option<Digest>,
}

impl Note {
    /// The note of what came of a job; none where there is a result, or it goes on later.
    pub fn of(came: &Came) -> Option<Note> {
        match came {
            Came::Made(_) | Came::Stopped => None,
            Came::Lost(digest) => Some(Note { why: String::new(), transient: true, lost: Some(*digest) }),
            Came::Failed { why, transient } => Some(Note { why: why.clone(), transient: *transient, lost: None }),
        }
    }

    /// What came of it.
    pub fn came(self) -> Came {
        match self.lost {
            Some(digest) => Came::Lost(digest),
            None => Came::Failed { why: self.why, transient: self.transient },
        }
    }

    /// Writes the note of `key`.
    ///
    /// # Errors
    /// Where it can't be written.
    pub fn publish(&self, store: &Store, key: Digest) -> io::Result<()> {
        publish(&failed(store).join(key.hex().as_str()), &serde_json::to_vec(self)?)
    }

    /// The note of `key`, if there is one.
    pub fn read(store: &Store, key: Digest) -> Option<Note> {
        serde_json::from_slice(&fs::read(failed(store).join(key.hex().as_str())).ok()?).ok()
    }
}

fn failed(store: &Store) -> PathBuf {
    folder(store).join("failed")
}

/// Keys that there are notes of.
pub fn notes(store: &Store) -> HashSet<Digest> {
    let entries = fs::read_dir(failed(store)).into_iter().flatten().flatten();
    entries.filter_map(|e| e.file_name().to_str()?.parse().ok()).collect()
}

/// Removes the note of `key`.
pub fn forget(store: &Store, key: Digest) {
    let _ = fs::remove_file(failed(store).join(key.hex().as_str()));
}

/// Writes beside the file, then renames: a reader sees all of it or none.
fn publish(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = folder.join(format!(".{}.{name}", std::process::id()));
    fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, path)).inspect_err(|_| drop(fs::remove_file(&beside)))
}
