//! # The code map
//!
//! `hvi-flow` runs a study of hypervelocity impact as a graph of cached computations. A pipeline file (TOML) names steps;
//! each uses a *stage*, a pure function from parameters and inputs to one *artifact*; a sweep makes one *node* a point;
//! each node's result is kept in the *store* under the digest of its *recipe*.
//!
//! ```text
//! pipelines/*.toml --pipeline--> Pipeline --plan--> Plan --execute--> Report --outputs--> out/NAME/report.html
//!                                                    |        |
//!                                             registry        cache/ (store)
//!                                                    |
//!                stages/: md -> eos -> validate, impact -> radiograph, empirical   (kit: what each is made of; tradeoff: what accuracy costs)
//! ```
//!
//! | file | what |
//! |---|---|
//! | `cli.rs`, `commands.rs`, `commands/` | the command line, one file a command |
//! | `pipeline.rs`, `pipeline/`, `value.rs`, `sweep.rs` | the pipeline file as written, with places for messages |
//! | `plan.rs`, `reference.rs` | references resolved, ports matched, parameters checked, order |
//! | `schema.rs`, `reference_page.rs` | from the stages' types: the pipeline file's JSON schema, and `docs/stages.md` |
//! | `registry.rs` | every stage, and the digest of its code (`build.rs` makes it) |
//! | `execute.rs`, `execute/` | lookup, packing into cores and memory, workers, failures, cancel |
//! | `unchanged.rs` | a run that has nothing to do, known without a plan |
//! | `forecast.rs`, `history.rs` | what a run would do and why; what earlier runs did |
//! | `schedule.rs` | how a plan would pack onto the cores of a cluster |
//! | `events.rs`, `console.rs` | what happens, and how it is shown |
//! | `outputs.rs`, `report.rs`, `report.html`, `figure.rs`, `hdf5_table.rs`, `hdf5_file.rs`, `extended_xyz.rs`, `vtkhdf.rs` | what people get: page, CSV, SVG, PNG, HDF5, XYZ, VTKHDF |
//! | `tradeoff.rs` | `[tradeoff.NAME]`: sets of runs, joined with what they cost |
//! | `region.rs` | `region = "auto"`: of a sweep of states only those that the scenes come to |
//! | `repeat.rs` | a study computed again for its times: medians in the records, and the same bits |
//! | `choose.rs` | `[choose.NAME]`: settings by the error or the time asked for, from a measured front |
//! | `amount.rs`, `named_file.rs` | times and sizes as people write them; files that they name |
//! | `watch.rs` | the page of a study that runs, on this machine's own address |
//! | `ro_crate.rs` | where exported results come from, for other programs |
//! | `mistake.rs` | wrong input, shown with line and mark |
//!
//! Invariants: `src/` has no formula; a stage sees no file, clock or environment, and its answer has the same bits for any
//! number of threads; `cache/` decodes nothing; the plan is complete before the first stage runs; everything a result may
//! depend on is in its recipe, and nothing else is.
//!
//! Glossary: *step*, a `[step.NAME]` of a pipeline; *point*, one combination of a step's sweep; *node*, one computation;
//! *port*, a named input of a stage; *recipe*, what identifies a computation; *record*, what came of it.
pub mod amount;
pub mod choose;
pub mod cli;
pub mod commands;
pub mod console;
pub mod events;
pub mod execute;
pub mod extended_xyz;
pub mod figure;
pub mod forecast;
pub mod hdf5_file;
pub mod hdf5_table;
pub mod history;
pub mod mistake;
pub mod named_file;
pub mod outputs;
pub mod pipeline;
pub mod plan;
pub mod reference;
pub mod reference_page;
pub mod region;
pub mod registry;
pub mod repeat;
pub mod report;
pub mod ro_crate;
pub mod schedule;
pub mod schema;
pub mod sweep;
pub mod tradeoff;
pub mod unchanged;
pub mod value;
pub mod vtkhdf;
pub mod watch;
