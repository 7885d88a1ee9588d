//! Equations of state: pressure, temperature, sound speed and phase from volume and energy; and their fit.
//!
//! `eos.rs` the one interface, `points.rs` its answers for many states; `model/` one file a
//! model; `curve.rs` Hugoniot and release; `landmarks.rs` melting in numbers; `handbook.rs` published parameters (stage
//! `eos.handbook`), `definition.rs` as people write them; `curves/` what to look at (stage `eos.curves`); `survey.rs` one
//! against another (stage `eos.survey`); `tabulate.rs` tables
//! (stages `eos.table`, `eos.sesame`); `fit/` GRAY from states (stage `eos.gray`);
//! `result.rs` what they pass on; `show.rs` how it looks.
//! SI throughout: V specific volume [m3/kg], E specific energy [J/kg], P [Pa], T [K]; energy is zero at the reference
//! state (V0, T0) of the metals.
pub mod curve;
pub mod curves;
pub mod definition;
mod eos;
pub mod fit;
pub mod handbook;
pub mod landmarks;
pub mod model;
mod points;
mod result;
mod show;
pub mod survey;
pub mod tabulate;
pub use eos::{Eos, EosError, Phase, Point};
use hvi_kit::lanes;
pub use hvi_kit::lanes::Instructions;
pub use model::gray::Gray;
pub use model::gray::patches::Patches;
pub use model::ideal_gas::IdealGas;
pub use model::mie_gruneisen::MieGruneisen;
pub use model::stiffened_gas::StiffenedGas;
pub use model::tabulated::Tabulated;
pub use model::tillotson::Tillotson;
pub use points::Points;
pub use result::EosResult;
