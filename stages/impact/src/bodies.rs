//! All bodies of a scene in one list: projectile, plate, further plates, further bodies; and the parameters of the last two.
use crate::material::{self, Material};
use crate::params::{Params, Shape, SpaceChoice};
use crate::scene::{self, Layout};
use crate::solid::Solid;
use hvi_kit::math;
use hvi_kit::units::{Length, Velocity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A further plate at rest, behind the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RearPlate {
    /// From the front of the first plate to the front of this one; the first plate's thickness where they touch.
    pub distance: Length,
    /// Its thickness.
    pub thickness: Length,
    /// Its width. Default: the first plate's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<Length>,
    /// Its material: a name, or a table of all constants.
    #[serde(deserialize_with = "material::by_name_or_table")]
    #[schemars(schema_with = "material::name_or_table")]
    pub material: Material,
}

/// A further body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeBody {
    /// Its shape and place.
    pub shape: Solid,
    /// Its velocity along x, y and z. Default: at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[Velocity; 3]>,
    /// Its material: a name, or a table of all constants.
    #[serde(deserialize_with = "material::by_name_or_table")]
    #[schemars(schema_with = "material::name_or_table")]
    pub material: Material,
}

/// A body as the scene takes it.
pub struct Piece<'a> {
    /// Its name in results.
    pub name: &'a str,
    /// Its key in the parameters, as in `plates.rear`.
    pub key: String,
    /// The key of its place or shape, as in `plates.rear.distance`.
    pub place: String,
    /// Where it is.
    pub solid: Solid,
    /// Its velocity [m/s].
    pub velocity: [f64; 3],
    /// What it is made of.
    pub material: &'a Material,
}

/// The bodies in the order of their numbers: projectile, plate, `plates` and `bodies` by name.
pub fn pieces<'a>(params: &'a Params, layout: &Layout) -> Vec<Piece<'a>> {
    let (p, plate) = (&params.projectile, &params.plate);
    let wide = |from: f64, thickness: f64, width: f64| {
        Solid::cuboid([from, -0.5 * width, -0.5 * width], [from + thickness, 0.5 * width, 0.5 * width])
    };
    let x = |x: f64| [x, 0.0, 0.0].map(Length::new);
    let round = Length::new(layout.diameter);
    let projectile = match p.shape {
        Shape::Sphere => Solid::Sphere { centre: x(scene::sphere_centre(layout)), diameter: round },
        Shape::Cylinder => Solid::Cylinder { from: x(-p.size()), to: x(0.0), diameter: round },
        Shape::Slab => wide(-p.size(), p.size(), f64::INFINITY),
    };
    let mut all = vec![
        Piece {
            name: "projectile",
            key: "projectile".into(),
            place: "projectile.shape".into(),
            solid: projectile,
            velocity: flight(params),
            material: &p.material,
        },
        Piece {
            name: "plate",
            key: "plate".into(),
            place: "plate.thickness".into(),
            solid: wide(0.0, plate.thickness.si(), layout.width),
            velocity: [0.0; 3],
            material: &plate.material,
        },
    ];
    all.extend(params.plates.iter().map(|(name, rear)| Piece {
        name,
        key: format!("plates.{name}"),
        place: format!("plates.{name}.distance"),
        solid: wide(rear.distance.si(), rear.thickness.si(), rear.width.map_or(layout.width, Length::si)),
        velocity: [0.0; 3],
        material: &rear.material,
    }));
    all.extend(params.bodies.iter().map(|(name, body)| Piece {
        name,
        key: format!("bodies.{name}"),
        place: format!("bodies.{name}.shape"),
        solid: body.shape.clone(),
        velocity: body.velocity.map_or([0.0; 3], |v| v.map(Velocity::si)),
        material: &body.material,
    }));
    all
}

/// The projectile's velocity [m/s]: oblique ones fly in the plane y = 0.
pub fn flight(params: &Params) -> [f64; 3] {
    let (v, angle) = (params.velocity.si(), params.tilt());
    [v * math::cos(angle), 0.0, v * math::sin(angle)]
}

/// How many axes `space` has.
pub fn axes(space: SpaceChoice) -> usize {
    match space {
        SpaceChoice::Line => 1,
        SpaceChoice::Axisymmetric => 2,
        SpaceChoice::Quarter | SpaceChoice::Half | SpaceChoice::Full => 3,
    }
}
