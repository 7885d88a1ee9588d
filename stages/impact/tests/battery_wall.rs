//! The battery's wall heating and release melting.
mod battery;
mod common;
use battery::{check, wall};

#[test]
fn the_contact_stays_cool() {
    check(&wall::rows());
}

#[test]
fn release_melts_what_the_isentrope_melts() {
    check(&wall::melt_rows());
}

#[test]
fn unseen_contacts() {
    check(&wall::unseen_rows());
}
