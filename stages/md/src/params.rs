//! What is asked of a run.
use crate::lattice;
use crate::potential::{Named, Potential, Structure};
use crate::pressed::Pressed;
use crate::sampled::{Asked, LEAST_SAMPLES};
use crate::system::LEAST_SKIN;
use hvi_kit::math::cbrt;
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{File, Invalid, Needs};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What computes a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum By {
    /// This program.
    #[default]
    Native,
    /// LAMMPS, as the program `lmp`.
    Lammps,
}

/// Parameters of the stage `md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// What computes it: this program's own kernels, or LAMMPS.
    #[serde(default)]
    pub engine: By,
    /// How atoms act on each other: the name of a built-in potential, or `{ file = "Cu_u3.eam", format = "funcfl" }` with
    /// the format `funcfl`, `setfl` or `eam/fs` and, where the file has several, the `element`.
    pub potential: Named,
    /// Number of atoms, 4 n^3: a cube of n^3 face-centred cells.
    #[serde(default = "defaults::atoms")]
    pub atoms: u32,
    /// Volume over that of the lattice at 0 K without pressure, 0.45 to 1.7; with `pressed`, that which it begins at.
    pub volume_ratio: f64,
    /// Comes to the state by pressure, as Liu, Wang and Zhang (2013) do: `pressed = { rise = "20 GPa" }`. The lattice is relaxed
    /// at `volume_ratio` and room temperature at constant energy, pressed at constant temperature until it is `rise` above its
    /// own pressure, and heated at the volume that it then has. Native engine only.
    #[serde(default)]
    pub pressed: Option<Pressed>,
    /// Temperature of the heat bath, above 0 and up to 20,000 K.
    pub temperature: Temperature,
    /// Time step, 0.1 to 10 fs.
    #[serde(default = "defaults::time_step")]
    pub time_step: Time,
    /// Time that is run before averaging, from the lattice at rest and velocities at twice the temperature.
    #[serde(default = "defaults::equilibration")]
    pub equilibration: Time,
    /// Standard error of the pressure to stop at.
    #[serde(default = "defaults::target_error")]
    pub target_error: Pressure,
    /// Averaging goes on at least so long.
    #[serde(default = "defaults::shortest")]
    pub shortest: Time,
    /// Averaging goes on no longer than this, whether the target is reached or not.
    #[serde(default = "defaults::longest")]
    pub longest: Time,
    /// Seed of the first velocities.
    #[serde(default = "defaults::seed")]
    pub seed: u64,
    /// Keeps positions and velocities so often while it averages, as a trajectory in extended XYZ; by default none. Native engine
    /// only.
    #[serde(default)]
    pub trajectory: Option<Time>,
    /// Processes that LAMMPS runs as, by MPI, 1 to 1024: worth it from some 10,000 atoms a process on. They part the atoms among
    /// them, so that sums are taken in another order: another number of them is another computation. LAMMPS only.
    #[serde(default = "defaults::ranks")]
    pub ranks: u32,
}

/// Most positions of all atoms and frames that a trajectory may have: 48 B each.
const MOST_POSITIONS: f64 = 2e7;

/// The potential that `named` means, and the cubic edge of its lattice at rest without pressure [angstrom]; its file, if it has
/// one, is `potential.file`.
///
/// # Errors
/// [`Invalid`] where there is no such file, or it is malformed, or the metal has no face-centred lattice.
pub(crate) fn crystal(named: &Named, files: &BTreeMap<String, File>) -> Result<(Potential, f64), Invalid> {
    const PLACE: &str = "potential.file";
    if let Some(other) = files.keys().find(|key| *key != PLACE) {
        return Err(Invalid::new(other, format!("a file goes to `{PLACE}` only")));
    }
    let file = files.get(PLACE);
    let key = if file.is_some() { PLACE } else { "potential" };
    let potential = named.potential(file).map_err(|e| Invalid::new(key, e.to_string()))?;
    let unfit = || Invalid::new("potential", "it has no face-centred cubic lattice, the one that is run here");
    if !matches!(potential.structure(), Structure::Fcc | Structure::Other) {
        return Err(unfit());
    }
    let ground = lattice::equilibrium_edge(&potential).ok_or_else(unfit)?;
    Ok((potential, ground))
}

