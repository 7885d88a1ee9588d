//! The program as its user meets it: commands, cache, wrong input, and the tree's own rules.
#[expect(dead_code, reason = "the build script's own tests run here: cargo has no other place for them")]
#[path = "../src/build.rs"]
mod build;

mod suite {
    pub mod bad_input;
    pub mod bits;
    pub mod browser;
    pub mod cache;
    pub mod choose;
    pub mod chromium;
    pub mod commands;
    pub mod corpus;
    pub mod eos;
    pub mod faults;
    pub mod key;
    pub mod language;
    pub mod mutation;
    pub mod project;
    pub mod region;
    #[cfg(feature = "s3")]
    pub mod s3;
    pub mod schema;
    pub mod slurm;
    pub mod stops;
    pub mod tidy;
    pub mod tradeoff;
    pub mod unchanged;
    pub mod vtkhdf;
}
