//! One time step of the material point method, and the run's state.
//!
//! Cubic B-splines, affine (APIC) transfer, stress at the middle of the step, and every joule that a transfer takes out of
//! motion returned as heat: kinetic (affine included) plus internal energy is conserved to rounding.
use crate::contact::Contact;
use crate::g2p::Update;
use crate::grid::Grid;
use crate::material::Law;
use crate::method::{Method, Scheme, Transfer};
use crate::p2g::{Force, Momentum};
use crate::particle::Particle;
use crate::signal::{self, Signal};
use crate::store::{Frame, Lost, Store};
use crate::task::{self, Crew};
use crate::window::Shared;
use crate::{conduction, remap, xpic};
use hvi_kit::lanes::Instructions;
use serde::{Deserialize, Serialize};
use std::any::Any;

/// What stays the same through a run.
pub struct Setting<const D: usize> {
    /// Grid spacing [m].
    pub cell: f64,
    /// (r, z): `position[1]` is a radius, and the hoop terms act.
    pub axisymmetric: bool,
    /// Mirror planes at 0, by axis.
    pub mirrors: [bool; D],
    /// Laws of the materials, by body.
    pub laws: Vec<Law>,
    /// Courant number.
    pub cfl: f64,
    /// Variant of the method.
    pub method: Method,
    /// Bodies meet in the course of the run: no particle may go further than `cfl` cells in a step.
    pub has_gaps: bool,
    /// Velocity [m/s]: matter that is slower, and under no more stress than goes with it in a wave, sleeps until a neighbour
    /// block's wakes it. The error in velocity is as much. 0: nothing sleeps.
    pub quiet: f64,
    /// Threads that do the passes; the answer has the same bits for any number.
    pub threads: usize,
    /// Instruction set of the inner loops; the answer has the same bits on all.
    pub instructions: Instructions,
    /// Number of the material of each body: bodies of the same law share one.
    materials: Vec<usize>,
}

impl<const D: usize> Setting<D> {
    /// Flat space without mirrors, the default method at Courant number .5.
    pub fn new(cell: f64, laws: Vec<Law>) -> Self {
        let materials = laws.iter().map(|law| laws.iter().position(|l| l == law).expect("itself")).collect();
        Setting {
            cell,
            axisymmetric: false,
            mirrors: [false; D],
            laws,
            cfl: 0.5,
            method: Method::default(),
            has_gaps: false,
            quiet: 0.0,
            threads: 1,
            instructions: Instructions::best(),
            materials,
        }
    }

    /// Material of body `body`: the first body with the same law.
    #[inline(always)]
    pub fn material(&self, body: u8) -> usize {
        self.materials[body as usize]
    }

    /// Least radius to divide by [m]: a particle may come to lie on the axis to rounding.
    #[inline(always)]
    pub fn least_radius(&self) -> f64 {
        1e-9 * self.cell
    }

    /// Numbers of materials that conduct heat are below this.
    fn conductors(&self) -> usize {
        if self.method.conduction > 0.0 { self.materials.iter().max().map_or(0, |m| m + 1) } else { 0 }
    }

    fn frame(&self) -> Frame {
        let kernel = self.method.kernel;
        Frame { cell: self.cell, reach: kernel.reach(), apart: self.method.friction.is_some() }
    }
}

/// What a step adds to the accounts of a block's particles.
#[derive(Clone, Copy, Debug)]
pub struct Booked {
    /// See [`Totals`].
    pub viscous: f64,
    /// See [`Totals`].
    pub transfer: f64,
    /// See [`Totals`].
    pub unresolved: f64,
    /// See [`Totals`].
    pub floored: f64,
    /// See [`Totals`].
    pub limited: u64,
    /// See [`Totals`].
    pub highest_pressure: f64,
    /// See [`Totals`].
    pub least_ratio: f64,
    /// A particle's state isn't finite.
    pub wrong: bool,
}

impl Default for Booked {
    fn default() -> Self {
        Booked {
            viscous: 0.0,
            transfer: 0.0,
            unresolved: 0.0,
            floored: 0.0,
            limited: 0,
            highest_pressure: f64::NEG_INFINITY,
            least_ratio: f64::INFINITY,
            wrong: false,
        }
    }
}

/// Accounts and records since the start, per the particles' mass unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Heat of artificial viscosity [J].
    pub viscous: f64,
    /// Heat of the transfers [J].
    pub transfer: f64,
    /// Motion that no particle holds and that is no heat [J]: see [`crate::method::TransferHeat`].
    pub unresolved: f64,
    /// Energy of the floor [J].
    pub floored: f64,
    /// Particle-steps whose volume change was limited: to a half over the step, or to .3 over its first half.
    pub limited: u64,
    /// Highest pressure [Pa].
    pub highest_pressure: f64,
    /// Least volume over initial volume.
    pub least_ratio: f64,
}

