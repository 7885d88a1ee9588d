//! The battery's yardstick scene.
mod battery;
mod common;
use battery::{check, yardstick};

#[test]
fn s1() {
    check(&yardstick::rows());
}

#[test]
fn s1_to_the_end() {
    check(&yardstick::long_rows());
}

#[test]
fn refinement() {
    check(&yardstick::refinement(&[3, 5, 8], "4 us"));
}
