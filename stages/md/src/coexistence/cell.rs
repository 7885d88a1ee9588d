//! A long cell, half crystal and half melt, whose walls and heat are free: it finds the melting temperature by itself.
use super::guess;
use super::phase::{HOT, RESPONSE};
use super::result::Look;
use crate::barostat::{Shape, Walls};
use crate::fault::Fault;
use crate::lanes::Isa;
use crate::system::{Snapshot, System};
use crate::table::Tables;
use crate::units::{BOLTZMANN, TIME};
use crate::{lattice, local_order};
use hvi_kit::math::exp;
use hvi_kit::{Ctx, StageError};
use serde::{Deserialize, Serialize};

/// Time between two looks [ps].
const LOOK: f64 = 0.25;
/// Share of crystalline atoms outside of which one phase is as good as gone.
const SURVIVES: std::ops::Range<f64> = 0.06..0.94;
/// Part of the cell's length that is heated until it melts: the heat that flows out of it melts the rest of the half.
const HEATED: std::ops::Range<f64> = 0.55..0.95;
/// Longest time that half of the cell may take to melt, and time to cool it again [ps].
const MELTING: f64 = 6.0;
const COOLING: f64 = 1.5;
/// Heat capacity of an atom in hot metal at constant pressure, in k.
const HEAT: f64 = 3.5;
/// Bins of the profile.
const BINS: usize = 40;

/// The cell under way.
pub struct Cell {
    system: System,
    walls: Walls,
    cells: [usize; 3],
    /// Time step [ps].
    step: f64,
    /// Looks since walls and heat are free.
    pub looks: Vec<Look>,
    /// Temperature of each step since then [K].
    temperatures: Vec<f64>,
}

/// A cell between two looks, as bytes.
#[derive(Serialize, Deserialize)]
pub struct Kept {
    system: Snapshot,
    walls: Walls,
    looks: Vec<Look>,
    temperatures: Vec<f64>,
}

/// What a cell is made for.
pub struct Wanted<'a> {
    /// The potential.
    pub tables: &'a Tables,
    /// Cubic edge of the lattice at rest without pressure [angstrom].
    pub ground: f64,
    /// Pressure [eV/angstrom3].
    pub pressure: f64,
    /// Temperature of the start [K].
    pub start: f64,
    /// Cubic cells along x, y, z.
    pub cells: [usize; 3],
    /// Time step [ps].
    pub step: f64,
    /// Seed of the first velocities.
    pub seed: u64,
}

impl Cell {
    /// A crystal at the start's temperature, of which the upper half is then molten and cooled.
    ///
    /// # Errors
    /// [`StageError`] where atoms leave the potential's range, the half doesn't melt, or the run is cancelled.
    pub fn new(wanted: &Wanted<'_>, isa: Isa, ctx: &Ctx<'_>) -> Result<Cell, StageError> {
        let edge = guess::edge(&wanted.tables.potential, wanted.ground, wanted.pressure, wanted.start);
        let sites = lattice::block(wanted.cells, [edge; 3]);
        let edges = wanted.cells.map(|n| edge * n as f64);
        let mut system = System::in_box(wanted.tables.clone(), isa, &sites, edges).map_err(StageError::physics)?;
        system.heat(2.0 * wanted.start, wanted.seed);
        let thermal = BOLTZMANN * wanted.start;
        let free = system.freedom();
        let walls = |shape| Walls::new(shape, wanted.pressure, thermal, free, RESPONSE[1]);
        let mut cell = Cell {
            walls: walls(Shape::Kept),
            system,
            cells: wanted.cells,
            step: wanted.step,
            looks: Vec::new(),
            temperatures: Vec::new(),
        };
        cell.scaled(COOLING, [wanted.start; 2], ctx)?;
        // while half of it is hot the crystal keeps its width
        cell.walls = walls(Shape::Along);
        let mut spent = 0.0;
        while cell.upper_order() > 0.5 * local_order::LEAST {
            if spent >= MELTING {
                return Err(StageError::physics(format!(
                    "half of the cell did not melt within {MELTING} ps at {:.0} K: raise `guess`",
                    HOT * wanted.start
                )));
            }
            cell.scaled(0.5, [wanted.start, HOT * wanted.start], ctx)?;
            spent += 0.5;
        }
        cell.scaled(COOLING, [wanted.start; 2], ctx)?;
        cell.walls = walls(Shape::Free);
        Ok(cell)
    }

    /// What it is now.
    pub fn keep(&self) -> Kept {
        Kept {
            system: self.system.snapshot(),
            walls: self.walls.clone(),
            looks: self.looks.clone(),
            temperatures: self.temperatures.clone(),
        }
    }

