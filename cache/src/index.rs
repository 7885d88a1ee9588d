//! The index: one file with an entry a result, read once, so that a lookup opens no file.
//!
//! It only saves work. It is appended to, one `write` of 128 bytes an entry, so that two processes may append at once
//! (128 divides a page: a reader never meets half an entry); a later entry of a key replaces an earlier one. Each entry
//! proves itself by a hash. What isn't in it is looked up in `results/` and added; a damaged index is moved aside and
//! grows anew the same way.
use crate::record::Entry;
use crate::{Digest, own};
use std::collections::HashMap;
use std::fs::File;
use std::hash::{BuildHasherDefault, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes of an entry, and of the head.
const SIZE: usize = 128;
const HEAD: &[u8] = b"hvi-index/1";

/// What the index knows of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    pub entry: Entry,
    /// When the object was written, as its file system says [ns since 1970]: another time means that it must be hashed again.
    pub object_time: i64,
}

/// The index of a store, in memory.
pub(crate) struct Index {
    path: PathBuf,
    bytes: Vec<u8>,
    places: HashMap<Digest, u32, BuildHasherDefault<Leading>>,
    file: Option<File>,
}

/// The index can't be trusted.
#[derive(Debug, PartialEq)]
pub(crate) struct Broken;

/// Keys are hashes already: their first bytes will do.
#[derive(Default)]
struct Leading(u64);
impl Hasher for Leading {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        if let Some(first) = bytes.first_chunk::<8>() {
            self.0 = u64::from_le_bytes(*first);
        }
    }
    fn write_usize(&mut self, _: usize) {}
}

impl Index {
    /// Reads the index at `path`; none is an empty one.
    pub fn load(path: PathBuf) -> Result<Index, Broken> {
        let mut index = Index::empty(path);
        // What can't be read can't be used, and costs only time.
        let Ok(bytes) = own::read(&index.path) else { return Ok(index) };
        if bytes.is_empty() {
            return Ok(index);
        }
        if bytes.len() % SIZE != 0 || !bytes.starts_with(HEAD) {
            return Err(Broken);
        }
        index.bytes = bytes;
        index.places.reserve(index.bytes.len() / SIZE);
        for (i, entry) in index.bytes.chunks_exact(SIZE).enumerate().skip(1) {
            index.places.insert(key_of(entry), i as u32);
        }
        Ok(index)
    }

    pub fn empty(path: PathBuf) -> Index {
        Index { path, bytes: Vec::new(), places: HashMap::default(), file: None }
    }

    /// What it knows of `key`.
    pub fn get(&self, key: Digest) -> Result<Option<Known>, Broken> {
        let Some(&place) = self.places.get(&key) else { return Ok(None) };
        let start = place as usize * SIZE;
        decode(&self.bytes[start..start + SIZE]).map(Some).ok_or(Broken)
    }

    /// Keys of the results of `kind` that were added last, the last one first.
    pub fn latest(&self, kind: &str, most: usize) -> Vec<Digest> {
        let mut padded = [0; Entry::LONGEST_KIND];
        let Some(place) = padded.get_mut(..kind.len()) else { return Vec::new() };
        place.copy_from_slice(kind.as_bytes());
        let entries = self.bytes.chunks_exact(SIZE).skip(1).rev();
        entries.filter(|entry| entry[64..96] == padded).map(key_of).take(most).collect()
    }

    /// Adds what is known of `key`. A store that can't be written keeps it in memory only.
    pub fn add(&mut self, key: Digest, known: &Known) {
        let entry = encode(key, known);
        if self.bytes.is_empty() {
            self.bytes.extend(head());
        }
        self.places.insert(key, (self.bytes.len() / SIZE) as u32);
        self.bytes.extend(entry);
        let _ = self.append(&entry);
    }

    fn append(&mut self, entry: &[u8; SIZE]) -> io::Result<()> {
        if self.file.is_none() {
            let mut file = own::options().append(true).create(true).open(&self.path)?;
            if file.metadata()?.len() == 0 {
                // Two processes may both do so: the second head stands where an entry would, and is nobody's.
                file.write_all(&head())?;
            }
            self.file = Some(file);
        }
        let file = self.file.as_mut().expect("just opened");
        let written = file.write(entry)?;
        if written < SIZE {
            // The disk is full: half an entry would break the index.
            let whole = file.metadata()?.len() / SIZE as u64 * SIZE as u64;
            file.set_len(whole)?;
        }
        Ok(())
    }

    /// The bytes of an index with these entries and no others.
    pub fn of(entries: impl Iterator<Item = (Digest, Known)>) -> Vec<u8> {
        let mut bytes = head().to_vec();
        entries.for_each(|(key, known)| bytes.extend(encode(key, &known)));
        bytes
    }

    /// Entries that don't prove themselves.
    pub fn broken(path: &Path) -> usize {
        let Ok(bytes) = own::read(path) else { return 0 };
        let entries = bytes.chunks(SIZE).skip(1).filter(|entry| !entry.starts_with(HEAD));
        usize::from(!bytes.is_empty() && !bytes.starts_with(HEAD)) + entries.filter(|e| decode(e).is_none()).count()
    }
}

fn head() -> [u8; SIZE] {
    let mut head = [b' '; SIZE];
    head[..HEAD.len()].copy_from_slice(HEAD);
    head[SIZE - 1] = b'\n';
    head
}

fn key_of(entry: &[u8]) -> Digest {
    Digest::from_bytes(*entry.first_chunk().expect("an entry is long enough"))
}

/// key, output, kind (32 bytes each); bytes, object time (8); wall, CPU time (4); 8 bytes of the hash of all that.
fn encode(key: Digest, known: &Known) -> [u8; SIZE] {
    let Known { entry, object_time } = known;
    let mut out = [0; SIZE];
    let mut kind = [0; Entry::LONGEST_KIND];
    kind[..entry.kind().len()].copy_from_slice(entry.kind().as_bytes());
    let parts: [&[u8]; 7] = [
        key.bytes(),
        entry.output.bytes(),
        &kind,
        &entry.bytes.to_le_bytes(),
        &object_time.to_le_bytes(),
        &entry.wall_s.to_le_bytes(),
        &entry.cpu_s.to_le_bytes(),
    ];
    let mut end = 0;
    for part in parts {
        out[end..end + part.len()].copy_from_slice(part);
        end += part.len();
    }
    let seal = *Digest::of(&out[..end]).bytes();
    out[end..].copy_from_slice(&seal[..SIZE - end]);
    out
}

fn decode(entry: &[u8]) -> Option<Known> {
    let (body, seal) = entry.split_at_checked(120)?;
    if Digest::of(body).bytes()[..8] != *seal {
        return None;
    }
    let four = |at: usize| f32::from_le_bytes(body[at..at + 4].try_into().expect("four bytes"));
    let eight = |at: usize| -> [u8; 8] { body[at..at + 8].try_into().expect("eight bytes") };
    let kind = std::str::from_utf8(&body[64..96]).ok()?.trim_end_matches('\0');
    let output = key_of(&body[32..]);
    let entry = Entry::new(output, kind, u64::from_le_bytes(eight(96)), four(112), four(116))?;
    Some(Known { entry, object_time: i64::from_le_bytes(eight(104)) })
}
