//! The density projection: every particle's mass spread over the pixels that it covers, without noise.
use crate::camera::{Camera, Raster};
use hvi_impact::result::{Impact, Particles, Space};
use hvi_kit::{Cancelled, Ctx, math};
use std::f64::consts::PI;

/// Half of the least width on the film [pixels]: a point would vanish where it lies on a pixel's edge.
const NARROWEST: f64 = 1e-4;

/// Side of the cube of intact matter that a 3-D particle stands for, or of the square section of a ring [m].
///
/// Particles that lie as they were created tile their body exactly: solid matter shows no pattern of particles. Bounded
/// by the cell, because a ring driven onto the axis would otherwise grow without limit.
pub fn size(space: Space, particles: &Particles, i: usize, cell: f64) -> f64 {
    let volume = f64::from(particles.mass[i]) / f64::from(particles.density[i]);
    let side = match space {
        Space::Full { .. } => math::cbrt(volume),
        Space::Line | Space::Axisymmetric => (volume / (2.0 * PI * f64::from(particles.position[1][i]))).sqrt(),
    };
    side.min(cell)
}

/// Signs of (x, y, z) of a stored particle and of its mirror images.
pub fn images(space: Space) -> Vec<[f64; 3]> {
    let (y, z) = match space {
        Space::Full { mirror_y, mirror_z } => (mirror_y, mirror_z),
        Space::Line | Space::Axisymmetric => (false, false),
    };
    let both = |mirrored: bool| if mirrored { &[1.0, -1.0][..] } else { &[1.0][..] };
    both(y).iter().flat_map(|&sy| both(z).iter().map(move |&sz| [1.0, sy, sz])).collect()
}

/// Position of particle `i` in its mirror image `sign` [m].
pub fn place(particles: &Particles, i: usize, sign: [f64; 3]) -> [f64; 3] {
    let at = |axis: usize| particles.position[axis].get(i).map_or(0.0, |&x| f64::from(x) * sign[axis]);
    [at(0), at(1), at(2)]
}

/// Mass per pixel [kg] on a film: exposures add up.
pub struct Plate {
    /// Where the pixels lie.
    pub raster: Raster,
    /// `[height][width]`, the top row first.
    pub mass: Vec<f64>,
}

impl Plate {
    /// An unexposed film.
    pub fn new(raster: Raster) -> Plate {
        Plate { raster, mass: vec![0.0; raster.pixels()] }
    }

    /// Adds one state of `run` as seen by `camera`; `sides` [m] says how far each particle is smeared.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn expose(
        &mut self,
        run: &Impact,
        p: &Particles,
        sides: &[f64],
        camera: &Camera,
        ctx: &Ctx<'_>,
    ) -> Result<(), Cancelled> {
        self.expose_body(run, p, sides, camera, None, ctx)
    }

    /// As [`Plate::expose`], of one body only, by its number.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn expose_body(
        &mut self,
        run: &Impact,
        p: &Particles,
        sides: &[f64],
        camera: &Camera,
        body: Option<usize>,
        ctx: &Ctx<'_>,
    ) -> Result<(), Cancelled> {
        let images = images(run.space);
        for i in 0..p.mass.len() {
            if body.is_some_and(|b| usize::from(p.body[i]) != b) {
                continue;
            }
            if i % 4096 == 0 {
                ctx.tick(i as f64, p.mass.len() as f64, "projecting")?;
            }
            let (mass, side) = (f64::from(p.mass[i]), sides[i]);
            for &sign in &images {
                let at = place(p, i, sign);
                match run.space {
                    Space::Full { .. } => self.add_box(camera.project(at), side, mass),
                    _ if camera.is_edge_on() => self.add_band(at[0], at[1], side, mass),
                    _ => self.add_ring(camera, at[0], at[1], side, mass),
                }
            }
        }
        Ok(())
    }

    /// A square of side `side` about `centre`, of even mass.
    fn add_box(&mut self, centre: [f64; 2], side: f64, mass: f64) {
        let r = self.raster;
        let (half, across) = ((0.5 * side / r.pixel).max(NARROWEST), (centre[0] - r.left) / r.pixel);
        let down = (r.top - centre[1]) / r.pixel;
        // Mass per pixel inside the square; at its edges the part of the pixel that it covers.
        let full = mass / (4.0 * half * half);
        let span = |middle: f64, count: u32| {
            let (low, high) = (middle - half, middle + half);
            (low, high, low.floor().max(0.0), high.ceil().min(f64::from(count)))
        };
        let (left, right, first, last) = span(across, r.width);
        let (top, bottom, upper, lower) = span(down, r.height);
        let part = |edge: f64, low: f64, high: f64| ((edge + 1.0).min(high) - edge.max(low)).max(0.0);
        for row in upper as usize..lower.max(upper) as usize {
            let share = full * part(row as f64, top, bottom);
            let line = &mut self.mass[row * r.width as usize..];
            for column in first as usize..last.max(first) as usize {
                line[column] += share * part(column as f64, left, right);
            }
        }
    }

    /// A ring of square section seen edge-on: its exact projection, that of the annulus between r -+ side/2.
    ///
    /// The thin ring's kernel is 1 / (pi sqrt(r^2 - y^2)); over a pixel row it integrates to arcsines, which stay finite.
    fn add_band(&mut self, x: f64, r: f64, side: f64, mass: f64) {
        let raster = self.raster;
        let (inner, outer) = ((r - 0.5 * side).max(0.0), r + 0.5 * side);
        let area = PI * (outer * outer - inner * inner);
        let (half, across) = (0.5 * side / raster.pixel, (x - raster.left) / raster.pixel);
        let columns: Vec<_> = covered(across, half, raster.width).collect();
        let rows = covered(raster.top / raster.pixel, outer / raster.pixel, raster.height);
        let above = |y: f64| disc_above(outer, y) - disc_above(inner, y);
        let mut upper = None;
        for (row, _) in rows {
            let edge = raster.top - row as f64 * raster.pixel;
            let over = upper.unwrap_or_else(|| above(edge));
            let under = above(edge - raster.pixel);
            upper = Some(under);
            let share = mass * (under - over) / area;
            for &(column, part) in &columns {
                self.mass[row * raster.width as usize + column] += share * part;
            }
        }
    }

    /// A ring seen at an angle: points along it, closer than half of what one of them covers.
    fn add_ring(&mut self, camera: &Camera, x: f64, r: f64, side: f64, mass: f64) {
        let step = 0.5 * side.max(self.raster.pixel);
        let n = (2.0 * PI * r / step).ceil().max(8.0);
        let (turn_sin, turn_cos) = (math::sin(2.0 * PI / n), math::cos(2.0 * PI / n));
        // Turning a unit vector step by step costs two products a point; its error after n < 1e5 turns is below 1e-11.
        let (mut s, mut c) = (math::sin(PI / n), math::cos(PI / n));
        for _ in 0..n as usize {
            self.add_box(camera.project([x, r * c, r * s]), side, mass / n);
            (s, c) = (s * turn_cos + c * turn_sin, c * turn_cos - s * turn_sin);
        }
    }
}

