//! What an impact run leaves: particles at the times asked for, the ledger, and how much melted.
use crate::effects::Effect;
use hvi_kit::Artifact;
use hvi_kit::view::{Scalar, View};
use serde::{Deserialize, Serialize};

/// The space a run was made in; particle coordinates are read by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Space {
    /// Plane waves: `position[0]` along the impact direction, per square metre of area.
    Line,
    /// `position[0]` along the axis, `position[1]` the radius r >= 0; each particle is a whole ring (2 pi r).
    Axisymmetric,
    /// Right-handed x, y, z, the impact along +x; only the part with `y >= 0` (half) or also `z >= 0` (quarter) may be there.
    Full {
        /// Mirror plane y = 0: the other half is not stored.
        mirror_y: bool,
        /// Mirror plane z = 0: the other half is not stored.
        mirror_z: bool,
    },
}

/// Phase codes of GRAY: 0 solid, 1 melting, 2 liquid, 3 hot liquid, 4 vapour.
pub const PHASES: [&str; 5] = ["solid", "melting", "liquid", "hot liquid", "vapour"];

/// A body of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// `"projectile"`, `"plate"`, or the name of a further plate or body.
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// Mass of the whole body as discretised, mirrored parts included [kg] ([kg/m2] in [`Space::Line`]).
    pub mass: f64,
    /// Initial density [kg/m3].
    pub density: f64,
}

/// Particles at one time, structure of arrays, `[particles]` each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Particles {
    /// Coordinates [m], by [`Space`].
    pub position: [Vec<f32>; 3],
    /// Velocity [m/s], same axes.
    pub velocity: [Vec<f32>; 3],
    /// Mass that the stored particle stands for, mirror images not included [kg].
    pub mass: Vec<f32>,
    /// Density [kg/m3], of the intact matter where the particle has separated.
    pub density: Vec<f32>,
    /// Pressure [Pa].
    pub pressure: Vec<f32>,
    /// Temperature [K].
    pub temperature: Vec<f32>,
    /// Specific internal energy [J/kg].
    pub energy: Vec<f32>,
    /// Share of liquid, 0..1.
    pub liquid: Vec<f32>,
    /// Phase code, see [`PHASES`], at the volume of the intact matter (V_eff).
    pub phase: Vec<u8>,
    /// Index into [`Impact::bodies`].
    pub body: Vec<u8>,
    /// 1 where the particle has failed (spalled or damaged).
    pub failed: Vec<u8>,
}

/// Masses by phase of one body, as shares of the *projectile's* mass (the paper's measure).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Melt {
    /// By phase code, at V_eff = min(V, volume where P(V, E) = 0): separated matter keeps the phase its heat gives it.
    pub by_phase: [f64; 5],
    /// By phase code, at the particle's own (numerically expanded) volume: the paper's likely measure.
    pub by_phase_own_volume: [f64; 5],
    /// Mass-weighted liquid share at V_eff.
    pub liquid: f64,
    /// Of that, in matter that began within three cells of where bodies meet: artificial viscosity overheats it, on cells of any size.
    pub contact: f64,
}

/// The run at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time since the start [s].
    pub time: f64,
    /// The particles.
    pub particles: Particles,
    /// Melted masses, one a body.
    pub melt: Vec<Melt>,
}

/// State of matter at a time: of a particle, or the mean about a place (NaN where nothing is).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct At {
    /// Time [s].
    pub time: f64,
    /// Where [m], by [`Space`].
    pub position: [f64; 3],
    /// Velocity [m/s], same axes.
    pub velocity: [f64; 3],
    /// Density [kg/m3], a particle's own: it falls as a void opens in it.
    pub density: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Specific internal energy [J/kg].
    pub energy: f64,
    /// Equivalent plastic strain.
    pub plastic_strain: f64,
    /// Share of the matter that has failed.
    pub failed: f64,
}

impl At {
    fn values(&mut self) -> [&mut f64; 9] {
        let [x, y, z] = &mut self.velocity;
        let rest = (&mut self.density, &mut self.pressure, &mut self.temperature, &mut self.energy);
        [x, y, z, rest.0, rest.1, rest.2, rest.3, &mut self.plastic_strain, &mut self.failed]
    }

    /// Adds `weight` times what `other` says of matter.
    pub(crate) fn add(&mut self, other: &At, weight: f64) {
        let mut other = *other;
        for (sum, x) in self.values().into_iter().zip(other.values()) {
            *sum += weight * *x;
        }
    }

