//! Figures as SVG, pictures as PNG, tables as CSV.
use hvi_kit::view::{Figure, Picture, Table};
/// SVG.
pub fn svg(_: &Figure) -> String { String::new() }
/// PNG.
pub fn png(_: &Picture) -> Vec<u8> { Vec::new() }
/// CSV.
pub fn csv(_: &Table) -> String { String::new() }
