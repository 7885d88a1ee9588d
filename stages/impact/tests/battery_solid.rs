//! The battery's solids.
mod battery;
mod common;
use battery::{check, solid};

#[test]
fn standing_waves_keep_their_amplitude() {
    check(&solid::wave_rows());
}

#[test]
fn elastic_precursor() {
    check(&solid::precursor_rows());
}

#[test]
fn spall() {
    check(&solid::spall_rows(80));
}

#[test]
fn taylor_bar() {
    check(&solid::taylor_rows(10));
}

#[test]
fn spinning_cube() {
    check(&solid::spin_rows());
}
