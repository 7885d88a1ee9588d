//! Digest of each stage's code.
fn main() {}
