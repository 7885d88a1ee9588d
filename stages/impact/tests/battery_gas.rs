//! The battery's gases.
mod battery;
mod common;
use battery::{check, gas};

#[test]
fn noh() {
    check(&gas::noh_rows(100, 20));
}

#[test]
fn sod() {
    check(&gas::sod_rows());
}

#[test]
fn expansion() {
    check(&gas::expansion_rows());
}
