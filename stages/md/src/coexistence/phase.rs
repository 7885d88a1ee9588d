//! One phase alone at a pressure and a temperature: its volume and enthalpy.
use super::guess;
use super::result::PhaseAt;
use crate::averaging::mean;
use crate::barostat::{Shape, Walls};
use crate::lanes::Isa;
use crate::system::{LEAST_SKIN, System};
use crate::table::Tables;
use crate::thermostat::Chain;
use crate::units::{BOLTZMANN, SPECIFIC_ENERGY, SPECIFIC_VOLUME};
use crate::{lattice, local_order};
use hvi_kit::{Ctx, StageError};

/// Steps from one look at the cancel flag to the next.
const LOOK: usize = 50;
/// Response times of heat bath and walls [ps].
pub const RESPONSE: [f64; 2] = [0.1, 0.3];
/// Time for melting at [`HOT`] times the temperature, and for settling, each [ps].
const PREPARING: f64 = 1.5;
/// Temperature at which a crystal without surface melts within a picosecond, over that of melting.
pub const HOT: f64 = 2.0;

/// What holds while a phase runs.
pub struct Conditions<'a> {
    /// The potential.
    pub tables: &'a Tables,
    /// Cubic edge of the lattice at rest without pressure [angstrom].
    pub ground: f64,
    /// Pressure [eV/angstrom3].
    pub pressure: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Time step [ps].
    pub step: f64,
    /// Time to average over [ps].
    pub time: f64,
    /// Seed of the first velocities.
    pub seed: u64,
}

impl Conditions<'_> {
    /// Volume and enthalpy of the crystal, or of the melt where `melted`.
    ///
    /// # Errors
    /// [`StageError`] where atoms leave the potential's range, or the run is cancelled.
    pub fn run(&self, melted: bool, isa: Isa, ctx: &Ctx<'_>) -> Result<PhaseAt, StageError> {
        let edge = guess::edge(&self.tables.potential, self.ground, self.pressure, self.temperature);
        let needed = 2.0 * (self.tables.potential.cutoff() + LEAST_SKIN) * 1.05;
        let cells = ((needed / edge).ceil() as usize).max(5);
        let sites = lattice::sites(cells, edge);
        let mut system =
            System::new(self.tables.clone(), isa, &sites, edge * cells as f64).map_err(StageError::physics)?;
        system.heat(2.0 * self.temperature, self.seed);
        let thermal = BOLTZMANN * self.temperature;
        let walls = Walls::new(Shape::Kept, self.pressure, thermal, system.freedom(), RESPONSE[1]);
        let mut walls = walls.with_bath(thermal, RESPONSE[1]);
        if melted {
            self.melt(&mut system, &mut walls, cells, ctx)?;
        }
        self.scaled(&mut system, &mut walls, self.temperature, ctx)?;
        let mut chain = Chain::new(thermal, system.freedom(), RESPONSE[0]);
        let steps = |time: f64| (time / self.step).round() as usize;
        for k in 0..steps(PREPARING) {
            tick(ctx, k)?;
            walls.advance(&mut system, self.step, Some(&mut chain)).map_err(StageError::physics)?;
        }
        let (mut volumes, mut energies) = (Vec::new(), Vec::new());
        for k in 0..steps(self.time) {
            tick(ctx, k)?;
            walls.advance(&mut system, self.step, Some(&mut chain)).map_err(StageError::physics)?;
            volumes.push(system.volume());
            energies.push(system.energy() + self.pressure * system.volume());
        }
        self.stayed(&system, cells, melted)?;
        Ok(self.average(&system, &volumes, &energies, melted))
    }

    /// Heats, each time by a quarter more, until nothing of the crystal is left.
    fn melt(&self, system: &mut System, walls: &mut Walls, cells: usize, ctx: &Ctx<'_>) -> Result<(), StageError> {
        for hotter in [1.0, 1.25, 1.5, 1.75] {
            self.scaled(system, walls, hotter * HOT * self.temperature, ctx)?;
            if order(system, cells) < 0.5 * local_order::LEAST {
                break;
            }
        }
        Ok(())
    }

    /// Refuses a melt that froze, or was never one, and a crystal that melted.
    fn stayed(&self, system: &System, cells: usize, melted: bool) -> Result<(), StageError> {
        if (order(system, cells) < local_order::LEAST) == melted {
            return Ok(());
        }
        let what = if melted { "the melt alone became a crystal" } else { "the crystal alone melted" };
        Err(StageError::physics(format!(
            "{what} at {:.0} K, though both phases live side by side there: take a shorter time `alone` or another `seed`",
            self.temperature
        )))
    }

    /// Runs [`PREPARING`] with velocities scaled to `temperature` [K] again and again.
    fn scaled(
        &self,
        system: &mut System,
        walls: &mut Walls,
        temperature: f64,
        ctx: &Ctx<'_>,
    ) -> Result<(), StageError> {
        for k in 0..(PREPARING / self.step).round() as usize {
            tick(ctx, k)?;
            walls.advance(system, self.step, None).map_err(StageError::physics)?;
            if k % 10 == 9 {
                system.scale(temperature);
            }
        }
        Ok(())
    }

    /// Per mass. The motion of the centre of mass, which the run lacks, is added: 3/2 kT, in a crystal 3 kT with its place.
    fn average(&self, system: &System, volumes: &[f64], energies: &[f64], melted: bool) -> PhaseAt {
        let potential = &self.tables.potential;
        let molar = potential.molar_mass();
        let atoms = system.atoms() as f64;
        let (volume, energy) = (mean(volumes), mean(energies));
        let thermal = BOLTZMANN * self.temperature;
        let kinetic = 0.5 * (system.freedom() + if melted { 3.0 } else { 6.0 }) * thermal;
        let rest = lattice::at_rest(potential, self.ground).energy;
        let (per_volume, per_energy) = (SPECIFIC_VOLUME / molar / atoms, SPECIFIC_ENERGY / molar / atoms);
        PhaseAt {
            volume: volume.value * per_volume,
            volume_error: volume.error * per_volume,
            enthalpy: (energy.value + kinetic - rest * atoms) * per_energy,
            enthalpy_error: energy.error * per_energy,
        }
    }
}

/// Mean local order of a cube of `cells`^3 cubic cells.
fn order(system: &System, cells: usize) -> f64 {
    let all = local_order::of(system, system.edges().map(|edge| edge / cells as f64));
    all.iter().sum::<f64>() / all.len() as f64
}

/// Looks at the cancel flag now and then.
fn tick(ctx: &Ctx<'_>, step: usize) -> Result<(), StageError> {
    if step.is_multiple_of(LOOK) {
        ctx.tick(0.97, 1.0, "each phase alone")?;
    }
    Ok(())
}
