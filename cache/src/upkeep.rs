//! Upkeep of a store: count it, verify every byte, repair it, and remove what nobody needs.
use crate::index::{Index, Known};
use crate::lock;
use crate::store::{self, Store, time_of};
use crate::{Digest, Record, StoreError, own};
use std::collections::{HashMap, HashSet};
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Files of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shelf {
    /// How many.
    pub count: usize,
    /// Their bytes.
    pub bytes: u64,
}

/// What a store holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Results by digest.
    pub objects: Shelf,
    /// What came of each key.
    pub results: Shelf,
    /// What was asked for each key.
    pub recipes: Shelf,
    /// Checkpoints of what was stopped.
    pub partial: Shelf,
    /// What was damaged and moved aside.
    pub damaged: Shelf,
    /// What was being written.
    pub tmp: Shelf,
    /// The index [B].
    pub index: u64,
}

impl Stats {
    /// All bytes.
    pub fn bytes(&self) -> u64 {
        let shelves = [self.objects, self.results, self.recipes, self.partial, self.damaged, self.tmp];
        shelves.iter().map(|s| s.bytes).sum::<u64>() + self.index
    }
}

/// A file that isn't what it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Where it was.
    pub path: PathBuf,
    /// What was found, and what was done.
    pub why: String,
}

/// What a verification found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verified {
    /// Objects that hash to their names.
    pub objects: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Records whose seals fit.
    pub records: usize,
    /// The rest.
    pub problems: Vec<Problem>,
}

/// What a repair did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// Results in the new index.
    pub indexed: usize,
    /// Records removed: damaged, or their object is gone.
    pub records: usize,
    /// Leftovers of killed runs removed from `tmp/` and `locks/`.
    pub leftovers: usize,
}

/// What may stay in a store.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Results beyond these bytes go, oldest first.
    pub max_bytes: Option<u64>,
    /// Results older than this go.
    pub older_than: Option<Duration>,
    /// Keys whose results stay whatever their age and size.
    pub pins: HashSet<Digest>,
    /// Count only, remove nothing.
    pub dry_run: bool,
}

/// What was removed, or would be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Collected {
    /// Results.
    pub results: usize,
    /// Files of any kind.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Bytes that stay.
    pub left: u64,
}

/// Younger files may belong to a run that goes on.
const SETTLED: Duration = Duration::from_secs(3600);

struct Found {
    path: PathBuf,
    /// The digest that its path spells, if it does.
    name: Option<Digest>,
    meta: Metadata,
}

impl Found {
    fn age(&self) -> Duration {
        // A time in the future (a clock set back) is no age.
        self.meta.modified().ok().and_then(|t| SystemTime::now().duration_since(t).ok()).unwrap_or_default()
    }
}

/// Every file on a shelf, in the order of names; a symbolic link is a file, wherever it leads. A shelf that isn't there is empty.
fn files(shelf: &Path) -> Vec<Found> {
    let mut all = Vec::new();
    let mut todo = vec![(shelf.to_path_buf(), String::new())];
    while let Some((folder, prefix)) = todo.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let (path, Ok(meta)) = (entry.path(), entry.metadata()) else { continue };
            let spelled = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if meta.is_dir() {
                todo.push((path, spelled));
            } else {
                all.push(Found { path, name: spelled.parse().ok(), meta });
            }
        }
    }
    all.sort_by(|a, b| a.path.cmp(&b.path));
    all
}

fn count(shelf: &Path) -> Shelf {
    let found = files(shelf);
    Shelf { count: found.len(), bytes: found.iter().map(|f| f.meta.len()).sum() }
}

impl Store {
    /// Counts what the store holds.
    pub fn stats(&self) -> Stats {
        let shelf = |name: &str| count(&self.root.join(name));
        Stats {
            objects: shelf("objects"),
            results: shelf("results"),
            recipes: shelf("recipes"),
            partial: shelf("partial"),
            damaged: shelf("damaged"),
            tmp: shelf("tmp"),
            index: fs::metadata(self.root.join("index")).map_or(0, |m| m.len()),
        }
    }

    /// Keys that processes compute just now.
    pub fn claimed(&self) -> Vec<Digest> {
        self.files("locks").iter().filter(|f| lock::is_held(&f.path)).filter_map(|f| f.name).collect()
    }

    /// Keys of all results on record.
    pub(crate) fn keys(&self) -> Vec<Digest> {
        self.files("results").into_iter().filter_map(|f| f.name).collect()
    }

