//! Walls that give way: a box whose edges follow the pressure, by deterministic, time-reversible motion.
//!
//! G. J. Martyna, D. J. Tobias and M. L. Klein, J. Chem. Phys. 101, 4177 (1994), with the correction by the number of degrees
//! of freedom; edges at right angles, each with a rate of its own or all with one. With N_f degrees of freedom, mass W of a
//! wall, rates g and pressures P by axis:
//! `x' = v + g x`, `v' = F/m - (g + sum g/N_f) v`, `edge' = g edge`, `W g' = V (P - P_0) + sum m v^2/N_f`.
//! Without a heat bath H + P_0 V + sum W g^2/2 is conserved and the ensemble is that of constant enthalpy; with chains on
//! atoms and walls it is that of constant pressure and temperature. Walls and baths act in the middle of a step.
use crate::fault::Fault;
use crate::system::System;
use crate::thermostat::Chain;
use hvi_kit::math::exp;
use serde::{Deserialize, Serialize};

/// How the box may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// All edges by the same factor: for liquids, and the paper's pressure steps.
    Kept,
    /// Each edge by itself, at right angles: for crystals in a box with two phases, whose stress must be the same along all axes.
    Free,
    /// The edge along z only.
    Along,
}

/// The walls of a box under pressure.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Walls {
    shape: Shape,
    /// Pressure from outside [eV/angstrom3].
    pressure: f64,
    /// Inertia of one wall [eV ps2].
    inertia: f64,
    /// Rates of the edges [1/ps].
    rate: [f64; 3],
    /// The heat bath of the walls, where there is one.
    bath: Option<Chain>,
}

impl Walls {
    /// Walls at rest under `pressure` [eV/angstrom3], for `freedom` degrees of freedom near `thermal` = k_B T [eV], with
    /// response time `time` [ps].
    pub fn new(shape: Shape, pressure: f64, thermal: f64, freedom: f64, time: f64) -> Walls {
        let inertia = (freedom / 3.0 + 1.0) * thermal * time * time;
        Walls { shape, pressure, inertia, rate: [0.0; 3], bath: None }
    }

    /// With a heat bath at `thermal` = k_B T [eV] of response time `time` [ps].
    pub fn with_bath(mut self, thermal: f64, time: f64) -> Walls {
        let freedom = match self.shape {
            Shape::Kept | Shape::Along => 1.0,
            Shape::Free => 3.0,
        };
        self.bath = Some(Chain::new(thermal, freedom, time));
        self
    }

    /// Changes the pressure from outside to `pressure` [eV/angstrom3].
    pub fn press(&mut self, pressure: f64) {
        self.pressure = pressure;
    }

    /// Energy of the walls, of the pressure's work in `volume` [angstrom3] and of the walls' heat bath [eV].
    pub fn energy(&self, volume: f64) -> f64 {
        0.5 * self.twice_kinetic() + self.pressure * volume + self.bath.as_ref().map_or(0.0, Chain::energy)
    }

    /// Turns time round.
    pub fn reverse(&mut self) {
        self.rate = self.rate.map(|g| -g);
        if let Some(bath) = &mut self.bath {
            bath.reverse();
        }
    }

    /// One step of `system` over `dt` [ps] within the walls, with the heat bath `chain` if there is one.
    ///
    /// # Errors
    /// [`Fault`] as [`System::advance`], and where the box becomes too small.
    pub fn advance(&mut self, system: &mut System, dt: f64, chain: Option<&mut Chain>) -> Result<(), Fault> {
        self.kick(system, 0.5 * dt);
        system.begin(dt);
        self.stretch(system, 0.5 * dt);
        let factor = chain.map_or(1.0, |c| c.step(system.middle_kinetic(), dt));
        let own = self.twice_kinetic();
        let slowed = self.bath.as_mut().map_or(1.0, |b| b.step(own, dt));
        self.rate = self.rate.map(|g| slowed * g);
        // the bath's factor commutes with the stretch, so that the step stays the same backwards
        self.stretch(system, 0.5 * dt);
        system.finish(dt, factor)?;
        self.kick(system, 0.5 * dt);
        let edges = system.edges();
        if edges.iter().all(|e| e.is_finite()) {
            Ok(())
        } else {
            Err(Fault::Lost { step: system.steps(), time: system.time() })
        }
    }

    /// Twice the kinetic energy of the walls [eV].
    fn twice_kinetic(&self) -> f64 {
        let squares = self.rate.map(|g| g * g);
        self.inertia * ((squares[0] + squares[1]) + squares[2])
    }

    /// Moves the rates over `dt` [ps] by what presses from within and without.
    fn kick(&mut self, system: &System, dt: f64) {
        let (kinetic, virial) = (system.twice_kinetics(), system.virials());
        let share = system.twice_kinetic() / system.freedom();
        let outside = self.pressure * system.volume();
        let push = [0, 1, 2].map(|k| kinetic[k] + virial[k] - outside + share);
        let push = match self.shape {
            Shape::Kept => [((push[0] + push[1]) + push[2]) / 3.0; 3],
            Shape::Free => push,
            Shape::Along => [0.0, 0.0, push[2]],
        };
        for k in 0..3 {
            self.rate[k] += dt * push[k] / self.inertia;
        }
    }

    /// Stretches the box over `dt` [ps] at the present rates.
    fn stretch(&self, system: &mut System, dt: f64) {
        let rate = self.rate;
        let shared = ((rate[0] + rate[1]) + rate[2]) / system.freedom();
        system.deform(rate.map(|g| exp(dt * g)), rate.map(|g| exp(-dt * (g + shared))));
    }
}
