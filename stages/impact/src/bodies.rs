//! All bodies of a scene in one list: projectile, plate, further plates, further bodies; and the parameters of the last two.
use crate::material::{self, Material};
use crate::mesh::Mesh;
use crate::params::{Params, Shape, SpaceChoice};
use crate::scene::{self, Layout};
use crate::solid::{Solid, Surface};
use hvi_kit::math;
use hvi_kit::units::{Length, Velocity};
use hvi_kit::{File, Invalid};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

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

/// A file with a closed surface of triangles: `file = "part.stl"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// What one unit of the file's coordinates is.
    #[serde(default = "millimetre")]
    pub unit: Length,
}

fn millimetre() -> Length {
    Length::new(1e-3)
}

impl Params {
    fn solids(&mut self) -> impl Iterator<Item = (String, &mut Solid)> {
        let bodies = self.bodies.iter_mut().map(|(name, body)| (format!("bodies.{name}.shape"), &mut body.shape));
        bodies.chain(self.voids.iter_mut().map(|void| ("voids".to_string(), void)))
    }

    /// Whether a shape is a mesh whose file has not been read.
    pub fn has_open_meshes(&self) -> bool {
        self.bodies.values().map(|body| &body.shape).chain(&self.voids).any(Solid::is_open)
    }

    /// The parameters with the surfaces of `files`, by keys as `meshes.NAME.file`.
    ///
    /// # Errors
    /// A file that is missing, goes elsewhere or holds no closed surface; a shape that names no mesh.
    pub fn with_meshes(&self, files: &BTreeMap<String, File>) -> Result<Params, Invalid> {
        let key = |name: &str| format!("meshes.{name}.file");
        if let Some(other) = files.keys().find(|k| !self.meshes.keys().any(|name| **k == key(name))) {
            return Err(Invalid::new(other, "is no place for a file: surfaces go to `meshes.NAME.file`"));
        }
        let mut surfaces = BTreeMap::new();
        for (name, MeshFile { unit }) in &self.meshes {
            let unit = unit.si();
            if !(unit > 0.0) {
                return Err(Invalid::new(&format!("meshes.{name}.unit"), format!("is {unit} m, must be above 0")));
            }
            let file = files.get(&key(name));
            let file = file.ok_or_else(|| Invalid::new(&key(name), "is missing: the path of an STL file"))?;
            let mesh = Mesh::read(&file.0).map_err(|why| Invalid::new(&key(name), why))?;
            surfaces.insert(name.clone(), Surface { mesh: Arc::new(mesh), unit });
        }
        let mut params = self.clone();
        for (place, solid) in params.solids() {
            solid.resolve(&|name| surfaces.get(name).cloned()).map_err(|name| {
                let known: Vec<&str> = surfaces.keys().map(String::as_str).collect();
                Invalid::new(&place, format!("names the mesh `{name}`, which `meshes` has not: {}", known.join(", ")))
            })?;
        }
        Ok(params)
    }
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