    /// Every result on record, by key.
    pub fn records(&self) -> Vec<(Digest, Record)> {
        let found = self.files("results").into_iter();
        found.filter_map(|f| Some((f.name?, store::read_record(f.name?, &own::read(&f.path).ok()?)?))).collect()
    }

    /// Reads and hashes every object, checks every record, recipe, checkpoint and the index; moves aside what is damaged.
    pub fn verify(&self) -> Verified {
        let mut all = Verified::default();
        for found in self.files("objects") {
            let bytes = own::read(&found.path).unwrap_or_default();
            if found.name == Some(Digest::of(&bytes)) {
                all.objects += 1;
                all.bytes += bytes.len() as u64;
            } else {
                self.put_aside(&found, "its bytes don't hash to its name", &mut all.problems);
            }
        }
        for found in self.files("results") {
            let read = || store::read_record(found.name?, &own::read(&found.path).ok()?);
            match read() {
                None => self.put_aside(&found, "its seal doesn't fit", &mut all.problems),
                Some(record) if !self.path("objects", record.output).exists() => {
                    let why = format!("its result {} is gone: run again, or `hvi-flow cache repair`", record.output);
                    all.problems.push(Problem { path: found.path, why });
                }
                Some(_) => all.records += 1,
            }
        }
        for found in self.files("recipes") {
            let read = || store::read_recipe(found.name?, &own::read(&found.path).ok()?);
            if read().is_none() {
                self.put_aside(&found, "it doesn't hash to its name", &mut all.problems);
            }
        }
        for found in self.files("partial") {
            if found.name.is_none_or(|key| self.partial(key).is_none()) {
                let why = "a damaged checkpoint: removed".into();
                all.problems.push(Problem { path: found.path, why });
            }
        }
        let path = self.root.join("index");
        let broken = Index::broken(&path);
        if broken > 0 {
            let why = format!("{broken} entries are damaged: {}", store::set_index_aside(&self.root));
            all.problems.push(Problem { path: path.clone(), why });
            *self.index() = Index::empty(path);
        }
        all
    }

    fn put_aside(&self, found: &Found, why: &str, problems: &mut Vec<Problem>) {
        let name = found.path.strip_prefix(&self.root).unwrap_or(&found.path).to_string_lossy().replace('/', "-");
        self.set_aside(&found.path, &name);
        problems.push(Problem { path: found.path.clone(), why: format!("{why}: moved aside to `damaged/{name}`") });
    }

    /// Removes records that are damaged or whose object is gone and what killed runs left, and writes the index anew.
    ///
    /// # Errors
    /// [`StoreError::Busy`] where a run uses the store; others where it can't be written.
    pub fn repair(&self) -> Result<Repaired, StoreError> {
        let _alone = self.held(true)?;
        let mut done = Repaired::default();
        let mut entries: HashMap<Digest, Known> = HashMap::new();
        for found in self.files("results") {
            let read = || {
                let key = found.name?;
                let record = store::read_record(key, &own::read(&found.path).ok()?)?;
                let object = fs::symlink_metadata(self.path("objects", record.output)).ok()?;
                let entry = record.entry();
                (object.len() == record.bytes).then(|| (key, Known { entry, object_time: time_of(&object) }))
            };
            match read() {
                // A time that the index doesn't know means that the object is hashed when it is next looked up.
                Some((key, known)) => drop(entries.insert(key, Known { object_time: self.time_seen(key), ..known })),
                None => {
                    fs::remove_file(&found.path).map_err(StoreError::write(&found.path))?;
                    done.records += 1;
                }
            }
        }
        done.indexed = entries.len();
        self.rewrite_index(&entries)?;
        for found in self.unfinished() {
            done.leftovers += usize::from(fs::remove_file(&found.path).is_ok());
        }
        done.leftovers += self.free_locks();
        Ok(done)
    }

    fn time_seen(&self, key: Digest) -> i64 {
        self.index().get(key).ok().flatten().map_or(i64::MIN, |known| known.object_time)
    }

    fn rewrite_index(&self, entries: &HashMap<Digest, Known>) -> Result<(), StoreError> {
        let mut sorted: Vec<(Digest, Known)> = entries.iter().map(|(key, known)| (*key, *known)).collect();
        sorted.sort_by_key(|(key, _)| *key);
        let path = self.root.join("index");
        self.publish(&path, &Index::of(sorted.into_iter()))?;
        *self.index() = Index::load(path.clone()).unwrap_or_else(|_| Index::empty(path));
        Ok(())
    }