mod defaults {
    use hvi_kit::units::{Pressure, Time};
    pub fn atoms() -> u32 {
        500
    }
    pub fn time_step() -> Time {
        Time::new(3e-15)
    }
    pub fn equilibration() -> Time {
        Time::new(1e-12)
    }
    pub fn target_error() -> Pressure {
        Pressure::new(1e8)
    }
    pub fn shortest() -> Time {
        Time::new(2e-12)
    }
    pub fn longest() -> Time {
        Time::new(60e-12)
    }
    pub fn seed() -> u64 {
        1
    }
    pub fn ranks() -> u32 {
        1
    }
}

impl Params {
    /// Cubic cells along an edge: the n of the 4 n^3 nearest to `atoms`.
    pub fn cells(&self) -> usize {
        let off = |n: &usize| (4 * n * n * n).abs_diff(self.atoms as usize);
        (1..=1024).min_by_key(off).expect("the range is not empty")
    }

    /// The first parameter that is out of its range.
    ///
    /// # Errors
    /// [`Invalid`] with the range, and the nearest number of atoms that will do.
    pub fn check(&self) -> Result<(), Invalid> {
        let within = |key: &str, value: f64, from: f64, to: f64, text: &str| {
            if (from..=to).contains(&value) { Ok(()) } else { Err(Invalid::new(key, text)) }
        };
        within(
            "volume_ratio",
            self.volume_ratio,
            0.45,
            1.7,
            &format!("{} is outside of 0.45 to 1.7", self.volume_ratio),
        )?;
        within("temperature", self.temperature.si(), 1.0, 2e4, "it must be 1 K to 20000 K")?;
        within("time_step", self.time_step.si(), 1e-16, 1e-14, "it must be 0.1 fs to 10 fs")?;
        within("equilibration", self.equilibration.si(), 0.0, 1e-9, "it must be 0 to 1 ns")?;
        within("target_error", self.target_error.si(), 1e5, 1e12, "it must be 0.0001 GPa to 1000 GPa")?;
        let least = LEAST_SAMPLES as f64 * self.time_step.si();
        within("shortest", self.shortest.si(), least, 1e-8, &format!("it must be {least:e} s (50 steps) to 10 ns"))?;
        within("longest", self.longest.si(), self.shortest.si(), 1e-8, "it must be from `shortest` to 10 ns")?;
        if let Some(pressed) = &self.pressed {
            pressed.check()?;
            if self.engine == By::Lammps {
                return Err(Invalid::new("pressed", "it takes engine = \"native\""));
            }
        }
        if let Some(every) = self.trajectory {
            self.check_trajectory(every)?;
        }
        if !(1..=1024).contains(&self.ranks) {
            return Err(Invalid::new("ranks", format!("{} is outside of 1 to 1024", self.ranks)));
        }
        if self.ranks > 1 && self.engine == By::Native {
            return Err(Invalid::new("ranks", "it takes engine = \"lammps\""));
        }
        match &self.potential {
            Named::BuiltIn(_) => self.potential(&BTreeMap::new()).map(drop),
            Named::File(_) => Ok(()),
        }
    }

    fn check_trajectory(&self, every: Time) -> Result<(), Invalid> {
        if self.engine == By::Lammps {
            return Err(Invalid::new("trajectory", "it takes engine = \"native\""));
        }
        let [least, most] = [self.time_step.si(), self.longest.si()];
        if !(least..=most).contains(&every.si()) {
            return Err(Invalid::new(
                "trajectory",
                format!("it must be {least:e} s, a step, to {most:e} s, `longest`"),
            ));
        }
        let positions = f64::from(self.atoms) * most / every.si();
        if positions > MOST_POSITIONS {
            let why =
                format!("that may be {positions:.0e} positions, more than {MOST_POSITIONS:.0e}: keep fewer frames");
            return Err(Invalid::new("trajectory", why));
        }
        Ok(())
    }

    /// Time before averaging: on the way to the state, and of equilibration.
    pub fn before(&self) -> Time {
        Time::new(self.equilibration.si() + self.pressed.as_ref().map_or(0.0, Pressed::time))
    }

