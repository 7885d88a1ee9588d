//! What must hold between the bodies of a scene, said with numbers before the first step.
use crate::bodies::{self, Piece, axes, pieces};
use crate::material::Material;
use crate::params::{Params, SpaceChoice};
use crate::scene::{self, Layout};
use crate::solid::{self, Bounds};
use hvi_kit::math;
use hvi_kit::{Invalid, units::Velocity};
use std::f64::consts::PI;

/// Most bodies of a scene.
const MOST: usize = 64;
/// Least cells through a body.
const CELLS: f64 = 2.0;
/// Points of the raster, an axis, on which two bodies are looked at where their boxes meet.
const RASTER: usize = 24;
/// Steepest angle to the plate's normal [deg].
const STEEPEST: f64 = 80.0;

/// Checks angle, names, materials, sizes and directions: all that the number of particles does not hang on.
///
/// # Errors
/// The first that is wrong.
pub fn bodies(params: &Params, layout: &Layout) -> Result<(), Invalid> {
    angle(params)?;
    names(params)?;
    for void in &params.voids {
        if let Some(why) = void.fault() {
            return Err(Invalid::new("voids", why));
        }
    }
    for (name, body) in &params.bodies {
        if let Some(why) = body.shape.fault() {
            return Err(Invalid::new(&format!("bodies.{name}.shape"), why));
        }
        direction(params.space(), name, body.velocity)?;
    }
    for (name, plate) in &params.plates {
        let sizes = [("thickness", Some(plate.thickness)), ("width", plate.width), ("distance", Some(plate.distance))];
        for (key, size) in sizes.into_iter().filter_map(|(key, size)| Some((key, size?.si()))) {
            if !(size > 0.0) {
                let why = format!("is {} mm, must be above 0", size * 1e3);
                return Err(Invalid::new(&format!("plates.{name}.{key}"), why));
            }
        }
    }
    for piece in pieces(params, layout) {
        constants(params, &piece.key, piece.material)?;
    }
    thick_enough(params, layout)
}

fn angle(params: &Params) -> Result<(), Invalid> {
    let degrees = params.tilt() * 180.0 / PI;
    if !(0.0..=STEEPEST).contains(&degrees) {
        return Err(Invalid::new("angle", format!("is {degrees:.6} deg, must lie between 0 and {STEEPEST} deg")));
    }
    if degrees > 0.0 && !matches!(params.space(), SpaceChoice::Half | SpaceChoice::Full) {
        return Err(Invalid::new("angle", "an oblique impact needs space = \"half\" or \"full\""));
    }
    Ok(())
}

fn names(params: &Params) -> Result<(), Invalid> {
    let count = 2 + params.plates.len() + params.bodies.len();
    if count > MOST {
        return Err(Invalid::new("bodies", format!("makes {count} bodies, at most {MOST} fit")));
    }
    let taken = |name: &String| name == "projectile" || name == "plate";
    if let Some(name) = params.plates.keys().find(|n| taken(n)) {
        return Err(Invalid::new(&format!("plates.{name}"), "has the name of another body, give it one of its own"));
    }
    if let Some(name) = params.bodies.keys().find(|n| taken(n) || params.plates.contains_key(*n)) {
        return Err(Invalid::new(&format!("bodies.{name}"), "has the name of another body, give it one of its own"));
    }
    Ok(())
}

/// A mirror's normal velocity, and that across a line, is none.
fn direction(space: SpaceChoice, name: &str, velocity: Option<[Velocity; 3]>) -> Result<(), Invalid> {
    let along = match space {
        SpaceChoice::Line | SpaceChoice::Axisymmetric | SpaceChoice::Quarter => [true, false, false],
        SpaceChoice::Half => [true, false, true],
        SpaceChoice::Full => [true; 3],
    };
    let key = format!("bodies.{name}.velocity");
    for (d, v) in velocity.iter().flatten().map(|v| v.si()).enumerate() {
        if !(v.abs() <= 30e3) {
            return Err(Invalid::new(
                &key,
                format!("has {v} m/s along {}, must be at most 30 km/s", ["x", "y", "z"][d]),
            ));
        }
        if v != 0.0 && !along[d] {
            let why = format!("has {v} m/s along {}, which space = {space:?} does not have", ["x", "y", "z"][d]);
            return Err(Invalid::new(&key, why.to_lowercase()));
        }
    }
    Ok(())
}

