//! Values that stages exchange.
use crate::view::{Scalar, View};
use hvi_cache::{Digest, Store, StoreError};
use serde::{Serialize, de::DeserializeOwned};

/// Bytes that are not the artifact they claim to be.
#[derive(Debug, thiserror::Error)]
#[error("not a {kind}: {why}")]
pub struct DecodeError {
    /// What was expected.
    pub kind: &'static str,
    /// What was found.
    pub why: String,
}

/// An artifact could not be had from the store.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum LoadError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Decode(#[from] DecodeError),
}

/// Loads the artifact whose bytes have digest `d`.
///
/// # Errors
/// [`LoadError`] where the object is missing, damaged or of another kind.
pub fn load<A: Artifact>(store: &Store, d: Digest) -> Result<A, LoadError> {
    Ok(A::decode(&store.get(d)?)?)
}

/// A value one stage makes and another takes, stored under the digest of its bytes.
///
/// The encoding is postcard's published wire format (little-endian, f64 as its 8 bytes) behind the kind's name:
/// the same value always gives the same bytes, and `decode(encode(x)) == x` bit for bit.
pub trait Artifact: Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Name and format version, e.g. `"eos/1"`; ports connect only where kinds are equal.
    const KIND: &'static str;

    /// The numbers that sum it up: one row of a sweep's table.
    fn scalars(&self) -> Vec<Scalar>;

    /// What a person looks at: tables, figures, pictures.
    fn views(&self) -> Vec<View> {
        Vec::new()
    }

    /// Canonical bytes.
    fn encode(&self) -> Vec<u8> {
        let head = Self::KIND.as_bytes().to_vec();
        postcard::to_extend(self, head).expect("artifacts are plain data of known length")
    }

    /// Reads what [`Artifact::encode`] wrote.
    ///
    /// # Errors
    /// [`DecodeError`] where the kind differs, or the bytes are too short, too long or malformed.
    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let wrong = |why: String| DecodeError { kind: Self::KIND, why };
        let body = bytes.strip_prefix(Self::KIND.as_bytes()).ok_or_else(|| {
            wrong(format!("it begins with {:?}", String::from_utf8_lossy(&bytes[..bytes.len().min(16)])))
        })?;
        let (value, rest) = postcard::take_from_bytes(body).map_err(|e| wrong(e.to_string()))?;
        if rest.is_empty() { Ok(value) } else { Err(wrong(format!("{} bytes too many", rest.len()))) }
    }
}

/// The content of a file that a pipeline names; its path is no part of it.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize)]
pub struct File(pub Vec<u8>);
impl Artifact for File {
    const KIND: &'static str = "file/1";
    fn scalars(&self) -> Vec<Scalar> {
        vec![Scalar::number("size", self.0.len() as f64, "B")]
    }
}
impl File {
    /// The content as text.
    ///
    /// # Errors
    /// [`DecodeError`] where it isn't UTF-8.
    pub fn text(&self) -> Result<&str, DecodeError> {
        std::str::from_utf8(&self.0).map_err(|e| DecodeError { kind: "text file", why: e.to_string() })
    }
}
