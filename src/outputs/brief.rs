//! What results showed of themselves when they were last read: one changed point of a sweep means one result read.
//!
//! A file beside the manifest, no more than a short cut: it is sealed with the digest of the program's own code, and what
//! it lacks is read from the store.
use crate::registry;
use hvi_kit::Digest;
use hvi_kit::view::{Scalar, View};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;
use std::{fs, io};

/// What a result shows.
#[derive(Clone, Serialize, Deserialize)]
pub struct Brief {
    /// The numbers that sum it up.
    pub scalars: Vec<Scalar>,
    /// Number of its pictures.
    pub pictures: usize,
    /// Whether it has anything else.
    pub more: bool,
    /// These, where the page shows them and there is nothing else, which is large.
    pub views: Vec<View>,
}

impl Brief {
    /// Of what a result shows.
    pub fn of(scalars: &[Scalar], views: &[View]) -> Brief {
        let pictures = views.iter().filter(|v| matches!(v, View::Picture(_))).count();
        let is_small = |view: &View| matches!(view, View::Table(_) | View::Figure(_) | View::Text(_));
        let kept = if views.iter().all(is_small) { views.to_vec() } else { Vec::new() };
        Brief { scalars: scalars.to_vec(), pictures, more: views.len() > pictures, views: kept }
    }
}

/// By digest of the result.
pub type Briefs = HashMap<[u8; 32], Brief>;

const NAME: &str = ".brief";

/// Those kept in `folder`; none where the file is damaged, or written by a program with other code.
pub fn read(folder: &Path) -> Briefs {
    let whole = || {
        let bytes = fs::read(folder.join(NAME)).ok()?;
        let (seal, body) = bytes.split_first_chunk::<32>()?;
        if seal_of(body).bytes() != seal {
            return None;
        }
        let all: Vec<([u8; 32], Brief)> = postcard::from_bytes(body).ok()?;
        Some(all.into_iter().collect())
    };
    whole().unwrap_or_default()
}

/// Keeps `briefs` in `folder`.
///
/// # Errors
/// Where the file can't be written.
pub fn publish(folder: &Path, briefs: &Briefs) -> io::Result<()> {
    let all: Vec<(&[u8; 32], &Brief)> = briefs.iter().collect();
    let body = postcard::to_stdvec(&all).map_err(io::Error::other)?;
    let mut bytes = seal_of(&body).bytes().to_vec();
    bytes.extend(body);
    super::publish(&folder.join(NAME), &bytes)
}

/// Ties the bytes to the code that made them.
fn seal_of(body: &[u8]) -> Digest {
    let code = registry::CODE.iter().flat_map(|(name, digest)| [name.as_bytes(), digest.as_bytes()]);
    let parts: Vec<&[u8]> = code.chain([registry::PROGRAM.as_bytes(), body]).collect();
    Digest::of_all(&parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_comes_back_and_what_is_damaged_does_not() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read(folder.path()).is_empty());
        let brief =
            Brief { scalars: vec![Scalar::number("pressure", 0.1, "GPa")], pictures: 2, more: true, views: vec![] };
        publish(folder.path(), &HashMap::from([([7; 32], brief)])).unwrap();
        let back = read(folder.path());
        assert_eq!(back[&[7; 32]].scalars, [Scalar::number("pressure", 0.1, "GPa")]);
        assert_eq!((back.len(), back[&[7; 32]].pictures, back[&[7; 32]].more), (1, 2, true));
        let path = folder.path().join(NAME);
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&path, bytes).unwrap();
        assert!(read(folder.path()).is_empty());
    }
}
