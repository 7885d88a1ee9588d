//! From parameters to particles: sizes, lattices, masses.
use crate::bodies::{self, Piece};
use crate::params::{Params, Shape, SpaceChoice};
use crate::particle::Particle;
use crate::result::Space;
use crate::solid::{self, Solid};
use hvi_kit::math;
use std::f64::consts::PI;

/// Lengths and times that follow from the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Grid spacing [m].
    pub cell: f64,
    /// Spacing of the particles [m].
    pub spacing: f64,
    /// End of the run [s].
    pub end: f64,
    /// Width of the plate [m]; infinite on a line.
    pub width: f64,
    /// Projectile's diameter [m]; infinite for a slab.
    pub diameter: f64,
    /// What the particles' masses are multiplied by to make the whole scene's: mirror images, or radians.
    pub multiple: f64,
}

impl Layout {
    /// The layout that `params` ask for.
    pub fn of(params: &Params) -> Layout {
        let (size, thickness) = (params.projectile.size(), params.plate.thickness.si());
        let cell = thickness.min(size) / params.cells as f64;
        let sound = params.plate.material.sound_speed(&params.plate.material.eos);
        let end = params.end.map_or_else(|| rule(params, size, thickness, sound), |t| t.si());
        let diameter = params.projectile.diameter.map_or(f64::INFINITY, |d| d.si());
        let width =
            params.plate.width.map_or(1.5 * diameter / math::cos(params.tilt()) + 1.1 * sound * end, |w| w.si());
        let multiple = match params.space() {
            SpaceChoice::Line | SpaceChoice::Full => 1.0,
            SpaceChoice::Axisymmetric => 2.0 * PI,
            SpaceChoice::Quarter => 4.0,
            SpaceChoice::Half => 2.0,
        };
        Layout { cell, spacing: cell / params.particles as f64, end, width, diameter, multiple }
    }
}

/// The end of a run that has none named [s].
fn rule(params: &Params, size: f64, thickness: f64, sound: f64) -> f64 {
    let back = params.plates.values().map(|p| p.distance.si() + p.thickness.si()).fold(thickness, f64::max);
    let passing = 3.0 * (size + back) / bodies::flight(params)[0];
    if params.plates.is_empty() { passing.min(8.0 * (size + thickness) / sound) } else { passing }
}

/// The space as results name it.
pub fn space(choice: SpaceChoice) -> Space {
    match choice {
        SpaceChoice::Line => Space::Line,
        SpaceChoice::Axisymmetric => Space::Axisymmetric,
        SpaceChoice::Quarter => Space::Full { mirror_y: true, mirror_z: true },
        SpaceChoice::Half => Space::Full { mirror_y: true, mirror_z: false },
        SpaceChoice::Full => Space::Full { mirror_y: false, mirror_z: false },
    }
}

/// Mirror planes at 0, by axis.
pub fn mirrors(choice: SpaceChoice) -> [bool; 3] {
    match choice {
        SpaceChoice::Line | SpaceChoice::Full => [false; 3],
        SpaceChoice::Axisymmetric | SpaceChoice::Half => [false, true, false],
        SpaceChoice::Quarter => [false, true, true],
    }
}

/// Mass [kg] of a projectile that the lattice only comes near, at `density` [kg/m3]: a sphere, or a cylinder in three
/// dimensions. Other bodies are filled exactly.
pub fn round_mass(params: &Params, density: f64) -> Option<f64> {
    let radius = 0.5 * params.projectile.diameter?.si();
    match params.projectile.shape {
        Shape::Sphere => Some(density * 4.0 / 3.0 * PI * radius * radius * radius),
        Shape::Cylinder if params.space() != SpaceChoice::Axisymmetric => {
            Some(density * PI * radius * radius * params.projectile.size())
        }
        _ => None,
    }
}

