//! The stage `impact`.
use crate::bodies::{Piece, pieces};
use crate::material::{Law, Switches};
use crate::params::{Params, SpaceChoice};
use crate::result::{Body, Impact, Ledger, Snapshot};
use crate::scene::{self, Layout};
use crate::step::{Setting, State, Stop};
use crate::{ledger, melt};
use hvi_eos::{Eos, EosResult};
use hvi_kit::{Ctx, Invalid, Needs, Places, Stage, StageError};
use serde::{Deserialize, Serialize};

hvi_kit::inputs! {
    /// Fitted equations of state, where a body names one.
    pub struct ImpactInputs {
        /// Keys `projectile.eos`, `plate.eos`, `plates.NAME.eos`, `bodies.NAME.eos`, each optional: without it the material's own holds.
        eos: Places<EosResult>,
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
        params.check()
    }

    fn cost(params: &Params) -> f64 {
        let layout = Layout::of(params);
        let sound = params.plate.material.sound_speed(&params.plate.material.eos);
        let signal = sound + 0.5 * params.velocity.si();
        let steps = layout.end * signal / (params.cfl * layout.cell);
        let per_step = match params.space {
            SpaceChoice::Line => 0.3e-6,
            SpaceChoice::Axisymmetric => 0.9e-6,
            _ => 2.0e-6,
        };
        steps * scene::count(params, &layout) * per_step
    }

    fn needs(params: &Params) -> Needs {
        let layout = Layout::of(params);
        // The particles with their work space, the nodes around them (few share a block where debris is thin), and what is kept
        // of them at each output time, twice while it is encoded.
        let (held, kept): (f64, f64) = match params.space {
            SpaceChoice::Line => (1200.0, 2.0 * KEPT),
            SpaceChoice::Axisymmetric => (1600.0, 2.0 * KEPT),
            _ => (2500.0, 2.0 * KEPT),
        };
        let each = held + kept * (params.times.len() + 1) as f64;
        Needs { threads: 1, memory: (8 << 20) + (scene::count(params, &layout) * each) as u64 }
    }

    fn run(params: &Params, inputs: ImpactInputs, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
        match params.space {
            SpaceChoice::Line => run::<1>(params, inputs, ctx),
            SpaceChoice::Axisymmetric => run::<2>(params, inputs, ctx),
            SpaceChoice::Quarter | SpaceChoice::Half | SpaceChoice::Full => run::<3>(params, inputs, ctx),
        }
    }
}

/// Times between the start and the end at which the ledger is kept.
const ENTRIES: usize = 100;
/// Size of a particle in a snapshot [B].
const KEPT: f64 = 51.0;
/// Largest energy drift a run may end with: a thousand times what rounding makes of 1e6 particles and 1e4 steps.
const DRIFT: f64 = 1e-8;

/// A run under way and what it has to show so far: what a checkpoint holds.
#[derive(Serialize, Deserialize)]
struct Progress<const D: usize> {
    state: State<D>,
    bodies: Vec<Body>,
    entries: Vec<Ledger>,
    snapshots: Vec<Snapshot>,
    next_entry: usize,
}

fn run<const D: usize>(params: &Params, inputs: ImpactInputs, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
    let layout = Layout::of(params);
    let pieces = pieces(params, &layout);
    let eos = equations_of_state(&pieces, inputs);
    let densities: Vec<f64> = eos.iter().map(|eos| 1.0 / eos.reference_volume()).collect();
    let setting = setting::<D>(params, &layout, &pieces, eos);
    let entry = |state: &State<D>, start: Option<&Ledger>| ledger::entry(state, &setting, layout.multiple, start);
    let mut run: Progress<D> = ctx.resume().unwrap_or_else(|| {
        let state = State::new(scene::particles::<D>(params, &layout, &densities), &setting);
        let bodies = bodies(&pieces, &state, layout.multiple, &densities);
        Progress { entries: vec![entry(&state, None)], bodies, state, snapshots: Vec::new(), next_entry: 1 }
    });
    for until in output_times(params, layout.end).split_off(run.snapshots.len()) {
        while run.state.time < until {
            run.state.step(&setting, until).map_err(|stop| failure(&stop, &run.state, &setting, &run.bodies))?;
            if run.state.time >= layout.end * run.next_entry as f64 / ENTRIES as f64 || run.state.time >= until {
                run.next_entry = 1 + (ENTRIES as f64 * run.state.time / layout.end) as usize;
                run.entries.push(entry(&run.state, Some(&run.entries[0])));
                check_drift(run.entries.last().expect("just pushed"))?;
            }
            ctx.save(|| &run);
            ctx.tick(run.state.time, layout.end, "stepping")?;
        }
        let space = scene::space(params.space);
        run.snapshots.push(melt::snapshot(&run.state, &setting, space, layout.multiple, run.bodies[0].mass));
    }
    let Progress { state, bodies, entries, snapshots, .. } = run;
    let leading = [0.001, 0.01, 0.05].map(|share| ledger::leading(&state.particles, 0, share));
    let size = params.projectile.size().min(params.plate.thickness.si());
    Ok(Impact {
        space: scene::space(params.space),
        cell: layout.cell,
        cells_through: size / layout.cell,
        velocity: params.velocity.si(),
        diameter: layout.diameter,
        thickness: params.plate.thickness.si(),
        notes: notes(params, &layout, &state, &bodies, &entries),
        bodies,
        snapshots,
        ledger: entries,
        leading,
    })
}

