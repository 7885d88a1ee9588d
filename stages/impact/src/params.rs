//! Parameters of the stage `impact`, and their checks.
use crate::bodies::{FreeBody, MeshFile, RearPlate};
use crate::checks;
use crate::effects::{Choice, Guard};
use crate::kernel::Kernel;
use crate::material::{self, Material};
use crate::method::{self, Method, Scheme, Transfer, TransferHeat};
use crate::probes::Probes;
use crate::scene::{self, Layout};
use crate::solid::Solid;
use hvi_kit::Invalid;
use hvi_kit::units::{Angle, Length, Time, Velocity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Parameters of an impact run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The moving body.
    pub projectile: Projectile,
    /// The body at rest.
    pub plate: Plate,
    /// Impact speed; 10 m/s to 30 km/s.
    pub velocity: Velocity,
    /// Angle between the line of flight and the plate's normal, 0 to 80 deg, in the plane y = 0: `space` must be half or full.
    /// Default: normal impact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
    /// Further plates behind the first, as of a Whipple shield, each under its name: `distance` from the front of the
    /// first to its front, `thickness`, `material`, and if need be `width` (default: the first plate's) and `eos`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub plates: BTreeMap<String, RearPlate>,
    /// Further bodies, each under its name: `shape` (see Solid below), `material`, and if need be `velocity` (three,
    /// along x, y and z; default: at rest) and `eos`. Coordinates: x along the plate's normal, 0 at its front, the
    /// projectile at negative x; in (r, z) y is the radius and z is 0.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub bodies: BTreeMap<String, FreeBody>,
    /// Surfaces from STL files (text or binary), each under its name, for the shape `mesh`: `{ file = "part.stl", unit = "1 mm" }`.
    /// They must be closed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub meshes: BTreeMap<String, MeshFile>,
    /// Places without matter, cut out of all bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub voids: Vec<Solid>,
    /// Cells through the smaller of the plate's thickness and the projectile's size along the impact; at least 2, and
    /// below 5 with a warning.
    #[serde(default = "cells")]
    pub cells: u32,
    /// Particles a cell along each axis, 1 to 4.
    #[serde(default = "particles")]
    pub particles: u32,
    /// Dimensions and symmetry. Default: axisymmetric; with `effects = "auto"` the least that the scene's symmetry allows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<SpaceChoice>,
    /// End of the run. Default: `3 (L + t) / v`, three times what the projectile's length L and the plate's thickness t
    /// (to the back of the last of several plates) take at the impact speed normal to the plate, and with one plate at most
    /// `8 (L + t) / c` with its longitudinal sound speed c.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<Time>,
    /// Times at which all particles are kept; the end is always among them.
    #[serde(default)]
    pub times: Vec<Time>,
    /// What is followed through the run: `points`, `planes` and `particles`, each under its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probes: Option<Probes>,
    /// Courant number, up to 0.8.
    #[serde(default = "cfl")]
    pub cfl: f64,
    /// Shape of the weights.
    #[serde(default)]
    pub kernel: Kernel,
    /// Return of velocity from the grid.
    #[serde(default)]
    pub transfer: Transfer,
    /// What becomes of motion that the grid holds and particles can't.
    #[serde(default)]
    pub transfer_heat: TransferHeat,
    /// When stress is brought up to date.
    #[serde(default)]
    pub scheme: Scheme,
    /// Coefficient of friction, 0 to 10, between projectile and all else, which may then slide and part. Default: bodies stick
    /// where they meet, and part only by spall and damage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Coefficient of artificial heat conduction in shocks, 0 to 100; 0: none. Default: 80.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conduction: Option<f64>,
    /// Johnson-Cook strength; without it matter is a fluid. Default: on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<bool>,
    /// Whether strength depends on the rate of strain. Default: yes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<bool>,
    /// Whether heat softens below melting. Default: yes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub softening: Option<bool>,
    /// Johnson-Cook damage. Default: of the materials that have constants for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage: Option<bool>,
    /// `auto`: what the keys `space`, `strength`, `rate`, `softening`, `damage`, `spall`, `friction` and `conduction` leave open is
    /// decided before the run by closed-form estimates, each decision with its number and threshold in the result. Default: what
    /// is left open has the keys' own defaults.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effects: Option<Choice>,
    /// What a run does where an effect that `effects = "auto"` left off passes its threshold after all: begin again with it, or stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard: Option<Guard>,
    /// Whether matter that no wave has reached yet is left out of the steps: slower than 1e-9 of the impact speed, and under no more
    /// stress than goes with that. Default: yes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sleep: Option<bool>,
    /// Tension cut-off with void opening. Default: of the materials that have a spall strength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spall: Option<bool>,
}

