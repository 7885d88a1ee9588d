//! Results as they stand: what tells later that they all still do, by one look at the index and at each object.
use crate::{Digest, Store};
use serde::{Deserialize, Serialize};
use std::fs;
use std::os::unix::fs::MetadataExt;

/// How the index and the objects of some results looked when the store last found them whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    index: IndexMark,
    /// Digest, size [B] and time [ns since 1970] of each object.
    objects: Vec<([u8; 32], u64, i64)>,
}

/// Size [B], times of the last change of content and of the file [ns since 1970], inode: whoever adds, removes or moves
/// results changes it.
type IndexMark = (u64, i64, i64, u64);

impl Store {
    /// How the results of `keys` stand, which the store has found whole; none where the index doesn't know all of them, or
    /// can't be written.
    pub fn standing(&self, keys: impl Iterator<Item = Digest>) -> Option<Standing> {
        let known = |key| {
            let known = self.index().get(key).ok()??;
            Some((*known.entry.output.bytes(), known.entry.bytes, known.object_time))
        };
        let mut objects = keys.map(known).collect::<Option<Vec<_>>>()?;
        objects.sort_unstable();
        objects.dedup();
        Some(Standing { index: self.index_mark()?, objects })
    }

    /// Whether all results stand as they did: then each would be found whole, as it was then.
    pub fn stands(&self, before: &Standing) -> bool {
        let is_same =
            |(d, bytes, time): &([u8; 32], u64, i64)| self.object_mark(Digest::from_bytes(*d)) == Some((*bytes, *time));
        self.index_mark() == Some(before.index) && before.objects.iter().all(is_same)
    }

    fn index_mark(&self) -> Option<IndexMark> {
        let found = fs::metadata(self.folder().join("index")).ok()?;
        let time = |s: i64, ns: i64| s.wrapping_mul(1_000_000_000).wrapping_add(ns);
        Some((
            found.len(),
            time(found.mtime(), found.mtime_nsec()),
            time(found.ctime(), found.ctime_nsec()),
            found.ino(),
        ))
    }
}
