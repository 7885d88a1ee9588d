//! The store on disk: `recipes/`, `results/` and `objects/`, an `index` of the results, `partial/`, `locks/`, `tmp/`, `damaged/`.
//!
//! Publishing is write-to-`tmp`-then-rename, so it is atomic and idempotent: a reader sees all of a file or none of it,
//! and two writers of one key write the same bytes. No lock is needed for correctness. Opening makes nothing: the folders
//! come with the first thing that is stored, so a store that can't be written still serves what it has.
use crate::error::FORMAT;
use crate::index::{Index, Known};
use crate::lock::{self, Claim, InUse};
use crate::{Digest, Entry, Recipe, Record, Second, StoreError, own};
use rustix::fs::AtFlags;
use std::{
    fs,
    io::{self, Write},
    os::{fd::OwnedFd, unix::fs::MetadataExt},
    path::{Path, PathBuf},
    sync::{
        Mutex, MutexGuard, OnceLock, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};

/// Ties bytes to their key: what was damaged, or moved to another key's place, doesn't fit its seal.
pub(crate) fn seal_of(key: Digest, bytes: &[u8]) -> Digest {
    Digest::of_all(&[key.hex().as_str().as_bytes(), b"\n", bytes])
}

/// What the store has for a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// A result, there and whole.
    Whole(Entry),
    /// It had the result with this digest, whose bytes are damaged or gone.
    Damaged(Digest),
    /// Nothing.
    Nothing,
}

/// A store: a folder of results by what was asked.
pub struct Store {
    pub(crate) root: PathBuf,
    /// Read when it is first needed.
    index: OnceLock<Mutex<Index>>,
    serial: AtomicU64,
    /// The folder of the objects, held open: a look at one of them is then a way of two names.
    objects: OnceLock<OwnedFd>,
    /// Whether this process has seen to it that the folders are there.
    ready: AtomicBool,
    notices: Mutex<Vec<String>>,
    /// Serves what this one lacks.
    pub(crate) second: Option<Box<Second>>,
    /// Whether it could not be asked: it is asked no more.
    pub(crate) second_is_lost: AtomicBool,
}

impl Store {
    /// Opens the store in folder `root`, which may be absent or not writable; makes nothing.
    ///
    /// # Errors
    /// [`StoreError::Format`] where it holds another format; [`StoreError::NoFolder`] where a file is in its place;
    /// [`StoreError::Link`] where one of its folders is a symbolic link;
    /// [`StoreError::Io`] where that can't be read.
    pub fn open(root: impl Into<PathBuf>) -> Result<Store, StoreError> {
        let root = root.into();
        check_place(&root)?;
        check_links(&root)?;
        check_format(&root)?;
        let (serial, ready) = (AtomicU64::new(0), AtomicBool::new(false));
        let (index, objects, notices) = (OnceLock::new(), OnceLock::new(), Mutex::default());
        let second_is_lost = AtomicBool::new(false);
        Ok(Store { root, index, serial, objects, ready, notices, second: None, second_is_lost })
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.root
    }

    /// What was found damaged and moved aside since the last call, one sentence each.
    pub fn notices(&self) -> Vec<String> {
        std::mem::take(&mut self.notices.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(crate) fn notice(&self, text: String) {
        self.notices.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    }

    pub(crate) fn index(&self) -> MutexGuard<'_, Index> {
        let index = self.index.get_or_init(|| {
            let at = self.root.join("index");
            let read = Index::load(at.clone()).unwrap_or_else(|_| {
                self.notice(set_index_aside(&self.root));
                Index::empty(at)
            });
            Mutex::new(read)
        });
        index.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn path(&self, shelf: &str, d: Digest) -> PathBuf {
        let hex = d.hex();
        let (first, rest) = hex.as_str().split_at(2);
        let mut path = PathBuf::with_capacity(self.root.as_os_str().len() + 80);
        path.extend([self.root.as_path(), Path::new(shelf), Path::new(first), Path::new(rest)]);
        path
    }

    /// Makes the folders and says which format they have.
    fn prepare(&self) -> Result<(), StoreError> {
        if self.ready.load(Ordering::Acquire) {
            return Ok(());
        }
        for shelf in ["recipes", "results", "objects", "tmp", "locks", "partial"] {
            let path = self.root.join(shelf);
            fs::create_dir_all(&path).map_err(StoreError::write(&path))?;
        }
        let path = self.root.join("format");
        if own::read(&path).map_or(true, |found| found != format_file().as_bytes()) {
            self.publish_to(&path, format_file().as_bytes())?;
        }
        self.ready.store(true, Ordering::Release);
        Ok(())
    }

    /// Writes to a file of its own in `tmp/`, then renames.
    pub(crate) fn publish(&self, to: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        self.prepare()?;
        self.publish_to(to, bytes)
    }

    fn publish_to(&self, to: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        let folder = to.parent().unwrap_or(&self.root);
        if folder != self.root && own::is_link(folder) {
            return Err(StoreError::Link { path: folder.into() });
        }
        let shelf = self.root.join("tmp");
        let (tmp, mut file) = self.new_file(&shelf).map_err(StoreError::write(&shelf))?;
        let written = file.write_all(bytes).map_err(StoreError::write(&tmp));
        drop(file);
        let written = written.and_then(|()| rename(&tmp, to).map_err(StoreError::write(to)));
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
                // Somebody tidied up meanwhile.
                Err(e) if e.kind() == io::ErrorKind::NotFound => fs::create_dir_all(shelf)?,
                Err(e) => return Err(e),
            }
        }
    }