    /// What it says of matter over `total`.
    pub(crate) fn over(mut self, total: f64) -> At {
        self.values().into_iter().for_each(|x| *x = if total > 0.0 { *x / total } else { f64::NAN });
        self
    }
}

/// What has passed a plane along x since the start, less what came back; mirror images included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Passed {
    /// Time [s].
    pub time: f64,
    /// Mass [kg].
    pub mass: f64,
    /// Its momentum along the impact direction as it passed [kg m/s].
    pub momentum: f64,
    /// Its kinetic energy as it passed [J].
    pub kinetic: f64,
    /// Its internal energy as it passed [J].
    pub internal: f64,
}

/// What was followed, over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Track {
    /// The matter at a place.
    Point(Vec<At>),
    /// One particle.
    Particle(Vec<At>),
    /// A plane across x.
    Plane(Vec<Passed>),
}

/// A probe and what it has shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// Where it was put [m].
    pub place: [f64; 3],
    /// What it has shown.
    pub track: Track,
}

/// Sums over the whole scene at one time; conserved ones don't move. Mirror images included; per radian nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Time [s].
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// Mass [kg].
    pub mass: f64,
    /// Momentum along the impact direction [kg m/s].
    pub momentum: f64,
    /// Kinetic energy, affine motion included [J].
    pub kinetic: f64,
    /// Internal energy, one a body [J].
    pub internal: Vec<f64>,
    /// The same by phase code, see [`PHASES`], at the volume of the intact matter [J]; one a body.
    pub by_phase: Vec<[f64; 5]>,
    /// Kinetic and internal energy of particles that share no grid node with any other and fly on alone [J]: what has left the
    /// scene, on a grid that has no border. It is part of the sums above.
    pub flying: f64,
    /// Part of the internal energy that came from artificial viscosity, so far [J].
    pub viscous: f64,
    /// Part of the internal energy that the transfer returned as heat, so far [J].
    pub transfer: f64,
    /// Motion that the grid had, no particle can hold, and that is no heat: see [`crate::method::TransferHeat`], so far [J].
    pub unresolved: f64,
    /// Energy added where a negative internal energy was set to zero, so far [J].
    pub floored: f64,
    /// Relative drift of kinetic + unresolved + internal - floored since the start.
    pub drift: f64,
    /// Highest pressure so far [Pa].
    pub highest_pressure: f64,
    /// Highest density over initial density so far.
    pub highest_compression: f64,
    /// Time step [s].
    pub time_step: f64,
}

/// One decision of the plan made before the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The effect.
    pub effect: String,
    /// `on`, `off`, or what was chosen.
    pub choice: String,
    /// What the number is.
    pub what: String,
    /// The number that decided.
    pub number: f64,
    /// From where on the effect is on.
    pub threshold: f64,
    /// Unit of both.
    pub unit: String,
    /// Where the number comes from.
    pub source: String,
}

/// An effect that was left off and passed its threshold in the run, which began again with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// The effect.
    pub effect: Effect,
    /// When [s].
    pub time: f64,
    /// What the number is.
    pub what: String,
    /// What it was.
    pub number: f64,
    /// What it may be.
    pub threshold: f64,
}

/// What an impact run leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Impact {
    /// The space it was made in.
    pub space: Space,
    /// Cell size [m].
    pub cell: f64,
    /// Cells through the thinner of plate thickness and projectile size along the impact.
    pub cells_through: f64,
    /// Impact speed [m/s].
    pub velocity: f64,
    /// Diameter of the projectile across the impact direction [m]; infinite for a slab.
    pub diameter: f64,
    /// Thickness of the plate [m].
    pub thickness: f64,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// At the times asked for, in order; the last is the end.
    pub snapshots: Vec<Snapshot>,
    /// In order of time, the first at the start.
    pub ledger: Vec<Ledger>,
    /// Angle of the line of flight to the plate's normal [rad].
    pub angle: f64,
    /// What was followed through the run.
    pub probes: Vec<Probe>,
    /// What was decided before the run; empty where nothing was.
    pub decisions: Vec<Decision>,
    /// Effects left off that the run showed to be missing, in the order in which they were turned on.
    pub crossings: Vec<Crossing>,
    /// Velocity along the impact of the leading .1, 1 and 5 % of the projectile's mass at the end [m/s].
    pub leading: [f64; 3],
    /// Decisions and warnings a reader of the result must know, one sentence each.
    pub notes: Vec<String>,
}

impl Artifact for Impact {
    const KIND: &'static str = "impact/3";
    fn scalars(&self) -> Vec<Scalar> {
        crate::show::scalars(self)
    }
    fn views(&self) -> Vec<View> {
        crate::show::views(self)
    }
}
