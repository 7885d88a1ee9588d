//! The battery's single particles.
mod battery;
mod common;
use battery::{check, material};

#[test]
fn johnson_cook_follows_its_equation() {
    check(&material::shear_rows());
}

#[test]
fn johnson_cook_has_its_limits() {
    check(&material::limit_rows());
}

#[test]
fn states_far_from_home() {
    check(&material::state_rows(200_000));
}
