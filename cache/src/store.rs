//! The store on disk: `recipes/`, `results/`, `objects/`, `tmp/`, `damaged/`.
//!
//! Publishing is write-to-`tmp`-then-rename, so it is atomic and idempotent: a reader sees all of a file or none of it,
//! and two writers of one key write the same bytes. No lock is needed for correctness.
use crate::{Digest, Recipe};
use serde::{Deserialize, Serialize};
use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

/// Why the store could not serve.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum StoreError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error("object {0} was damaged: it was moved aside to `damaged/`; run again to recompute it")]
    Damaged(Digest),
    #[error(
        "{path}: this store has format {found}, this program reads {FORMAT}: use another --store, or the program that wrote it"
    )]
    Format { path: PathBuf, found: String },
}

const FORMAT: &str = "hvi-store/1";

/// Ties a record to its key: one that was damaged, or moved to another key's place, doesn't fit its seal.
fn seal_of(key: Digest, json: &str) -> String {
    Digest::of(format!("{key}\n{json}").as_bytes()).to_string()
}

/// What came of a recipe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Digest of the result's bytes.
    pub output: Digest,
    /// Kind of artifact.
    pub kind: String,
    /// Number of bytes.
    pub bytes: u64,
    /// Wall time it took [s].
    pub wall_s: f64,
    /// CPU time of the thread that computed it [s].
    pub cpu_s: f64,
    /// Host it was computed on.
    pub host: String,
}

/// A store: a folder of results by what was asked.
pub struct Store {
    root: PathBuf,
    serial: AtomicU64,
}

impl Store {
    /// Opens the store in folder `root`, made if absent.
    ///
    /// # Errors
    /// [`StoreError::Io`] where the folder can't be made or read; [`StoreError::Format`] where it holds another format.
    pub fn open(root: impl Into<PathBuf>) -> Result<Store, StoreError> {
        let store = Store { root: root.into(), serial: AtomicU64::new(0) };
        let path = store.root.join("format");
        match fs::read_to_string(&path) {
            Ok(found) if found.trim() == FORMAT => return Ok(store),
            Ok(found) => return Err(StoreError::Format { path, found: found.trim().chars().take(40).collect() }),
            Err(_) => {}
        }
        for shelf in ["recipes", "results", "objects", "tmp"] {
            let path = store.root.join(shelf);
            fs::create_dir_all(&path).map_err(|source| StoreError::Io { path, source })?;
        }
        store.publish(&path, FORMAT.as_bytes())?;
        Ok(store)
    }

    fn path(&self, shelf: &str, d: Digest) -> PathBuf {
        let hex = d.to_string();
        self.root.join(shelf).join(&hex[..2]).join(&hex[2..])
    }

    /// Writes to a file of its own in `tmp/`, then renames.
    fn publish(&self, to: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        let at = |path: &Path| {
            let path = path.to_path_buf();
            move |source| StoreError::Io { path, source }
        };
        let shelf = self.root.join("tmp");
        for folder in [to.parent().expect("a file in the store has a folder"), &shelf] {
            fs::create_dir_all(folder).map_err(at(folder))?;
        }
        let (tmp, mut file) = self.new_file(&shelf).map_err(at(&shelf))?;
        let written = file.write_all(bytes).map_err(at(&tmp)).and_then(|()| fs::rename(&tmp, to).map_err(at(to)));
        if written.is_err() {
            let _ = fs::remove_file(&tmp);
        }
        written
    }

    /// A file that no other process has, also where process numbers repeat (two hosts, two containers).
    fn new_file(&self, shelf: &Path) -> io::Result<(PathBuf, fs::File)> {
        loop {
            let serial = self.serial.fetch_add(1, Ordering::Relaxed);
            let path = shelf.join(format!("{}-{serial}", std::process::id()));
            match fs::OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((path, file)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }

    /// Stores `bytes` under their digest.
    ///
    /// # Errors
    /// [`StoreError::Io`] where they can't be written.
    pub fn put(&self, bytes: &[u8]) -> Result<Digest, StoreError> {
        let d = Digest::of(bytes);
        let path = self.path("objects", d);
        if fs::read(&path).map_or(true, |found| found != bytes) {
            self.publish(&path, bytes)?;
        }
        Ok(d)
    }

    /// The bytes with digest `d`. Bytes that don't hash to `d` are moved to `damaged/`.
    ///
    /// # Errors
    /// [`StoreError::Io`] where they can't be read, [`StoreError::Damaged`] where they aren't what they should be.
    pub fn get(&self, d: Digest) -> Result<Vec<u8>, StoreError> {
        let path = self.path("objects", d);
        let bytes = fs::read(&path).map_err(|source| StoreError::Io { path: path.clone(), source })?;
        if Digest::of(&bytes) == d {
            return Ok(bytes);
        }
        self.set_aside(&path, d);
        Err(StoreError::Damaged(d))
    }

    fn set_aside(&self, path: &Path, d: Digest) {
        let aside = self.root.join("damaged");
        let moved = fs::create_dir_all(&aside).and_then(|()| fs::rename(path, aside.join(d.to_string())));
        if moved.is_err() {
            let _ = fs::remove_file(path);
        }
    }

    /// What came of `key`, if it is known. A record that isn't whole, or belongs to another key, counts as unknown.
    pub fn lookup(&self, key: Digest) -> Option<Record> {
        let text = fs::read_to_string(self.path("results", key)).ok()?;
        let (seal, json) = text.split_once('\n')?;
        if seal != seal_of(key, json) {
            return None;
        }
        serde_json::from_str(json).ok()
    }

    /// Whether the object with digest `d` is there and whole; changes nothing.
    pub fn holds(&self, d: Digest) -> bool {
        fs::read(self.path("objects", d)).is_ok_and(|bytes| Digest::of(&bytes) == d)
    }

    /// Publishes what came of `recipe`.
    ///
    /// # Errors
    /// [`StoreError::Io`] where it can't be written.
    pub fn record(&self, recipe: &Recipe, record: &Record) -> Result<(), StoreError> {
        let key = recipe.key();
        let asked = serde_json::to_vec(recipe).expect("recipes are plain data");
        let came = serde_json::to_string(record).expect("records are plain data");
        self.publish(&self.path("recipes", key), &asked)?;
        self.publish(&self.path("results", key), format!("{}\n{came}", seal_of(key, &came)).as_bytes())
    }

    /// The recipe behind `key`, if it is known.
    pub fn recipe(&self, key: Digest) -> Option<Recipe> {
        let recipe: Recipe = serde_json::from_slice(&fs::read(self.path("recipes", key)).ok()?).ok()?;
        (recipe.key() == key).then_some(recipe)
    }
}
