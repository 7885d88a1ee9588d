//! Two resolutions of the same runs: the melted fraction extrapolated to a vanishing cell, and the law fitted to that.
use crate::eta::{Full, Params, Zeros};
use crate::law::{self, Fit, Sample};
use crate::point::{Point, close, tidy};
use crate::spread::{self, Spread};
use hvi_kit::StageError;
use serde::{Deserialize, Serialize};

/// A partner's cell is larger by this factor or more: below it the extrapolation would magnify every scatter tenfold.
const COARSER: f64 = 1.1;

/// One scene at two cell sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The run with the larger cell.
    pub coarse: Point,
    /// The run with the smaller one.
    pub fine: Point,
}

impl Pair {
    /// Melted fraction for a vanishing cell, if its error goes as the cell size (1/N): Richardson's extrapolation of first order.
    /// May lie outside 0..1.
    pub fn limit(&self) -> f64 {
        let (coarse, fine) = (self.coarse.eta, self.fine.eta);
        fine + (fine - coarse) / (self.coarse.cell / self.fine.cell - 1.0)
    }

    /// How far the extrapolation went: its size stands for its uncertainty.
    pub fn uncertainty(&self) -> f64 {
        (self.limit() - self.fine.eta).abs()
    }

    /// The fine run with the extrapolated fraction, clipped to 0..1.
    fn clipped(&self) -> Point {
        Point { eta: self.limit().clamp(0.0, 1.0), ..self.fine.clone() }
    }
}

/// The law for a vanishing cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The law.
    pub fit: Fit,
    /// Its spread over families of D/t.
    pub spread: Option<Spread>,
    /// Pairs that entered the fit.
    pub pairs: u32,
    /// Root mean square deviation from the extrapolated, clipped fractions.
    pub rms: f64,
}

/// What two resolutions say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refined {
    /// In the order of the finer runs.
    pub pairs: Vec<Pair>,
    /// The law fitted to the extrapolated fractions, or why they can't determine one.
    pub limit: Result<Limit, String>,
}

/// Finds each finer run's partner.
///
/// Of several coarser ones the finest is taken.
///
/// # Errors
/// A finer run without partner.
pub fn pairs(runs: &[Point], finer: &[Point]) -> Result<Vec<Pair>, StageError> {
    let same = |a: &Point, b: &Point| a.is_scaled(b) && close(a.diameter, b.diameter) && a.cell >= COARSER * b.cell;
    finer
        .iter()
        .map(|fine| {
            let partners = runs.iter().filter(|coarse| same(coarse, fine));
            let coarse = partners.min_by(|a, b| a.cell.total_cmp(&b.cell)).ok_or_else(|| alone(fine))?;
            Ok(Pair { coarse: coarse.clone(), fine: fine.clone() })
        })
        .collect()
}

fn alone(fine: &Point) -> StageError {
    let mm = |x: f64| tidy(x * 1e3);
    StageError::physics(format!(
        "the finer run at {} km/s, D = {} mm, t = {} mm ({} on {}, cell {} mm) has no partner in `runs`: one of the same \
         velocity, diameter, thickness, materials and space, whose cell is at least {COARSER} times as large. Add it to \
         `runs`, or take this one out of `finer`",
        tidy(fine.velocity * 1e-3),
        mm(fine.diameter),
        mm(fine.thickness),
        fine.materials[0],
        fine.materials[1],
        mm(fine.cell),
    ))
}

/// Extrapolates each pair and fits eq 35 to the outcome, all pairs with the same weight.
pub fn refined(pairs: Vec<Pair>, p: &Params) -> Refined {
    let kept = |point: &Point| !(point.eta == 0.0 && p.zeros == Zeros::Drop || point.is_full() && p.full == Full::Drop);
    let clipped = pairs.iter().map(Pair::clipped).filter(kept);
    let samples: Vec<Sample> = clipped.map(|point| point.sample(p.full == Full::Limit)).collect();
    Refined { limit: limit(&samples, p), pairs }
}

fn limit(samples: &[Sample], p: &Params) -> Result<Limit, String> {
    if samples.len() < 4 {
        return Err(format!("{} pairs enter the fit; the law's three parameters need 4 or more", samples.len()));
    }
    let fit = law::fit(samples).map_err(|e| e.to_string())?;
    Ok(Limit {
        fit,
        spread: spread::bootstrap(samples, p.bootstrap, p.seed),
        pairs: samples.len() as u32,
        rms: (law::squares(samples, &fit.law) / samples.len() as f64).sqrt(),
    })
}