    /// What killed runs left in `tmp/`.
    fn unfinished(&self) -> Vec<Found> {
        self.files("tmp").into_iter().filter(|f| f.age() > SETTLED).collect()
    }

    /// Removes the files of locks that nobody holds; returns their number.
    fn free_locks(&self) -> usize {
        let free = |f: &Found| f.name.is_some_and(|key| matches!(self.claim(key), Ok(Some(_))));
        self.files("locks").iter().filter(|f| free(f)).count()
    }

    /// Removes results by age and size, oldest first, but for those that are pinned; then what belongs to no result.
    ///
    /// # Errors
    /// [`StoreError::Busy`] where a run uses the store; others where it can't be written.
    pub fn gc(&self, limits: &Limits) -> Result<Collected, StoreError> {
        let _alone = if limits.dry_run { None } else { Some(self.held(true)?) };
        let (results, recipes, objects) = (self.files("results"), self.files("recipes"), self.files("objects"));
        let (kept, outputs) = self.keep(&results, &recipes, &objects, limits);
        let is = |set: &HashSet<Digest>, f: &Found| f.name.is_some_and(|d| set.contains(&d));
        let known: HashMap<Digest, Known> =
            kept.iter().filter_map(|key| Some((*key, self.index().get(*key).ok()??))).collect();
        let mut going: Vec<Found> = results.into_iter().filter(|f| !is(&kept, f)).collect();
        let mut done = Collected { results: going.len(), ..Collected::default() };
        going.extend(recipes.into_iter().filter(|f| !is(&kept, f)));
        going.extend(objects.into_iter().filter(|f| !is(&outputs, f)));
        let old = |f: &Found| limits.older_than.is_none_or(|age| f.age() > age);
        going.extend(
            self.files("partial").into_iter().filter(|f| !f.name.is_some_and(|d| limits.pins.contains(&d)) && old(f)),
        );
        going.extend(self.files("damaged"));
        going.extend(self.unfinished());
        done.files = going.len();
        done.bytes = going.iter().map(|f| f.meta.len()).sum();
        done.left = self.stats().bytes().saturating_sub(done.bytes);
        if !limits.dry_run {
            // Before the objects go: an index never promises what isn't there for longer than this takes.
            self.rewrite_index(&known)?;
            going.iter().try_for_each(|f| fs::remove_file(&f.path).map_err(StoreError::write(&f.path)))?;
            self.free_locks();
        }
        Ok(done)
    }

    fn files(&self, shelf: &str) -> Vec<Found> {
        files(&self.root.join(shelf))
    }

    /// The keys whose results stay, and the objects that these need.
    fn keep(
        &self,
        results: &[Found],
        recipes: &[Found],
        objects: &[Found],
        limits: &Limits,
    ) -> (HashSet<Digest>, HashSet<Digest>) {
        let sizes = |found: &[Found]| -> HashMap<Digest, u64> {
            found.iter().filter_map(|f| Some((f.name?, f.meta.len()))).collect()
        };
        let (recipes, objects) = (sizes(recipes), sizes(objects));
        let pinned = |f: &&Found| f.name.is_some_and(|key| limits.pins.contains(&key));
        // Pinned ones first: they count against the size, and leave what is over to the others, youngest first.
        let mut order: Vec<&Found> = results.iter().collect();
        order.sort_by_key(|f| (!pinned(f), std::cmp::Reverse(time_of(&f.meta))));
        let (mut kept, mut outputs, mut total) = (HashSet::new(), HashSet::new(), 0);
        for found in order {
            let read = || Some((found.name?, store::read_record(found.name?, &own::read(&found.path).ok()?)?));
            let Some((key, record)) = read() else { continue };
            let object =
                if outputs.contains(&record.output) { 0 } else { objects.get(&record.output).copied().unwrap_or(0) };
            let size = found.meta.len() + recipes.get(&key).copied().unwrap_or(0) + object;
            let too_old = limits.older_than.is_some_and(|age| found.age() > age);
            let too_much = limits.max_bytes.is_some_and(|most| total + size > most);
            if pinned(&found) || !(too_old || too_much) {
                total += size;
                kept.insert(key);
                outputs.insert(record.output);
            }
        }
        (kept, outputs)
    }
}
