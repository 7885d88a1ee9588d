//! One state from beginning to end: lattice, equilibration, averaging until the error is small enough.
use crate::averaging::{Averages, Cube, Series};
use crate::lanes::Isa;
use crate::lattice;
use crate::order::{FARTHEST, Order};
use crate::params::Params;
use crate::potential::Potential;
use crate::state::{Phase, State};
use crate::system::{Snapshot, System};
use crate::table::Tables;
use crate::thermostat::Chain;
use crate::units::{BOLTZMANN, PRESSURE, SPECIFIC_ENERGY, SPECIFIC_VOLUME, TIME};
use hvi_kit::math::cbrt;
use hvi_kit::{Ctx, File, StageError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Response time of the heat bath [ps]: of 0.1 and 1 ps the one with the smaller error of P.
const RESPONSE: f64 = 0.1;
/// Time over which motion and structure share heat [s]: a few vibrations.
const SHARE: f64 = 0.25e-12;
/// Steps between scalings of the velocities while equilibrating.
const SCALE_EVERY: usize = 10;
/// Steps from one look at the structure, at the cancel flag and at the errors to the next.
pub const LEAST_SAMPLES: usize = 50;

/// Runs the state that `params`, which have been checked, describe.
///
/// # Errors
/// [`StageError::Physics`] with step and atom where atoms leave the potential's range; [`StageError::Cancelled`].
pub fn state(params: &Params, files: &BTreeMap<String, File>, isa: Isa, ctx: &Ctx<'_>) -> Result<State, StageError> {
    let mut run = match ctx.resume() {
        Some(kept) => Run::resume(params, files, isa, kept)?,
        None => Run::new(params, files, isa)?,
    };
    while run.go_on(ctx)? {}
    Ok(run.state())
}

/// What comes next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Doing {
    /// This step of the equilibration.
    Equilibrating(usize),
    /// Averaging, with a look at the errors after so many samples.
    Averaging(usize),
}

/// All that a run can't make again.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    doing: Doing,
    system: Snapshot,
    chain: Chain,
    series: Series,
    looks: Vec<Order>,
    discarded: usize,
}

struct Run<'a> {
    doing: Doing,
    params: &'a Params,
    system: System,
    chain: Chain,
    potential: Potential,
    /// Cubic edge of the lattice at rest without pressure [angstrom].
    ground: f64,
    /// Cubic edge of the lattice [angstrom].
    lattice: f64,
    /// Time step [ps].
    step: f64,
    cube: Cube,
    series: Series,
    /// Looks at the structure while averaging.
    looks: Vec<Order>,
    /// Steps spent on averages that were thrown away since the phase changed.
    discarded: usize,
    /// Standard error to stop at [eV/angstrom3].
    target: f64,
}