    /// What is wrong with the potential's file, if anything.
    ///
    /// # Errors
    /// As [`Params::potential`].
    pub fn check_files(&self, files: &BTreeMap<String, File>) -> Result<(), Invalid> {
        self.potential(files).map(drop)
    }

    /// The potential, and the cubic edge of its lattice at rest without pressure [angstrom]; its file, if it has one, is
    /// `potential.file`.
    ///
    /// # Errors
    /// [`Invalid`] where there is no such file, or it is malformed, or the metal has no face-centred lattice, or the box is
    /// too small for it.
    pub fn potential(&self, files: &BTreeMap<String, File>) -> Result<(Potential, f64), Invalid> {
        let (potential, ground) = crystal(&self.potential, files)?;
        self.check_atoms(&potential, ground)?;
        Ok((potential, ground))
    }

    /// Whether the crystal, whose cubic edge at rest without pressure is `ground` [angstrom], fits.
    fn check_atoms(&self, potential: &Potential, ground: f64) -> Result<(), Invalid> {
        let cells = self.cells();
        let of = |n: usize| 4 * n * n * n;
        if of(cells) != self.atoms as usize {
            return Err(Invalid::new("atoms", format!("{} is not 4 n^3; the nearest is {}", self.atoms, of(cells))));
        }
        let edge = ground * cbrt(self.volume_ratio);
        let needed = 2.0 * (potential.cutoff() + LEAST_SKIN);
        if edge * (cells as f64) < needed {
            let enough = (1..).find(|&n| edge * n as f64 >= needed).expect("some multiple is long enough");
            return Err(Invalid::new(
                "atoms",
                format!(
                    "{} atoms at volume_ratio {} fill a cube of {:.2} angstrom, but the potential reaches so far that it must be {needed:.2}: \
                     take {} atoms or more",
                    self.atoms,
                    self.volume_ratio,
                    edge * cells as f64,
                    of(enough)
                ),
            ));
        }
        Ok(())
    }

    /// One thread, as states are run side by side, or one for each process of LAMMPS; memory at its peak, with the tables and all samples.
    pub fn needs(&self) -> Needs {
        let steps = (self.before().si() + self.longest.si()) / self.time_step.si();
        // 60 to 70 listed neighbours at the lattice's volume, 22 B each with what is kept of them, and 300 B of its own
        let atom = 300.0 + 1600.0 / self.volume_ratio;
        let sample = 100.0;
        let frames = self.trajectory.map_or(0.0, |every| self.longest.si() / every.si());
        let kept = 150.0 * frames * f64::from(self.atoms);
        let threads = self.ranks as usize;
        Needs { threads, memory: (4e6 + atom * f64::from(self.atoms) + sample * steps + kept) as u64 }
    }

    /// The state that is asked for.
    ///
    /// # Errors
    /// As [`Params::potential`].
    pub fn asked(&self, files: &BTreeMap<String, File>) -> Result<Asked<'_>, Invalid> {
        let (potential, ground) = self.potential(files)?;
        Ok(Asked { params: self, potential, ground, lattice: ground * cbrt(self.volume_ratio) })
    }

    /// Steps that `time` is.
    pub fn steps(&self, time: Time) -> usize {
        (time.si() / self.time_step.si()).round() as usize
    }

    /// Predicted core-seconds, for AVX-512 at about 3 GHz.
    pub fn cost(&self) -> f64 {
        let step = self.time_step.si();
        // standard error after 1 ps, as measured: with the heat control in the liquid, mapped in the crystal
        let heat = self.temperature.si() / 1000.0;
        let melting = 2.45 / (self.volume_ratio * self.volume_ratio * self.volume_ratio);
        let liquid = heat > melting;
        let after_1_ps =
            0.06e9 * heat * (500.0 / f64::from(self.atoms)).sqrt() * if liquid { 1.0 } else { 0.4 } / self.volume_ratio;
        let ratio = after_1_ps / self.target_error.si();
        let averaged = (ratio * ratio * 1e-12).clamp(self.shortest.si(), self.longest.si());
        let engine = if self.engine == By::Lammps { 4.0 } else { 1.0 };
        let nanoseconds = engine * if liquid { 300.0 } else { 200.0 } / self.volume_ratio;
        (self.before().si() + averaged) / step * f64::from(self.atoms) * nanoseconds * 1e-9
    }
}
