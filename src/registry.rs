//! Every stage, in the order of the chain: the one place to add one.
use hvi_kit::StageDef;

/// All stages.
pub static STAGES: &[StageDef] = &[
    StageDef::of::<hvi_md::Md>(),
    StageDef::of::<hvi_md::TwoPhases>(),
    StageDef::of::<hvi_eos::fit::Fitting>(),
    StageDef::of::<hvi_eos::handbook::Handbook>(),
    StageDef::of::<hvi_eos::tabulate::Table>(),
    StageDef::of::<hvi_eos::tabulate::Sesame>(),
    StageDef::of::<hvi_eos::curves::CurvesStage>(),
    StageDef::of::<hvi_validate::hugoniot::Hugoniot>(),
    StageDef::of::<hvi_validate::isotherm::Isotherm>(),
    StageDef::of::<hvi_impact::ImpactStage>(),
    StageDef::of::<hvi_radiograph::Radiograph>(),
    StageDef::of::<hvi_empirical::Eta>(),
];

/// The stage called `name`.
pub fn stage(name: &str) -> Option<&'static StageDef> {
    STAGES.iter().find(|s| s.name == name)
}

/// Digest of the code behind `stage`: see `src/build.rs`.
pub fn code(stage: &StageDef) -> hvi_kit::Digest {
    let name = (stage.type_name)().split("::").next().unwrap_or_default();
    let known = CODE.iter().find(|(krate, _)| *krate == name);
    known.and_then(|(_, hex)| hex.parse().ok()).expect("the build script lists every stage's crate")
}

include!(concat!(env!("OUT_DIR"), "/code.rs"));