/// Pixels of `0..count` that the interval `centre -+ half` (in pixels) covers, each with its share of the interval.
pub fn covered(centre: f64, half: f64, count: u32) -> impl Iterator<Item = (usize, f64)> {
    let half = half.max(NARROWEST);
    let (low, high) = (centre - half, centre + half);
    let (first, last) = (low.floor().max(0.0), high.ceil().min(f64::from(count)));
    (0..(last - first).max(0.0) as usize).map(move |k| {
        let edge = first + k as f64;
        let overlap = (edge + 1.0).min(high) - edge.max(low);
        (edge as usize, overlap.max(0.0) / (high - low))
    })
}

/// Area of the disc of `radius` above the height `y` over its centre.
fn disc_above(radius: f64, y: f64) -> f64 {
    if y >= radius {
        return 0.0;
    }
    if y <= -radius {
        return PI * radius * radius;
    }
    let r2 = radius * radius;
    r2 * (0.5 * PI - libm::asin(y / radius)) - y * (r2 - y * y).sqrt()
}

/// Bounds (low, high) on the film of particle `i` in its image `sign`, its size not included [m].
pub fn bounds(space: Space, camera: &Camera, p: &Particles, i: usize, sign: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let at = place(p, i, sign);
    if matches!(space, Space::Full { .. }) {
        let here = camera.project(at);
        return (here, here);
    }
    let centre = camera.project([at[0], 0.0, 0.0]);
    let reach = |axis: [f64; 3]| at[1] * (axis[1] * axis[1] + axis[2] * axis[2]).sqrt();
    let (du, dv) = (reach(camera.right), reach(camera.up));
    ([centre[0] - du, centre[1] - dv], [centre[0] + du, centre[1] + dv])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance: the rounding of pixel coordinates near 10 over the narrowest interval, 2e-4 pixels.
    #[test]
    fn shares_of_an_interval_sum_to_one() {
        for (centre, half) in [(0.5, 0.2), (2.2, 1.7), (3.5, 1.5), (1.0, 0.0)] {
            let sum: f64 = covered(centre, half, 10).map(|c| c.1).sum();
            assert!((sum - 1.0).abs() < 1e-10, "{centre} -+ {half}: {sum}");
        }
        let inside: f64 = covered(1.0, 2.0, 10).map(|c| c.1).sum();
        assert!((inside - 0.75).abs() < 1e-15);
        assert_eq!(covered(-3.0, 1.0, 10).count() + covered(13.0, 1.0, 10).count(), 0);
    }

    /// The circular segment above h r has the area r^2 (acos h - h sqrt(1 - h^2)); acos(1/2) = pi/3.
    #[test]
    fn segment_of_a_disc() {
        assert!((disc_above(2.0, 0.0) - 2.0 * PI).abs() < 1e-14);
        let h: f64 = 0.5;
        let expected = 9.0 * (PI / 3.0 - h * (1.0 - h * h).sqrt());
        assert!((disc_above(3.0, 1.5) - expected).abs() < 1e-13);
    }
}
