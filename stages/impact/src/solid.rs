//! Shapes of bodies and voids: sphere, cylinder, box, shell, a mesh, and what union, difference and intersection make of them.
use crate::mesh::Mesh;
use hvi_kit::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A place (x, y, z): x along the plate's normal, 0 at its front, the projectile at negative x; (0, 0, 0) is the point of impact.
///
/// In (r, z) y is the radius and z is 0: the section is turned about the axis. On a line y and z are 0.
pub type Place = [Length; 3];

/// A shape in space. Where a mirror plane cuts it, the part at y >= 0 (and z >= 0 in a quarter) counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Solid {
    /// A ball.
    Sphere {
        /// Its middle.
        centre: Place,
        /// Its diameter.
        diameter: Length,
    },
    /// A round bar.
    Cylinder {
        /// Middle of one end face.
        from: Place,
        /// Middle of the other.
        to: Place,
        /// Its diameter.
        diameter: Length,
    },
    /// A box with faces across the axes.
    Box {
        /// The corner of least x, y and z.
        from: Place,
        /// The opposite corner.
        to: Place,
    },
    /// A hollow sphere.
    Shell {
        /// Its middle.
        centre: Place,
        /// Its outer diameter.
        diameter: Length,
        /// Thickness of its wall.
        thickness: Length,
    },
    /// A closed surface from a file: one of the step's `meshes`.
    Mesh {
        /// Its name there.
        name: String,
        /// Where the origin of the file's coordinates lies. Default: at the point of impact.
        #[serde(default = "origin")]
        at: Place,
        /// The surface, once its file has been read.
        #[serde(skip)]
        surface: Option<Surface>,
    },
    /// What any of these holds.
    Union(Vec<Solid>),
    /// What all of these hold.
    Intersection(Vec<Solid>),
    /// What the first holds and none of the others.
    Difference(Vec<Solid>),
}

/// A surface and the length of its file's unit [m].
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Arc<Mesh>,
    /// One unit of its coordinates [m].
    pub unit: f64,
}

fn origin() -> Place {
    [Length::new(0.0); 3]
}

fn si(place: &Place) -> [f64; 3] {
    place.map(Length::si)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|d| a[d] - b[d])
}

/// Lower and upper corner of a box about a shape [m].
pub type Bounds = ([f64; 3], [f64; 3]);

impl Solid {
    /// A box between two corners [m].
    pub fn cuboid(from: [f64; 3], to: [f64; 3]) -> Solid {
        Solid::Box { from: from.map(Length::new), to: to.map(Length::new) }
    }

