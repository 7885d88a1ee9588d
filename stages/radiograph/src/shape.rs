//! The measures that experimenters take from a film: the cloud's length, width, outline and leading edge, and the hole.
use crate::project::{images, place};
use hvi_impact::result::{Impact, Particles, Snapshot, Space};
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table};
use serde::{Deserialize, Serialize};

/// Matter moving along the impact faster than this share of its speed is cloud; slower matter stays with the plate.
const MOVING: f64 = 0.05;
/// Share of the cloud's mass beyond its front, and beyond its sides: strays that no film shows.
const STRAYS: f64 = 0.005;
/// Share of the cloud's mass that makes its leading edge.
const EDGE: f64 = 0.01;
/// Slices along the impact that the outline has.
const SLICES: usize = 48;

/// What a debris cloud and the hole measure, at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Time [s].
    pub time: f64,
    /// Matter counts as cloud beyond this x [m]: two cells behind the rear of the plate as it was.
    pub rear: f64,
    /// From the plate's rear to the front of the cloud; 0.5 % of its mass is farther [m].
    pub length: f64,
    /// Its greatest width; 0.5 % of its mass is farther out [m].
    pub width: f64,
    /// Mean velocity along the impact of the leading 1 % of its mass [m/s].
    pub front_speed: f64,
    /// Diameter of the hole: of the circle that has no more than 0.5 % of the plate's matter near it inside [m].
    pub hole: f64,
    /// x, and the radii that 5 % and 99.5 % of the mass of a slice lie within [m].
    pub outline: Vec<[f64; 3]>,
    /// Mass of the cloud [kg].
    pub mass: f64,
}

impl Shape {
    /// Measures `shot` of `run`; nothing on a line, which has no width, and before there is a cloud.
    pub fn of(run: &Impact, shot: &Snapshot) -> Option<Shape> {
        if run.space == Space::Line {
            return None;
        }
        let (p, copies) = (&shot.particles, images(run.space).len() as f64);
        let rear = run.thickness + 2.0 * run.cell;
        let cloud: Vec<usize> = (0..p.mass.len()).filter(|&i| is_cloud(run, p, i, rear)).collect();
        let weigh =
            |of: &dyn Fn(usize) -> f64| cloud.iter().map(|&i| (of(i), f64::from(p.mass[i]))).collect::<Vec<_>>();
        let x = |i: usize| f64::from(p.position[0][i]);
        let mass: f64 = cloud.iter().map(|&i| f64::from(p.mass[i])).sum();
        if !(mass > 0.0) {
            return None;
        }
        let front = quantile(weigh(&x), 1.0 - STRAYS);
        let edge = quantile(weigh(&x), 1.0 - EDGE);
        let (mut ahead, mut momentum) = (0.0, 0.0);
        for &i in cloud.iter().filter(|&&i| x(i) >= edge) {
            ahead += f64::from(p.mass[i]);
            momentum += f64::from(p.mass[i]) * f64::from(p.velocity[0][i]);
        }
        Some(Shape {
            time: shot.time,
            rear,
            length: front - run.thickness,
            width: 2.0 * quantile(weigh(&|i| radius(p, i)), 1.0 - STRAYS),
            front_speed: momentum / ahead,
            hole: hole(run, p),
            outline: outline(p, &cloud, rear, front),
            mass: copies * mass,
        })
    }

    /// Whether particle `i` counts as cloud.
    pub fn holds(&self, run: &Impact, p: &Particles, i: usize) -> bool {
        is_cloud(run, p, i, self.rear)
    }
}

fn is_cloud(run: &Impact, p: &Particles, i: usize, rear: f64) -> bool {
    f64::from(p.position[0][i]) > rear && f64::from(p.velocity[0][i]) > MOVING * run.velocity
}

/// Distance from the axis [m].
fn radius(p: &Particles, i: usize) -> f64 {
    let [_, y, z] = place(p, i, [1.0; 3]);
    (y * y + z * z).sqrt()
}

