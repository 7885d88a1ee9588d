//! Averages over a run, plain or harmonically mapped, with standard errors.
//!
//! In the harmonic limit the force on an atom says how its potential energy differs from the mean, so that
//! `Y = sum F.(x - site) + 3 (N-1) k T`, whose mean is exactly 0 in any crystal, carries most of the noise:
//! `E = <U + Y/2> + 3/2 (N-1) k T` and `P = <W + c Y> + (N-1) k T/V`, W the virial over 3V, with c by regression
//! (S. G. Moustafa, A. J. Schultz and D. A. Kofke, Phys. Rev. E 92, 043303 (2015); as a control variate).
//!
//! In a liquid much of the noise of U and W is that of the heat: within a run the temperature T of the motion wanders
//! around that of the bath, which is its exact mean, and U and W follow with the heat capacity and the thermal pressure.
//! Plain averages therefore take T - T_bath as their control variate, with the coefficient by regression on averages over
//! [`Cube::block`]s (sample by sample U and T exchange heat and go opposite ways). It halves the variance.
//!
//! The centre of mass is at rest, so 3 of 3N modes are missing. In a crystal each holds 3 kT/3 and presses with gamma
//! times that, and c V is gamma - 1/3: `3 k T` and `(3 c + 1/V) k T` are added. In a liquid only the motion is missing:
//! `3/2 k T` and `k T/V`.
//!
//! The modes of a cold crystal hardly exchange heat within a run: each keeps the energy it began with, and as each presses
//! with a gamma of its own, the pressure keeps an offset that no look at one run can show. Mapped pressures therefore have a
//! least error, see [`frozen`].
use crate::units::BOLTZMANN;
use hvi_kit::math::{block_mean, exp};
use serde::{Deserialize, Serialize};

/// What is kept of each step, one a step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Series {
    /// Potential energy [eV].
    pub energy: Vec<f64>,
    /// Virial over three volumes [eV/angstrom3].
    pub pressure: Vec<f64>,
    /// Sum of F.(x - site) [eV].
    pub site_virial: Vec<f64>,
    /// Temperature of the motion [K].
    pub temperature: Vec<f64>,
}

/// Blocks that a longest block length leaves, and with fewer of which no coefficient is fitted.
const LEAST_BLOCKS: usize = 8;

/// A mean and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// The box that was averaged over.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// Number of atoms.
    pub atoms: f64,
    /// Volume [angstrom3].
    pub volume: f64,
    /// k_B T of the heat bath [eV].
    pub thermal: f64,
    /// Samples over which motion and structure share heat.
    pub block: usize,
    /// Time from one sample to the next [ps].
    pub step: f64,
}

/// Mean energy [eV] of all atoms, and pressure [eV/angstrom3].
#[derive(Clone, Copy, Debug)]
pub struct Averages {
    /// Energy, kinetic energy included [eV].
    pub energy: Mean,
    /// Pressure [eV/angstrom3].
    pub pressure: Mean,
}

/// Mean and standard error that accounts for correlation, by block averages.
///
/// The error is itself known only to 1/sqrt(2(n-1)) of it, n the number of longest blocks, and a run that stops when its
/// error has come down to a target stops where chance made it small: that much is added. (Without it 32 liquid runs that
/// claimed 0.094 GPa were scattered by 0.13.)
pub fn mean(x: &[f64]) -> Mean {
    let (value, error) = block_mean(x);
    let mut blocks = x.len();
    while blocks / 2 >= LEAST_BLOCKS {
        blocks /= 2;
    }
    let doubt = 1.0 / (2.0 * (blocks as f64 - 1.0).max(1.0)).sqrt();
    Mean { value, error: error * (1.0 + doubt) }
}

impl Series {
    /// Forgets all samples.
    pub fn clear(&mut self) {
        *self = Series::default();
    }

    /// Plain averages: right for any phase.
    pub fn plain(&self, cube: Cube) -> Averages {
        let bath = cube.thermal / BOLTZMANN;
        let control: Vec<f64> = self.temperature.iter().map(|t| t - bath).collect();
        let blocks =
            |x: &[f64]| x.chunks_exact(cube.block).map(|b| b.iter().sum::<f64>() / b.len() as f64).collect::<Vec<_>>();
        let smooth = blocks(&control);
        let averaged = |of: &[f64]| {
            let c = if smooth.len() < LEAST_BLOCKS { 0.0 } else { -slope(&blocks(of), &smooth) };
            corrected(of, &control, c)
        };
        let (mut energy, mut pressure) = (averaged(&self.energy), averaged(&self.pressure));
        energy.value += 1.5 * cube.atoms * cube.thermal;
        pressure.value += cube.atoms * cube.thermal / cube.volume;
        Averages { energy, pressure }
    }