    /// The cell that `kept` was taken of, made for `wanted`.
    pub fn resume(wanted: &Wanted<'_>, isa: Isa, kept: Kept) -> Cell {
        Cell {
            system: System::resume(wanted.tables.clone(), isa, kept.system),
            walls: kept.walls,
            cells: wanted.cells,
            step: wanted.step,
            looks: kept.looks,
            temperatures: kept.temperatures,
        }
    }

    /// Runs for `time` [ps] while the temperatures of the rest and of the heated part are set again and again [K].
    fn scaled(&mut self, time: f64, temperatures: [f64; 2], ctx: &Ctx<'_>) -> Result<(), StageError> {
        let atoms = self.system.atoms() as u32;
        let [from, to] = [HEATED.start, HEATED.end].map(|share| (share * f64::from(atoms)) as u32);
        for k in 0..(time / self.step).round() as usize {
            self.walls.advance(&mut self.system, self.step, None).map_err(StageError::physics)?;
            if k % 10 == 9 {
                ctx.tick(0.0, 1.0, "crystal and melt are made")?;
                self.system.scale_part(|site| !(from..to).contains(&site), temperatures[0]);
                self.system.scale_part(|site| (from..to).contains(&site), temperatures[1]);
            }
        }
        Ok(())
    }

    /// Free motion from one look to the next.
    ///
    /// # Errors
    /// [`Fault`] where atoms leave the potential's range.
    pub fn advance(&mut self) -> Result<(), Fault> {
        let steps = self.steps_a_look();
        for _ in 0..steps {
            self.walls.advance(&mut self.system, self.step, None)?;
            self.temperatures.push(self.system.temperature());
        }
        let last = &self.temperatures[self.temperatures.len() - steps..];
        let temperature = last.iter().sum::<f64>() / steps as f64;
        let order = self.order();
        let solid = order.iter().filter(|o| **o > local_order::LEAST).count() as f64 / order.len() as f64;
        let time = self.temperatures.len() as f64 * self.step * TIME;
        self.looks.push(Look { time, temperature, solid });
        Ok(())
    }

    fn steps_a_look(&self) -> usize {
        (LOOK / self.step).round().max(1.0) as usize
    }

    /// Whether crystal and melt are both still there.
    pub fn has_both(&self) -> bool {
        self.looks.last().is_none_or(|l| SURVIVES.contains(&l.solid))
    }

    /// Time since walls and heat are free [ps].
    pub fn time(&self) -> f64 {
        self.temperatures.len() as f64 * self.step
    }

    /// Mean temperature and its standard error [K], and the time averaged over [ps], once `settling` [ps] are left out.
    ///
    /// The surfaces wander slowly, and the temperature with them: by T sqrt(k/C) at constant enthalpy, C the heat capacity of the
    /// cell, for as long as the solid share remembers. A short run sees too little of that, so it is the least error. The memory is
    /// that of the whole run: a part that was picked for its small noise would know less of it.
    ///
    /// What is left out grows, up to half, as long as that lowers the variance of the mean: a start far from equilibrium
    /// costs more than the samples it takes away (K. P. White, Simulation 69, 323 (1997)).
    pub fn average(&self, settling: f64) -> (f64, f64, f64) {
        let skip = (settling / LOOK).ceil() as usize;
        let all: Vec<f64> = self.looks.iter().skip(skip).map(|l| l.temperature).collect();
        let solid: Vec<f64> = self.looks.iter().skip(skip).map(|l| l.solid).collect();
        let noise = |from: usize| {
            let rest = &all[from..];
            let n = rest.len() as f64;
            let mean = rest.iter().sum::<f64>() / n;
            rest.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n * n)
        };
        let best = (0..=all.len() / 2).min_by(|a, b| noise(*a).total_cmp(&noise(*b))).unwrap_or(0);
        let (value, error) = slow_mean(&all[best..]);
        let n = (all.len() - best) as f64;
        let least = value / (HEAT * self.atoms() as f64).sqrt() * of_mean(memory(&solid) / n);
        (value, error.max(least), n * LOOK)
    }

    fn order(&self) -> Vec<f64> {
        local_order::of(&self.system, self.lattice())
    }

    /// Edges of the crystal's cubic cell [angstrom]: cubic, as the stress is the same along all axes.
    fn lattice(&self) -> [f64; 3] {
        let edges = self.system.edges();
        [0.5 * (edges[0] / self.cells[0] as f64 + edges[1] / self.cells[1] as f64); 3]
    }

    /// Mean order of the upper half's middle, where it melts last.
    fn upper_order(&self) -> f64 {
        let profile = self.profile();
        let middle = &profile[5 * BINS / 8..7 * BINS / 8];
        middle.iter().sum::<f64>() / middle.len() as f64
    }

    /// Mean order along the long axis, by share of its length.
    pub fn profile(&self) -> Vec<f64> {
        let (edge, order) = (self.system.edges()[2], self.order());
        let mut sums = vec![(0.0, 0.0); BINS];
        for (p, o) in self.system.positions().zip(order) {
            let share = p[2] / edge;
            let bin = (((share - share.floor()) * BINS as f64) as usize).min(BINS - 1);
            sums[bin].0 += o;
            sums[bin].1 += 1.0;
        }
        sums.into_iter().map(|(o, n): (f64, f64)| o / n.max(1.0)).collect()
    }

    /// Number of atoms.
    pub fn atoms(&self) -> usize {
        self.system.atoms()
    }
}

