//! Explicit material point method for hypervelocity impact.
//!
//! `params.rs` what a pipeline says, `bodies.rs` of all bodies, `solid.rs` of their shapes,
//! `mesh.rs` of surfaces from files, `probes.rs` of what is followed; `effects.rs` which effects the scene calls for; `checks.rs` what must hold between them; `scene.rs` particles from it; `method.rs` which variant of the method; `particle.rs` one
//! particle, `pack.rs` eight of them, `store.rs` all; `step.rs` one time step, made of `p2g.rs` (particles to grid), `conduction.rs`,
//! `contact.rs` and `g2p.rs` (grid to particles; `xpic.rs` XPIC's damping, `remap.rs` deformation in a pass of its own), passes over
//! all blocks of particles by `task.rs`, with `signal.rs` for the time step, on the sparse `grid.rs` (found by `table.rs`), seen through `window.rs`, with the
//! inner loops of `transfer.rs` and the weights of `kernel.rs`; `material/` what matter does; `ledger.rs` sums over the scene;
//! `melt.rs` phases and snapshots; `result.rs` what a run leaves, `show.rs` what of it a person sees; `stage.rs` the stage `impact`,
//! `fault.rs` what it says where a run goes wrong.
pub mod bodies;
mod checks;
mod conduction;
mod contact;
pub mod effects;
mod fault;
mod g2p;
mod grid;
pub mod kernel;
mod ledger;
pub mod material;
mod melt;
pub mod mesh;
pub mod method;
mod p2g;
mod pack;
pub mod params;
pub mod particle;
pub mod probes;
mod remap;
pub mod result;
pub mod scene;
mod show;
mod signal;
pub mod solid;
mod stage;
pub mod step;
mod store;
mod table;
mod task;
mod tensor;
mod transfer;
mod window;
mod xpic;
pub use params::Params;
pub use show::{decision, decision_columns};
pub use stage::{ImpactInputs, ImpactStage};
