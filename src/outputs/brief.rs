//! What results showed of themselves when they were last read: one changed point of a sweep means one result read.
//!
//! A file beside the manifest, no more than a short cut: what it lacks is read from the store.
use super::sealed;
use hvi_kit::view::{Scalar, View};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// What a result shows.
#[derive(Serialize, Deserialize)]
pub struct Brief {
    /// The numbers that sum it up.
    #[serde(with = "shared")]
    pub scalars: Arc<[Scalar]>,
    /// Number of its pictures.
    pub pictures: usize,
    /// Whether it has anything else.
    pub more: bool,
    /// These, where the page shows them and there is nothing else, which is large.
    pub views: Vec<View>,
    /// Whether a point of this run has it: others are not kept.
    #[serde(skip)]
    pub is_used: bool,
}

impl Brief {
    /// Of what a result shows.
    pub fn of(scalars: &Arc<[Scalar]>, views: &[View]) -> Brief {
        let pictures = views.iter().filter(|v| matches!(v, View::Picture(_))).count();
        let is_small = |view: &View| matches!(view, View::Table(_) | View::Figure(_) | View::Text(_));
        let kept = if views.iter().all(is_small) { views.to_vec() } else { Vec::new() };
        Brief { scalars: scalars.clone(), pictures, more: views.len() > pictures, views: kept, is_used: false }
    }
}

/// A shared list as a plain one.
mod shared {
    use super::{Arc, Deserialize, Scalar, Serialize};
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(all: &Arc<[Scalar]>, serializer: S) -> Result<S::Ok, S::Error> {
        all[..].serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<[Scalar]>, D::Error> {
        Vec::deserialize(deserializer).map(Into::into)
    }
}

/// By digest of the result.
pub type Briefs = HashMap<[u8; 32], Brief>;

const NAME: &str = ".brief";

/// Those kept in `folder`.
pub fn read(folder: &Path) -> Briefs {
    sealed::read(&folder.join(NAME)).unwrap_or_default()
}

/// Keeps those of `briefs` in `folder` that this run used.
///
/// # Errors
/// Where the file can't be written.
pub fn publish(folder: &Path, briefs: &mut Briefs) -> io::Result<()> {
    briefs.retain(|_, brief| brief.is_used);
    sealed::publish(&folder.join(NAME), briefs)
}
