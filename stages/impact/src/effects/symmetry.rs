//! The fewest dimensions that a scene's symmetry allows.
use crate::params::{Params, Shape, SpaceChoice};
use crate::solid::{Place, Solid};
use hvi_kit::units::{Length, Velocity};

/// How symmetric a thing is; a scene is as symmetric as the least of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Symmetry {
    None,
    /// Mirror plane y = 0.
    One,
    /// Mirror planes y = 0 and z = 0.
    Two,
    /// A body of revolution about x.
    Round,
}

/// The space for `params`, and why.
pub fn of(params: &Params) -> (SpaceChoice, String) {
    if params.projectile.shape == Shape::Slab {
        return (SpaceChoice::Line, "slabs, endless across the impact".into());
    }
    let mut parts = vec![(
        "the impact's direction".to_string(),
        if params.tilt() == 0.0 { Symmetry::Round } else { Symmetry::One },
    )];
    for (name, body) in &params.bodies {
        parts.push((format!("`bodies.{name}`"), solid(&body.shape).min(motion(body.velocity))));
    }
    parts.extend(params.voids.iter().map(|void| ("a void".to_string(), solid(void))));
    let (least, symmetry) = parts.into_iter().min_by_key(|part| part.1).expect("one at least");
    let (space, is) = match symmetry {
        Symmetry::Round => (SpaceChoice::Axisymmetric, "all are bodies of revolution about the line of flight"),
        Symmetry::Two => (SpaceChoice::Quarter, "has two mirror planes and is no body of revolution"),
        Symmetry::One => (SpaceChoice::Half, "has one mirror plane, y = 0"),
        Symmetry::None => (SpaceChoice::Full, "has no mirror plane"),
    };
    (space, if symmetry == Symmetry::Round { is.into() } else { format!("{least} {is}") })
}

fn motion(velocity: Option<[Velocity; 3]>) -> Symmetry {
    match velocity.map(|v| v.map(Velocity::si)) {
        Some([_, y, _]) if y != 0.0 => Symmetry::None,
        Some([_, _, z]) if z != 0.0 => Symmetry::One,
        _ => Symmetry::Round,
    }
}

/// Of a shape whose middle is at `centre` and that is round itself.
fn at(centre: &Place) -> Symmetry {
    match centre.map(Length::si) {
        [_, 0.0, 0.0] => Symmetry::Round,
        [_, 0.0, _] => Symmetry::One,
        _ => Symmetry::None,
    }
}

/// Of a box or bar between two places: whether each lies as the other's image.
fn between(from: &Place, to: &Place) -> Symmetry {
    let even = |d: usize| from[d].si() == -to[d].si();
    match (even(1), even(2)) {
        (true, true) => Symmetry::Two,
        (true, false) => Symmetry::One,
        _ => Symmetry::None,
    }
}

fn solid(shape: &Solid) -> Symmetry {
    match shape {
        Solid::Sphere { centre, .. } | Solid::Shell { centre, .. } => at(centre),
        Solid::Cylinder { from, to, .. } => {
            let along_x = from[1] == to[1] && from[2] == to[2];
            let across = from[0] == to[0] && (from[1].si() == 0.0 || from[2].si() == 0.0);
            let in_plane = if from[1].si() == 0.0 && to[1].si() == 0.0 { Symmetry::One } else { Symmetry::None };
            if along_x {
                at(from)
            } else if across {
                between(from, to).max(in_plane)
            } else {
                in_plane
            }
        }
        Solid::Box { from, to } => between(from, to),
        Solid::Mesh { .. } => Symmetry::None,
        Solid::Union(parts) | Solid::Intersection(parts) | Solid::Difference(parts) => {
            parts.iter().map(solid).min().unwrap_or(Symmetry::Round)
        }
    }
}