    /// Harmonically mapped averages: for a crystal whose atoms all stayed at their sites.
    pub fn mapped(&self, cube: Cube) -> Averages {
        let modes = cube.atoms - 1.0;
        let control: Vec<f64> = self.site_virial.iter().map(|y| y + 3.0 * modes * cube.thermal).collect();
        let c = -slope(&self.pressure, &control);
        let mut energy = corrected(&self.energy, &control, 0.5);
        let mut pressure = corrected(&self.pressure, &control, c);
        let harmonic = cube.thermal * (1.5 * modes).sqrt();
        let anharmonic = scatter(&self.energy, &control, 0.5) / harmonic;
        let time = self.energy.len() as f64 * cube.step;
        pressure.error = pressure.error.max(scatter(&self.pressure, &control, c) * frozen(anharmonic, time));
        energy.value += (1.5 * modes + 3.0) * cube.thermal;
        pressure.value += (modes / cube.volume + 3.0 * c + 1.0 / cube.volume) * cube.thermal;
        Averages { energy, pressure }
    }
}

/// Mean of `of + c control`.
fn corrected(of: &[f64], control: &[f64], c: f64) -> Mean {
    mean(&of.iter().zip(control).map(|(x, y)| x + c * y).collect::<Vec<_>>())
}

/// Standard deviation of single samples of `of + c control`.
fn scatter(of: &[f64], control: &[f64], c: f64) -> f64 {
    let samples = || of.iter().zip(control).map(|(x, y)| x + c * y);
    let n = of.len() as f64;
    let mean = samples().sum::<f64>() / n;
    (samples().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt()
}

/// Least standard error of a mapped pressure over a run of `time` [ps], over the scatter of its samples: what the energies
/// that the modes began with leave.
///
/// Were modes independent and their energies constant, half of the scatter's square would be that of mean energies, 0.7 of
/// the scatter; 0.3 to 0.5 is seen. It decays as exp(-t/tau), tau falling with the square of the rate at which modes couple,
/// and so with `anharmonic`^4: the noise that mapping leaves in the energy, over that of the harmonic potential energy. 0.45
/// and tau = 2e-4 ps / anharmonic^4 are a description of runs, not a theory: 24 seeds at each of 13 states, 100 to 3000 K and
/// 0.65 to 1.03 V0, over 1 to 16 ps, where claimed over scattered errors then are 0.65 to 1.9.
fn frozen(anharmonic: f64, time: f64) -> f64 {
    let square = anharmonic * anharmonic;
    let x = time * square * square / 2e-4;
    // Variance of the mean of a signal that forgets itself as exp(-t/tau); its series where the difference cancels.
    let left = if x < 1e-2 { 1.0 - x / 3.0 } else { 2.0 * (x - 1.0 + exp(-x)) / (x * x) };
    0.45 * left.sqrt()
}

/// Slope of y over x by least squares; 0 where x doesn't vary.
fn slope(y: &[f64], x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
    }
    if xx > 0.0 { xy / xx } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A harmonic crystal by hand: U = -S/2 and W = w0 - S g/V, S the site virial, itself -kT times a chi-squared of
    /// 3(N-1) degrees of freedom. Mapped averages have no noise at all: E = 3NkT and P = w0 + (3g + 1) NkT/V.
    #[test]
    fn harmonic_crystal_is_exact() {
        let (cube, g, w0) = (Cube { atoms: 10.0, volume: 100.0, thermal: 0.1, block: 10, step: 3e-3 }, 1.4, 0.02);
        let mut random = Random::new(1);
        let mut series = Series::default();
        for _ in 0..200 {
            let s: f64 = -cube.thermal * (0..27).map(|_| random.normal()).map(|x| x * x).sum::<f64>();
            series.energy.push(-0.5 * s);
            series.pressure.push(w0 - g * s / cube.volume);
            series.site_virial.push(s);
        }
        let mapped = series.mapped(cube);
        assert!((mapped.energy.value - 3.0).abs() < 1e-12 && mapped.energy.error < 1e-12, "{mapped:?}");
        let expected = w0 + (3.0 * g + 1.0) * 10.0 * 0.1 / 100.0;
        assert!((mapped.pressure.value - expected).abs() < 1e-12 && mapped.pressure.error < 1e-12, "{mapped:?}");
    }

    /// The least error neither jumps where the series takes over nor outlives the exchange of heat.
    #[test]
    fn frozen_modes_thaw() {
        let at = |x: f64| frozen(1.0, 2e-4 * x);
        assert!((at(0.0099) / at(0.0101) - 1.0).abs() < 1e-3, "{} {}", at(0.0099), at(0.0101));
        assert!((at(1e6) / 0.45 - 2e-6f64.sqrt()).abs() < 1e-6 && frozen(0.0, 1.0) == 0.45);
    }
}
