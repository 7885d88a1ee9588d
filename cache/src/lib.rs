//! Content-addressed store of stage results: what was asked (`Recipe`), what came of it (`Record`), and the bytes.
//!
//! It knows bytes only: no stage, no physics, no file format but its own.
mod digest;
mod recipe;
mod store;
pub use digest::Digest;
pub use recipe::{Change, Recipe, Slot};
pub use store::{Record, Store, StoreError};
