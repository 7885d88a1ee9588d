//! The scene before anything moves, drawn from its parameters: Figs 7, 10 and 13 of the paper.
use crate::bodies::{self, Piece};
use crate::params::{Params, SpaceChoice};
use crate::scene::Layout;
use crate::solid::Solid;
use hvi_kit::view::{Drawing, Shape, View};

/// Rows that a shape without an outline of its own is drawn with.
const ROWS: usize = 160;
/// Plates are shown this many projectile sizes to either side.
const ASIDE: f64 = 1.1;

/// A section through the scene along the line of flight; nothing on a line, which has no width.
pub fn scene(params: &Params) -> Vec<View> {
    if params.space() == SpaceChoice::Line {
        return Vec::new();
    }
    let layout = Layout::of(params);
    let section = Section { up: if params.space() == SpaceChoice::Axisymmetric { 1 } else { 2 }, params };
    let pieces = bodies::pieces(params, &layout);
    let half = ASIDE * layout.diameter.max(params.projectile.size()).max(reach(params, section.up));
    let mut shapes = Vec::new();
    for (body, piece) in pieces.iter().enumerate() {
        section.body(&mut shapes, body, &piece.solid, half);
    }
    section.sizes(&mut shapes, &pieces, half);
    let back = pieces.iter().map(|p| p.solid.bounds().1[0]).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let front = -1.9 * params.projectile.size();
    if params.space() == SpaceChoice::Axisymmetric {
        shapes.push(Shape::Axis { from: mm([front, 0.0]), to: mm([back + 0.4 * half, 0.0]) });
    }
    let name = |p: &Piece<'_>| format!("{}: {}", p.name, p.material.name);
    vec![View::Drawing(Drawing {
        title: "Set-up".into(),
        bodies: pieces.iter().map(name).collect(),
        shapes,
        note: note(params, &layout, half),
    })]
}

/// How far the further bodies reach from the axis [m].
fn reach(params: &Params, up: usize) -> f64 {
    let far = |s: &Solid| s.bounds().0[up].abs().max(s.bounds().1[up].abs());
    params.bodies.values().map(|b| far(&b.shape)).filter(|x| x.is_finite()).fold(0.0, f64::max)
}

fn note(params: &Params, layout: &Layout, half: f64) -> String {
    let space = match params.space() {
        SpaceChoice::Line | SpaceChoice::Axisymmetric => "turned about the dashed axis",
        SpaceChoice::Quarter => "a quarter of it is computed, between two planes of symmetry",
        SpaceChoice::Half => "half of it is computed, up to a plane of symmetry",
        SpaceChoice::Full => "all of it is computed",
    };
    let whole = if layout.width > 2.0 * half {
        format!(" The plate goes on to {} mm across.", digits(1e3 * layout.width))
    } else {
        String::new()
    };
    format!(
        "Section through the scene, {space}. Cells of {} mm, {} particles a cell along each axis; to {} µs.{whole}",
        digits(1e3 * layout.cell),
        params.particles,
        digits(1e6 * layout.end)
    )
}

fn mm(x: [f64; 2]) -> [f64; 2] {
    x.map(|x| 1e3 * x)
}

/// Three digits, no trailing zeros.
fn digits(x: f64) -> String {
    format!("{}", format!("{x:.2e}").parse::<f64>().unwrap_or(x))
}

/// The plane that is drawn: x to the right, the axis `up` upwards.
struct Section<'a> {
    up: usize,
    params: &'a Params,
}

