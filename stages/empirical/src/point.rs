//! From an impact run to one value of the melted fraction.
use crate::law::Sample;
use hvi_impact::result::{Impact, Melt, Space};
use hvi_kit::StageError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What counts as changed in phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Mass-weighted share of liquid at the volume of the intact matter.
    #[default]
    Liquid,
    /// Mass that has melted completely (liquid, hot liquid, vapour), at the volume of the intact matter.
    Complete,
    /// Mass that has begun to melt or more, at the volume of the intact matter.
    MeltingOrMore,
    /// As `complete`, at the particle's own volume, which numerical expansion inflates; the paper's likely measure.
    CompleteOwnVolume,
    /// As `melting-or-more`, at the particle's own volume.
    MeltingOrMoreOwnVolume,
}

impl Measure {
    /// The melted fraction of a body, as a share of the projectile's mass.
    pub fn of(self, melt: &Melt) -> f64 {
        match self {
            Measure::Liquid => melt.liquid,
            Measure::Complete => melt.by_phase[2..].iter().sum(),
            Measure::MeltingOrMore => melt.by_phase[1..].iter().sum(),
            Measure::CompleteOwnVolume => melt.by_phase_own_volume[2..].iter().sum(),
            Measure::MeltingOrMoreOwnVolume => melt.by_phase_own_volume[1..].iter().sum(),
        }
    }

    /// Masses by phase at the volume that the measure goes by.
    pub fn phases(self, melt: &Melt) -> [f64; 5] {
        match self {
            Measure::Liquid | Measure::Complete | Measure::MeltingOrMore => melt.by_phase,
            Measure::CompleteOwnVolume | Measure::MeltingOrMoreOwnVolume => melt.by_phase_own_volume,
        }
    }

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Measure::Liquid => "mass-weighted share of liquid, at the volume of the intact matter (V_eff)",
            Measure::Complete => "mass that has melted completely, at the volume of the intact matter (V_eff)",
            Measure::MeltingOrMore => "mass that is melting or more, at the volume of the intact matter (V_eff)",
            Measure::CompleteOwnVolume => {
                "mass that has melted completely, at the particles' own (numerically expanded) volume"
            }
            Measure::MeltingOrMoreOwnVolume => {
                "mass that is melting or more, at the particles' own (numerically expanded) volume"
            }
        }
    }
}

/// One run, as the law sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Impact speed [m/s].
    pub velocity: f64,
    /// Diameter of the projectile [m].
    pub diameter: f64,
    /// Thickness of the plate [m].
    pub thickness: f64,
    /// Materials of the projectile and the plate.
    pub materials: [String; 2],
    /// The space it was made in.
    pub space: Space,
    /// Cell size [m].
    pub cell: f64,
    /// Cells through the thinner of plate and projectile.
    pub cells: f64,
    /// Time at which the phases were read [s].
    pub time: f64,
    /// Melted fraction of the projectile, by the measure chosen.
    pub eta: f64,
    /// Liquid share of the projectile in matter that began within three cells of the contact, where artificial viscosity overheats.
    pub contact: f64,
    /// Phase masses of the projectile over its mass, codes 0-4.
    pub projectile: [f64; 5],
    /// Phase masses of the plate over the projectile's mass, codes 0-4.
    pub plate: [f64; 5],
    /// Whether the fit uses it.
    pub used: bool,
}

/// Melted shares from here on count as all of it.
const ALL: f64 = 0.999;

/// Whether two sizes or speeds are the same but for the rounding of their units.
pub fn close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-6
}

/// Without the last digits that unit conversion or a sum of shares leaves (1.6000000000000001 mm).
pub fn tidy(x: f64) -> f64 {
    format!("{x:.10e}").parse().unwrap_or(x)
}

impl Point {
    /// Reads the last snapshot of `run`.
    ///
    /// # Errors
    /// A run without a projectile or snapshot, oblique or on more than one plate, or with values that mean nothing.
    pub fn new(run: &Impact, measure: Measure) -> Result<Point, StageError> {
        let name = format!("the run at {} m/s, D = {} m, t = {} m", run.velocity, run.diameter, run.thickness);
        let refuse = |why: &str| StageError::physics(format!("{name} {why}"));
        let last = run.snapshots.last().ok_or_else(|| refuse("has no snapshot; keep its end"))?;
        if run.angle != 0.0 {
            let degrees = run.angle * 180.0 / std::f64::consts::PI;
            return Err(refuse(&format!(
                "is oblique, by {degrees:.3} deg: the law is one of normal impacts; leave it out"
            )));
        }
        if let Some(third) = run.bodies.get(2) {
            let more = run.bodies.len() - 2;
            return Err(refuse(&format!(
                "has {more} more bodies than projectile and plate, the first `{}`: the law knows one plate; leave it out",
                third.name
            )));
        }
        let body = |name: &str| run.bodies.iter().position(|b| b.name == name).and_then(|i| last.melt.get(i));
        let projectile =
            body("projectile").ok_or_else(|| refuse("has no body named projectile with its melted masses"))?;
        let eta = measure.of(projectile);
        let sizes = [run.velocity, run.diameter, run.thickness, run.cell];
        if !sizes.iter().all(|&x| x > 0.0 && x.is_finite()) || !(-1e-6..1.0 + 1e-4).contains(&eta) {
            return Err(refuse(&format!(
                "has the melted fraction {eta}: speed, sizes and cell must be above 0 and finite, the fraction in 0..1"
            )));
        }
        let material = |name: &str| run.bodies.iter().find(|b| b.name == name).map(|b| b.material.clone());
        Ok(Point {
            materials: ["projectile", "plate"].map(|name| material(name).unwrap_or_default()),
            space: run.space,
            cell: run.cell,
            velocity: run.velocity,
            diameter: run.diameter,
            thickness: run.thickness,
            cells: run.cells_through,
            time: last.time,
            eta: eta.clamp(0.0, 1.0),
            contact: projectile.contact,
            projectile: measure.phases(projectile),
            plate: body("plate").map(|m| measure.phases(m)).unwrap_or_default(),
            used: true,
        })
    }

    /// Whether (nearly) all of the projectile has melted.
    pub fn is_full(&self) -> bool {
        self.eta >= ALL
    }

    /// Cells across the diameter of the projectile, N_D.
    pub fn across(&self) -> f64 {
        self.diameter / self.cell
    }

    /// Diameter over thickness.
    pub fn ratio(&self) -> f64 {
        self.diameter / self.thickness
    }

    /// Whether speed, D/t, materials and space are the same: the same scene up to its scale.
    pub fn is_scaled(&self, other: &Point) -> bool {
        close(self.velocity, other.velocity)
            && close(self.ratio(), other.ratio())
            && self.materials == other.materials
            && self.space == other.space
    }

    /// The point in the law's variables.
    pub fn sample(&self, limited: bool) -> Sample {
        Sample { v: self.velocity * 1e-3, ratio: self.ratio(), eta: self.eta, at_limit: limited && self.is_full() }
    }
}
