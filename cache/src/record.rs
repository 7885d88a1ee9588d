//! What came of a recipe: the result's name, what it cost, and where it comes from.
use crate::Digest;
use serde::{Deserialize, Serialize};

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
    /// CPU time of the threads that computed it [s].
    pub cpu_s: f64,
    /// Host it was computed on.
    pub host: String,
    /// Version of the program that computed it.
    #[serde(default)]
    pub program: String,
    /// Compiler that built the program, with its target.
    #[serde(default)]
    pub compiler: String,
    /// Threads it was given.
    #[serde(default)]
    pub threads: usize,
    /// Cores of the host.
    #[serde(default)]
    pub cores: usize,
    /// When it was done, in seconds since 1970 (UTC).
    #[serde(default)]
    pub finished: u64,
    /// Core-seconds that were foretold: what it took is held against this to foretell the next one.
    #[serde(default)]
    pub foretold_s: f64,
}

/// What a run needs to know of a record, and the index holds: which bytes, and what they cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Digest of the result's bytes.
    pub output: Digest,
    /// Number of bytes.
    pub bytes: u64,
    /// Wall time it took [s].
    pub wall_s: f32,
    /// CPU time it took [s].
    pub cpu_s: f32,
    kind: [u8; Entry::LONGEST_KIND],
}

impl Entry {
    /// Longest name of a kind [B].
    pub const LONGEST_KIND: usize = 32;

    pub(crate) fn new(output: Digest, kind: &str, bytes: u64, wall_s: f32, cpu_s: f32) -> Option<Entry> {
        let mut padded = [0; Entry::LONGEST_KIND];
        padded.get_mut(..kind.len())?.copy_from_slice(kind.as_bytes());
        Some(Entry { output, bytes, wall_s, cpu_s, kind: padded })
    }

    /// Kind of artifact.
    pub fn kind(&self) -> &str {
        let end = self.kind.iter().position(|b| *b == 0).unwrap_or(self.kind.len());
        std::str::from_utf8(&self.kind[..end]).unwrap_or_default()
    }
}

impl Record {
    /// The part of it that the index holds.
    ///
    /// # Panics
    /// Where the kind's name is longer than [`Entry::LONGEST_KIND`]: such a record can't be stored.
    pub fn entry(&self) -> Entry {
        Entry::new(self.output, &self.kind, self.bytes, self.wall_s as f32, self.cpu_s as f32)
            .expect("a kind's name is short")
    }
}