impl Totals {
    fn add(&mut self, booked: &Booked) {
        self.viscous += booked.viscous;
        self.transfer += booked.transfer;
        self.unresolved += booked.unresolved;
        self.floored += booked.floored;
        self.limited += booked.limited;
        self.highest_pressure = self.highest_pressure.max(booked.highest_pressure);
        self.least_ratio = self.least_ratio.min(booked.least_ratio);
    }
}

/// A run under way; what only lives within a step is not part of its checkpoints.
#[derive(Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// Time [s].
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Last time step, before it was cut to meet an output time [s].
    pub dt: f64,
    /// Time step of the first step [s].
    pub first_dt: f64,
    /// Accounts.
    pub totals: Totals,
    store: Store<D>,
    /// A particle beyond the grid's range from the start, if any.
    lost: Option<u32>,
    #[serde(skip)]
    grid: Grid<D>,
    #[serde(skip)]
    contact: Contact<D>,
    #[serde(skip)]
    crew: Crew,
    #[serde(skip)]
    signal: Option<Signal>,
    cut: f64,
}

/// What stopped a run.
#[derive(Debug)]
pub enum Stop {
    /// A particle (its number at the start) left the range of numbers.
    Lost(u32),
    /// A particle's energy, volume or pressure isn't finite.
    NotFinite(u32),
    /// The time step [s] fell below a thousandth of the first, by this particle.
    Collapsed(u32, f64),
}

/// Nodes lighter than this times a mean particle stand still.
const EMPTY: f64 = 1e-12;
/// The time step grows by no more than this.
const GROWTH: f64 = 1.1;
/// Least time step over the first.
const COLLAPSE: f64 = 1e-3;

impl<const D: usize> State<D> {
    /// The start of a run: fills in the particles' state.
    pub fn new(mut particles: Vec<Particle<D>>, setting: &Setting<D>) -> Self {
        for p in &mut particles {
            setting.laws[p.body as usize].prepare(p);
        }
        let mass: f64 = particles.iter().map(|p| p.mass).sum();
        let cut = EMPTY * mass / particles.len() as f64;
        let totals = Totals { least_ratio: 1.0, ..Totals::default() };
        let (store, lost) = Store::new(&particles, setting.frame());
        State {
            time: 0.0,
            steps: 0,
            dt: f64::INFINITY,
            first_dt: f64::INFINITY,
            totals,
            store,
            lost: lost.map(|Lost(id)| id),
            grid: Grid::default(),
            contact: Contact::default(),
            crew: Crew::default(),
            signal: None,
            cut,
        }
    }

    /// All particles, those of a block of the grid together.
    pub fn particles(&self) -> impl Iterator<Item = Particle<D>> {
        self.store.iter()
    }

    /// Shows every particle to `look`, in order: cheaper than [`State::particles`] where few of their numbers are wanted.
    #[inline(always)]
    pub fn visit(&self, look: impl FnMut(Particle<D>)) {
        self.store.visit(look);
    }

    /// How many particles there are.
    pub fn count(&self) -> usize {
        self.store.len()
    }

    /// Changes every particle's state; none may leave its cell.
    pub fn alter(&mut self, change: impl FnMut(&mut Particle<D>)) {
        self.signal = None;
        self.store.alter(change);
    }

    /// Takes one step, not beyond time `until` [s].
    ///
    /// # Errors
    /// [`Stop`] where a particle's state leaves what the method can carry.
    pub fn step(&mut self, setting: &Setting<D>, until: f64) -> Result<(), Stop> {
        // The inner loops are compiled here, once a dimension, and not again in every crate that takes steps.
        match D {
            1 => step_line(self, setting, until),
            2 => step_plane(self, setting, until),
            _ => step_space(self, setting, until),
        }
    }

