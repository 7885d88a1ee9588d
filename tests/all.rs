//! The program as its user meets it: commands, cache, wrong input, and the tree's own rules.
mod suite {
    pub mod bad_input;
    pub mod cache;
    pub mod project;
    pub mod tidy;
}
