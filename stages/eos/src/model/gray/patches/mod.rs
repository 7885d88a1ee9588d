//! GRAY in patches: polynomials between its own borders, built to a stated error, in place of its formulas.
//!
//! The solid, the melting band, the liquid and the hot liquid each fill the strip between two borders E_k(V); in a strip,
//! `y = (E - E_k)/(E_(k+1) - E_k)` runs from 0 to 1 and everything is smooth. A strip is cut into columns of y and rows of V0/V:
//! in y polynomials through Chebyshev-Lobatto nodes, of degree 3 while the whole fits the second-level cache, else 5; in V0/V cubic
//! Hermite on the slopes at the nodes. Both meet their neighbours' values at every edge, so P and T are continuous across borders
//! of phases and patches alike, to the rounding of single width.
//!
//! `grid.rs` where a state lies and what is read there; `line.rs` how a patch comes about; `many.rs` many states at once.
mod grid;
mod line;
mod many;

use super::{Gray, Parameters};
use crate::lanes::{Eight, Real, Work};
use crate::{EosError, Instructions, Point, Points};
use grid::{Grid, REGIMES};
use line::nodes;
use many::Many;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a [`Patches`] is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchParameters {
    /// GRAY's.
    pub gray: Parameters,
    /// Largest error allowed, see [`PatchErrors`].
    pub accuracy: f64,
}

/// Largest errors, found between the nodes of every patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchErrors {
    /// Of P, relative to the larger of |P| and rho0 C^2/100 (copper: 1.4 GPa).
    pub pressure: f64,
    /// Of T, relative to the larger of T and T0.
    pub temperature: f64,
    /// Of the sound speed, relative to the larger of it and C/4 (it is nearly 0 where cold matter is expanded to tearing).
    pub sound_speed: f64,
    /// Of the share of liquid.
    pub liquid: f64,
    /// Of the energies at the borders, relative to the solid's width. So near to a border the phase, and with it the sound
    /// speed, which jumps there, may be the other side's.
    pub border: f64,
    /// Of the melting temperature, relative.
    pub melting: f64,
}
impl PatchErrors {
    /// The largest of them.
    pub fn largest(&self) -> f64 {
        [self.temperature, self.sound_speed, self.liquid, self.border, self.melting]
            .into_iter()
            .fold(self.pressure, f64::max)
    }
    fn or(self, other: PatchErrors) -> PatchErrors {
        PatchErrors {
            pressure: self.pressure.max(other.pressure),
            temperature: self.temperature.max(other.temperature),
            sound_speed: self.sound_speed.max(other.sound_speed),
            liquid: self.liquid.max(other.liquid),
            border: self.border.max(other.border),
            melting: self.melting.max(other.melting),
        }
    }
}

/// GRAY in patches; the vapour, matter denser than x = [`Parameters::cap`] and the hot liquid beyond thrice its coldest
/// temperature are GRAY's own formulas still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "PatchParameters", into = "PatchParameters")]
pub struct Patches {
    gray: Box<Gray>,
    accuracy: f64,
    grid: Grid,
    errors: PatchErrors,
}

/// Patches to less than this would be slower than the formulas (docs/eos-speed.md), and numbers of single width would not do.
const FINEST: f64 = 1e-5;

/// Bytes at most, of patches of degree 3 and of degree 5: a second-level cache, and beyond any cache.
const MOST: [usize; 2] = [1 << 20, 12 << 20];

impl Patches {
    /// Refines until the error is within `accuracy`.
    ///
    /// # Errors
    /// [`EosError`] where `accuracy` is not between 1e-5 and 0.1, or can't be reached with patches that fit a cache.
    pub fn new(gray: Gray, accuracy: f64) -> Result<Patches, EosError> {
        let wrong = |why| Err(EosError { name: "GRAY in patches", parameter: "accuracy", why });
        if !(FINEST..=0.1).contains(&accuracy) {
            return wrong(format!(
                "is {accuracy}, must lie between {FINEST} and 0.1; finer, GRAY's formulas are faster"
            ));
        }
        let mut best = f64::INFINITY;
        for (nodes, most) in nodes().iter().zip(MOST) {
            match refine(&gray, accuracy, nodes, most) {
                Ok((grid, errors)) => return Ok(Patches { gray: Box::new(gray), accuracy, grid, errors }),
                Err(least) => best = best.min(least),
            }
        }
        wrong(format!("is {accuracy}: {best:.1e} is the best that {} MB of patches reach", MOST[1] >> 20))
    }

