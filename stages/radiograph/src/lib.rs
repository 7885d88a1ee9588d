//! X-ray-like images of impact results: the density projection, and the phase map beside it.
//!
//! `camera.rs` where the film stands; `project.rs` mass onto pixels; `xray.rs` what a flash
//! leaves on a film, by `attenuation.rs`; `spread.rs` how far each particle
//! is smeared; `film.rs` the result and its grey scale; `phases.rs` the
//! cut coloured by phase; `shape.rs` lengths that a film is measured for; `scale_bar.rs` the bar below a picture.
mod attenuation;
mod camera;
mod film;
mod phases;
mod project;
mod scale_bar;
mod shape;
mod spread;
mod xray;
pub use camera::{Angles, Camera, Frame, Named, Raster, View, describe};
pub use film::{Film, Tone};
pub use phases::{COLOURS, PhaseMap};
pub use project::Plate;
pub use shape::Shape;
pub use xray::{Exposed, Xray};

use film::{digits, microseconds};
use hvi_impact::result::{Impact, Snapshot, Space};
use hvi_kit::units::{Length, Time};
use hvi_kit::{Ctx, Invalid, Stage, StageError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What to expose, from where, and how to develop it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Direction of the view.
    #[serde(default)]
    pub view: View,
    /// Times of the exposures, all on one film; none: the end of the run.
    #[serde(default)]
    pub exposures: Vec<Time>,
    /// Pixels across.
    #[serde(default = "default_width")]
    pub width: u32,
    /// Part of the film plane to show; none: all but the outermost 0.3 % of the mass on each side, with a margin.
    #[serde(default)]
    pub frame: Option<Frame>,
    /// Fill the gaps between particles that a thin cloud has; else every particle is as large as its own matter.
    #[serde(default = "yes")]
    pub smooth: bool,
    /// How mass per area becomes grey.
    #[serde(default)]
    pub tone: Tone,
    /// Thickness of solid plate material that is full black; none: what 99.5 % of the exposed pixels stay below.
    #[serde(default)]
    pub black: Option<Length>,
    /// A physical X-ray film beside the projection: attenuation by material and energy, blur, motion, the film's response.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xray: Option<Xray>,
}

fn yes() -> bool {
    true
}

fn default_width() -> u32 {
    900
}

hvi_kit::inputs! {
    /// What a radiograph takes.
    pub struct Inputs {
        /// The run.
        run: Impact,
    }
}

/// Part of the mass that may lie beyond each edge of an automatic frame.
const STRAYS: f64 = 3e-3;
/// Part of an automatic frame's width that is added on every side.
const MARGIN: f64 = 0.04;
/// Frames are at most this many times as high as wide, or as wide as high.
const LONGEST: f64 = 8.0;

/// The stage `radiograph`.
pub struct Radiograph;

impl Stage for Radiograph {
    const NAME: &'static str = "radiograph";
    const SUMMARY: &'static str = "X-ray-like film of an impact run by density projection, and cuts coloured by phase";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Film;

    fn check(p: &Params) -> Result<(), Invalid> {
        if !(16..=4096).contains(&p.width) {
            return Err(Invalid::new("width", format!("{} pixels across; 16 to 4096 are possible", p.width)));
        }
        if p.exposures.iter().any(|t| t.si() < 0.0) {
            return Err(Invalid::new("exposures", "a time before the start, 0 s"));
        }
        if p.black.is_some_and(|b| b.si() <= 0.0) {
            return Err(Invalid::new("black", "the thickness that is full black must be above 0 m"));
        }
        if let Some(xray) = &p.xray {
            xray.check()?;
        }
        if let Some(f) = p.frame {
            let (w, h) = (f.to[0].si() - f.from[0].si(), f.to[1].si() - f.from[1].si());
            if w <= 0.0 || h <= 0.0 {
                return Err(Invalid::new("frame", "`to` must lie right of and above `from`"));
            }
            if w > LONGEST * h || h > LONGEST * w {
                return Err(Invalid::new("frame", format!("one side is more than {LONGEST} times the other")));
            }
        }
        Ok(())
    }

    fn cost(p: &Params) -> f64 {
        p.exposures.len().max(1) as f64 * (0.2 + f64::from(p.width) / 900.0)
    }

