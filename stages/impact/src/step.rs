//! One time step of the material point method, and the run's state.
//!
//! Cubic B-splines, affine (APIC) transfer, stress at the middle of the step, and every joule that a transfer takes out of
//! motion returned as heat: kinetic (affine included) plus internal energy is conserved to rounding.
use crate::conduction::Conduction;
use crate::contact::Contact;
use crate::grid::{Grid, Lost};
use crate::material::Law;
use crate::method::{Method, Scheme};
use crate::p2g::Work;
use crate::particle::Particle;
use crate::{g2p, grid_update, p2g, remap, xpic};
use serde::{Deserialize, Serialize};

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
            materials,
        }
    }

    /// Material of body `body`: the first body with the same law.
    #[inline(always)]
    pub fn material(&self, body: u8) -> usize {
        self.materials[body as usize]
    }

    /// Radius to divide by [m]: a particle may come to lie on the axis to rounding.
    #[inline(always)]
    pub fn radius(&self, radius: f64) -> f64 {
        radius.max(1e-9 * self.cell)
    }
}

/// Accounts and records since the start, per the particles' mass unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Heat of artificial viscosity [J].
    pub viscous: f64,
    /// Heat of the transfers [J].
    pub transfer: f64,
    /// Energy of the floor [J].
    pub floored: f64,
    /// Particle-steps whose volume change was limited: to a half over the step, or to .3 over its first half.
    pub limited: u64,
    /// Highest pressure [Pa].
    pub highest_pressure: f64,
    /// Least volume over initial volume.
    pub least_ratio: f64,
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
    /// The particles.
    pub particles: Vec<Particle<D>>,
    /// Accounts.
    pub totals: Totals,
    #[serde(skip)]
    grid: Grid<D>,
    #[serde(skip)]
    slots: Vec<u32>,
    #[serde(skip)]
    work: Vec<Work<D>>,
    #[serde(skip)]
    conduction: Conduction,
    #[serde(skip)]
    contact: Contact<D>,
    cut: f64,
}

/// What stopped a run.
#[derive(Debug)]
pub enum Stop {
    /// A particle (index) left the range of numbers.
    Lost(usize),
    /// A particle's (index) energy, volume or pressure isn't finite.
    NotFinite(usize),
    /// The time step [s] fell below a thousandth of the first, by this particle (index).
    Collapsed(usize, f64),
}

/// Nodes lighter than this times a mean particle stand still.
const EMPTY: f64 = 1e-12;
/// The time step grows by no more than this.
const GROWTH: f64 = 1.1;
/// Steps between sorts of the particles by cell: they move less than half a cell a step.
const SORT: u64 = 16;
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
        State {
            time: 0.0,
            steps: 0,
            dt: f64::INFINITY,
            first_dt: f64::INFINITY,
            particles,
            totals,
            grid: Grid::default(),
            slots: Vec::new(),
            work: Vec::new(),
            conduction: Conduction::default(),
            contact: Contact::default(),
            cut,
        }
    }

    /// Takes one step, not beyond time `until` [s].
    ///
    /// # Errors
    /// [`Stop`] where a particle's state leaves what the method can carry.
    pub fn step(&mut self, setting: &Setting<D>, until: f64) -> Result<(), Stop> {
        let dt = self.choose_dt(setting, until)?;
        if self.steps.is_multiple_of(SORT) {
            self.sort(setting.cell);
        }
        let (grid, work) = (&mut self.grid, &mut self.work);
        grid.lay_out(
            &self.particles,
            setting.cell,
            &setting.mirrors,
            setting.method.friction.is_some(),
            &mut self.slots,
        )
        .map_err(|Lost(i)| Stop::Lost(i))?;
        p2g::momentum(&self.particles, &self.slots, grid, setting, work);
        grid_update::velocities(grid, self.cut);
        if let Some(friction) = setting.method.friction {
            self.contact.find(&self.particles, work, grid, setting, self.cut);
            self.contact.meet(grid, friction);
        }
        p2g::gradients(&self.particles, work, grid, setting.cell);
        xpic::damp(&self.particles, work, grid, setting, self.cut);
        if setting.method.conduction > 0.0 {
            self.conduction.conduct(&self.particles, work, grid, setting, dt);
        }
        p2g::force(&mut self.particles, work, grid, setting, dt);
        grid_update::accelerate(grid, self.cut, dt);
        if let Some(friction) = setting.method.friction {
            self.contact.part(grid, friction);
            self.contact.warm(&self.particles, work, grid, setting.cell);
        }
        let wrong = g2p::update(&mut self.particles, work, grid, setting, dt, &mut self.totals);
        if setting.method.scheme == Scheme::Musl {
            remap::deform(&mut self.particles, work, grid, setting, self.cut, dt, &mut self.totals);
        }
        self.time = if self.time + dt >= until * (1.0 - 1e-15) { until } else { self.time + dt };
        self.steps += 1;
        wrong.map_or(Ok(()), |i| Err(Stop::NotFinite(i)))
    }

    /// Step 0: `dt = CFL dx / max(Q + sqrt(Q^2 + c^2))`, growing slowly; in the first steps, where the divergence at the
    /// contact isn't known yet, the impact speed stands in for it. Where bodies meet later, speed bounds the signal from below.
    fn choose_dt(&mut self, setting: &Setting<D>, until: f64) -> Result<f64, Stop> {
        let (mut signal, mut speed2, mut fastest) = (0.0, 0.0f64, 0);
        for (i, p) in self.particles.iter().enumerate() {
            let s = Law::signal_speed(p, setting.cell);
            if s > signal && !p.alone {
                (signal, fastest) = (s, i);
            }
            if self.steps < 3 || setting.has_gaps {
                speed2 = speed2.max(p.velocity.iter().map(|v| v * v).sum());
            }
        }
        if self.steps < 3 {
            signal += Law::CONTACT * speed2.sqrt();
        } else {
            signal = signal.max(speed2.sqrt());
        }
        self.dt = (setting.cfl * setting.cell / signal).min(GROWTH * self.dt);
        if self.steps == 0 {
            self.first_dt = self.dt;
        }
        if self.dt.is_nan() || self.dt < COLLAPSE * self.first_dt {
            return Err(Stop::Collapsed(fastest, self.dt));
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

    /// Sorts the particles by block and cell, so that neighbours in space are neighbours in memory.
    fn sort(&mut self, cell: f64) {
        self.particles.sort_by_cached_key(|p| {
            let c: [i64; D] = std::array::from_fn(|d| crate::kernel::cell_of(p.position[d], cell) as i64);
            (c.map(|x| x >> 2), c, p.id)
        });
    }
}
