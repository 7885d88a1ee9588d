//! Models, one file each.
pub mod gray;
pub mod ideal_gas;
pub mod mie_gruneisen;
pub mod table;
