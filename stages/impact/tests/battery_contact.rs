//! The battery's contact.
mod battery;
mod common;
use battery::{check, contact};

#[test]
fn bars_part() {
    check(&contact::rows());
}
