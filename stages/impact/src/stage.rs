//! The stage `impact`.
use crate::bodies::{Piece, pieces};
use crate::effects::{self, Guard, Plan, Watch};
use crate::fault;
use crate::material::{Law, Material, Switches};
use crate::method::Transfer;
use crate::params::{Params, SpaceChoice};
use crate::probes::Following;
use crate::result::{Body, Crossing, Impact, Ledger, Snapshot};
use crate::scene::{self, Layout};
use crate::step::{Setting, State};
use crate::{ledger, melt};
use hvi_eos::{Eos, EosResult};
use hvi_kit::{ByInput, Ctx, File, Invalid, Needs, Places, Stage, StageError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

hvi_kit::inputs! {
    /// Fitted equations of state, where a body names one.
    pub struct ImpactInputs {
        /// Keys `projectile.eos`, `plate.eos`, `plates.NAME.eos`, `bodies.NAME.eos`, each optional: without it the material's own holds.
        eos: Places<EosResult>,
        /// Surfaces, at `meshes.NAME.file`: STL files, text or binary.
        file: Places<File>,
    }
}

/// A hypervelocity impact by the material point method.
pub struct ImpactStage;

impl Stage for ImpactStage {
    const NAME: &'static str = "impact";
    const SUMMARY: &'static str =
        "impact of a projectile on plates and other bodies, normal or oblique, by the material point method";
    type Params = Params;
    type Inputs = ImpactInputs;
    type Output = Impact;

    fn check(params: &Params) -> Result<(), Invalid> {
        params.settled().check()
    }

    fn check_files(params: &Params, files: &BTreeMap<String, File>) -> Result<(), Invalid> {
        if params.meshes.is_empty() && files.is_empty() && !params.has_open_meshes() {
            return Ok(());
        }
        params.with_meshes(files)?.settled().check()
    }

    fn sketch(params: &Params) -> Vec<hvi_kit::view::View> {
        crate::show::sketch::scene(params)
    }

    fn cost(params: &Params) -> f64 {
        let params = &params.settled();
        let layout = Layout::of(params);
        let sound = params.plate.material.sound_speed(&params.plate.material.eos);
        let signal = sound + 0.5 * params.velocity.si();
        let steps = layout.end * signal / (params.cfl * layout.cell);
        let per_step = match params.space() {
            SpaceChoice::Line => 0.15e-6,
            SpaceChoice::Axisymmetric => 0.3e-6,
            _ => 0.6e-6,
        };
        steps * scene::count(params, &layout) * per_step
    }

    fn needs(params: &Params) -> Needs {
        let params = &params.settled();
        let layout = Layout::of(params);
        // The particles with their work space, the nodes around them (few share a block where debris is thin), and what is kept
        // of them at each output time, twice while it is encoded.
        let (held, kept): (f64, f64) = match params.space() {
            SpaceChoice::Line => (1200.0, 2.0 * KEPT),
            SpaceChoice::Axisymmetric => (1600.0, 2.0 * KEPT),
            _ => (1800.0, 2.0 * KEPT),
        };
        let each = held + kept * (params.times.len() + 1) as f64;
        let count = scene::count(params, &layout);
        // Fewer particles a thread than this wait for each other more than they gain.
        Needs { threads: 1 + (count / 10_000.0) as usize, memory: (8 << 20) + (count * each) as u64 }
    }

    fn reach(params: &Params) -> ByInput {
        effects::reach(params)
    }

    fn run(params: &Params, inputs: ImpactInputs, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
        let meshed = params.with_meshes(&inputs.file.0);
        let meshed = meshed.map_err(|e| StageError::physics(format_args!("{}: {}", e.key, e.why)))?;
        let params = &meshed.settled();
        match params.space() {
            SpaceChoice::Line => run::<1>(params, inputs, ctx),
            SpaceChoice::Axisymmetric => run::<2>(params, inputs, ctx),
            SpaceChoice::Quarter | SpaceChoice::Half | SpaceChoice::Full => run::<3>(params, inputs, ctx),
        }
    }
}

/// Times between the start and the end at which the ledger is kept.
const ENTRIES: usize = 100;
/// Matter slower than this times the impact speed, and under no more stress than goes with it, sleeps.
const QUIET: f64 = 1e-9;
/// Size of a particle in a snapshot [B].
const KEPT: f64 = 51.0;

/// A run under way and what it has to show so far: what a checkpoint holds.
#[derive(Serialize, Deserialize)]
struct Progress<const D: usize> {
    state: State<D>,
    bodies: Vec<Body>,
    entries: Vec<Ledger>,
    snapshots: Vec<Snapshot>,
    next_entry: usize,
    following: Option<Following>,
    watch: Watch,
    crossings: Vec<Crossing>,
}

/// How an attempt ends.
enum Ended {
    Whole(Box<Impact>),
    /// An effect that was left off is missing.
    Crossed(Crossing),
}

/// Runs by plan, again with what the plan left off where the run shows it to be missing.
fn run<const D: usize>(params: &Params, inputs: ImpactInputs, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
    let eos = equations_of_state(&pieces(params, &Layout::of(params)), inputs)?;
    let mut plan = effects::plan(params, &eos);
    let mut kept: Option<Progress<D>> = ctx.resume();
    let mut crossings = kept.as_ref().map(|run| run.crossings.clone()).unwrap_or_default();
    for crossing in &crossings {
        plan = plan.after(crossing);
    }
    loop {
        match attempt(&plan, &eos, kept.take(), &crossings, ctx)? {
            Ended::Whole(impact) => return Ok(*impact),
            Ended::Crossed(crossing) if params.guard == Some(Guard::Error) => return Err(fault::crossed(&crossing)),
            Ended::Crossed(crossing) => {
                plan = plan.after(&crossing);
                crossings.push(crossing);
            }
        }
    }
}

fn attempt<const D: usize>(
    plan: &Plan,
    eos: &[Eos],
    kept: Option<Progress<D>>,
    crossings: &[Crossing],
    ctx: &Ctx<'_>,
) -> Result<Ended, StageError> {
    let params = &plan.params;
    let layout = Layout::of(params);
    let pieces = pieces(params, &layout);
    let densities: Vec<f64> = eos.iter().map(|eos| 1.0 / eos.reference_volume()).collect();
    let mut setting = setting::<D>(params, &layout, &pieces, eos.to_vec());
    setting.threads = ctx.threads;
    let materials: Vec<&Material> = pieces.iter().map(|piece| piece.material).collect();
    let entry = |state: &State<D>, start: Option<&Ledger>| ledger::entry(state, &setting, layout.multiple, start);
    let particles = scene::particles::<D>(params, &layout, &densities);
    let contact = melt::at_contact(&particles, layout.cell);
    let mut run: Progress<D> = kept.unwrap_or_else(|| {
        let state = State::new(particles, &setting);
        Progress {
            entries: vec![entry(&state, None)],
            bodies: bodies(&pieces, &state, layout.multiple, &densities),
            snapshots: Vec::new(),
            next_entry: 1,
            following: params.probes.as_ref().map(|probes| Following::new(probes, &state, &setting, &layout)),
            watch: Watch::new(plan, &state, &setting, &layout),
            crossings: crossings.to_vec(),
            state,
        }
    });
    for until in output_times(params, layout.end).split_off(run.snapshots.len()) {
        while run.state.time < until {
            run.state.step(&setting, until).map_err(|stop| fault::stopped(&stop, &run.state, &setting, &run.bodies))?;
            if let Some(following) = &mut run.following {
                following.step(&run.state, &setting, &layout);
            }
            if run.state.time >= layout.end * run.next_entry as f64 / ENTRIES as f64 || run.state.time >= until {
                run.next_entry = 1 + (ENTRIES as f64 * run.state.time / layout.end) as usize;
                run.entries.push(entry(&run.state, Some(&run.entries[0])));
                fault::check_drift(&run.entries, &run.state, &setting, &run.bodies)?;
                if let Some(crossing) = run.watch.look(plan, &run.state, &setting, &materials) {
                    return Ok(Ended::Crossed(crossing));
                }
            }
            ctx.save(|| &run);
            ctx.tick(run.state.time, layout.end, "stepping")?;
        }
        let space = scene::space(params.space());
        run.snapshots.push(melt::snapshot(
            &run.state,
            &setting,
            space,
            [layout.multiple, run.bodies[0].mass],
            &contact,
        ));
    }
    Ok(Ended::Whole(Box::new(whole(plan, &layout, eos, run))))
}

/// The result of a run that has come to its end.
fn whole<const D: usize>(plan: &Plan, layout: &Layout, eos: &[Eos], run: Progress<D>) -> Impact {
    let params = &plan.params;
    let mut notes = notes(params, layout, &run.state, &run.bodies, &run.entries);
    for (eos, body) in eos.iter().zip(&run.bodies) {
        if eos.melting_temperature(eos.reference_volume()).is_none() {
            notes.push(format!(
                "The equation of state of `{}` ({}) knows no melting: its matter counts as solid, and its shares of liquid say nothing.",
                body.name,
                eos.name()
            ));
        }
    }
    let leading = [0.001, 0.01, 0.05].map(|share| ledger::leading(run.state.particles(), 0, share));
    let size = params.projectile.size().min(params.plate.thickness.si());
    Impact {
        space: scene::space(params.space()),
        cell: layout.cell,
        cells_through: size / layout.cell,
        velocity: params.velocity.si(),
        diameter: layout.diameter,
        thickness: params.plate.thickness.si(),
        angle: params.tilt(),
        probes: run.following.map(Following::done).unwrap_or_default(),
        decisions: plan.decisions.clone(),
        crossings: run.crossings,
        notes,
        bodies: run.bodies,
        snapshots: run.snapshots,
        ledger: run.entries,
        leading,
    }
}

/// Densities of a metal by its strength model's handbook and by an equation of state differ by alloy and potential, not by more.
const UNLIKE: f64 = 0.2;

/// By body: what is plugged in, else the material's own.
fn equations_of_state(pieces: &[Piece<'_>], inputs: ImpactInputs) -> Result<Vec<Eos>, StageError> {
    let mut plugged = inputs.eos.0;
    let mut own = |piece: &Piece<'_>| {
        let Some(result) = plugged.remove(&format!("{}.eos", piece.key)) else { return Ok(piece.material.eos.clone()) };
        let [given, known] = [&result.eos, &piece.material.eos].map(|eos| 1e-3 / eos.reference_volume());
        if (given / known - 1.0).abs() > UNLIKE {
            return Err(StageError::physics(format_args!(
                "{}: its equation of state is of matter of {given:.2} g/cm3, its material {} has {known:.2} g/cm3: give it both of one metal",
                piece.key, piece.material.name
            )));
        }
        Ok(result.eos)
    };
    pieces.iter().map(&mut own).collect()
}

fn setting<const D: usize>(params: &Params, layout: &Layout, pieces: &[Piece<'_>], eos: Vec<Eos>) -> Setting<D> {
    let switches = Switches {
        strength: params.strength(),
        damage: params.damage.unwrap_or(true),
        spall: params.spall.unwrap_or(true),
    };
    let all = scene::mirrors(params.space());
    let law = |(eos, piece): (Eos, &Piece<'_>)| Law::new(&acting(params, piece.material), eos, switches);
    let laws = eos.into_iter().zip(pieces).map(law).collect();
    let mut setting = Setting::new(layout.cell, laws);
    setting.axisymmetric = params.space() == SpaceChoice::Axisymmetric;
    setting.mirrors = std::array::from_fn(|d| all[d]);
    setting.has_gaps = pieces.len() > 2;
    (setting.cfl, setting.method) = (params.cfl, params.method());
    if params.sleep.unwrap_or(true) {
        setting.quiet = QUIET * params.velocity.si();
    }
    setting
}

/// A material without what its strength does not depend on.
fn acting(params: &Params, material: &Material) -> Material {
    let mut material = material.clone();
    if params.rate == Some(false) {
        material.strength.c = 0.0;
    }
    if params.softening == Some(false) {
        // 1 - T*^m is 1 up to melting.
        material.strength.m = f64::INFINITY;
    }
    material
}

fn bodies<const D: usize>(pieces: &[Piece<'_>], state: &State<D>, multiple: f64, densities: &[f64]) -> Vec<Body> {
    let mass = |b: usize| multiple * state.particles().filter(|p| p.body as usize == b).map(|p| p.mass).sum::<f64>();
    pieces
        .iter()
        .enumerate()
        .map(|(b, piece)| Body {
            name: piece.name.into(),
            material: piece.material.name.clone(),
            mass: mass(b),
            density: densities[b],
        })
        .collect()
}

/// The times asked for and the end, in order, each once.
fn output_times(params: &Params, end: f64) -> Vec<f64> {
    let mut times: Vec<f64> = params.times.iter().map(|t| t.si()).filter(|&t| t < end).collect();
    times.push(end);
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// What a reader of the result must know.
fn notes<const D: usize>(
    params: &Params,
    layout: &Layout,
    state: &State<D>,
    bodies: &[Body],
    entries: &[Ledger],
) -> Vec<String> {
    let mut notes = vec![
        resolution(params, layout, entries),
        "Phases by V_eff = min(V, V where P(V, E) = 0); own-volume phases also count matter whose melting temperature \
         fell by numerical expansion alone."
            .into(),
    ];
    if let Some(exact) = scene::round_mass(params, bodies[0].density) {
        let error = 100.0 * (bodies[0].mass / exact - 1.0);
        notes.push(format!(
            "The projectile's mass is {error:+.2} % off: its round surface is made of whole lattice points."
        ));
    }
    if params.cells < 5 {
        notes.push(format!("Only {} cells through the thinner body: 5 or more are advised.", params.cells));
    }
    if params.end.is_none() {
        notes.push(format!("Ended by rule at {:.3} us.", layout.end * 1e6));
    }
    if params.space() != SpaceChoice::Line && params.plate.width.is_none() {
        notes.push(format!("Plate {:.2} mm wide, by rule: no wave is back from its rim.", layout.width * 1e3));
    }
    if state.totals.limited > 0 {
        notes.push(format!(
            "{} particle-steps would have shrunk to less than half (or by 30 % to the middle of the step) and were limited.",
            state.totals.limited
        ));
    }
    notes
}

/// Heat of the transfer beyond which another transfer is advised, in percent of the initial kinetic energy.
const WARM: f64 = 5.0;

/// The grid, what became heat through it, and what of the result depends on that.
fn resolution(params: &Params, layout: &Layout, entries: &[Ledger]) -> String {
    let across = if layout.diameter.is_finite() {
        format!(", {:.1} across the projectile", layout.diameter / layout.cell)
    } else {
        String::new()
    };
    let percent = |heat: fn(&Ledger) -> f64| 100.0 * entries.last().map_or(0.0, heat) / entries[0].kinetic;
    let advice = if params.transfer == Transfer::Apic && percent(|l| l.transfer) > WARM {
        " With transfer = \"aflip\" less becomes heat in the transfer."
    } else {
        ""
    };
    let unresolved = match percent(|l| l.unresolved) {
        0.0 => String::new(),
        share => format!(" {share:.1} % is motion that the grid does not resolve and that was not made heat."),
    };
    format!(
        "{} cells of {:.4} mm through the thinner body{across}, {} particles a cell and axis. Of the initial kinetic energy \
         {:.1} % became heat in the transfer between particles and grid, {:.1} % in artificial viscosity. The melted share \
         holds this heat: it falls as the cells across the projectile grow in number, and rises as cfl falls ({} here), since \
         more steps transfer more often. Compare runs of the same cells across and cfl, or extrapolate.{unresolved}{advice}",
        params.cells,
        layout.cell * 1e3,
        params.particles,
        percent(|l| l.transfer),
        percent(|l| l.viscous),
        params.cfl
    )
}
