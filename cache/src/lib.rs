//! Content-addressed store of stage results: what was asked (`Recipe`), what came of it (`Record`), and the bytes.
//!
//! It knows bytes only: no stage, no physics, no file format but its own.
//!
//! | file | what |
//! |---|---|
//! | `digest.rs`, `recipe.rs`, `record.rs` | names of bytes, what was asked, what came of it |
//! | `store.rs` | publishing, reading, looking up |
//! | `index.rs` | lookups without opening a file |
//! | `standing.rs` | whether results still stand, without reading the index |
//! | `second.rs`, `bucket.rs` | results from another store: a folder, or a bucket of an S3-compatible service |
//! | `own.rs` | its own files, and no others |
//! | `lock.rs` | who computes what |
//! | `upkeep.rs` | count, verify, repair, remove |
//! | `error.rs` | why it could not serve |
#[cfg(feature = "s3")]
mod bucket;
mod digest;
mod error;
mod index;
mod lock;
mod own;
mod recipe;
mod record;
mod second;
mod standing;
mod store;
mod upkeep;
pub use digest::{Digest, Hex};
pub use error::StoreError;
pub use lock::{Claim, InUse};
pub use recipe::{Asked, Change, Plugged, Recipe, Slot};
pub use record::{Entry, Record};
pub use second::{Copied, Second};
pub use standing::Standing;
pub use store::{Found, Store};
pub use upkeep::{Collected, Limits, Problem, Repaired, Shelf, Stats, Verified};
