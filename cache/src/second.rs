//! Results from another store, a folder or a bucket: fetched when they are asked for, or copied all at once; checked on
//! arrival, and the other store is only read but for `push`.
#[cfg(feature = "s3")]
use crate::bucket::Bucket;
use crate::store::{self, Found, Store};
use crate::{Digest, Entry, StoreError, own};
use std::path::Path;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Results under way to or from a bucket at once: it answers many requests as quickly as one.
const AT_ONCE: usize = 16;

/// Another store.
pub enum Second {
    /// A folder.
    Folder(Store),
    /// A bucket of an S3-compatible service.
    #[cfg(feature = "s3")]
    Bucket(Bucket),
}

/// What a copy did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Copied {
    /// Results that were copied.
    pub results: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Results that were there already.
    pub known: usize,
    /// Results that are not whole where they come from.
    pub damaged: usize,
}

impl Second {
    /// The store in a folder, or `s3://BUCKET/PREFIX`; makes nothing, and asks no service yet.
    ///
    /// # Errors
    /// As [`Store::open`]; [`StoreError::NoS3`] where this program was built without.
    pub fn open(place: &Path) -> Result<Second, StoreError> {
        match place.to_str().filter(|text| text.starts_with("s3://")) {
            #[cfg(feature = "s3")]
            Some(url) => Ok(Second::Bucket(Bucket::new(url))),
            #[cfg(not(feature = "s3"))]
            Some(_) => Err(StoreError::NoS3),
            None => Ok(Second::Folder(Store::open(place)?)),
        }
    }

    /// Where it is.
    pub fn name(&self) -> String {
        match self {
            Second::Folder(store) => store.folder().display().to_string(),
            #[cfg(feature = "s3")]
            Second::Bucket(bucket) => bucket.url().into(),
        }
    }

    /// Bytes of a shelf, or none. A folder that can't be read is as if it had nothing.
    fn read(&self, shelf: &str, d: Digest) -> Result<Option<Vec<u8>>, StoreError> {
        match self {
            Second::Folder(store) => Ok(own::read(&store.path(shelf, d)).ok()),
            #[cfg(feature = "s3")]
            Second::Bucket(bucket) => bucket.read(shelf, d),
        }
    }

    fn keys(&self) -> Result<Vec<Digest>, StoreError> {
        match self {
            Second::Folder(store) => Ok(store.keys()),
            #[cfg(feature = "s3")]
            Second::Bucket(bucket) => bucket.keys(),
        }
    }
}

/// Record, recipe and result of a key, all there and whole.
struct Whole {
    record: crate::Record,
    recipe: crate::Recipe,
    object: Vec<u8>,
}

impl Whole {
    fn read(from: &Second, key: Digest) -> Result<Option<Whole>, StoreError> {
        let Some(record) = from.read("results", key)?.and_then(|bytes| store::read_record(key, &bytes)) else {
            return Ok(None);
        };
        let Some(object) = from.read("objects", record.output)?.filter(|bytes| Digest::of(bytes) == record.output)
        else {
            return Ok(None);
        };
        let recipe = from.read("recipes", key)?.and_then(|bytes| store::read_recipe(key, &bytes));
        Ok(recipe.map(|recipe| Whole { record, recipe, object }))
    }
}

impl Store {
    /// This store, which serves what it lacks from `second`.
    pub fn with_second(mut self, second: Second) -> Store {
        self.second = Some(Box::new(second));
        self
    }

    /// What the second store has for `key`, now in this one.
    pub(crate) fn look_behind(&self, key: Digest) -> Option<Entry> {
        let second = self.second.as_ref().filter(|_| !self.second_is_lost.load(Ordering::Relaxed))?;
        match Whole::read(second, key) {
            // This one can't be written: as if the other had nothing.
            Ok(whole) => self.take(whole?).ok(),
            Err(e) => {
                if !self.second_is_lost.swap(true, Ordering::Relaxed) {
                    self.notice(format!("{e}: the run goes on without it"));
                }
                None
            }
        }
    }

    fn take(&self, whole: Whole) -> Result<Entry, StoreError> {
        self.put(&whole.object)?;
        self.record(&whole.recipe, &whole.record)?;
        Ok(whole.record.entry())
    }

    /// Copies every result that another store has and this one lacks.
    ///
    /// # Errors
    /// [`StoreError`] where the other one can't be asked, or this one not be written; what came before stays.
    pub fn pull(&self, from: &Second) -> Result<Copied, StoreError> {
        each(&from.keys()?, |key| {
            if matches!(self.find_here(key), Found::Whole(_)) {
                return Ok(Copied { known: 1, ..Copied::default() });
            }
            match Whole::read(from, key)? {
                Some(whole) => Ok(Copied { results: 1, bytes: self.take(whole)?.bytes, ..Copied::default() }),
                None => Ok(Copied { damaged: 1, ..Copied::default() }),
            }
        })
    }

    /// Copies every result that this store has to another one that lacks it.
    ///
    /// # Errors
    /// As [`Store::pull`].
    pub fn push(self, to: &Second) -> Result<Copied, StoreError> {
        match to {
            Second::Folder(store) => store.pull(&Second::Folder(self)),
            #[cfg(feature = "s3")]
            Second::Bucket(bucket) => {
                let (keys, there) = (self.keys(), bucket.keys()?);
                let there: std::collections::HashSet<Digest> = there.into_iter().collect();
                let own = Second::Folder(self);
                each(&keys, |key| {
                    if there.contains(&key) {
                        return Ok(Copied { known: 1, ..Copied::default() });
                    }
                    let Some(whole) = Whole::read(&own, key)? else {
                        return Ok(Copied { damaged: 1, ..Copied::default() });
                    };
                    let bytes = whole.object.len() as u64;
                    let copy = |shelf| Ok::<_, StoreError>(own.read(shelf, key)?.unwrap_or_default());
                    // The record last: whoever finds it finds all.
                    bucket.write("objects", whole.record.output, whole.object)?;
                    bucket.write("recipes", key, copy("recipes")?)?;
                    bucket.write("results", key, copy("results")?)?;
                    Ok(Copied { results: 1, bytes, ..Copied::default() })
                })
            }
        }
    }
}

/// Does `work` for all keys, some at once, and adds up; the first error ends it.
fn each(keys: &[Digest], work: impl Fn(Digest) -> Result<Copied, StoreError> + Sync) -> Result<Copied, StoreError> {
    let (next, all, failed) = (AtomicUsize::new(0), Mutex::new(Copied::default()), Mutex::new(None));
    let worker = || {
        while let Some(&key) = keys.get(next.fetch_add(1, Ordering::Relaxed)) {
            match work(key) {
                Ok(one) => {
                    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                    all.results += one.results;
                    all.bytes += one.bytes;
                    all.known += one.known;
                    all.damaged += one.damaged;
                }
                Err(e) => {
                    next.store(keys.len(), Ordering::Relaxed);
                    failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(e);
                }
            }
        }
    };
    std::thread::scope(|scope| (0..AT_ONCE.min(keys.len())).for_each(|_| drop(scope.spawn(worker))));
    match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(e) => Err(e),
        None => Ok(all.into_inner().unwrap_or_else(PoisonError::into_inner)),
    }
}
