//! The battery's plane shocks.
mod battery;
mod common;
use battery::{check, shock};

#[test]
fn named_free_surfaces() {
    check(&shock::reference());
}

#[test]
fn mie_gruneisen_at_100_cells() {
    check(&shock::mie_gruneisen(100));
}

#[test]
fn mie_gruneisen_at_200_cells() {
    check(&shock::mie_gruneisen(200));
}

#[test]
fn gray_at_100_cells() {
    check(&shock::with_gray(100));
}

#[test]
fn gray_at_200_cells() {
    check(&shock::with_gray(200));
}