    fn take_step(&mut self, setting: &Setting<D>, until: f64) -> Result<(), Stop> {
        if let Some(id) = self.lost {
            return Err(Stop::Lost(id));
        }
        let dt = self.choose_dt(setting, until)?;
        let method = &setting.method;
        let cut = self.cut;
        let State { store, grid, crew, contact, .. } = self;
        // Passes of any but the plain method take four nodes an axis.
        let plain = method.scheme == Scheme::Midpoint && method.friction.is_none();
        let plain = plain && matches!(method.transfer, Transfer::Apic | Transfer::Aflip | Transfer::Flip);
        let fits = plain && task::fits::<D>() && !setting.instructions.is_portable();
        store.touch(if fits { method.kernel.nodes() } else { 4 });
        grid.lay_out(store, &setting.mirrors, setting.conductors());
        store.wake(grid.blocks(), setting.quiet > 0.0 && plain);
        crew.each(store, setting, &Momentum { setting, field: Shared::new(&mut grid.start) });
        grid.fold_start();
        grid.find_velocities(cut, crew, setting.threads);
        if let Some(friction) = method.friction {
            contact.find(store, grid, setting, cut, crew);
            contact.meet(grid, friction);
        }
        if let Transfer::Xpic { order } = method.transfer {
            xpic::damp(store, grid, setting, order, cut, crew);
        }
        store.sites.iter_mut().flatten().for_each(|site| site.booked = Booked::default());
        if method.scheme == Scheme::Usf {
            remap::deform(store, grid, setting, cut, dt, crew);
        }
        let mut force = std::mem::take(&mut grid.force);
        crew.each(store, setting, &Force { setting, grid, field: Shared::new(&mut force), dt });
        grid.force = force;
        if method.conduction > 0.0 {
            conduction::conduct(store, grid, setting, dt, crew);
        }
        grid.fold_force();
        if let Some(friction) = method.friction {
            contact.part(grid, friction, dt);
            contact.warm(store, setting, crew);
        }
        grid.find_changes(cut, dt, crew, setting.threads);
        crew.each(store, setting, &Update { setting, grid, dt, frame: store.frame() });
        if method.scheme.deforms_last() {
            remap::deform(store, grid, setting, cut, dt, crew);
        }
        self.signal = Some(signal::fastest(store));
        let mut wrong = false;
        for site in store.sites.iter().flatten() {
            self.totals.add(&site.booked);
            wrong |= site.booked.wrong;
        }
        self.time = if self.time + dt >= until * (1.0 - 1e-15) { until } else { self.time + dt };
        self.steps += 1;
        if wrong {
            let mut all = self.store.iter().chain(self.store.leaving().copied());
            let found = all.find(|p| !(p.energy + p.ratio + p.unclamped).is_finite());
            return Err(Stop::NotFinite(found.map_or(0, |p| p.id)));
        }
        self.store.settle().map_err(|Lost(id)| Stop::Lost(id))
    }

    /// Step 0: `dt = CFL dx / max(Q + sqrt(Q^2 + c^2))`, growing slowly; in the first steps, where the divergence at the
    /// contact isn't known yet, the impact speed stands in for it. Where bodies meet later, speed bounds the signal from below.
    fn choose_dt(&mut self, setting: &Setting<D>, until: f64) -> Result<f64, Stop> {
        // Every step leaves it behind; only at a start it has to be looked for.
        let known = self.signal.take();
        let Signal { mut speed, velocity } =
            known.unwrap_or_else(|| signal::listen(&mut self.store, setting, &mut self.crew));
        if self.steps < 3 {
            speed += Law::CONTACT * velocity;
        } else if setting.has_gaps {
            speed = speed.max(velocity);
        }
        self.dt = (setting.cfl * setting.cell / speed).min(GROWTH * self.dt);
        if self.steps == 0 {
            self.first_dt = self.dt;
        }
        if self.dt.is_nan() || self.dt < COLLAPSE * self.first_dt {
            let of = |p: &Particle<D>| Law::signal_speed(p.sound_speed, p.divergence, setting.cell);
            let fastest = self.store.iter().filter(|p| !p.alone).max_by(|a, b| of(a).total_cmp(&of(b)));
            return Err(Stop::Collapsed(fastest.map_or(0, |p| p.id), self.dt));
        }
        // The last two steps before an output time share what is left, so that none is tiny.
        let left = until - self.time;
        Ok(if left <= self.dt {
            left
        } else if left < 2.0 * self.dt {
            0.5 * left
        } else {
            self.dt
        })
    }
}

fn step_line(state: &mut dyn Any, setting: &dyn Any, until: f64) -> Result<(), Stop> {
    step_in::<1>(state, setting, until)
}
fn step_plane(state: &mut dyn Any, setting: &dyn Any, until: f64) -> Result<(), Stop> {
    step_in::<2>(state, setting, until)
}
fn step_space(state: &mut dyn Any, setting: &dyn Any, until: f64) -> Result<(), Stop> {
    step_in::<3>(state, setting, until)
}

fn step_in<const D: usize>(state: &mut dyn Any, setting: &dyn Any, until: f64) -> Result<(), Stop> {
    let state: &mut State<D> = state.downcast_mut().expect("a state of this dimension");
    state.take_step(setting.downcast_ref().expect("a setting of this dimension"), until)
}
