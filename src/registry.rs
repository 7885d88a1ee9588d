//! Every stage, in the order of the chain: the one place to add one.
use hvi_kit::StageDef;
use std::collections::HashMap;
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

/// Digest of the code behind `stage`: see `src/build.rs`.
pub fn code(stage: &StageDef) -> hvi_kit::Digest {
    static DIGESTS: OnceLock<HashMap<&str, hvi_kit::Digest>> = OnceLock::new();
    let digests = DIGESTS.get_or_init(|| {
        let of_crate = |krate: &str| CODE.iter().find(|(name, _)| *name == krate).and_then(|(_, hex)| hex.parse().ok());
        let krate = |stage: &StageDef| (stage.type_name)().split("::").next().unwrap_or_default();
        let of_stage = |stage| of_crate(krate(stage)).expect("the build script lists every stage's crate");
        STAGES.iter().map(|stage| (stage.name, of_stage(stage))).collect()
    });
    digests[stage.name]
}

include!(concat!(env!("OUT_DIR"), "/code.rs"));