/// Mean of a series that forgets itself slowly, and its standard error, from the integrated correlation time tau up to the
/// first lag of 5 tau (N. Madras and A. D. Sokal, J. Stat. Phys. 50, 109 (1988)); with the error of that time added, as a run that
/// stops when its error has come down stops where chance made it small. Blocks would have to be longer than a run of a
/// few tau has room for.
fn slow_mean(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let (tau, doubt, mean, variance) = correlation(x);
    (mean, (2.0 * tau * (1.0 + doubt) * variance / n).sqrt())
}

/// Integrated correlation time of `x` in samples, without what the sample's own mean takes of it: of a series that forgets itself as
/// exp(-t/tau) the rate 1/tau is seen too high by a few over its length n (M. G. Kendall, Biometrika 41, 403 (1954): the first
/// correlation rho by -(1 + 3 rho)/n). 7/n and a factor of 4 at most make the errors of means right within a fifth, of series from 4 to
/// 33 tau long: see the tests.
fn memory(x: &[f64]) -> f64 {
    let seen = correlation(x).0;
    seen / (1.0 - (7.0 * seen / x.len() as f64).min(0.75))
}

/// Standard deviation of the mean over that of a sample, of a series that forgets itself over the share `r` of its length.
fn of_mean(r: f64) -> f64 {
    (2.0 * r * (1.0 - r * (1.0 - exp(-1.0 / r)))).sqrt()
}

/// Integrated correlation time of `x` in samples, 0.5 where there is none, its relative error, and mean and variance of `x`.
fn correlation(x: &[f64]) -> (f64, f64, f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let covariance = |lag: usize| {
        let pairs = x.iter().zip(&x[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (n - lag as f64)
    };
    let variance = covariance(0);
    let (mut tau, mut lag) = (0.5, 1);
    while (lag as f64) < 5.0 * tau && 2 * lag < x.len() && variance > 0.0 {
        tau = (tau + covariance(lag) / variance).max(0.5);
        lag += 1;
    }
    let doubt = (2.0 * (2.0 * lag as f64 + 1.0) / n).sqrt();
    (tau, doubt, mean, variance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Series that forget themselves over 19.5 samples, 4 to 33 times as long: errors by their memory are those that their means are
    /// scattered by, within a quarter (200 of them know their scatter to 5 %).
    #[test]
    fn errors_by_memory_are_honest() {
        let mut random = Random::new(5);
        let (keep, runs): (f64, f64) = (0.95, 200.0);
        for n in [80, 160, 320, 640] {
            let (mut scatter, mut claimed) = (0.0, 0.0);
            for _ in 0..200 {
                let mut x = random.normal() / (1.0 - keep * keep).sqrt();
                let mut next = || {
                    x = keep * x + random.normal();
                    x
                };
                let series: Vec<f64> = (0..n).map(|_| next()).collect();
                scatter += (series.iter().sum::<f64>() / f64::from(n)).powi(2) / runs;
                claimed += of_mean(memory(&series) / f64::from(n)).powi(2) / (1.0 - keep * keep) / runs;
            }
            let ratio = (claimed / scatter).sqrt();
            assert!((0.75..1.25).contains(&ratio), "{n}: {ratio}");
        }
    }

    /// 40 series of 150 looks that forget themselves over 20: scattered as they claim, within a half (40 of them know their
    /// scatter to 11 %, and each knows its own time badly).
    #[test]
    fn errors_of_slow_series_are_honest() {
        let mut random = Random::new(2);
        let keep: f64 = 0.95;
        let all: Vec<(f64, f64)> = (0..40)
            .map(|_| {
                let mut x = random.normal() / (1.0 - keep * keep).sqrt();
                let mut next = || {
                    x = keep * x + random.normal();
                    x
                };
                slow_mean(&(0..150).map(|_| next()).collect::<Vec<f64>>())
            })
            .collect();
        let scatter = (all.iter().map(|a| a.0 * a.0).sum::<f64>() / 40.0).sqrt();
        let claimed = (all.iter().map(|a| a.1 * a.1).sum::<f64>() / 40.0).sqrt();
        assert!((0.67..1.5).contains(&(claimed / scatter)), "{claimed} claimed, {scatter} seen");
    }
}
