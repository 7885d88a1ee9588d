//! Short cuts in files of their own: read back only whole, and only by the very program that wrote them.
use crate::registry;
use hvi_kit::Digest;
use serde::{Serialize, de::DeserializeOwned};
use std::path::Path;
use std::{fs, io};

/// What was kept at `path`; nothing where the file is damaged, or was written by a program with other code.
pub fn read<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let bytes = fs::read(path).ok()?;
    let (seal, body) = bytes.split_first_chunk::<32>()?;
    if seal_of(body).bytes() != seal {
        return None;
    }
    postcard::from_bytes(body).ok()
}

/// Keeps `value` at `path`.
///
/// # Errors
/// Where the file can't be written.
pub fn publish(path: &Path, value: &impl Serialize) -> io::Result<()> {
    let body = postcard::to_stdvec(value).map_err(io::Error::other)?;
    super::publish(path, &[&seal_of(&body).bytes()[..], &body].concat())
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
        let path = folder.path().join("kept");
        assert_eq!(read::<Vec<f64>>(&path), None);
        publish(&path, &vec![0.1, 0.2]).unwrap();
        assert_eq!(read(&path), Some(vec![0.1, 0.2]));
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&path, bytes).unwrap();
        assert_eq!(read::<Vec<f64>>(&path), None);
    }
}
