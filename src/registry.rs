//! Every stage, in the order of the chain: the one place to add one.
use hvi_kit::{Digest, Shown, StageDef, Store};
use std::cell::Cell;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;

/// All stages.
pub static STAGES: &[StageDef] = &[
    StageDef::of::<hvi_md::Md>(),
    StageDef::of::<hvi_md::TwoPhases>(),
    StageDef::of::<hvi_eos::fit::Fitting>(),
    StageDef::of::<hvi_eos::handbook::Handbook>(),
    StageDef::of::<hvi_eos::tabulate::Table>(),
    StageDef::of::<hvi_eos::tabulate::Sesame>(),
    StageDef::of::<hvi_eos::curves::CurvesStage>(),
    StageDef::of::<hvi_eos::survey::SurveyStage>(),
    StageDef::of::<hvi_validate::hugoniot::Hugoniot>(),
    StageDef::of::<hvi_validate::isotherm::Isotherm>(),
    StageDef::of::<hvi_impact::ImpactStage>(),
    StageDef::of::<hvi_radiograph::Radiograph>(),
    StageDef::of::<hvi_validate::taylor::TaylorBars>(),
    StageDef::of::<hvi_validate::debris::DebrisClouds>(),
    StageDef::of::<hvi_empirical::Eta>(),
    StageDef::of::<hvi_reproduction::Reproduction>(),
];

/// The stage called `name`.
pub fn stage(name: &str) -> Option<&'static StageDef> {
    STAGES.iter().find(|s| s.name == name)
}

thread_local! {
    /// Whether this thread shows a result: what comes of it is said where it is asked for.
    static SHOWS: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread just now shows a result: a panic then is reported as damage of the result.
pub fn shows() -> bool {
    SHOWS.get()
}

/// What people see of the result `digest` of `stage`. Bytes that fit their digest, but were never made by the stage (a store may come
/// from others), may make no sense to it: that is no defect of the program.
///
/// # Errors
/// Why there is nothing to see.
pub fn show(stage: &StageDef, digest: Digest, store: &Store) -> Result<Shown, String> {
    SHOWS.set(true);
    let shown = catch_unwind(AssertUnwindSafe(|| (stage.show)(digest, store)));
    SHOWS.set(false);
    let senseless = || {
        let name = stage.name;
        format!("its bytes make no sense as a result of `{name}`: remove it with `hvi-flow cache gc` and run again")
    };
    shown.map_err(|_| senseless())?.map_err(|e| e.to_string())
}

/// Digest of the code behind `stage`: see `src/build.rs`.
pub fn code(stage: &StageDef) -> Digest {
    static DIGESTS: OnceLock<HashMap<&str, Digest>> = OnceLock::new();
    let digests = DIGESTS.get_or_init(|| {
        let of_crate = |krate: &str| CODE.iter().find(|(name, _)| *name == krate).and_then(|(_, hex)| hex.parse().ok());
        let krate = |stage: &StageDef| (stage.type_name)().split("::").next().unwrap_or_default();
        let of_stage = |stage| of_crate(krate(stage)).expect("the build script lists every stage's crate");
        STAGES.iter().map(|stage| (stage.name, of_stage(stage))).collect()
    });
    digests[stage.name]
}

include!(concat!(env!("OUT_DIR"), "/code.rs"));
