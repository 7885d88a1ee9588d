//! What a run has sampled, by whichever engine, and the state that follows from it.
use crate::averaging::{Averages, Cube, Series};
use crate::lattice;
use crate::order::{FARTHEST, Order};
use crate::params::Params;
use crate::potential::Potential;
use crate::state::{Phase, State};
use crate::units::{BOLTZMANN, PRESSURE, SPECIFIC_ENERGY, SPECIFIC_VOLUME, TIME};
use hvi_kit::view::Frame;
use serde::{Deserialize, Serialize};

/// Time over which motion and structure share heat [s]: a few vibrations.
const SHARE: f64 = 0.25e-12;
/// Steps from one look at the structure, at the cancel flag and at the errors to the next.
pub const LEAST_SAMPLES: usize = 50;

/// Samples of a state: one of [`Series`] a step, one look at the structure every [`LEAST_SAMPLES`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Sampled {
    /// Of each step.
    pub series: Series,
    /// Looks at the structure.
    pub looks: Vec<Order>,
    /// Positions and velocities now and then, if they are asked for.
    pub frames: Vec<Frame>,
    /// Steps spent on averages that were thrown away since the phase changed.
    pub discarded: usize,
}

/// The state that is sampled.
#[derive(Clone, Debug)]
pub struct Asked<'a> {
    /// What was asked.
    pub params: &'a Params,
    /// How atoms act on each other.
    pub potential: Potential,
    /// Cubic edge of the lattice at rest without pressure [angstrom].
    pub ground: f64,
    /// Cubic edge of the lattice [angstrom].
    pub lattice: f64,
}

impl Asked<'_> {
    /// The box that is averaged over.
    pub fn cube(&self) -> Cube {
        let (atoms, step) = (f64::from(self.params.atoms), self.params.time_step.si());
        let edge = self.lattice * self.params.cells() as f64;
        Cube {
            atoms,
            volume: edge * edge * edge,
            thermal: BOLTZMANN * self.params.temperature.si(),
            block: (SHARE / step).ceil() as usize,
            step: step / TIME,
        }
    }

    /// Standard error to stop at [eV/angstrom3].
    pub fn target(&self) -> f64 {
        self.params.target_error.si() / PRESSURE
    }
}

impl Sampled {
    /// Whether the last look shows another phase than the first one of these averages.
    pub fn phase_changed(&self) -> bool {
        match (self.looks.first(), self.looks.last()) {
            (Some(first), Some(last)) => first.is_solid() != last.is_solid(),
            _ => false,
        }
    }

    /// Forgets what was sampled before the phase changed.
    pub fn discard(&mut self) {
        self.discarded += self.series.energy.len();
        self.series.clear();
        self.looks.clear();
    }

    fn phase(&self) -> Phase {
        if self.looks.last().is_some_and(Order::is_solid) { Phase::Solid } else { Phase::Liquid }
    }

    /// Whether harmonically mapped averages are right: a crystal, and every atom was at its site whenever looked at.
    fn can_map(&self) -> bool {
        self.phase() == Phase::Solid && self.looks.iter().all(|l| l.farthest < FARTHEST)
    }

    /// Averages with their errors, mapped where that is right.
    pub fn averages(&self, cube: Cube) -> Averages {
        if self.can_map() { self.series.mapped(cube) } else { self.series.plain(cube) }
    }

    /// The state, after `steps` steps in all.
    pub fn state(&self, asked: &Asked<'_>, steps: u64) -> State {
        let (cube, params) = (asked.cube(), asked.params);
        let molar = asked.potential.molar_mass();
        let rest = lattice::at_rest(&asked.potential, asked.ground).energy * cube.atoms;
        let Averages { energy, pressure } = self.averages(cube);
        let per_mass = SPECIFIC_ENERGY / (molar * cube.atoms);
        let volume = |edge: f64| 0.25 * edge * edge * edge * SPECIFIC_VOLUME / molar;
        let looks = self.looks.len() as f64;
        let over_looks = |of: fn(&Order) -> f64| self.looks.iter().map(of).sum::<f64>() / looks;
        State {
            volume: volume(asked.lattice),
            lattice_volume: volume(asked.ground),
            molar_mass: molar * 1e-3,
            temperature: params.temperature.si(),
            pressure: pressure.value * PRESSURE,
            pressure_error: pressure.error * PRESSURE,
            energy: (energy.value - rest) * per_mass,
            energy_error: energy.error * per_mass,
            temperature_error: 0.0,
            phase: self.phase(),
            atoms: params.atoms,
            averaged: self.series.energy.len() as f64 * params.time_step.si(),
            steps,
            mapped: self.can_map(),
            on_target: pressure.error <= asked.target(),
            order: over_looks(|l| l.translational),
            displacement: over_looks(|l| l.displacement2).sqrt(),
            void: self.looks.last().map_or(0.0, |l| l.void),
            trajectory: self.frames.clone(),
        }
    }
}