/// Number of particles, near enough for a bound and a cost.
pub fn count(params: &Params, layout: &Layout) -> f64 {
    let (size, thickness, radius) = (params.projectile.size(), params.plate.thickness.si(), 0.5 * layout.diameter);
    let h = layout.spacing;
    let sphere = params.projectile.shape == Shape::Sphere;
    let more: f64 = bodies::pieces(params, layout)[2..].iter().map(|p| estimate(&p.solid, params.space(), h)).sum();
    more + match params.space() {
        SpaceChoice::Line => (size + thickness) / h,
        SpaceChoice::Axisymmetric => {
            let section = if sphere { 0.5 * PI * radius * radius } else { size * radius };
            (section + 0.5 * thickness * layout.width) / (h * h)
        }
        _ => {
            let volume = if sphere { 4.0 / 3.0 * PI * radius * radius * radius } else { size * PI * radius * radius };
            (volume + thickness * layout.width * layout.width) / (h * h * h) / layout.multiple
        }
    }
}

/// Points of the raster, an axis, by which a shape is measured.
const RASTER: usize = 16;

/// Number of particles at `spacing` [m] that `solid` takes, near enough for a bound.
pub fn estimate(solid: &Solid, space: SpaceChoice, spacing: f64) -> f64 {
    let (low, high) = clip(solid.bounds(), space);
    let axes = bodies::axes(space);
    let boxes: f64 = (0..axes).map(|d| (high[d] - low[d]).max(0.0) / spacing).product();
    let inside = solid::raster(low, high, axes, RASTER).filter(|&x| solid.holds(x)).count();
    boxes * inside as f64 / RASTER.pow(axes as u32) as f64
}

/// The part of a box on this side of the mirror planes.
pub fn clip((mut low, high): solid::Bounds, space: SpaceChoice) -> solid::Bounds {
    for (low, is_mirror) in low.iter_mut().zip(mirrors(space)) {
        if is_mirror {
            *low = low.max(0.0);
        }
    }
    (low, high)
}

/// Where the centre of a spherical projectile lies [m]: on the plate's lattice, half to one and a half spacings in front.
pub fn sphere_centre(layout: &Layout) -> f64 {
    -(0.5 * layout.diameter / layout.spacing + 0.5 - 1e-9).ceil() * layout.spacing
}

/// A line of particles that fills `from .. to` [m]: centres and the common spacing, the nearest to `spacing` that fits.
fn fill(from: f64, to: f64, spacing: f64) -> (Vec<f64>, f64) {
    let n = ((to - from) / spacing).round().max(1.0);
    let h = (to - from) / n;
    ((0..n as usize).map(|i| from + (i as f64 + 0.5) * h).collect(), h)
}

/// Builds one body after the other.
struct Builder<'a, const D: usize> {
    choice: SpaceChoice,
    voids: &'a [Solid],
    density: f64,
    velocity: [f64; 3],
    body: u8,
    particles: Vec<Particle<D>>,
}

impl<const D: usize> Builder<'_, D> {
    /// One particle in the box `h` around `at`; in (r, z) its volume is that of its ring, per radian.
    fn add(&mut self, at: [f64; D], h: [f64; D]) {
        let mut volume: f64 = h.iter().product();
        if self.choice == SpaceChoice::Axisymmetric {
            volume *= at[1];
        }
        let velocity = std::array::from_fn(|d| self.velocity[d]);
        let id = self.particles.len() as u32;
        self.particles.push(Particle::new(at, velocity, self.density * volume, volume, id, self.body));
    }

    /// All combinations of coordinates that lie `inside`.
    fn lattice(&mut self, axes: [(Vec<f64>, f64); D], inside: impl Fn(&[f64; D]) -> bool) {
        let h: [f64; D] = std::array::from_fn(|d| axes[d].1);
        let total: usize = axes.iter().map(|a| a.0.len()).product();
        for number in 0..total {
            let mut rest = number;
            let mut at = [0.0; D];
            for d in (0..D).rev() {
                at[d] = axes[d].0[rest % axes[d].0.len()];
                rest /= axes[d].0.len();
            }
            if inside(&at) && !self.voids.iter().any(|v| v.holds(in_space(&at))) {
                self.add(at, h);
            }
        }
    }

    /// Coordinates across the impact out to `half` [m]: from 0 where there is a mirror, else on both sides of it.
    fn across(&self, axis: usize, half: f64, spacing: f64) -> (Vec<f64>, f64) {
        let (mut line, h) = fill(0.0, half, spacing);
        if !mirrors(self.choice)[axis] {
            let behind: Vec<f64> = line.iter().rev().map(|x| -x).collect();
            line.splice(0..0, behind);
        }
        (line, h)
    }
}