/// The material's constants, and those that a model asked for needs of it.
fn constants(params: &Params, body: &str, material: &Material) -> Result<(), Invalid> {
    if let Some((key, why)) = material.fault() {
        return Err(Invalid::new(&format!("{body}.material.{key}"), why));
    }
    let lacks = |model: &str, what: &str| {
        let why =
            format!("`{}` has no {what}, which {model} = true needs: add it, or leave {model} out", material.name);
        Err(Invalid::new(&format!("{body}.material"), why))
    };
    match (params.damage, params.spall) {
        (Some(true), _) if material.damage.is_none() => lacks("damage", "damage constants d1 to d5"),
        (_, Some(true)) if material.spall.is_none() => lacks("spall", "spall strength"),
        _ => Ok(()),
    }
}

/// At least two cells through each body.
fn thick_enough(params: &Params, layout: &Layout) -> Result<(), Invalid> {
    for piece in pieces(params, layout).iter().skip(2) {
        let (thin, cell) = (piece.solid.thinnest(axes(params.space())), layout.cell);
        // A hair, for thicknesses meant as whole cells.
        if thin < CELLS * cell * (1.0 - 1e-9) {
            let key = match params.plates.contains_key(piece.name) {
                true => format!("plates.{}.thickness", piece.name),
                false => piece.place.clone(),
            };
            let why = format!(
                "is {:.4} mm at its thinnest, {:.2} cells of {:.4} mm: at least {CELLS} are needed; make it thicker, or \
                 set cells = {}",
                thin * 1e3,
                thin / cell,
                cell * 1e3,
                (CELLS * cell * f64::from(params.cells) / thin).ceil()
            );
            return Err(Invalid::new(&key, why));
        }
    }
    Ok(())
}

/// Checks that no two bodies overlap, that each has matter, and that what moves meets something.
///
/// # Errors
/// The first that is wrong.
pub fn places(params: &Params, layout: &Layout) -> Result<(), Invalid> {
    let all = pieces(params, layout);
    for (i, piece) in all.iter().enumerate().skip(2) {
        let count = scene::estimate(&piece.solid, params.space(), layout.spacing);
        if count < 1.0 {
            let why = format!("holds no particle at a spacing of {:.4} mm in this space", layout.spacing * 1e3);
            return Err(Invalid::new(&piece.place, why));
        }
        for other in &all[..i] {
            overlap(params, piece, other)?;
        }
    }
    plates_are_met(params, layout)?;
    bodies_meet(params, layout, &all)
}

fn overlap(params: &Params, piece: &Piece<'_>, other: &Piece<'_>) -> Result<(), Invalid> {
    let count = axes(params.space());
    let (a, b) = (piece.solid.bounds(), other.solid.bounds());
    let common = (std::array::from_fn(|d| a.0[d].max(b.0[d])), std::array::from_fn(|d| a.1[d].min(b.1[d])));
    let (low, high) = scene::clip(common, params.space());
    // Faces meant to touch may overlap by rounding.
    if (0..count).any(|d| high[d] - low[d] <= 1e-9 * (a.1[d] - a.0[d])) {
        return Ok(());
    }
    let both = |x: [f64; 3]| piece.solid.holds(x) && other.solid.holds(x) && !params.voids.iter().any(|v| v.holds(x));
    let shared: Vec<[f64; 3]> = solid::raster(low, high, count, RASTER).filter(|&x| both(x)).collect();
    let Some(first) = shared.first() else { return Ok(()) };
    let range = |d: usize| {
        let (from, to) = shared.iter().fold((first[d], first[d]), |(l, h), x| (l.min(x[d]), h.max(x[d])));
        let half = 0.5 * (high[d] - low[d]) / RASTER as f64;
        format!("{} {:.3} .. {:.3} mm", ["x", "y", "z"][d], (from - half) * 1e3, (to + half) * 1e3)
    };
    let ranges: Vec<String> = (0..count).map(range).collect();
    let why = format!(
        "overlaps `{}`: both hold matter within {}; move one of them, or cut one out of the other with a difference",
        other.key,
        ranges.join(", ")
    );
    Err(Invalid::new(&piece.place, why))
}