impl Section<'_> {
    fn body(&self, out: &mut Vec<Shape>, body: usize, solid: &Solid, half: f64) {
        let (low, high) = solid.bounds();
        let span = [low[self.up].max(-half), high[self.up].min(half)];
        let plain = self.params.voids.is_empty();
        match solid {
            Solid::Sphere { centre, diameter } if plain && self.in_plane(solid) => {
                let centre = [centre[0].si(), centre[self.up].si()];
                out.push(Shape::Disc { centre: mm(centre), radius: 0.5e3 * diameter.si(), body });
                self.mirror(out, centre[1]);
            }
            Solid::Cylinder { from, to, .. } if plain && self.in_plane(solid) && is_level(from, to) => {
                self.rectangle(out, body, [low[0], high[0]], span);
            }
            Solid::Box { .. } if plain => self.rectangle(out, body, [low[0], high[0]], span),
            _ => self.sampled(out, body, solid, [low[0], high[0]], span),
        }
    }

    /// Whether the shape's middle lies in the plane drawn.
    fn in_plane(&self, solid: &Solid) -> bool {
        let (low, high) = solid.bounds();
        let other = 3 - self.up;
        (low[other] + high[other]).abs() <= 1e-9 * (high[other] - low[other])
    }

    /// The last shape again below the axis, where the section is turned about it and the shape stands clear of it.
    fn mirror(&self, out: &mut Vec<Shape>, middle: f64) {
        if self.up == 2 || middle == 0.0 {
            return;
        }
        let turned = match out.last() {
            Some(Shape::Disc { centre, radius, body }) => {
                Shape::Disc { centre: [centre[0], -centre[1]], radius: *radius, body: *body }
            }
            Some(Shape::Outline { corners, body }) => {
                Shape::Outline { corners: corners.iter().map(|c| [c[0], -c[1]]).collect(), body: *body }
            }
            _ => return,
        };
        out.push(turned);
    }

    fn rectangle(&self, out: &mut Vec<Shape>, body: usize, x: [f64; 2], y: [f64; 2]) {
        let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]].map(mm).into();
        out.push(Shape::Outline { corners, body });
        let middle = y[0] + y[1];
        self.mirror(out, if middle.abs() < 1e-9 * (y[1] - y[0]) { 0.0 } else { middle });
    }

    /// Any shape, row by row, where it holds matter and no void does.
    fn sampled(&self, out: &mut Vec<Shape>, body: usize, solid: &Solid, x: [f64; 2], y: [f64; 2]) {
        let (dx, dy) = ((x[1] - x[0]) / ROWS as f64, (y[1] - y[0]) / ROWS as f64);
        if !(dx > 0.0 && dy > 0.0 && dx.is_finite()) {
            return;
        }
        let holds = |i: usize, j: usize| {
            let mut at = [x[0] + (i as f64 + 0.5) * dx, 0.0, 0.0];
            at[self.up] = y[0] + (j as f64 + 0.5) * dy;
            solid.holds(at) && !self.params.voids.iter().any(|v| v.holds(at))
        };
        for j in 0..ROWS {
            let mut begun = None;
            for i in 0..=ROWS {
                let inside = i < ROWS && holds(i, j);
                match (begun, inside) {
                    (None, true) => begun = Some(i),
                    (Some(from), false) => {
                        let row = y[0] + j as f64 * dy;
                        let across = [from, i].map(|k| x[0] + k as f64 * dx);
                        self.rectangle(out, body, across, [row, row + dy]);
                        begun = None;
                    }
                    _ => {}
                }
            }
        }
    }

    /// Lengths of projectile and plate, and the arrow of the impact.
    fn sizes(&self, out: &mut Vec<Shape>, pieces: &[Piece<'_>], half: f64) {
        let p = &self.params.projectile;
        let (low, high) = pieces[0].solid.bounds();
        let label = |x: f64| format!("{} mm", digits(1e3 * x));
        let gap = 0.12 * half;
        if let Some(diameter) = p.diameter {
            let x = low[0] - gap;
            let ends = [low[self.up], high[self.up]].map(|y| mm([x, y]));
            out.push(Shape::Length { from: ends[0], to: ends[1], text: label(diameter.si()) });
        }
        if let Some(length) = p.length {
            let y = high[self.up] + gap;
            out.push(Shape::Length { from: mm([low[0], y]), to: mm([high[0], y]), text: label(length.si()) });
        }
        let t = self.params.plate.thickness.si();
        out.push(Shape::Length { from: mm([0.0, -half - gap]), to: mm([t, -half - gap]), text: label(t) });
        let (sin, cos) = {
            let v = bodies::flight(self.params);
            let speed = (v[0] * v[0] + v[2] * v[2]).sqrt();
            (v[2] / speed, v[0] / speed)
        };
        let (start, length) = (low[0] - 0.5 * half, 0.35 * half);
        let to = [start, 0.5 * (low[self.up] + high[self.up])];
        out.push(Shape::Arrow {
            from: mm([to[0] - length * cos, to[1] - length * sin]),
            to: mm(to),
            text: format!("{} km/s", digits(1e-3 * self.params.velocity.si())),
        });
    }
}

fn is_level(from: &crate::solid::Place, to: &crate::solid::Place) -> bool {
    from[1] == to[1] && from[2] == to[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing(toml: serde_json::Value) -> Drawing {
        let params: Params = serde_json::from_value(toml).unwrap();
        let View::Drawing(drawing) = scene(&params).remove(0) else { panic!("a drawing") };
        drawing
    }

    #[test]
    fn fig_7_of_the_paper() {
        let d = drawing(serde_json::json!({
            "projectile": { "shape": "sphere", "diameter": "20 mm", "material": "aluminium" },
            "plate": { "material": "copper", "thickness": "1.5 mm" },
            "velocity": "5.75 km/s",
        }));
        assert_eq!(d.bodies, ["projectile: aluminium", "plate: copper"]);
        let radius =
            d.shapes.iter().find_map(|s| if let Shape::Disc { radius, .. } = s { Some(*radius) } else { None });
        assert!((radius.unwrap() - 10.0).abs() < 1e-9);
        let said = |text: &str| {
            d.shapes.iter().any(|s| match s {
                Shape::Length { text: t, .. } | Shape::Arrow { text: t, .. } => t == text,
                _ => false,
            })
        };
        assert!(said("20 mm") && said("1.5 mm") && said("5.75 km/s"), "{:?}", d.shapes);
    }

    /// A shell is drawn row by row: its area in the section is that of a ring, to the width of a row.
    #[test]
    fn any_body_is_drawn() {
        let d = drawing(serde_json::json!({
            "projectile": { "shape": "cylinder", "diameter": "4 mm", "length": "2 mm", "material": "copper" },
            "plate": { "material": "aluminium", "thickness": "1 mm" },
            "velocity": "5 km/s",
            "space": "half",
            "angle": "30 deg",
            "bodies": { "tank": { "shape": { "shell": { "centre": ["10 mm", "0 mm", "0 mm"], "diameter": "8 mm",
                "thickness": "1 mm" } }, "material": "aluminium" } },
        }));
        let area = |s: &Shape| match s {
            Shape::Outline { corners, body: 2 } => (corners[1][0] - corners[0][0]) * (corners[2][1] - corners[1][1]),
            _ => 0.0,
        };
        let found: f64 = d.shapes.iter().map(area).sum();
        let ring = std::f64::consts::PI * (16.0 - 9.0);
        // Half a sample at either end of each of 160 rows with up to two pieces: 2 % of the ring.
        assert!((found / ring - 1.0).abs() < 0.02, "{found} {ring}");
        assert!(!d.note.is_empty());
    }
}
