//! What a result shows of itself to a person: plain data, drawn by the program, never by a stage.
use serde::{Deserialize, Serialize};

/// A number or a word with its name and unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scalar {
    /// What it is, e.g. `"pressure"`.
    pub name: String,
    /// Unit of the number as shown, `""` where it has none.
    pub unit: String,
    /// The value.
    pub value: Cell,
}
impl Scalar {
    /// A number in the unit given.
    pub fn number(name: &str, value: f64, unit: &str) -> Scalar {
        Scalar { name: name.into(), unit: unit.into(), value: Cell::Number(value) }
    }
    /// A word.
    pub fn text(name: &str, value: impl Into<String>) -> Scalar {
        Scalar { name: name.into(), unit: String::new(), value: Cell::Text(value.into()) }
    }
}

/// One cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// A number, in its column's unit.
    Number(f64),
    /// A number and its standard error, in its column's unit.
    Uncertain(f64, f64),
    /// A word.
    Text(String),
    /// Nothing known.
    Empty,
}
impl From<f64> for Cell {
    fn from(x: f64) -> Cell {
        Cell::Number(x)
    }
}
impl From<&str> for Cell {
    fn from(x: &str) -> Cell {
        Cell::Text(x.into())
    }
}
impl From<String> for Cell {
    fn from(x: String) -> Cell {
        Cell::Text(x)
    }
}

/// A table; `rows[i].len() == columns.len()`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Heading; also the name of its CSV file.
    pub title: String,
    /// Name and unit of each column.
    pub columns: Vec<(String, String)>,
    /// The cells.
    pub rows: Vec<Vec<Cell>>,
    /// Source, method, what to make of it; may be empty.
    pub note: String,
}

/// One axis of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// What is drawn along it.
    pub label: String,
    /// Its unit, `""` where it has none.
    pub unit: String,
    /// Logarithmic.
    pub log: bool,
}
impl Axis {
    /// A linear axis.
    pub fn linear(label: &str, unit: &str) -> Axis {
        Axis { label: label.into(), unit: unit.into(), log: false }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Style {
    /// A solid line through the points.
    Line,
    /// A dashed line through the points.
    Dashed,
    /// Filled dots.
    Dots,
    /// Open circles.
    Circles,
    /// Crosses.
    Crosses,
    /// Triangles.
    Triangles,
}

/// One set of points in a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Its name in the legend; empty: not in the legend.
    pub label: String,
    /// How it is drawn.
    pub style: Style,
    /// (x, y) in the axes' units.
    pub points: Vec<(f64, f64)>,
    /// Standard errors of y, one a point, or empty.
    pub errors: Vec<f64>,
}
impl Series {
    /// A series without error bars.
    pub fn new(label: &str, style: Style, points: Vec<(f64, f64)>) -> Series {
        Series { label: label.into(), style, points, errors: Vec::new() }
    }
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Heading; also the name of its SVG file.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn, the first at the back.
    pub series: Vec<Series>,
    /// Source, method, what to make of it; may be empty.
    pub note: String,
}

/// A picture of pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Heading; also the name of its PNG file.
    pub title: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `[height][width][3]` red, green, blue; the top row first.
    pub rgb: Vec<u8>,
    /// Colour, what it means; empty where the note says all.
    pub legend: Vec<([u8; 3], String)>,
    /// Source, scale, what to make of it; may be empty.
    pub note: String,
}

/// Atoms of one kind in a periodic box, at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Time [ps].
    pub time: f64,
    /// Edges of the box [angstrom].
    pub edges: [f64; 3],
    /// `[atoms][3]`, each atom at the same place of every frame, folded into the box [angstrom].
    pub positions: Vec<[f64; 3]>,
    /// `[atoms][3]` [angstrom/ps].
    pub velocities: Vec<[f64; 3]>,
}

/// Atoms as they move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Heading; also the name of its extended XYZ file.
    pub title: String,
    /// Symbol of the element.
    pub element: String,
    /// In order of time.
    pub frames: Vec<Frame>,
}

/// One value at each point of a cloud, or a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Its name; no `/`.
    pub name: String,
    /// Numbers a point: 1, or 3 of a vector.
    pub width: usize,
    /// `[points][width]`.
    pub values: Vec<f32>,
}

/// A cloud at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Time [s].
    pub time: f64,
    /// `[points][3]` [m].
    pub points: Vec<[f32; 3]>,
    /// The same ones at each moment.
    pub fields: Vec<Field>,
}

/// Points with values, as they move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cloud {
    /// Heading; also the name of its VTKHDF file.
    pub title: String,
    /// In order of time.
    pub moments: Vec<Moment>,
}

/// A text to take along: a result as a file that a program reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// Heading; also the name of its file.
    pub title: String,
    /// The file's extension, e.g. `"toml"`.
    pub extension: String,
    /// Its content.
    pub text: String,
}

/// One part of a drawing; coordinates in the drawing's unit, y upwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A closed outline, filled.
    Outline {
        /// Its corners.
        corners: Vec<[f64; 2]>,
        /// Which of the drawing's bodies it belongs to: each has a colour.
        body: usize,
    },
    /// A disc, filled.
    Disc {
        /// Its middle.
        centre: [f64; 2],
        /// Its radius.
        radius: f64,
        /// Which of the drawing's bodies it belongs to.
        body: usize,
    },
    /// An arrow, as of a velocity, with words at its tail.
    Arrow {
        /// Its tail.
        from: [f64; 2],
        /// Its tip.
        to: [f64; 2],
        /// What it means.
        text: String,
    },
    /// A length between two points, with its value.
    Length {
        /// One end.
        from: [f64; 2],
        /// The other.
        to: [f64; 2],
        /// Its value, with unit.
        text: String,
    },
    /// A line that is no matter: an axis or a plane of symmetry.
    Axis {
        /// One end.
        from: [f64; 2],
        /// The other.
        to: [f64; 2],
    },
}

/// A drawing to scale, the same scale both ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drawing {
    /// Heading; also the name of its SVG file.
    pub title: String,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// What is drawn, the first at the back.
    pub shapes: Vec<Shape>,
    /// Source, scale, what to make of it; may be empty.
    pub note: String,
}

/// Something to look at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the variants' types say it")]
pub enum View {
    Table(Table),
    Figure(Figure),
    Picture(Picture),
    Trajectory(Trajectory),
    Cloud(Cloud),
    Text(Text),
    Drawing(Drawing),
}
