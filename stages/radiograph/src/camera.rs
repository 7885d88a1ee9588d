//! From which direction the film is exposed, and which part of the film plane it covers.
use hvi_kit::math;
use hvi_kit::units::{Angle, Length};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Direction of the view: `"side"`, `"top"`, `"front"` or `{ azimuth = "30 deg", elevation = "10 deg" }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "\"side\", \"top\", \"front\" or { azimuth = \"30 deg\", elevation = \"10 deg\" }")]
pub enum View {
    /// By name.
    Named(Named),
    /// By angles.
    Angles(Angles),
}
impl Default for View {
    fn default() -> Self {
        View::Named(Named::Side)
    }
}

/// Views that have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Named {
    /// Across the impact direction, which points to the right; +y is up.
    Side,
    /// From +y, across the impact direction, which points to the right.
    Top,
    /// Against the impact direction: the cloud comes towards the viewer.
    Front,
}

/// A view by two turns of the viewer away from the side view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Angles {
    /// Turn about the upright axis; 0 is the side view, 90 deg the front view.
    #[serde(default = "no_turn")]
    pub azimuth: Angle,
    /// Rise above the horizontal plane; 90 deg is the view from the top.
    #[serde(default = "no_turn")]
    pub elevation: Angle,
}

fn no_turn() -> Angle {
    Angle::new(0.0)
}

/// The film plane: two orthogonal unit vectors in the run's (x, y, z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Horizontal on the film, to the right.
    pub right: [f64; 3],
    /// Vertical on the film, upwards.
    pub up: [f64; 3],
}

impl Camera {
    /// The film plane of `view`.
    pub fn new(view: View) -> Camera {
        match view {
            View::Named(Named::Side) => Camera { right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] },
            View::Named(Named::Top) => Camera { right: [1.0, 0.0, 0.0], up: [0.0, 0.0, -1.0] },
            View::Named(Named::Front) => Camera { right: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0] },
            View::Angles(angles) => {
                let (a, e) = (angles.azimuth.si(), angles.elevation.si());
                let (sin_a, cos_a, sin_e, cos_e) = (math::sin(a), math::cos(a), math::sin(e), math::cos(e));
                Camera { right: [cos_a, 0.0, -sin_a], up: [-sin_a * sin_e, cos_e, -cos_a * sin_e] }
            }
        }
    }

    /// Film coordinates (right, up) [m] of a point [m].
    pub fn project(&self, p: [f64; 3]) -> [f64; 2] {
        let dot = |a: [f64; 3]| a[0] * p[0] + a[1] * p[1] + a[2] * p[2];
        [dot(self.right), dot(self.up)]
    }

    /// Whether the impact direction lies along the film's horizontal: rings are then seen edge-on.
    pub fn is_edge_on(&self) -> bool {
        self.right == [1.0, 0.0, 0.0]
    }
}

/// The view in words, for titles.
pub fn describe(view: View) -> String {
    match view {
        View::Named(Named::Side) => "side view".into(),
        View::Named(Named::Top) => "view from the top".into(),
        View::Named(Named::Front) => "front view".into(),
        View::Angles(a) => {
            let degrees = |x: Angle| (x.si() * 180.0 / std::f64::consts::PI * 100.0).round() / 100.0;
            format!("azimuth {}°, elevation {}°", degrees(a.azimuth), degrees(a.elevation))
        }
    }
}

/// A rectangle of the film plane, in film coordinates (right, up).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Lower left corner.
    pub from: [Length; 2],
    /// Upper right corner.
    pub to: [Length; 2],
}

/// Square pixels over a rectangle of the film plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Raster {
    /// Left edge [m].
    pub left: f64,
    /// Upper edge [m].
    pub top: f64,
    /// Side of a pixel [m].
    pub pixel: f64,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Raster {
    /// `width` pixels across the rectangle from the corner `low` to the corner `high` [m]; whole pixels about its middle height.
    pub fn over(low: [f64; 2], high: [f64; 2], width: u32) -> Raster {
        let pixel = (high[0] - low[0]) / f64::from(width);
        // A hair less than the quotient, so that a frame meant as whole pixels doesn't get one more by rounding.
        let height = ((high[1] - low[1]) / pixel - 1e-6).ceil().max(1.0);
        let top = 0.5 * (low[1] + high[1]) + 0.5 * height * pixel;
        Raster { left: low[0], top, pixel, width, height: height as u32 }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}
