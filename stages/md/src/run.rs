//! One state from beginning to end: lattice, equilibration, averaging until the error is small enough.
use crate::averaging::Cube;
use crate::lanes::Isa;
use crate::lattice;
use crate::order::Order;
use crate::params::Params;
use crate::pressed::Course;
use crate::sampled::{Asked, LEAST_SAMPLES, Sampled};
use crate::state::State;
use crate::system::{Snapshot, System};
use crate::table::Tables;
use crate::thermostat::Chain;
use crate::units::TIME;
use hvi_kit::{Ctx, File, StageError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Response time of the heat bath [ps]: of 0.1 and 1 ps the one with the smaller error of P.
pub const RESPONSE: f64 = 0.1;
/// Steps between scalings of the velocities while equilibrating.
pub const SCALE_EVERY: usize = 10;
/// The share of the expected rest that is run before the next look at the errors.
pub const SHARE_OF_REST: f64 = 0.7;

/// Runs the state that `params`, which have been checked, describe; `files` holds the potential's, if it is one from a file.
///
/// # Errors
/// [`StageError::Physics`] with step and atom where atoms leave the potential's range; [`StageError::Cancelled`].
pub fn state(params: &Params, files: &BTreeMap<String, File>, isa: Isa, ctx: &Ctx<'_>) -> Result<State, StageError> {
    let mut run = match ctx.resume() {
        Some(kept) => Run::resume(params, files, isa, kept)?,
        None => Run::new(params, files, isa)?,
    };
    while run.go_on(ctx)? {}
    Ok(run.sampled.state(&run.asked, run.system.steps()))
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
    course: Option<Course>,
    lattice: f64,
    doing: Doing,
    system: Snapshot,
    chain: Chain,
    sampled: Sampled,
}

struct Run<'a> {
    asked: Asked<'a>,
    cube: Cube,
    /// The way to the state by pressure, while it is under way.
    course: Option<Course>,
    doing: Doing,
    system: System,
    chain: Chain,
    sampled: Sampled,
    /// Time step [ps].
    step: f64,
}