    /// Whether the point `x` [m] lies inside.
    pub fn holds(&self, x: [f64; 3]) -> bool {
        match self {
            Solid::Sphere { centre, diameter } => {
                let (r, radius) = (minus(x, si(centre)), 0.5 * diameter.si());
                dot(r, r) < radius * radius
            }
            Solid::Cylinder { from, to, diameter } => {
                let (axis, r, radius) = (minus(si(to), si(from)), minus(x, si(from)), 0.5 * diameter.si());
                let (along, square) = (dot(r, axis), dot(axis, axis));
                0.0 < along && along < square && dot(r, r) * square - along * along < radius * radius * square
            }
            Solid::Box { from, to } => (0..3).all(|d| from[d].si() <= x[d] && x[d] <= to[d].si()),
            Solid::Shell { centre, diameter, thickness } => {
                let (r, outer) = (minus(x, si(centre)), 0.5 * diameter.si());
                let inner = outer - thickness.si();
                let square = dot(r, r);
                square < outer * outer && square >= inner * inner
            }
            Solid::Mesh { at, surface, .. } => {
                surface.as_ref().is_some_and(|s| s.mesh.holds(minus(x, si(at)).map(|x| x / s.unit)))
            }
            Solid::Union(parts) => parts.iter().any(|s| s.holds(x)),
            Solid::Intersection(parts) => parts.iter().all(|s| s.holds(x)),
            Solid::Difference(parts) => parts[0].holds(x) && !parts[1..].iter().any(|s| s.holds(x)),
        }
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Bounds {
        match self {
            Solid::Sphere { centre, diameter } | Solid::Shell { centre, diameter, .. } => {
                let (c, radius) = (si(centre), 0.5 * diameter.si());
                (c.map(|x| x - radius), c.map(|x| x + radius))
            }
            Solid::Cylinder { from, to, diameter } => {
                let (a, b) = (si(from), si(to));
                let axis = minus(b, a);
                let square = dot(axis, axis);
                let reach: [f64; 3] =
                    std::array::from_fn(|d| 0.5 * diameter.si() * (1.0 - axis[d] * axis[d] / square).max(0.0).sqrt());
                (std::array::from_fn(|d| a[d].min(b[d]) - reach[d]), std::array::from_fn(|d| a[d].max(b[d]) + reach[d]))
            }
            Solid::Box { from, to } => (si(from), si(to)),
            Solid::Mesh { at, surface, .. } => {
                let (at, none) = (si(at), ([0.0; 3], [0.0; 3]));
                let (low, high) = surface.as_ref().map_or(none, |s| {
                    let (low, high) = s.mesh.bounds();
                    (low.map(|x| x * s.unit), high.map(|x| x * s.unit))
                });
                (std::array::from_fn(|d| at[d] + low[d]), std::array::from_fn(|d| at[d] + high[d]))
            }
            Solid::Union(parts) => join(parts, f64::min, f64::max),
            Solid::Intersection(parts) => join(parts, f64::max, f64::min),
            Solid::Difference(parts) => parts[0].bounds(),
        }
    }

    /// Least thickness of the parts that it is made of [m], over the first `axes` of the three.
    pub fn thinnest(&self, axes: usize) -> f64 {
        let least = |(low, high): Bounds| (0..axes).map(|d| high[d] - low[d]).fold(f64::INFINITY, f64::min);
        match self {
            Solid::Sphere { diameter, .. } => diameter.si(),
            Solid::Cylinder { from, to, diameter } => {
                let axis = minus(si(to), si(from));
                dot(axis, axis).sqrt().min(diameter.si())
            }
            Solid::Shell { thickness, .. } => thickness.si(),
            Solid::Box { .. } | Solid::Mesh { .. } | Solid::Intersection(_) => least(self.bounds()),
            Solid::Union(parts) => parts.iter().map(|s| s.thinnest(axes)).fold(f64::INFINITY, f64::min),
            Solid::Difference(parts) => parts[0].thinnest(axes),
        }
    }

    /// Puts the surfaces of `find` into all meshes of it.
    ///
    /// # Errors
    /// The name of the first mesh that `find` does not know.
    pub fn resolve(&mut self, find: &impl Fn(&str) -> Option<Surface>) -> Result<(), String> {
        match self {
            Solid::Mesh { name, surface, .. } => {
                *surface = find(name);
                if surface.is_some() { Ok(()) } else { Err(name.clone()) }
            }
            Solid::Union(parts) | Solid::Intersection(parts) | Solid::Difference(parts) => {
                parts.iter_mut().try_for_each(|part| part.resolve(find))
            }
            _ => Ok(()),
        }
    }

    /// Whether it has a mesh whose file has not been read.
    pub fn is_open(&self) -> bool {
        match self {
            Solid::Mesh { surface, .. } => surface.is_none(),
            Solid::Union(parts) | Solid::Intersection(parts) | Solid::Difference(parts) => {
                parts.iter().any(Solid::is_open)
            }
            _ => false,
        }
    }

    /// What is wrong with its numbers, if anything.
    pub fn fault(&self) -> Option<String> {
        let positive =
            |what: &str, x: f64| (!(x > 0.0)).then(|| format!("has a {what} of {} mm, must be above 0", x * 1e3));
        match self {
            Solid::Sphere { diameter, .. } => positive("diameter", diameter.si()),
            Solid::Cylinder { from, to, diameter } => {
                let axis = minus(si(to), si(from));
                positive("diameter", diameter.si()).or_else(|| positive("length", dot(axis, axis).sqrt()))
            }
            Solid::Box { from, to } => (0..3).find_map(|d| {
                let edge = to[d].si() - from[d].si();
                positive(["width along x", "width along y", "width along z"][d], edge)
            }),
            Solid::Mesh { .. } => None,
            Solid::Shell { diameter, thickness, .. } => positive("diameter", diameter.si())
                .or_else(|| positive("wall thickness", thickness.si()))
                .or_else(|| {
                    let (t, d) = (thickness.si() * 1e3, diameter.si() * 1e3);
                    (2.0 * t >= d).then(|| {
                        format!("has a wall of {t} mm, must be below half its diameter of {d} mm: a sphere is solid")
                    })
                }),
            Solid::Union(parts) | Solid::Intersection(parts) | Solid::Difference(parts) => {
                if parts.is_empty() {
                    return Some("combines no shapes, at least one is needed".into());
                }
                parts.iter().find_map(Solid::fault)
            }
        }
    }
}

fn join(parts: &[Solid], low: fn(f64, f64) -> f64, high: fn(f64, f64) -> f64) -> Bounds {
    let first = parts[0].bounds();
    parts[1..].iter().map(Solid::bounds).fold(first, |(a, b), (c, d)| {
        (std::array::from_fn(|k| low(a[k], c[k])), std::array::from_fn(|k| high(b[k], d[k])))
    })
}

/// Middles of a raster of `n` boxes an axis over the first `axes` of the three between `low` and `high`; 0 along the others.
pub fn raster(low: [f64; 3], high: [f64; 3], axes: usize, n: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..n.pow(axes as u32)).map(move |number| {
        let mut rest = number;
        std::array::from_fn(|d| {
            if d >= axes {
                return 0.0;
            }
            let i = rest % n;
            rest /= n;
            low[d] + (i as f64 + 0.5) * (high[d] - low[d]) / n as f64
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn place(x: f64, y: f64, z: f64) -> Place {
        [x, y, z].map(Length::new)
    }

    /// Volumes by counting points of a raster of 60 boxes an axis: a surface is out by half a box, some 1 % of the volume.
    #[test]
    fn volumes() {
        let ball = |d: f64| Solid::Sphere { centre: place(1.0, 2.0, 3.0), diameter: Length::new(d) };
        let bar = Solid::Cylinder { from: place(0.0, 0.0, 0.0), to: place(1.0, 1.0, 0.0), diameter: Length::new(0.8) };
        let shell =
            Solid::Shell { centre: place(1.0, 2.0, 3.0), diameter: Length::new(2.0), thickness: Length::new(0.5) };
        let cube = Solid::cuboid([1.0, 2.0, 3.0], [3.0, 4.0, 5.0]);
        let sphere = |d: f64| PI / 6.0 * d * d * d;
        let cases = [
            (ball(2.0), sphere(2.0)),
            (bar, PI * 0.16 * 2f64.sqrt()),
            (shell.clone(), sphere(2.0) - sphere(1.0)),
            (Solid::Difference(vec![ball(2.0), ball(1.0)]), sphere(2.0) - sphere(1.0)),
            (Solid::Union(vec![shell, ball(1.0)]), sphere(2.0)),
            (Solid::Intersection(vec![ball(2.0), cube.clone()]), sphere(2.0) / 8.0),
            (Solid::Union(vec![ball(2.0), cube]), 8.0 + sphere(2.0) * 7.0 / 8.0),
        ];
        for (solid, volume) in cases {
            assert_eq!(solid.fault(), None);
            let (low, high) = solid.bounds();
            let inside = raster(low, high, 3, 60).filter(|&x| solid.holds(x)).count() as f64;
            let found = inside / 216e3 * (0..3).map(|d| high[d] - low[d]).product::<f64>();
            assert!((found / volume - 1.0).abs() < 0.01, "{solid:?}: {found}, expected {volume}");
        }
    }

    #[test]
    fn faults_have_numbers() {
        let length = Length::new;
        let shell = Solid::Shell { centre: place(0.0, 0.0, 0.0), diameter: length(2e-3), thickness: length(1e-3) };
        assert!(shell.fault().unwrap().contains("1 mm, must be below half its diameter of 2 mm"));
        assert!(Solid::cuboid([0.0; 3], [1.0, -1e-3, 1.0]).fault().unwrap().contains("width along y of -1 mm"));
        assert!(Solid::Union(Vec::new()).fault().unwrap().contains("no shapes"));
    }
}