    /// Stores `bytes` under their digest.
    ///
    /// # Errors
    /// [`StoreError`] where they can't be written.
    pub fn put(&self, bytes: &[u8]) -> Result<Digest, StoreError> {
        let d = Digest::of(bytes);
        let path = self.path("objects", d);
        if own::read(&path).map_or(true, |found| found != bytes) {
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
        let bytes = own::read(&path).map_err(StoreError::read(&path))?;
        if Digest::of(&bytes) == d {
            return Ok(bytes);
        }
        self.set_aside(&path, &d.to_string());
        Err(StoreError::Damaged(d))
    }

    /// Moves a damaged file to `damaged/NAME`, or removes it where that fails.
    pub(crate) fn set_aside(&self, path: &Path, name: &str) {
        let aside = self.root.join("damaged");
        let moved = fs::create_dir_all(&aside).and_then(|()| fs::rename(path, aside.join(name)));
        if moved.is_err() {
            let _ = fs::remove_file(path);
        }
    }

    /// Whether the object with digest `d` is there and whole: reads and hashes it, changes nothing.
    pub fn holds(&self, d: Digest) -> bool {
        own::read(&self.path("objects", d)).is_ok_and(|bytes| Digest::of(&bytes) == d)
    }

    /// What the store has for `key`: from the index, with one look at the object's size and time.
    ///
    /// An object whose time isn't the one the index remembers is hashed; one that it remembers is hashed when it is used
    /// (see [`Store::get`]). What other processes recorded since the store was opened is found too, and what the second
    /// store has, if there is one.
    pub fn find(&self, key: Digest) -> Found {
        match self.find_here(key) {
            Found::Whole(entry) => Found::Whole(entry),
            lacking => self.look_behind(key).map_or(lacking, Found::Whole),
        }
    }

    pub(crate) fn find_here(&self, key: Digest) -> Found {
        let known = self.known(key);
        let entry = match known {
            Some(known) => known.entry,
            None => match self.lookup(key) {
                Some(record) => record.entry(),
                None => return Found::Nothing,
            },
        };
        let Some((bytes, time)) = self.object_mark(entry.output) else { return Found::Damaged(entry.output) };
        if bytes != entry.bytes {
            return Found::Damaged(entry.output);
        }
        if known.is_none_or(|known| known.object_time != time) {
            if !self.holds(entry.output) {
                return Found::Damaged(entry.output);
            }
            self.index().add(key, &Known { entry, object_time: time });
        }
        Found::Whole(entry)
    }

    /// Size [B] of the object with digest `d`, and when it was written [ns since 1970].
    pub(crate) fn object_mark(&self, d: Digest) -> Option<(u64, i64)> {
        let folder = match self.objects.get() {
            Some(folder) => folder,
            None => {
                let opened = fs::File::open(self.root.join("objects")).ok()?;
                self.objects.get_or_init(|| opened.into())
            }
        };
        let (hex, mut name) = (d.hex(), [b'/'; 65]);
        let (first, rest) = hex.as_str().as_bytes().split_at(2);
        name[..2].copy_from_slice(first);
        name[3..].copy_from_slice(rest);
        let there = rustix::fs::statat(folder, &name[..], AtFlags::SYMLINK_NOFOLLOW).ok()?;
        let time = there.st_mtime.wrapping_mul(1_000_000_000).wrapping_add(there.st_mtime_nsec as i64);
        Some((u64::try_from(there.st_size).ok()?, time))
    }

    fn known(&self, key: Digest) -> Option<Known> {
        let mut index = self.index();
        index.get(key).unwrap_or_else(|_| {
            self.notice(set_index_aside(&self.root));
            *index = Index::empty(self.root.join("index"));
            None
        })
    }

    /// What came of `key`, from its record. One that isn't whole, or belongs to another key, is moved aside and counts as
    /// unknown.
    pub fn lookup(&self, key: Digest) -> Option<Record> {
        let path = self.path("results", key);
        let bytes = own::read(&path).ok()?;
        let record = read_record(key, &bytes);
        if record.is_none() {
            self.notice(format!("the record of {} was damaged: it was moved aside to `damaged/`", key.short()));
            self.set_aside(&path, &format!("record-{key}"));
        }
        record
    }

    /// Keys of the `most` latest results of `kind`, the latest first, as far as the index knows them.
    pub fn latest(&self, kind: &str, most: usize) -> Vec<Digest> {
        self.index().latest(kind, most)
    }

    /// Publishes what came of `recipe`.
    ///
    /// # Errors
    /// [`StoreError`] where it can't be written.
    pub fn record(&self, recipe: &Recipe, record: &Record) -> Result<(), StoreError> {
        let key = recipe.key();
        let asked = serde_json::to_vec(recipe).expect("recipes are plain data");
        let came = serde_json::to_string(record).expect("records are plain data");
        self.publish(&self.path("recipes", key), &asked)?;
        let seal = seal_of(key, came.as_bytes());
        self.publish(&self.path("results", key), format!("{seal}\n{came}").as_bytes())?;
        let object = self.path("objects", record.output);
        let object_time = fs::metadata(&object).map_err(StoreError::read(&object)).map(|there| time_of(&there))?;
        self.index().add(key, &Known { entry: record.entry(), object_time });
        Ok(())
    }

    /// Publishes what is asked, so that another process can compute it by its key.
    ///
    /// # Errors
    /// [`StoreError`] where it can't be written.
    pub fn ask(&self, recipe: &Recipe) -> Result<(), StoreError> {
        let asked = serde_json::to_vec(recipe).expect("recipes are plain data");
        self.publish(&self.path("recipes", recipe.key()), &asked)
    }

    /// The recipe behind `key`, if it is known and whole.
    pub fn recipe(&self, key: Digest) -> Option<Recipe> {
        read_recipe(key, &own::read(&self.path("recipes", key)).ok()?)
    }

    /// Claims `key` for this process while it computes it: none where another process or thread has it, whose result
    /// [`Store::find`] has once the claim can be had. A claim ends when it is dropped, or with its process.
    ///
    /// # Errors
    /// [`StoreError`] where the store can't be written, or its file system has no locks: go on without.
    pub fn claim(&self, key: Digest) -> Result<Option<Claim>, StoreError> {
        self.prepare()?;
        let path = self.root.join("locks").join(key.hex().as_str());
        lock::claim(&path).map_err(StoreError::write(&path))
    }

    /// Says that this process uses the store, so that nothing is removed from it meanwhile.
    ///
    /// # Errors
    /// [`StoreError::Busy`] where somebody removes things just now; others where the store can't be written: go on without.
    pub fn hold(&self) -> Result<InUse, StoreError> {
        self.held(false)
    }

    pub(crate) fn held(&self, exclusive: bool) -> Result<InUse, StoreError> {
        self.prepare()?;
        let path = self.root.join("locks/store");
        let held = lock::hold(&path, exclusive).map_err(StoreError::write(&path))?;
        held.ok_or_else(|| StoreError::Busy { path: self.root.clone() })
    }

    /// Keeps what the computation of `key` needs to go on after a stop, in place of what was kept before.
    ///
    /// # Errors
    /// [`StoreError`] where it can't be written.
    pub fn keep_partial(&self, key: Digest, bytes: &[u8]) -> Result<(), StoreError> {
        let mut sealed = seal_of(key, bytes).bytes().to_vec();
        sealed.extend(bytes);
        self.publish(&self.root.join("partial").join(key.hex().as_str()), &sealed)
    }

    /// What was kept for `key`; what is damaged, or was kept for another key, is removed and counts as nothing.
    pub fn partial(&self, key: Digest) -> Option<Vec<u8>> {
        let path = self.root.join("partial").join(key.hex().as_str());
        let mut bytes = own::read(&path).ok()?;
        let whole = bytes.split_first_chunk::<32>().filter(|(seal, body)| seal_of(key, body).bytes() == *seal);
        if whole.is_none() {
            let _ = fs::remove_file(&path);
            return None;
        }
        bytes.drain(..32);
        Some(bytes)
    }

    /// When something was last kept for `key` [ns since 1970]: another time means that somebody came further.
    pub fn partial_mark(&self, key: Digest) -> Option<i64> {
        fs::metadata(self.root.join("partial").join(key.hex().as_str())).ok().map(|there| time_of(&there))
    }

    /// Forgets what was kept for `key`.
    pub fn drop_partial(&self, key: Digest) {
        let _ = fs::remove_file(self.root.join("partial").join(key.hex().as_str()));
    }
}

/// The file that says the format: the format, and a line that proves it.
fn format_file() -> String {
    format!("{FORMAT}\n{}\n", Digest::of(FORMAT.as_bytes()))
}

/// Refuses a place that is, or leads through, something other than a folder.
fn check_place(root: &Path) -> Result<(), StoreError> {
    let is_blocked = match fs::metadata(root) {
        Ok(there) => !there.is_dir(),
        Err(e) => e.kind() == io::ErrorKind::NotADirectory,
    };
    if is_blocked { Err(StoreError::NoFolder { path: root.into() }) } else { Ok(()) }
}

/// Refuses a store with a folder that is a symbolic link: what is moved and removed there would be somebody else's.
fn check_links(root: &Path) -> Result<(), StoreError> {
    let link = own::SHELVES.iter().map(|shelf| root.join(shelf)).find(|path| own::is_link(path));
    link.map_or(Ok(()), |path| Err(StoreError::Link { path }))
}

/// Refuses a store of another format; none is as good as this one. A damaged file says nothing: what lies in the store
/// proves itself.
fn check_format(root: &Path) -> Result<(), StoreError> {
    let path = root.join("format");
    match own::read(&path) {
        Ok(bytes) => {
            let text = String::from_utf8_lossy(&bytes);
            let (found, seal) = text.trim().split_once('\n').unwrap_or((text.trim(), ""));
            let is_whole = seal.is_empty() || seal == Digest::of(found.as_bytes()).hex().as_str();
            let number = found.strip_prefix("hvi-store/").and_then(|n| n.parse::<u32>().ok());
            if found == FORMAT || !is_whole || number.is_none() {
                return Ok(());
            }
            Err(StoreError::Format { path, found: found.chars().take(40).collect() })
        }
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(()),
        Err(_) if own::is_link(&path) => Ok(()),
        Err(source) => Err(StoreError::Io { path, source }),
    }
}

/// Moves a damaged index to `damaged/`; says so.
pub(crate) fn set_index_aside(root: &Path) -> String {
    let aside = root.join("damaged");
    let moved = fs::create_dir_all(&aside).and_then(|()| fs::rename(root.join("index"), aside.join("index")));
    let where_to = if moved.is_ok() { "it was moved aside to `damaged/` and grows anew" } else { "it is not used" };
    format!("the store's index was damaged: {where_to}")
}

fn rename(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            fs::create_dir_all(to.parent().unwrap_or(Path::new("")))?;
            fs::rename(from, to)
        }
        done => done,
    }
}

pub(crate) fn time_of(file: &fs::Metadata) -> i64 {
    file.mtime().wrapping_mul(1_000_000_000).wrapping_add(file.mtime_nsec())
}

pub(crate) fn read_record(key: Digest, bytes: &[u8]) -> Option<Record> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (seal, json) = text.split_once('\n')?;
    if seal != seal_of(key, json.as_bytes()).hex().as_str() {
        return None;
    }
    let record: Record = serde_json::from_str(json).ok()?;
    (record.kind.len() <= Entry::LONGEST_KIND).then_some(record)
}

pub(crate) fn read_recipe(key: Digest, bytes: &[u8]) -> Option<Recipe> {
    let recipe: Recipe = serde_json::from_slice(bytes).ok()?;
    (recipe.key() == key).then_some(recipe)
}