impl Run<'_> {
    fn new<'a>(params: &'a Params, files: &BTreeMap<String, File>, isa: Isa) -> Result<Run<'a>, StageError> {
        let asked = params.asked(files).map_err(|e| StageError::physics(e.why))?;
        let (cells, temperature) = (params.cells(), params.temperature.si());
        let sites = lattice::sites(cells, asked.lattice);
        let tables = Tables::new(asked.potential.clone());
        let mut system = System::new(tables, isa, &sites, asked.lattice * cells as f64).map_err(StageError::physics)?;
        let start = params.pressed.as_ref().map_or(temperature, |p| p.room.si());
        system.heat(2.0 * start, params.seed);
        let cube = asked.cube();
        let step = params.time_step.si();
        Ok(Run {
            course: params.pressed.as_ref().map(|p| Course::new(p, system.freedom(), step)),
            doing: Doing::Equilibrating(0),
            chain: Chain::new(cube.thermal, system.freedom(), RESPONSE),
            cube,
            system,
            sampled: Sampled::default(),
            step: step / TIME,
            asked,
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
        let Checkpoint { course, lattice, doing, system, chain, sampled } = kept;
        let system = System::resume(Tables::new(new.asked.potential.clone()), isa, system);
        let asked = Asked { lattice, ..new.asked };
        Ok(Run { cube: asked.cube(), asked, course, doing, system, chain, sampled, ..new })
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            course: self.course.clone(),
            lattice: self.asked.lattice,
            doing: self.doing,
            system: self.system.snapshot(),
            chain: self.chain.clone(),
            sampled: self.sampled.clone(),
        }
    }

    /// Runs to the next look; returns whether there is more to do.
    fn go_on(&mut self, ctx: &Ctx<'_>) -> Result<bool, StageError> {
        if self.course.is_some() {
            return self.press(ctx).map(|()| true);
        }
        match self.doing {
            Doing::Equilibrating(k) => self.equilibrate(k, ctx).map(|()| true),
            Doing::Averaging(next) => self.average(next, ctx),
        }
    }

    fn advance(&mut self) -> Result<(), StageError> {
        self.system.advance(self.step, Some(&mut self.chain)).map_err(StageError::physics)
    }

    /// Some steps of the way to the state by pressure; at its end the lattice is that of the volume found.
    fn press(&mut self, ctx: &Ctx<'_>) -> Result<(), StageError> {
        ctx.save(|| self.checkpoint());
        self.tick(ctx, 0.0, "relaxing and pressing")?;
        let Some(course) = &mut self.course else { return Ok(()) };
        if course.go_on(&mut self.system, self.step).map_err(StageError::physics)? {
            self.course = None;
            self.asked.lattice = self.system.edges()[0] / self.asked.params.cells() as f64;
            self.cube = self.asked.cube();
        }
        Ok(())
    }

    /// Some steps from step `from` on without looking at results. In the first half velocities are scaled to the temperature
    /// again and again, because far from equilibrium the chain's outer variables run away and switch it off for picoseconds.
    fn equilibrate(&mut self, from: usize, ctx: &Ctx<'_>) -> Result<(), StageError> {
        let params = self.asked.params;
        let steps = params.steps(params.equilibration);
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
                self.system.scale(params.temperature.si());
            }
        }
        self.doing =
            if to < steps { Doing::Equilibrating(to) } else { Doing::Averaging(params.steps(params.shortest)) };
        Ok(())
    }

    /// Tells how far the run is, given how many steps of averaging are still to be expected.
    fn tick(&self, ctx: &Ctx<'_>, averaging: f64, doing: &str) -> Result<(), StageError> {
        let params = self.asked.params;
        let done = self.system.steps() as f64;
        let ahead = (params.steps(params.before()) as f64 - done).max(0.0);
        let shortest = params.steps(params.shortest) as f64 - self.sampled.series.energy.len() as f64;
        Ok(ctx.tick(done, done + ahead + averaging.max(shortest).max(1.0), doing)?)
    }

    /// Averages up to the next look; returns false once the standard error of the pressure, looked at after `next` samples,
    /// is that asked for, or the longest time is spent.
    fn average(&mut self, next: usize, ctx: &Ctx<'_>) -> Result<bool, StageError> {
        let longest = self.asked.params.steps(self.asked.params.longest);
        let (mut taken, mut spent) = (0usize, false);
        while !spent && (taken == 0 || !taken.is_multiple_of(LEAST_SAMPLES)) {
            self.sample()?;
            taken = self.sampled.series.energy.len();
            spent = self.sampled.discarded + taken >= longest;
        }
        if self.sampled.phase_changed() && !spent {
            self.sampled.discard();
            self.doing = Doing::Equilibrating(0);
            return Ok(true);
        }
        let mut expected = 0.0;
        if taken >= next || spent {
            let (error, target) = (self.sampled.averages(self.cube).pressure.error, self.asked.target());
            if error <= target || spent {
                return Ok(false);
            }
            let ratio = error / target;
            expected = taken as f64 * (ratio * ratio - 1.0);
            self.doing = Doing::Averaging(taken + (SHARE_OF_REST * expected) as usize + LEAST_SAMPLES);
        }
        let left = longest.saturating_sub(self.sampled.discarded + taken) as f64;
        ctx.save(|| self.checkpoint());
        self.tick(ctx, expected.min(left), "averaging")?;
        Ok(true)
    }

    /// One step, and what is kept of it.
    fn sample(&mut self) -> Result<(), StageError> {
        self.advance()?;
        let params = self.asked.params;
        let Sampled { series, looks, frames, .. } = &mut self.sampled;
        series.energy.push(self.system.energy());
        series.pressure.push(self.system.virial() / (3.0 * self.cube.volume));
        series.site_virial.push(self.system.site_virial());
        series.temperature.push(self.system.temperature());
        let sample = series.energy.len();
        if let Some(every) = params.trajectory
            && sample.is_multiple_of(params.steps(every).max(1))
        {
            frames.push(self.system.frame());
        }
        if sample.is_multiple_of(LEAST_SAMPLES) {
            let (positions, ways): (Vec<_>, _) = (self.system.positions().collect(), self.system.displacements());
            looks.push(Order::of(&positions, &ways, self.asked.lattice, self.system.edges()[0]));
        }
        Ok(())
    }
}