/// Distance from the axis.
fn radius<const D: usize>(at: &[f64; D]) -> f64 {
    at[1..].iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A place in three dimensions: in (r, z) the radius stands for y.
fn in_space<const D: usize>(at: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|d| if d < D { at[d] } else { 0.0 })
}

/// The particles of the scene: the projectile, moving along +x, up to the plate's front at x = 0, then the plate, then the
/// further plates and bodies.
///
/// Flat bodies are filled exactly, with the spacing that fits nearest. A sphere takes the points of a lattice that
/// continues the plate's, those with their centre inside; it starts half to one and a half spacings in front of the plate.
/// Other shapes take the points inside of a lattice that fills the box about them.
/// `densities` [kg/m3] by body.
pub fn particles<const D: usize>(params: &Params, layout: &Layout, densities: &[f64]) -> Vec<Particle<D>> {
    let h = layout.spacing;
    let pieces = bodies::pieces(params, layout);
    let mut b = Builder {
        choice: params.space(),
        voids: &params.voids,
        density: densities[0],
        velocity: pieces[0].velocity,
        body: 0,
        particles: Vec::new(),
    };
    projectile(&mut b, params, layout);
    let plates = params.plates.values().map(|p| (p.distance.si(), p.thickness.si(), p.width.map(|w| w.si())));
    let first = (0.0, params.plate.thickness.si(), None);
    for (i, (from, thickness, width)) in std::iter::once(first).chain(plates).enumerate() {
        (b.density, b.velocity, b.body) = (densities[i + 1], [0.0; 3], i as u8 + 1);
        let axes = std::array::from_fn(|d| match d {
            0 => fill(from, from + thickness, h),
            _ => b.across(d, 0.5 * width.unwrap_or(layout.width), h),
        });
        b.lattice(axes, |_| true);
    }
    for (i, piece) in pieces.iter().enumerate().skip(2 + params.plates.len()) {
        (b.density, b.velocity, b.body) = (densities[i], piece.velocity, i as u8);
        free(&mut b, piece, h);
    }
    b.particles
}

/// A further body: a lattice over its box, on this side of the mirrors.
fn free<const D: usize>(b: &mut Builder<'_, D>, piece: &Piece<'_>, h: f64) {
    let (low, high) = clip(piece.solid.bounds(), b.choice);
    let axes = std::array::from_fn(|d| fill(low[d], high[d].max(low[d]), h));
    b.lattice(axes, |at| piece.solid.holds(in_space(at)));
}

fn projectile<const D: usize>(b: &mut Builder<'_, D>, params: &Params, layout: &Layout) {
    let (h, size, half) = (layout.spacing, params.projectile.size(), 0.5 * layout.diameter);
    match params.projectile.shape {
        Shape::Slab | Shape::Cylinder => {
            let round = params.projectile.shape == Shape::Cylinder && D == 3;
            let axes = std::array::from_fn(|d| match d {
                0 => fill(-size, 0.0, h),
                _ if round => b.across(d, (half / h).ceil() * h, h),
                _ => b.across(d, half, h),
            });
            b.lattice(axes, |at| !round || radius(at) < half);
        }
        Shape::Sphere => {
            let steps = (half / h + 1.0).ceil();
            let centre = sphere_centre(layout);
            let axes = std::array::from_fn(|d| match d {
                0 => fill(centre - steps * h, centre + steps * h, h),
                _ => b.across(d, steps * h, h),
            });
            b.lattice(axes, |at| {
                let x = at[0] - centre;
                x * x + radius(at) * radius(at) < half * half
            });
        }
    }
}