impl Run<'_> {
    fn new<'a>(params: &'a Params, files: &BTreeMap<String, File>, isa: Isa) -> Result<Run<'a>, StageError> {
        let (potential, ground) = params.potential(files).map_err(|e| StageError::physics(e.why))?;
        let (cells, lattice) = (params.cells(), ground * cbrt(params.volume_ratio));
        let sites = lattice::sites(cells, lattice);
        let tables = Tables::new(potential.clone());
        let mut system = System::new(tables, isa, &sites, lattice * cells as f64).map_err(StageError::physics)?;
        let thermal = BOLTZMANN * params.temperature.si();
        system.heat(2.0 * params.temperature.si(), params.seed);
        Ok(Run {
            doing: Doing::Equilibrating(0),
            params,
            chain: Chain::new(thermal, system.freedom(), RESPONSE),
            cube: Cube {
                atoms: system.atoms() as f64,
                volume: system.volume(),
                thermal,
                block: (SHARE / params.time_step.si()).ceil() as usize,
                step: params.time_step.si() / TIME,
            },
            system,
            potential,
            ground,
            lattice,
            step: params.time_step.si() / TIME,
            series: Series::default(),
            looks: Vec::new(),
            discarded: 0,
            target: params.target_error.si() / PRESSURE,
        })
    }

    /// The run that `kept` was taken of.
    fn resume<'a>(
        params: &'a Params,
        files: &BTreeMap<String, File>,
        isa: Isa,
        kept: Checkpoint,
    ) -> Result<Run<'a>, StageError> {
        let new = Run::new(params, files, isa)?;
        let Checkpoint { doing, system, chain, series, looks, discarded } = kept;
        let system = System::resume(Tables::new(new.potential.clone()), isa, system);
        Ok(Run { doing, system, chain, series, looks, discarded, ..new })
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            doing: self.doing,
            system: self.system.snapshot(),
            chain: self.chain.clone(),
            series: self.series.clone(),
            looks: self.looks.clone(),
            discarded: self.discarded,
        }
    }

    /// Runs to the next look; returns whether there is more to do.
    fn go_on(&mut self, ctx: &Ctx<'_>) -> Result<bool, StageError> {
        match self.doing {
            Doing::Equilibrating(k) => self.equilibrate(k, ctx).map(|()| true),
            Doing::Averaging(next) => self.average(next, ctx),
        }
    }

    fn steps(&self, time: hvi_kit::units::Time) -> usize {
        (time.si() / self.params.time_step.si()).round() as usize
    }

    fn advance(&mut self) -> Result<(), StageError> {
        self.system.advance(self.step, Some(&mut self.chain)).map_err(StageError::physics)
    }

    /// Some steps from step `from` on without looking at results. In the first half velocities are scaled to the temperature
    /// again and again, because far from equilibrium the chain's outer variables run away and switch it off for picoseconds.
    fn equilibrate(&mut self, from: usize, ctx: &Ctx<'_>) -> Result<(), StageError> {
        let steps = self.steps(self.params.equilibration);
        let to = (from + LEAST_SAMPLES).min(steps);
        ctx.save(|| self.checkpoint());
        self.tick(ctx, 0.0, "equilibrating")?;
        for k in from..to {
            if 2 * k >= steps {
                self.advance()?;
                continue;
            }
            self.system.advance(self.step, None).map_err(StageError::physics)?;
            if k % SCALE_EVERY == SCALE_EVERY - 1 {
                self.system.scale(self.params.temperature.si());
            }
        }
        self.doing =
            if to < steps { Doing::Equilibrating(to) } else { Doing::Averaging(self.steps(self.params.shortest)) };
        Ok(())
    }

    /// Tells how far the run is, given how many steps of averaging are still to be expected.
    fn tick(&self, ctx: &Ctx<'_>, averaging: f64, doing: &str) -> Result<(), StageError> {
        let done = self.system.steps() as f64;
        let ahead = (self.steps(self.params.equilibration) as f64 - done).max(0.0);
        let shortest = self.steps(self.params.shortest) as f64 - self.series.energy.len() as f64;
        Ok(ctx.tick(done, done + ahead + averaging.max(shortest).max(1.0), doing)?)
    }

    /// Averages up to the next look; returns false once the standard error of the pressure, looked at after `next` samples,
    /// is that asked for, or the longest time is spent.
    fn average(&mut self, next: usize, ctx: &Ctx<'_>) -> Result<bool, StageError> {
        let longest = self.steps(self.params.longest);
        let (mut taken, mut spent) = (0usize, false);
        while !spent && (taken == 0 || !taken.is_multiple_of(LEAST_SAMPLES)) {
            self.sample()?;
            taken = self.series.energy.len();
            spent = self.discarded + taken >= longest;
        }
        if self.phase_changed() && !spent {
            self.discarded += taken;
            self.series.clear();
            self.looks.clear();
            self.doing = Doing::Equilibrating(0);
            return Ok(true);
        }
        let mut expected = 0.0;
        if taken >= next || spent {
            let error = self.averages().pressure.error;
            if error <= self.target || spent {
                return Ok(false);
            }
            let ratio = error / self.target;
            expected = taken as f64 * (ratio * ratio - 1.0);
            self.doing = Doing::Averaging(taken + (0.7 * expected) as usize + LEAST_SAMPLES);
        }
        let left = longest.saturating_sub(self.discarded + taken) as f64;
        ctx.save(|| self.checkpoint());
        self.tick(ctx, expected.min(left), "averaging")?;
        Ok(true)
    }

    /// One step, and what is kept of it.
    fn sample(&mut self) -> Result<(), StageError> {
        self.advance()?;
        self.series.energy.push(self.system.energy());
        self.series.pressure.push(self.system.virial() / (3.0 * self.cube.volume));
        self.series.site_virial.push(self.system.site_virial());
        self.series.temperature.push(self.system.temperature());
        if self.series.energy.len().is_multiple_of(LEAST_SAMPLES) {
            self.looks.push(Order::of(&self.system, self.lattice));
        }
        Ok(())
    }

    /// Whether the last look shows another phase than the first one of these averages.
    fn phase_changed(&self) -> bool {
        match (self.looks.first(), self.looks.last()) {
            (Some(first), Some(last)) => first.is_solid() != last.is_solid(),
            _ => false,
        }
    }

    fn phase(&self) -> Phase {
        if self.looks.last().is_some_and(Order::is_solid) { Phase::Solid } else { Phase::Liquid }
    }

    /// Whether harmonically mapped averages are right: a crystal, and every atom was at its site whenever looked at.
    fn can_map(&self) -> bool {
        self.phase() == Phase::Solid && self.looks.iter().all(|l| l.farthest < FARTHEST)
    }

    fn averages(&self) -> Averages {
        if self.can_map() { self.series.mapped(self.cube) } else { self.series.plain(self.cube) }
    }

    fn state(&self) -> State {
        let molar = self.potential.molar_mass();
        let rest = lattice::at_rest(&self.potential, self.ground).energy * self.cube.atoms;
        let Averages { energy, pressure } = self.averages();
        let per_mass = SPECIFIC_ENERGY / (molar * self.cube.atoms);
        let volume = |edge: f64| 0.25 * edge * edge * edge * SPECIFIC_VOLUME / molar;
        let looks = self.looks.len() as f64;
        let over_looks = |of: fn(&Order) -> f64| self.looks.iter().map(of).sum::<f64>() / looks;
        State {
            volume: volume(self.lattice),
            lattice_volume: volume(self.ground),
            molar_mass: molar * 1e-3,
            temperature: self.params.temperature.si(),
            pressure: pressure.value * PRESSURE,
            pressure_error: pressure.error * PRESSURE,
            energy: (energy.value - rest) * per_mass,
            energy_error: energy.error * per_mass,
            temperature_error: 0.0,
            phase: self.phase(),
            atoms: self.params.atoms,
            averaged: self.series.energy.len() as f64 * self.params.time_step.si(),
            steps: self.system.steps(),
            mapped: self.can_map(),
            on_target: pressure.error <= self.target,
            order: over_looks(|l| l.translational),
            displacement: over_looks(|l| l.displacement2).sqrt(),
        }
    }
}
