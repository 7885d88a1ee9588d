//! What every stage is made of: the `Stage` trait, its context, its input ports, units, and what a result shows.
//!
//! `stage.rs` the trait; `port.rs` inputs; `artifact.rs` outputs; `ctx.rs` the world outside; `engine.rs` programs
//! outside; `units.rs` quantities; `reach.rs` the states that a scene brings matter to;
//! `view.rs` tables, figures and pictures; `math.rs` small numerics shared by stages; `lanes/` eight numbers side by side.
mod artifact;
mod ctx;
pub mod engine;
pub mod lanes;
pub mod math;
mod port;
mod reach;
mod stage;
pub mod units;
pub mod view;
pub use artifact::{Artifact, DecodeError, File, LoadError, load};
pub use ctx::{Cancel, Cancelled, Ctx, Host};
pub use hvi_cache::{Digest, Recipe, Slot, Store, StoreError};
pub use port::{Any, Arity, Inputs, Places, Plug, Port};
pub use reach::{ByInput, Reach, Reached};
pub use stage::{Checked, Invalid, Made, Needs, Shown, Stage, StageDef, StageError};
