//! Nose-Hoover chain of three variables: the canonical ensemble by deterministic, time-reversible motion.
//!
//! G. J. Martyna, M. L. Klein and M. Tuckerman, J. Chem. Phys. 97, 2635 (1992); the step is the half step of G. J. Martyna,
//! M. E. Tuckerman, D. J. Tobias and M. L. Klein, Mol. Phys. 87, 1117 (1996), with one step of the chain for a whole one.
use hvi_kit::math::exp;
use serde::{Deserialize, Serialize};

/// Variables in the chain.
const LENGTH: usize = 3;

/// A chain that holds `freedom` degrees of freedom at one temperature.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Chain {
    /// k_B T [eV].
    thermal: f64,
    /// Degrees of freedom.
    freedom: f64,
    /// Inertias [eV ps2].
    inertia: [f64; LENGTH],
    /// Positions, without unit.
    place: [f64; LENGTH],
    /// Velocities [1/ps].
    rate: [f64; LENGTH],
}

impl Chain {
    /// A chain at rest for `freedom` degrees of freedom at `thermal` = k_B T [eV], with response time `time` [ps].
    pub fn new(thermal: f64, freedom: f64, time: f64) -> Chain {
        let one = thermal * time * time;
        Chain { thermal, freedom, inertia: [freedom * one, one, one], place: [0.0; LENGTH], rate: [0.0; LENGTH] }
    }

    /// Force on variable `k`, given twice the kinetic energy of the atoms [eV].
    fn force(&self, k: usize, twice_kinetic: f64) -> f64 {
        let drive = match k {
            0 => twice_kinetic - self.freedom * self.thermal,
            _ => self.inertia[k - 1] * self.rate[k - 1] * self.rate[k - 1] - self.thermal,
        };
        drive / self.inertia[k]
    }

    /// Moves rate `k` over a time `dt`: half of the drag of the next variable, the force, the other half of the drag.
    fn kick(&mut self, k: usize, twice_kinetic: f64, dt: f64) {
        let drag = if k + 1 < LENGTH { exp(-0.5 * dt * self.rate[k + 1]) } else { 1.0 };
        self.rate[k] = (self.rate[k] * drag + dt * self.force(k, twice_kinetic)) * drag;
    }

    /// A time step `dt` [ps] of the chain, given twice the kinetic energy of the atoms [eV]: the factor for velocities.
    pub fn step(&mut self, twice_kinetic: f64, dt: f64) -> f64 {
        for k in (0..LENGTH).rev() {
            self.kick(k, twice_kinetic, 0.5 * dt);
        }
        let factor = exp(-dt * self.rate[0]);
        for k in 0..LENGTH {
            self.place[k] += dt * self.rate[k];
        }
        let twice_kinetic = twice_kinetic * factor * factor;
        for k in 0..LENGTH {
            self.kick(k, twice_kinetic, 0.5 * dt);
        }
        factor
    }

    /// Energy of the chain [eV]: with that of the atoms it is conserved.
    pub fn energy(&self) -> f64 {
        let kinetic: f64 = (0..LENGTH).map(|k| 0.5 * self.inertia[k] * self.rate[k] * self.rate[k]).sum();
        kinetic + self.thermal * (self.freedom * self.place[0] + self.place[1] + self.place[2])
    }

    /// Turns time round.
    pub fn reverse(&mut self) {
        self.rate = self.rate.map(|r| -r);
    }
}