/// What stays of the plate within two thicknesses of it is the hole's rim and all beyond.
fn hole(run: &Impact, p: &Particles) -> f64 {
    let Some(plate) = run.bodies.iter().position(|b| b.name == "plate") else { return 0.0 };
    let stays = |i: &usize| {
        let x = f64::from(p.position[0][*i]);
        usize::from(p.body[*i]) == plate
            && f64::from(p.velocity[0][*i]).abs() < MOVING * run.velocity
            && x > -2.0 * run.thickness
            && x < 3.0 * run.thickness
    };
    let near = (0..p.mass.len()).filter(stays).filter(|&i| radius(p, i) < 4.0 * run.diameter);
    2.0 * quantile(near.map(|i| (radius(p, i), f64::from(p.mass[i]))).collect(), STRAYS)
}

fn outline(p: &Particles, cloud: &[usize], rear: f64, front: f64) -> Vec<[f64; 3]> {
    let width = (front - rear) / SLICES as f64;
    let mut slices: Vec<Vec<(f64, f64)>> = vec![Vec::new(); SLICES];
    for &i in cloud {
        let at = ((f64::from(p.position[0][i]) - rear) / width).floor();
        if (0.0..SLICES as f64).contains(&at) {
            slices[at as usize].push((radius(p, i), f64::from(p.mass[i])));
        }
    }
    let middle = |k: usize| rear + (k as f64 + 0.5) * width;
    let filled = slices.into_iter().enumerate().filter(|(_, s)| !s.is_empty());
    filled.map(|(k, s)| [middle(k), quantile(s.clone(), 0.05), quantile(s, 1.0 - STRAYS)]).collect()
}

/// The value below which the share `share` of the weight lies; 0 of nothing.
fn quantile(mut weighted: Vec<(f64, f64)>, share: f64) -> f64 {
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = share * weighted.iter().map(|w| w.1).sum::<f64>();
    for &(value, weight) in &weighted {
        if weight >= left {
            return value;
        }
        left -= weight;
    }
    weighted.last().map_or(0.0, |w| w.0)
}

/// The measures of several times side by side.
pub fn table(shapes: &[Shape], velocity: f64) -> Table {
    let columns = [
        ("time", "us"),
        ("length", "mm"),
        ("width", "mm"),
        ("length over width", ""),
        ("leading edge", "km/s"),
        ("leading edge over impact speed", ""),
        ("hole", "mm"),
        ("mass of the cloud", "g"),
    ];
    let row = |s: &Shape| {
        let numbers = [
            s.time * 1e6,
            s.length * 1e3,
            s.width * 1e3,
            s.length / s.width,
            s.front_speed * 1e-3,
            s.front_speed / velocity,
            s.hole * 1e3,
            s.mass * 1e3,
        ];
        numbers.map(Cell::Number).to_vec()
    };
    Table {
        title: "Shape of the debris cloud".into(),
        columns: columns.map(|(n, u)| (n.to_string(), u.to_string())).to_vec(),
        rows: shapes.iter().map(row).collect(),
        note: "Cloud: matter behind the plate that moves along the impact at more than 5 % of its speed. Length: from the plate's \
               rear to where 0.5 % of the cloud's mass is ahead; width: to where 0.5 % is farther out. Leading edge: mean velocity of \
               the leading 1 % of the mass. Hole: 0.5 % of the plate's matter that stays lies within it."
            .into(),
    }
}

/// The outlines of several times: side profiles, as far as mass goes, and the hollow within.
pub fn figure(shapes: &[Shape]) -> Figure {
    let mut series = Vec::new();
    for s in shapes {
        let along = |k: usize| s.outline.iter().map(|o| (o[0] * 1e3, o[k] * 1e3)).collect::<Vec<_>>();
        series.push(Series::new(&crate::film::microseconds(s.time), Style::Line, along(2)));
        series.push(Series::new("", Style::Dashed, along(1)));
    }
    Figure {
        title: "Outline of the debris cloud".into(),
        x: Axis::linear("distance from the plate's front", "mm"),
        y: Axis::linear("radius", "mm"),
        series,
        note: "Solid: 99.5 % of the mass of a slice lies within; dashed: 5 %, so a cloud whose dashed line is off the axis is hollow.".into(),
    }
}