    fn run(p: &Params, inputs: Inputs, ctx: &Ctx<'_>) -> Result<Film, StageError> {
        let run = &inputs.run;
        if run.space == Space::Line {
            return Err(StageError::physics(
                "the run is one-dimensional: it has no width to project. Use an axisymmetric or 3-D run",
            ));
        }
        let shots = choose(run, &p.exposures)?;
        finite(&shots)?;
        let camera = Camera::new(p.view);
        let raster = match p.frame {
            Some(f) => Raster::over(f.from.map(Length::si), f.to.map(Length::si), p.width),
            None => frame_all(run, &shots, &camera, p.width),
        };
        let mut plate = Plate::new(raster);
        let sides: Vec<Vec<f64>> = shots.iter().map(|s| spread::sides(run, &s.particles, p.smooth)).collect();
        for (shot, sides) in shots.iter().zip(&sides) {
            plate.expose(run, &shot.particles, sides, &camera, ctx)?;
        }
        let side = Camera::new(View::default());
        let cut = if camera == side { raster } else { frame_all(run, &shots, &side, p.width) };
        let copies = project::images(run.space).len() as f64;
        let mass = shots.iter().flat_map(|s| &s.particles.mass).map(|&m| f64::from(m) * copies).sum();
        let caught: f64 = plate.mass.iter().sum();
        let density: Vec<f32> = plate.mass.iter().map(|m| (m / (raster.pixel * raster.pixel)) as f32).collect();
        let plate_density =
            run.bodies.iter().find(|b| b.name == "plate").or(run.bodies.first()).map_or(1.0, |b| b.density);
        Ok(Film {
            view: describe(p.view),
            exposures: shots.iter().map(|s| s.time).collect(),
            raster,
            mass,
            caught,
            smooth: p.smooth,
            tone: p.tone,
            black: p.black.map_or_else(|| Film::auto_black(&density), |b| b.si() * plate_density),
            velocity: run.velocity,
            exposed: match p.xray {
                Some(x) => Some(xray::expose(x, run, &shots, &sides, &camera, raster, ctx)?),
                None => None,
            },
            shapes: shots.iter().filter_map(|shot| Shape::of(run, shot)).collect(),
            phases: shots.iter().zip(&sides).map(|(shot, sides)| PhaseMap::new(run, shot, sides, cut)).collect(),
            density,
        })
    }
}

/// The snapshots nearest to `times`; the last one where none are named.
///
/// # Errors
/// A time that no snapshot lies within 1 % of, with the times there are.
fn choose<'a>(run: &'a Impact, times: &[Time]) -> Result<Vec<&'a Snapshot>, StageError> {
    let last = run.snapshots.last().ok_or_else(|| StageError::physics("the run has no snapshot to expose"))?;
    if times.is_empty() {
        return Ok(vec![last]);
    }
    let nearest = |t: f64| {
        let distance = |s: &&Snapshot| (s.time - t).abs();
        run.snapshots.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).filter(|s| distance(s) <= 0.01 * t)
    };
    times
        .iter()
        .map(|t| {
            nearest(t.si()).ok_or_else(|| {
                let there: Vec<_> = run.snapshots.iter().map(|s| microseconds(s.time)).collect();
                StageError::physics(format!(
                    "no snapshot within 1 % of {}: the run kept {}. Expose one of these, or let the impact step keep this time too",
                    microseconds(t.si()),
                    there.join(", ")
                ))
            })
        })
        .collect()
}

/// Refuses particles that no film can show.
fn finite(shots: &[&Snapshot]) -> Result<(), StageError> {
    for shot in shots {
        let p = &shot.particles;
        let bad = |i: usize| {
            let sound = p.position.iter().all(|axis| axis.get(i).is_none_or(|x| x.is_finite()));
            !(sound && p.mass[i] > 0.0 && p.density[i] > 0.0 && p.mass[i].is_finite())
        };
        if let Some(i) = (0..p.mass.len()).find(|&i| bad(i)) {
            return Err(StageError::physics(format!(
                "particle {i} at {}: position {:?} m, mass {} kg, density {} kg/m3; all must be finite, the last two above 0. The \
                 impact run is at fault",
                microseconds(shot.time),
                project::place(p, i, [1.0; 3]),
                digits(f64::from(p.mass[i])),
                digits(f64::from(p.density[i])),
            )));
        }
        if p.mass.is_empty() {
            return Err(StageError::physics(format!("the snapshot at {} has no particles", microseconds(shot.time))));
        }
    }
    Ok(())
}

/// A raster that holds all particles of `shots` but the outermost few, with a margin.
fn frame_all(run: &Impact, shots: &[&Snapshot], camera: &Camera, width: u32) -> Raster {
    let mut edges: [Vec<(f64, f64)>; 4] = Default::default();
    for p in shots.iter().map(|s| &s.particles) {
        for sign in project::images(run.space) {
            for i in 0..p.mass.len() {
                let (low, high) = project::bounds(run.space, camera, p, i, sign);
                let mass = f64::from(p.mass[i]);
                for (edge, at) in edges.iter_mut().zip([low[0], low[1], -high[0], -high[1]]) {
                    edge.push((at, mass));
                }
            }
        }
    }
    let [left, bottom, right, top] = edges.map(|edge| beyond(edge, STRAYS));
    let (mut low, mut high) = ([left, bottom], [-right, -top]);
    // A frame of some width even around a single particle, and no sliver.
    let side = (high[0] - low[0]).max(high[1] - low[1]).max(run.cell);
    for axis in 0..2 {
        let least = if axis == 0 { 0.6 * side } else { 0.3 * side };
        let more = 0.5 * (least - (high[axis] - low[axis])).max(0.0) + MARGIN * side;
        low[axis] -= more;
        high[axis] += more;
    }
    Raster::over(low, high, width)
}

/// The value below which the share `share` of the weight lies.
fn beyond(mut weighted: Vec<(f64, f64)>, share: f64) -> f64 {
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = share * weighted.iter().map(|w| w.1).sum::<f64>();
    for &(value, weight) in &weighted {
        if weight > left {
            return value;
        }
        left -= weight;
    }
    weighted.last().map_or(0.0, |w| w.0)
}

#[cfg(test)]
mod tests;