    /// The analytic model.
    pub fn gray(&self) -> &Gray {
        &self.gray
    }
    /// The largest error allowed.
    pub fn accuracy(&self) -> f64 {
        self.accuracy
    }
    /// The errors found.
    pub fn errors(&self) -> PatchErrors {
        self.errors
    }
    /// Number of patches, and their size [B].
    pub fn size(&self) -> (usize, usize) {
        self.grid.size()
    }

    /// Pressure, temperature, sound speed and phase at `volume` [m3/kg] and `energy` [J/kg].
    #[inline]
    pub fn point(&self, volume: f64, energy: f64) -> Point {
        let mut out = None;
        Instructions::best().run(One { of: self, volume, energy, out: &mut out });
        out.unwrap_or_else(|| self.gray.point(volume, energy))
    }

    /// Temperature, pressure, sound speed and share of liquid from what patches say.
    #[inline(always)]
    fn read<R: Real>(&self, [t, p, c2, liquid]: [R; 4]) -> [R; 4] {
        let sound_speed = c2.at_least(self.gray.constants.floor).root();
        [t.at_least(0.0), p, sound_speed, liquid.at_least(0.0).at_most(1.0)]
    }

    /// See [`crate::Eos::evaluate_with`].
    pub(crate) fn evaluate(&self, set: Instructions, volume: &[f64], energy: &[f64], out: &mut Points) {
        set.run(Many { of: self, volume, energy, out });
    }
    pub(crate) fn relaxed_volume(&self, volume: f64, energy: f64) -> f64 {
        // One state at a time the formulas are as fast.
        self.gray.relaxed_volume(volume, energy)
    }
    pub(crate) fn reference_volume(&self) -> f64 {
        self.gray.reference_volume()
    }
    pub(crate) fn reference_temperature(&self) -> f64 {
        self.gray.reference_temperature()
    }
    /// GRAY's own: a table of E(V, T) would bring an error of its own.
    pub(crate) fn energy_at(&self, volume: f64, temperature: f64) -> f64 {
        self.gray.energy_at(volume, temperature)
    }
}

/// One state; `None` outside all patches.
struct One<'a> {
    of: &'a Patches,
    volume: f64,
    energy: f64,
    out: &'a mut Option<Point>,
}

impl Work for One<'_> {
    #[inline(always)]
    fn run<R: Eight>(self) {
        let of = self.of;
        let Some((phase, value, _)) = of.grid.point::<R>(self.volume * of.gray.constants.per_volume, self.energy)
        else {
            return;
        };
        let [temperature, pressure, sound_speed, liquid] = of.read(value);
        *self.out = Some(Point { pressure, temperature, sound_speed, phase, liquid });
    }
}

/// Patches of the given nodes, refined until they are within `accuracy`, and their errors.
///
/// # Errors
/// The least error that `most` bytes reach.
fn refine(gray: &Gray, accuracy: f64, nodes: &[f64], most: usize) -> Result<(Grid, PatchErrors), f64> {
    let (mut rows, mut columns) = (16, [1; REGIMES]);
    let mut best = f64::INFINITY;
    loop {
        let grid = Grid::new(gray, rows, columns, nodes);
        if grid.size().1 > most {
            return Err(best);
        }
        let mut across = grid.errors(gray, nodes, &[0.0]);
        let within = grid.errors(gray, nodes, &[0.25, 0.5, 0.75]);
        let within = within.into_iter().fold(PatchErrors::default(), PatchErrors::or);
        best = best.min(within.largest());
        // A quarter is left for what lies between the places looked at.
        if within.largest() <= 0.75 * accuracy {
            return Ok((grid, within));
        }
        // On a row there is no error but that of the polynomials in y: where it counts, cut those; else the rows.
        across.iter_mut().for_each(|e| e.border = 0.0);
        let coarse: Vec<usize> = (0..REGIMES).filter(|&k| across[k].largest() > 0.5 * accuracy).collect();
        coarse.iter().for_each(|&k| columns[k] *= 2);
        if coarse.is_empty() {
            rows += rows / 2;
        }
    }
}

impl TryFrom<PatchParameters> for Patches {
    type Error = EosError;
    fn try_from(p: PatchParameters) -> Result<Patches, EosError> {
        Patches::new(Gray::new(p.gray)?, p.accuracy)
    }
}
impl From<Patches> for PatchParameters {
    fn from(p: Patches) -> PatchParameters {
        PatchParameters { gray: p.gray.parameters, accuracy: p.accuracy }
    }
}