/// The fitted equation of state of each body, or its material's own.
fn equations_of_state(pieces: &[Piece<'_>], inputs: ImpactInputs) -> Vec<Eos> {
    let mut plugged = inputs.eos.0;
    let own = |piece: &Piece<'_>| plugged.remove(&format!("{}.eos", piece.key)).map(|result| result.eos);
    pieces.iter().map(own).zip(pieces).map(|(eos, piece)| eos.unwrap_or_else(|| piece.material.eos.clone())).collect()
}

fn setting<const D: usize>(params: &Params, layout: &Layout, pieces: &[Piece<'_>], eos: Vec<Eos>) -> Setting<D> {
    let switches = Switches {
        strength: params.strength,
        damage: params.damage.unwrap_or(true),
        spall: params.spall.unwrap_or(true),
    };
    let all = scene::mirrors(params.space);
    let laws = eos.into_iter().zip(pieces).map(|(eos, piece)| Law::new(piece.material, eos, switches)).collect();
    let mut setting = Setting::new(layout.cell, laws);
    setting.axisymmetric = params.space == SpaceChoice::Axisymmetric;
    setting.mirrors = std::array::from_fn(|d| all[d]);
    setting.has_gaps = pieces.len() > 2;
    (setting.cfl, setting.method) = (params.cfl, params.method());
    setting
}

fn bodies<const D: usize>(pieces: &[Piece<'_>], state: &State<D>, multiple: f64, densities: &[f64]) -> Vec<Body> {
    let mass =
        |b: usize| multiple * state.particles.iter().filter(|p| p.body as usize == b).map(|p| p.mass).sum::<f64>();
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

fn check_drift(entry: &Ledger) -> Result<(), StageError> {
    if entry.drift.abs() <= DRIFT {
        return Ok(());
    }
    Err(StageError::physics(format_args!(
        "step {}, {:.4} us: energy has drifted by {:.2e} of the start's, {DRIFT:.0e} is allowed; this is a fault of the \
         program, please report the parameters",
        entry.step,
        entry.time * 1e6,
        entry.drift
    )))
}

/// Says where and what, and what to do.
fn failure<const D: usize>(stop: &Stop, state: &State<D>, setting: &Setting<D>, bodies: &[Body]) -> StageError {
    let (i, what) = match *stop {
        Stop::Lost(i) => (i, "its position is not within 5e8 cells of the origin".to_string()),
        Stop::NotFinite(i) => {
            let p = &state.particles[i];
            (
                i,
                format!(
                    "energy {:e} J/kg, V/V0 {:.4e}, pressure {:e} Pa must all be finite",
                    p.energy, p.ratio, p.pressure
                ),
            )
        }
        Stop::Collapsed(i, dt) => {
            (i, format!("it asks for a time step of {dt:.2e} s, at least {:.2e} s is allowed", 1e-3 * state.first_dt))
        }
    };
    let p = &state.particles[i];
    StageError::physics(format_args!(
        "step {}, {:.4} us: particle {} of the {} at {:?} mm, {:?} m/s (V/V0 {:.4e}, {:.4e} J/kg, sound speed {:.4e} m/s): \
         {what}; try a smaller cfl, or a different number of cells ({:.4} mm now)",
        state.steps,
        state.time * 1e6,
        p.id,
        bodies[p.body as usize].name,
        p.position.map(|x| x * 1e3),
        p.velocity,
        p.ratio,
        p.energy,
        p.sound_speed,
        setting.cell * 1e3
    ))
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
    if params.space != SpaceChoice::Line && params.plate.width.is_none() {
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

/// The grid, what became heat through it, and what of the result depends on that.
fn resolution(params: &Params, layout: &Layout, entries: &[Ledger]) -> String {
    let across = if layout.diameter.is_finite() {
        format!(", {:.1} across the projectile", layout.diameter / layout.cell)
    } else {
        String::new()
    };
    let percent = |heat: fn(&Ledger) -> f64| 100.0 * entries.last().map_or(0.0, heat) / entries[0].kinetic;
    format!(
        "{} cells of {:.4} mm through the thinner body{across}, {} particles a cell and axis. Of the initial kinetic energy \
         {:.1} % became heat in the transfer between particles and grid, {:.1} % in artificial viscosity. The melted share \
         holds this heat: it falls as the cells across the projectile grow in number, and rises as cfl falls ({} here), since \
         more steps transfer more often. Compare runs of the same cells across and cfl, or extrapolate.",
        params.cells,
        layout.cell * 1e3,
        params.particles,
        percent(|l| l.transfer),
        percent(|l| l.viscous),
        params.cfl
    )
}
