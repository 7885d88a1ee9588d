//! The battery's grid.
mod battery;
mod common;
use battery::{check, grid};

#[test]
fn nearly_empty_nodes() {
    check(&grid::edge_rows());
}

#[test]
fn nothing_to_leave() {
    check(&grid::leaving_rows());
}

#[test]
fn mirrors() {
    check(&grid::symmetry_rows(2));
}

#[test]
fn order_of_convergence() {
    check(&grid::order_rows([16, 32]));
}
