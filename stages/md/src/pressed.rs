//! The way to a state that Liu, Wang and Zhang (2013, section 4) went: a lattice at room temperature is relaxed, pressed, and
//! only then heated at the volume that it has come to.
//!
//! 1. Constant volume and energy, by default 30 ps: from the lattice at rest and velocities at twice room temperature, half of
//!    which becomes potential energy. The mean pressure over the second half is P_0.
//! 2. Constant pressure and temperature: over the first half the pressure rises evenly from P_0 by `rise`; the mean volume over
//!    the second half is V_1.
//! 3. Constant volume V_1 and temperature: as any state of the stage `md`, from these atoms.
//!
//! They went on from one pressure to the next and from one temperature to the next; here each state goes the whole way from the
//! lattice by itself, so that states do not depend on each other and run side by side. The way to V_1 knows nothing of the
//! state's temperature: states that differ in it only have the same V_1 to the last bit.
use crate::barostat::{Shape, Walls};
use crate::fault::Fault;
use crate::run::RESPONSE;
use crate::sampled::LEAST_SAMPLES;
use crate::system::System;
use crate::thermostat::Chain;
use crate::units::{BOLTZMANN, PRESSURE};
use hvi_kit::Invalid;
use hvi_kit::units::{Pressure, Temperature, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Response time of the walls [ps]: slow beside a cold crystal's own motion, which 0.2 ps is not under 80 GPa, and still fifty
/// swings in the time that the volume is averaged over.
const WALLS: f64 = 1.0;

/// How a state is come to by pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressed {
    /// Pressure above that of the relaxed lattice, P_0: -10 to 500 GPa. The paper goes up in steps of 2 GPa.
    pub rise: Pressure,
    /// Temperature while it is relaxed and pressed, 1 to 2000 K.
    #[serde(default = "room")]
    pub room: Temperature,
    /// Time at constant volume and energy, 1 ps to 1 ns.
    #[serde(default = "relaxation")]
    pub relaxation: Time,
    /// Time at constant pressure and temperature, 1 ps to 1 ns: half of it to get there, half to find the volume.
    #[serde(default = "pressing")]
    pub pressing: Time,
}

fn room() -> Temperature {
    Temperature::new(300.0)
}
fn relaxation() -> Time {
    Time::new(30e-12)
}
fn pressing() -> Time {
    Time::new(10e-12)
}

impl Pressed {
    /// The first parameter that is out of its range.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let within = |key: &str, value: f64, from: f64, to: f64, text: &str| {
            if (from..=to).contains(&value) { Ok(()) } else { Err(Invalid::new(key, text)) }
        };
        within("pressed.rise", self.rise.si(), -1e10, 5e11, "it must be -10 GPa to 500 GPa")?;
        within("pressed.room", self.room.si(), 1.0, 2e3, "it must be 1 K to 2000 K")?;
        within("pressed.relaxation", self.relaxation.si(), 1e-12, 1e-9, "it must be 1 ps to 1 ns")?;
        within("pressed.pressing", self.pressing.si(), 1e-12, 1e-9, "it must be 1 ps to 1 ns")
    }

    /// Time before the state's own [s].
    pub(crate) fn time(&self) -> f64 {
        self.relaxation.si() + self.pressing.si()
    }
}

/// How far a system has come.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Course {
    /// Steps of relaxation and of pressing.
    steps: [usize; 2],
    /// Of which so many are done in all.
    done: usize,
    /// [eV/angstrom3]
    rise: f64,
    /// Sum of pressures over the second half of the relaxation [eV/angstrom3].
    pressures: f64,
    /// Sum of volumes over the second half of the pressing [angstrom3].
    volumes: f64,
    walls: Walls,
    chain: Chain,
}

impl Course {
    /// The course of `pressed` for a system of `freedom` degrees of freedom and time step `step` [s].
    pub fn new(pressed: &Pressed, freedom: f64, step: f64) -> Course {
        let thermal = BOLTZMANN * pressed.room.si();
        let walls = Walls::new(Shape::Kept, 0.0, thermal, freedom, WALLS).with_bath(thermal, WALLS);
        Course {
            steps: [pressed.relaxation, pressed.pressing].map(|t| (t.si() / step).round() as usize),
            done: 0,
            rise: pressed.rise.si() / PRESSURE,
            pressures: 0.0,
            volumes: 0.0,
            walls,
            chain: Chain::new(thermal, freedom, RESPONSE),
        }
    }

    /// Some steps of `dt` [ps]; at the end stretches `system` to the mean volume and returns true.
    ///
    /// # Errors
    /// [`Fault`] as [`System::advance`].
    pub fn go_on(&mut self, system: &mut System, dt: f64) -> Result<bool, Fault> {
        let [relaxing, pressing] = self.steps;
        for _ in 0..LEAST_SAMPLES {
            if self.done < relaxing {
                self.relax(system, dt)?;
            } else if self.done < relaxing + pressing {
                self.press(system, dt)?;
            } else {
                let volume = self.volumes / averaged(pressing);
                let factor = hvi_kit::math::cbrt(volume / system.volume());
                system.deform([factor; 3], [1.0; 3]);
                return Ok(true);
            }
            self.done += 1;
        }
        Ok(false)
    }

    fn relax(&mut self, system: &mut System, dt: f64) -> Result<(), Fault> {
        system.advance(dt, None)?;
        if self.done >= self.steps[0] / 2 {
            self.pressures += (system.twice_kinetic() + system.virial()) / (3.0 * system.volume());
        }
        Ok(())
    }

    fn press(&mut self, system: &mut System, dt: f64) -> Result<(), Fault> {
        let [relaxing, pressing] = self.steps;
        let (k, half) = (self.done - relaxing, pressing / 2);
        let share = (k as f64 / half.max(1) as f64).min(1.0);
        self.walls.press(self.pressures / averaged(relaxing) + share * self.rise);
        self.walls.advance(system, dt, Some(&mut self.chain))?;
        if k >= half {
            self.volumes += system.volume();
        }
        Ok(())
    }
}

/// Steps in the second half of `steps`.
fn averaged(steps: usize) -> f64 {
    (steps - steps / 2) as f64
}