fn cells() -> u32 {
    6
}
fn particles() -> u32 {
    2
}
fn cfl() -> f64 {
    0.5
}

/// Dimensions and symmetry of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SpaceChoice {
    /// Plane waves in one dimension.
    Line,
    /// (r, z).
    #[default]
    Axisymmetric,
    /// Three dimensions, mirror planes y = 0 and z = 0.
    Quarter,
    /// Three dimensions, mirror plane y = 0.
    Half,
    /// Three dimensions, no mirror.
    Full,
}

/// Shape of a projectile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// `diameter`.
    Sphere,
    /// `diameter` and `length`, its axis along the impact.
    Cylinder,
    /// `length`; endless across the impact: only on a line.
    Slab,
}

/// The moving body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Projectile {
    /// Its shape.
    pub shape: Shape,
    /// Diameter of a sphere or cylinder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter: Option<Length>,
    /// Length of a cylinder or slab.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
    /// Its material: a name, or a table of all constants.
    #[serde(deserialize_with = "material::by_name_or_table")]
    #[schemars(schema_with = "material::name_or_table")]
    pub material: Material,
}

impl Projectile {
    /// Size along the impact [m].
    pub fn size(&self) -> f64 {
        match self.shape {
            Shape::Sphere => self.diameter,
            Shape::Cylinder | Shape::Slab => self.length,
        }
        .map_or(0.0, Length::si)
    }
}

/// The body at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Its thickness along the impact.
    pub thickness: Length,
    /// Diameter in (r, z), edge of the square in three dimensions. Default: `1.5 D + 1.1 c T`, with the projectile's
    /// diameter D, the plate's longitudinal sound speed c and the end T of the run, so that no wave comes back from the
    /// rim.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<Length>,
    /// Its material: a name, or a table of all constants.
    #[serde(deserialize_with = "material::by_name_or_table")]
    #[schemars(schema_with = "material::name_or_table")]
    pub material: Material,
}

/// Most particles a run may have: some 5 GB where they are dense, up to 20 GB where debris is thin.
const MOST_PARTICLES: f64 = 1e7;

/// Whether a scene of `count` particles can be run; one of lengths beyond all numbers can't.
fn fits(count: f64) -> bool {
    count <= MOST_PARTICLES
}

impl Params {
    /// Dimensions and symmetry.
    pub fn space(&self) -> SpaceChoice {
        self.space.unwrap_or_default()
    }

    /// Whether matter has strength.
    pub fn strength(&self) -> bool {
        self.strength.unwrap_or(true)
    }

    /// Coefficient of heat conduction.
    pub fn conduction(&self) -> f64 {
        self.conduction.unwrap_or(method::CONDUCTION)
    }

    /// Angle of the line of flight to the plate's normal [rad].
    pub fn tilt(&self) -> f64 {
        self.angle.map_or(0.0, Angle::si)
    }

    /// Checks everything that can be known before the run; what hangs on a mesh once its file has been read, see
    /// [`Params::with_meshes`].
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(&self) -> Result<(), Invalid> {
        self.check_shape()?;
        self.check_method()?;
        self.probes.iter().try_for_each(|probes| probes.check(self.space()))?;
        if self.has_open_meshes() {
            return Ok(());
        }
        let layout = Layout::of(self);
        checks::bodies(self, &layout)?;
        for t in &self.times {
            if !(t.si() > 0.0 && t.si() <= layout.end) {
                let why =
                    format!("has {} us, must be above 0 and at most the end, {} us", t.si() * 1e6, layout.end * 1e6);
                return Err(Invalid::new("times", why));
            }
        }
        if let Some(diameter) = self.projectile.diameter
            && layout.width < diameter.si()
        {
            let why = format!("is {} mm, less than the projectile's {} mm", layout.width * 1e3, diameter.si() * 1e3);
            return Err(Invalid::new("plate.width", why));
        }
        let count = scene::count(self, &layout);
        if fits(count) {
            return checks::places(self, &layout);
        }
        let why = format!(
            "gives {count:.3e} particles (cells of {:.3e} m), at most {MOST_PARTICLES:.0e} fit: use fewer cells, a smaller \
             plate.width, an earlier end, or space = \"axisymmetric\"",
            layout.cell
        );
        Err(Invalid::new(self.too_many(), why))
    }

