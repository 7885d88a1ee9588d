//! The same bits from every stage: with one job and two, one thread and two, straight through and interrupted.
use super::project::{Project, objects};
use hvi_cache::Found;
use hvi_flow::{execute, pipeline, plan, registry};
use hvi_kit::{Cancel, Ctx, Digest, Host, Recipe, StageDef, StageError, Store};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Every stage, each as cheap as it comes.
const ALL: &str = r#"
[step.states]
use = "md"
potential = "mishin-2001"
atoms = 256
equilibration = "0.3 ps"
shortest = "0.3 ps"
longest = "0.6 ps"
sweep = { volume_ratio = "1.06 .. 0.7 in 7", temperature = ["300 K", "1500 K", "6000 K"] }
[step.melting]
use = "md.coexistence"
potential = "mishin-2001"
guess = "1450 K"
across = 4
along = 8
settling = "0.5 ps"
shortest = "5 ps"
longest = "5 ps"
alone = "1 ps"
target_error = "1000 K"
[step.copper]
use = "eos.gray"
states = "@states[*]"
[step.metal]
use = "eos.handbook"
set = "copper-royce"
[step.table]
use = "eos.table"
states = "@states[*]"
[step.sesame]
use = "eos.sesame"
table = "table.txt"
[step.curves]
use = "eos.curves"
eos = "@metal"
[step.survey]
use = "eos.survey"
eos = "@table"
reference = "@metal"
calls = 20_000
states = 256
[step.hugoniot]
use = "validate.hugoniot"
eos = "@copper"
states = "@states[*]"
marsh = "DATA/cu_hugoniot_marsh1980.csv"
database = "DATA/cu_hugoniot_shockwave_database.csv"
[step.isotherm]
use = "validate.isotherm"
eos = "@copper"
states = "@states[*]"
data = "DATA/cu_isotherm_dewaele2004.csv"
[step.hit]
use = "impact"
projectile = { shape = "sphere", material = "copper", eos = "@metal" }
plate = { material = "copper", thickness = "2.5 mm", eos = "@metal" }
cells = 2
[step.hit.sweep]
velocity = ["2 km/s", "3 km/s", "4 km/s", "5 km/s"]
"projectile.diameter" = ["1.6 mm", "3.2 mm", "6.4 mm"]
[step.quarter]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper" }
plate = { material = "copper", thickness = "0.5 mm", width = "2 mm" }
velocity = "3 km/s"
space = "quarter"
cells = 2
end = "0.3 us"
[step.film]
use = "radiograph"
run = "@quarter"
width = 64
[step.eta]
use = "empirical.eta"
runs = "@hit[*]"
[step.bar]
use = "impact"
projectile = { shape = "cylinder", diameter = "2 mm", length = "2 mm", material = "copper" }
plate = { material = "copper", thickness = "2 mm", width = "2 mm" }
velocity = "200 m/s"
cells = 4
end = "0.5 us"
[step.taylor]
use = "validate.taylor"
runs = "@bar"
shots = "bars.csv"
[step.thin]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "aluminium" }
plate = { material = "aluminium", thickness = "0.3 mm", width = "3 mm" }
velocity = "6 km/s"
cells = 2
end = "1 us"
[step.debris]
use = "validate.debris"
runs = "@thin"
ranges = "DATA/al_debris.csv"
[step.verdict]
use = "reproduction"
published = "DATA/paper_liu2013_results.csv"
best_copper = "@copper"
"#;

/// A shot that `bar` is: half the speed on a rigid plane.
const BARS: &str = "reference,rho0,T0,U,L0,D0,Lf,Lf_over_L0,Xf,Df,Wf\nA,8930,295,100,2,2,1.9,0.95,,2.1,\n";

/// A table for `eos.sesame`: pressure linear in density and temperature, energy in temperature.
const TABLE: &str = "4 3  8 9 10 12  300 2000 5000
    -14 1 16 46  -4 11 26 56  14 29 44 74
    0 0 0 0  0.65 0.65 0.65 0.65  1.81 1.81 1.81 1.81";

fn project() -> Project {
    let project = Project::new(&study());
    project.write("table.txt", TABLE);
    project.write("bars.csv", BARS);
    project
}

fn study() -> String {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/data");
    ALL.replace("DATA", data.to_str().unwrap())
}

