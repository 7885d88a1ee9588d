//! One start after the other until crystal and melt live side by side, and each alone at what was found.
use super::Params;
use super::cell::{Cell, Kept, Wanted};
use super::guess;
use super::phase::Conditions;
use super::result::{Attempt, Look, PhaseAt};
use crate::lanes::Isa;
use crate::table::Tables;
use crate::units::{PRESSURE, TIME};
use hvi_kit::{Ctx, StageError};
use serde::{Deserialize, Serialize};

/// Starts before the search gives up.
const STARTS: usize = 7;
/// What a start is changed by where one phase died: about half of the latent heat's worth of temperature.
const STRIDE: f64 = 0.1;

/// All that a run can't make again.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    start: f64,
    bracket: [f64; 2],
    attempts: Vec<Attempt>,
    cell: Kept,
    solid: Option<PhaseAt>,
}

/// The search under way.
pub struct Search<'a> {
    params: &'a Params,
    tables: &'a Tables,
    ground: f64,
    isa: Isa,
    /// Temperature that both phases began with [K].
    start: f64,
    /// Starts where the crystal alone was left, and where the melt was [K].
    bracket: [f64; 2],
    attempts: Vec<Attempt>,
    cell: Cell,
    /// The crystal alone, once it has run.
    solid: Option<PhaseAt>,
}

impl<'a> Search<'a> {
    /// The first start, or that which an earlier attempt was at; `ground` is the cubic edge of the lattice at rest [angstrom].
    ///
    /// # Errors
    /// As [`Cell::new`].
    pub fn begin(
        params: &'a Params,
        tables: &'a Tables,
        ground: f64,
        isa: Isa,
        ctx: &Ctx<'_>,
    ) -> Result<Search<'a>, StageError> {
        if let Some(kept) = ctx.resume::<Checkpoint>() {
            let Checkpoint { start, bracket, attempts, cell, solid } = kept;
            let cell = Cell::resume(&wanted(params, tables, ground, start), isa, cell);
            return Ok(Search { params, tables, ground, isa, start, bracket, attempts, cell, solid });
        }
        let start = match params.guess {
            Some(guess) => guess.si(),
            None => guess::melting(tables, ground, params.pressure.si() / PRESSURE).map_err(StageError::physics)?,
        };
        let cell = Cell::new(&wanted(params, tables, ground, start), isa, ctx)?;
        let bracket = [0.0, f64::INFINITY];
        Ok(Search { params, tables, ground, isa, start, bracket, attempts: Vec::new(), cell, solid: None })
    }

    /// Runs cells until one with both phases has its error small enough, or its time spent.
    ///
    /// # Errors
    /// [`StageError::Physics`] where no start keeps both phases; as [`Cell::new`].
    pub fn find(&mut self, ctx: &Ctx<'_>) -> Result<(), StageError> {
        while !self.run_cell(ctx)? {
            let last = self.cell.looks.last().copied().expect("it ran until a phase died");
            self.attempts.push(Attempt { start: self.start, solid: last.solid, end: last.temperature });
            if self.attempts.len() == STARTS {
                return Err(self.died());
            }
            self.start = another(self.start, last, &mut self.bracket);
            self.cell = Cell::new(&wanted(self.params, self.tables, self.ground, self.start), self.isa, ctx)?;
        }
        Ok(())
    }

    /// Runs the cell until it is averaged, and returns true, or a phase has died.
    fn run_cell(&mut self, ctx: &Ctx<'_>) -> Result<bool, StageError> {
        let [settling, shortest] = [self.params.settling, self.params.shortest].map(|t| t.si() / TIME);
        while self.cell.has_both() {
            if self.is_averaged() {
                return Ok(true);
            }
            self.cell.advance().map_err(StageError::physics)?;
            ctx.save(|| self.checkpoint());
            let expected = (settling + shortest).max(self.cell.time() + 1.0);
            ctx.tick(self.cell.time(), 1.05 * expected, "crystal and melt together")?;
        }
        Ok(false)
    }

    fn is_averaged(&self) -> bool {
        let [settling, shortest, longest] =
            [self.params.settling, self.params.shortest, self.params.longest].map(|t| t.si() / TIME);
        let averaged = self.cell.time() - settling;
        averaged >= longest || averaged >= shortest && self.average().1 <= self.params.target_error.si()
    }

    /// Melting temperature and its standard error [K], and the time averaged over [ps].
    pub fn average(&self) -> (f64, f64, f64) {
        self.cell.average(self.params.settling.si() / TIME)
    }

    /// Crystal and melt, each alone at `temperature` [K].
    ///
    /// # Errors
    /// As [`Conditions::run`].
    pub fn phases(&mut self, temperature: f64, ctx: &Ctx<'_>) -> Result<[PhaseAt; 2], StageError> {
        let at = Conditions {
            tables: self.tables,
            ground: self.ground,
            pressure: self.params.pressure.si() / PRESSURE,
            temperature,
            step: self.params.time_step.si() / TIME,
            time: self.params.alone.si() / TIME,
            seed: self.params.seed,
        };
        let solid = match self.solid {
            Some(solid) => solid,
            None => at.run(false, self.isa, ctx)?,
        };
        self.solid = Some(solid);
        ctx.save(|| self.checkpoint());
        Ok([solid, at.run(true, self.isa, ctx)?])
    }

    /// The cell with both phases, and the starts before it.
    pub fn end(self) -> (Cell, Vec<Attempt>) {
        (self.cell, self.attempts)
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            start: self.start,
            bracket: self.bracket,
            attempts: self.attempts.clone(),
            cell: self.cell.keep(),
            solid: self.solid,
        }
    }

    fn died(&self) -> StageError {
        let each = |a: &Attempt| {
            let what = if a.solid < 0.5 { "the crystal died" } else { "the melt died" };
            format!("from {:.0} K {what}, at {:.0} K", a.start, a.end)
        };
        let all: Vec<String> = self.attempts.iter().map(each).collect();
        StageError::physics(format!(
            "at {:.3} GPa no start of {} kept crystal and melt side by side: {}; give `guess` between a start where the crystal \
             died and one where the melt did, or a longer cell (`along` is {})",
            self.params.pressure.si() / 1e9,
            all.len(),
            all.join("; "),
            self.params.along
        ))
    }
}

/// What the cell that begins at `start` [K] is made for.
fn wanted<'a>(params: &Params, tables: &'a Tables, ground: f64, start: f64) -> Wanted<'a> {
    Wanted {
        tables,
        ground,
        pressure: params.pressure.si() / PRESSURE,
        start,
        cells: [params.across, params.across, params.along].map(|n| n as usize),
        step: params.time_step.si() / TIME,
        seed: params.seed,
    }
}

/// The next start: colder where the crystal died, warmer where the melt did, half way once both are known.
fn another(start: f64, last: Look, bracket: &mut [f64; 2]) -> f64 {
    let side = usize::from(last.solid < 0.5);
    bracket[side] = start;
    match *bracket {
        [low, high] if low > 0.0 && high.is_finite() => 0.5 * (low + high),
        [_, high] if high.is_finite() => (1.0 - STRIDE) * start.min(last.temperature),
        _ => (1.0 + STRIDE) * start.max(last.temperature),
    }
}