    /// The key that makes too many particles: one that does not at its default, else `cells` where the least would fit,
    /// else the thinner body, which sets the cell.
    fn too_many(&self) -> &'static str {
        let without = |change: fn(&mut Params)| {
            let mut params = self.clone();
            change(&mut params);
            fits(scene::count(&params, &Layout::of(&params)))
        };
        if self.plate.width.is_some() && without(|p| p.plate.width = None) {
            "plate.width"
        } else if self.plate.width.is_none() && self.end.is_some() && without(|p| p.end = None) {
            "end"
        } else if without(|p| p.plates.clear()) {
            "plates"
        } else if without(|p| p.bodies.clear()) {
            "bodies"
        } else if without(|p| p.cells = 2) {
            "cells"
        } else if self.plate.thickness.si() <= self.projectile.size() {
            "plate.thickness"
        } else if self.projectile.shape == Shape::Sphere {
            "projectile.diameter"
        } else {
            "projectile.length"
        }
    }

    fn check_shape(&self) -> Result<(), Invalid> {
        let p = &self.projectile;
        let positive = |key: &str, length: Option<Length>| match length {
            Some(l) if l.si() > 0.0 => Ok(()),
            Some(l) => Err(Invalid::new(key, format!("is {} m, must be above 0", l.si()))),
            None => Err(Invalid::new(key, format!("is missing: a {:?} needs it", p.shape).to_lowercase())),
        };
        let absent = |key: &str, length: Option<Length>, why: &str| match length {
            Some(_) => Err(Invalid::new(key, why)),
            None => Ok(()),
        };
        if p.shape == Shape::Sphere {
            absent("projectile.length", p.length, "has no meaning for a sphere: its diameter says all")?;
        } else {
            positive("projectile.length", p.length)?;
        }
        if p.shape == Shape::Slab {
            absent("projectile.diameter", p.diameter, "has no meaning for a slab, which is endless across the impact")?;
            absent("plate.width", self.plate.width, "has no meaning on a line")?;
        } else {
            positive("projectile.diameter", p.diameter)?;
        }
        positive("plate.thickness", Some(self.plate.thickness))?;
        if self.plate.width.is_some() {
            positive("plate.width", self.plate.width)?;
        }
        match (p.shape == Shape::Slab, self.space() == SpaceChoice::Line) {
            (true, false) => Err(Invalid::new("projectile.shape", "a slab needs space = \"line\"")),
            (false, true) => Err(Invalid::new("projectile.shape", "on a line the projectile must be a slab")),
            _ => Ok(()),
        }
    }

    /// The variant of the method asked for.
    pub fn method(&self) -> Method {
        Method {
            kernel: self.kernel,
            transfer: self.transfer,
            transfer_heat: self.transfer_heat,
            scheme: self.scheme,
            friction: self.friction,
            conduction: self.conduction(),
        }
    }

    fn check_method(&self) -> Result<(), Invalid> {
        if let Some((key, why)) = self.method().fault() {
            return Err(Invalid::new(key, why));
        }
        if !(0.0..=100.0).contains(&self.conduction()) {
            return Err(Invalid::new("conduction", format!("is {}, must lie between 0 and 100", self.conduction())));
        }
        if let Some(friction) = self.friction
            && !(0.0..=10.0).contains(&friction)
        {
            return Err(Invalid::new("friction", format!("is {friction}, must lie between 0 and 10")));
        }
        if self.kernel == Kernel::Gimp && self.particles != 2 {
            let why =
                format!("is {}, must be 2 with kernel = \"gimp\": its particles are half a cell wide", self.particles);
            return Err(Invalid::new("particles", why));
        }
        let v = self.velocity.si();
        if !(10.0..=30e3).contains(&v) {
            return Err(Invalid::new("velocity", format!("is {v} m/s, must lie between 10 m/s and 30 km/s")));
        }
        if self.cells < 2 {
            let why = format!("is {}, must be at least 2 through the thinner body (6 by default)", self.cells);
            return Err(Invalid::new("cells", why));
        }
        if !(1..=4).contains(&self.particles) {
            return Err(Invalid::new("particles", format!("is {}, must be 1 to 4 a cell and axis", self.particles)));
        }
        if !(self.cfl > 0.0 && self.cfl <= 0.8) {
            return Err(Invalid::new("cfl", format!("is {}, must be above 0 and at most 0.8", self.cfl)));
        }
        if let Some(end) = self.end
            && !(end.si() > 0.0 && end.si() <= 1.0)
        {
            return Err(Invalid::new("end", format!("is {} s, must be above 0 and at most 1 s", end.si())));
        }
        Ok(())
    }
}