#[test]
fn every_stage_gives_the_same_bits_however_it_is_run() {
    let (one, two) = (project(), project());
    for (project, jobs) in [(&one, "1"), (&two, "2")] {
        let said = project.hvi(&["run", "study.toml", "--jobs", jobs]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    assert!(objects(&one) == objects(&two), "one job and two");

    let pipeline = pipeline::read(&one.path("study.toml"), &[]).unwrap();
    let plan = plan::plan(&pipeline, &[]).unwrap();
    let store = Store::open(one.path("store")).unwrap();
    let (mut outputs, mut seen, mut resumed) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    for id in 0..plan.nodes.len() {
        let recipe = execute::recipe(&plan, id, &|need: usize| outputs.get(need).copied()).unwrap();
        let Found::Whole(entry) = store.find(recipe.key()) else { panic!("{} is not in the store", plan.label(id)) };
        outputs.push(entry.output);
        let stage = plan.nodes[id].stage;
        seen.insert(stage.name);
        // The ends of each sweep are enough.
        let nodes = plan.steps.iter().find(|step| step.nodes.contains(&id)).unwrap().nodes.clone();
        if id == nodes.start || id + 1 == nodes.end {
            let label = plan.label(id);
            let (ticks, threaded) = straight(stage, &recipe, &store);
            assert_eq!(threaded, entry.output, "{label} with two threads");
            let (interruptions, output) = interrupted(stage, &recipe, &store, ticks / 4);
            assert_eq!(output, entry.output, "{label} interrupted {interruptions} times");
            if interruptions > 1 {
                resumed.insert(stage.name);
            }
        }
    }
    let all: BTreeSet<_> = registry::STAGES.iter().map(|stage| stage.name).collect();
    assert_eq!(seen, all, "every stage");
    assert!(resumed.is_superset(&["md", "impact"].into()), "what takes long goes on from a checkpoint: {resumed:?}");
}

/// Stops a stage after a number of steps; its checkpoint is in the store.
struct Stopper<'a> {
    store: &'a Store,
    key: Digest,
    cancel: Cancel,
    ticks: AtomicU32,
    last: u32,
    went_on: AtomicBool,
}

impl Stopper<'_> {
    fn new<'a>(store: &'a Store, recipe: &Recipe, last: u32) -> Stopper<'a> {
        let (ticks, went_on) = (AtomicU32::new(0), AtomicBool::new(false));
        Stopper { store, key: recipe.key(), cancel: Cancel::default(), ticks, last, went_on }
    }
}

impl Host for Stopper<'_> {
    fn advance(&self, _: f64, _: f64, _: &str) {
        if self.ticks.fetch_add(1, Ordering::Relaxed) + 1 == self.last {
            self.cancel.set();
        }
    }
    fn keep(&self, bytes: &[u8]) {
        self.store.keep_partial(self.key, bytes).unwrap();
    }
    fn kept(&self) -> Option<Vec<u8>> {
        let kept = self.store.partial(self.key)?;
        self.went_on.store(true, Ordering::Relaxed);
        Some(kept)
    }
}

/// Steps of a straight run with two threads, and its output.
fn straight(stage: &StageDef, recipe: &Recipe, store: &Store) -> (u32, Digest) {
    let host = Stopper::new(store, recipe, u32::MAX);
    let made = (stage.run)(recipe, store, &Ctx { host: &host, cancel: &host.cancel, threads: 2 });
    (host.ticks.into_inner(), made.unwrap().output)
}

/// Stops a run after each `steps`, three times at most, with one thread and two in turn; how often it went on, and its
/// output.
fn interrupted(stage: &StageDef, recipe: &Recipe, store: &Store, steps: u32) -> (u32, Digest) {
    let mut went_on = 0;
    for attempt in 0..4 {
        let last = if attempt < 3 { steps } else { u32::MAX };
        let host = Stopper::new(store, recipe, last);
        let threads = 1 + attempt % 2;
        let made = (stage.run)(recipe, store, &Ctx { host: &host, cancel: &host.cancel, threads });
        went_on += u32::from(host.went_on.into_inner());
        match made {
            Ok(made) => {
                store.drop_partial(recipe.key());
                return (went_on, made.output);
            }
            Err(StageError::Cancelled(_)) => {}
            Err(e) => panic!("{}: {e}", stage.name),
        }
    }
    unreachable!("the last attempt is not stopped")
}
