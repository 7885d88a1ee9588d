//! Results from another store: fetched when they are asked for, or copied all at once; checked on arrival, and the other
//! store is only read.
use crate::store::{self, Found, Store};
use crate::{Digest, Entry, StoreError};
use std::fs;

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

impl Store {
    /// This store, which serves what it lacks from `second`.
    pub fn with_second(mut self, second: Store) -> Store {
        self.second = Some(Box::new(second));
        self
    }

    /// What the second store has for `key`, now in this one.
    pub(crate) fn look_behind(&self, key: Digest) -> Option<Entry> {
        let second = self.second.as_ref()?;
        // A second store that can't be read, or this one not written: as if it had nothing.
        self.fetch(second, key).ok()?
    }

    /// Copies recipe, result and record of `key` from another store, if they are all there and whole.
    ///
    /// # Errors
    /// [`StoreError`] where they can't be written here.
    pub fn fetch(&self, from: &Store, key: Digest) -> Result<Option<Entry>, StoreError> {
        let whole = || {
            let record = store::read_record(key, &fs::read(from.path("results", key)).ok()?)?;
            let object = fs::read(from.path("objects", record.output)).ok()?;
            (Digest::of(&object) == record.output).then_some((from.recipe(key)?, record, object))
        };
        let Some((recipe, record, object)) = whole() else { return Ok(None) };
        self.put(&object)?;
        self.record(&recipe, &record)?;
        Ok(Some(record.entry()))
    }

    /// Copies every result that another store has and this one lacks.
    ///
    /// # Errors
    /// [`StoreError`] where one can't be written here; those before it stay.
    pub fn fetch_all(&self, from: &Store) -> Result<Copied, StoreError> {
        let mut copied = Copied::default();
        for key in from.keys() {
            if matches!(self.find(key), Found::Whole(_)) {
                copied.known += 1;
            } else if let Some(entry) = self.fetch(from, key)? {
                copied.results += 1;
                copied.bytes += entry.bytes;
            } else {
                copied.damaged += 1;
            }
        }
        Ok(copied)
    }
}