/// A plate further back must lie on the line of flight, and the run must last until the projectile's first matter can be there.
fn plates_are_met(params: &Params, layout: &Layout) -> Result<(), Invalid> {
    let [along, _, across] = bodies::flight(params);
    for (name, plate) in &params.plates {
        let (distance, width) = (plate.distance.si(), plate.width.map_or(layout.width, |w| w.si()));
        let (time, aside) = (distance / along, distance * across / along);
        if time > layout.end {
            let why = format!(
                "is {:.4} us, but the projectile needs {:.4} us at {:.1} m/s to `plates.{name}`, {} mm behind the first: at \
                 least that",
                layout.end * 1e6,
                time * 1e6,
                along,
                distance * 1e3
            );
            return Err(Invalid::new("end", why));
        }
        if aside > 0.5 * (width + layout.diameter) {
            let why = format!(
                "is {:.4} mm, but the line of flight passes {:.4} mm beside its middle: at least {:.4} mm",
                width * 1e3,
                aside * 1e3,
                2e3 * aside
            );
            return Err(Invalid::new(&format!("plates.{name}.width"), why));
        }
    }
    Ok(())
}

/// Each moving body's box must run into another's before the end.
fn bodies_meet(params: &Params, layout: &Layout, all: &[Piece<'_>]) -> Result<(), Invalid> {
    let count = axes(params.space());
    for (i, piece) in all.iter().enumerate().skip(2 + params.plates.len()) {
        if piece.velocity == [0.0; 3] {
            continue;
        }
        let meets = |j: usize| {
            let relative = std::array::from_fn(|d| piece.velocity[d] - all[j].velocity[d]);
            meeting(piece.solid.bounds(), all[j].solid.bounds(), relative, count).map(|time| (time, &all[j].key))
        };
        let others = (0..all.len()).filter(|&j| j != i);
        let first = others.filter_map(meets).min_by(|a, b| a.0.total_cmp(&b.0));
        let speed = piece.velocity.map(|v| v * v).iter().sum::<f64>();
        match first {
            None => {
                let (low, high) = piece.solid.bounds();
                let why = format!(
                    "meets no other body: from x {:.3} .. {:.3}, y {:.3} .. {:.3}, z {:.3} .. {:.3} mm it flies past all at \
                     {:.1} m/s; turn it towards one",
                    low[0] * 1e3,
                    high[0] * 1e3,
                    low[1] * 1e3,
                    high[1] * 1e3,
                    low[2] * 1e3,
                    high[2] * 1e3,
                    math::sqrt(speed)
                );
                return Err(Invalid::new(&format!("{}.velocity", piece.key), why));
            }
            Some((time, other)) if time > layout.end => {
                let why = format!(
                    "is {:.4} us, but `{}` needs {:.4} us to `{other}`: at least that",
                    layout.end * 1e6,
                    piece.key,
                    time * 1e6
                );
                return Err(Invalid::new("end", why));
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// When the box `a`, moving at `velocity` [m/s] relative to the box `b`, first touches it [s].
fn meeting(a: Bounds, b: Bounds, velocity: [f64; 3], axes: usize) -> Option<f64> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for d in 0..axes {
        let (near, far) = (b.0[d] - a.1[d], b.1[d] - a.0[d]);
        let v = velocity[d];
        if v == 0.0 {
            if near > 0.0 || far < 0.0 {
                return None;
            }
            continue;
        }
        let (first, last) = if v > 0.0 { (near / v, far / v) } else { (far / v, near / v) };
        (enter, leave) = (enter.max(first), leave.min(last));
    }
    (enter <= leave && enter.is_finite()).then_some(enter)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube 3 away along x and 1 aside: at (1, .5) it touches after 2; straight on, or away, never.
    #[test]
    fn boxes_meet() {
        let (a, b) = (([0.0; 3], [1.0; 3]), ([3.0, 1.5, 0.0], [4.0, 2.5, 1.0]));
        assert_eq!(meeting(a, b, [1.0, 0.5, 0.0], 3), Some(2.0));
        assert_eq!(meeting(a, b, [1.0, 0.0, 0.0], 3), None);
        assert_eq!(meeting(a, b, [-1.0, -0.5, 0.0], 3), None);
        assert_eq!(meeting(a, b, [1.0, 0.0, 0.0], 1), Some(2.0));
    }
}
