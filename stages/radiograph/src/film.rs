//! The exposed film: what a radiograph leaves, and how it is shown.
use crate::camera::Raster;
use crate::phases::PhaseMap;
use crate::scale_bar;
use crate::shape::{self, Shape};
use crate::xray::Exposed;
use hvi_kit::view::{Picture, Scalar, View};
use hvi_kit::{Artifact, math};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How mass per area becomes grey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Logarithm of the mass per area over two decades: thin cloud and solid plate both show.
    #[default]
    Log,
    /// In proportion to the mass per area, as the count of material points in the paper's section 5.
    Linear,
}

/// An X-ray-like image of one run: mass along the line of sight, summed over the exposures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Direction of the view, in words.
    pub view: String,
    /// Times of the exposures [s].
    pub exposures: Vec<f64>,
    /// Where the pixels lie.
    pub raster: Raster,
    /// Mass per area of film [kg/m2], `[height][width]`, the top row first.
    pub density: Vec<f32>,
    /// Mass of all matter, once for every exposure [kg].
    pub mass: f64,
    /// Part of it that lies in the frame [kg].
    pub caught: f64,
    /// Whether gaps between particles were filled.
    pub smooth: bool,
    /// How mass per area becomes grey.
    pub tone: Tone,
    /// Mass per area that is full black [kg/m2].
    pub black: f64,
    /// Impact speed [m/s].
    pub velocity: f64,
    /// The physical X-ray film, where one was asked for.
    pub exposed: Option<Exposed>,
    /// What the cloud measures, one an exposure that has a cloud.
    pub shapes: Vec<Shape>,
    /// Cross-sections coloured by phase, one an exposure.
    pub phases: Vec<PhaseMap>,
}

/// Two decades below full black are told apart on the logarithmic scale.
const DECADES_RATIO: f64 = 100.0;

impl Film {
    /// Mass per area that 99.5 % of the exposed pixels stay below [kg/m2]: full black where none is asked for.
    pub fn auto_black(density: &[f32]) -> f64 {
        let mut exposed: Vec<f32> = density.iter().copied().filter(|&d| d > 0.0).collect();
        if exposed.is_empty() {
            return 1.0;
        }
        exposed.sort_by(f32::total_cmp);
        f64::from(exposed[(exposed.len() - 1) * 199 / 200])
    }

    /// Blackness 0..1 of a mass per area [kg/m2].
    pub fn blackness(&self, density: f64) -> f64 {
        let share = (density / self.black).min(1.0);
        match self.tone {
            Tone::Linear => share,
            Tone::Log => math::log(1.0 + share * DECADES_RATIO) / math::log(1.0 + DECADES_RATIO),
        }
    }

    /// The film as grey pixels: dark where there is much mass.
    pub fn picture(&self) -> Picture {
        let mut rgb = Vec::with_capacity(3 * self.density.len());
        for &density in &self.density {
            let grey = (255.0 * (1.0 - self.blackness(f64::from(density)))).round() as u8;
            rgb.extend([grey; 3]);
        }
        let times: Vec<String> = self.exposures.iter().map(|&t| microseconds(t)).collect();
        let scale = match self.tone {
            Tone::Log => "the logarithm of the mass per area over two decades",
            Tone::Linear => "in proportion to the mass per area",
        };
        let outside = 100.0 * (1.0 - self.caught / self.mass);
        let note = format!(
            "Density projection: mass along the line of sight, dark where there is much. Grey is {scale}; full black is \
             {} kg/m2 or more. {}{}A pixel is {} mm; {} % of the mass lies outside the frame.",
            digits(self.black),
            if times.len() > 1 { format!("{} exposures add up on one film. ", times.len()) } else { String::new() },
            if self.smooth { "Where a cloud has thinned, particles are smeared up to their neighbours. " } else { "" },
            digits(self.raster.pixel * 1e3),
            digits(outside.max(0.0)),
        );
        let picture = Picture {
            title: format!("Film, {}, {}", self.view, times.join(" + ")),
            width: self.raster.width,
            height: self.raster.height,
            rgb,
            legend: Vec::new(),
            note,
        };
        scale_bar::add(picture, self.raster.pixel)
    }
}

/// A time in microseconds, in words.
pub fn microseconds(seconds: f64) -> String {
    format!("{} µs", digits(seconds * 1e6))
}

/// A number with three digits and no trailing zeros.
pub fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let text = format!("{x:.2e}");
    let value: f64 = text.parse().unwrap_or(x);
    if (1e-4..1e6).contains(&value.abs()) { format!("{value}") } else { text }
}

impl Artifact for Film {
    const KIND: &'static str = "film/2";

    fn scalars(&self) -> Vec<Scalar> {
        vec![
            Scalar::number("full black", self.black, "kg/m2"),
            Scalar::number("pixel", self.raster.pixel * 1e3, "mm"),
            // To the digits that the single-precision masses hold: their sums differ in the last ones.
            Scalar::number("mass in frame", (1e4 * self.caught / self.mass).round() / 100.0, "%"),
        ]
    }

    fn views(&self) -> Vec<View> {
        let film = View::Picture(self.picture());
        let times: Vec<String> = self.exposures.iter().map(|&t| microseconds(t)).collect();
        let title = format!("X-ray, {}, {}", self.view, times.join(" + "));
        let exposed = self.exposed.iter().map(|e| View::Picture(e.picture(self.raster, title.clone())));
        let mut all: Vec<View> = std::iter::once(film)
            .chain(exposed)
            .chain(self.phases.iter().map(|map| View::Picture(map.picture())))
            .collect();
        if !self.shapes.is_empty() {
            all.push(View::Table(shape::table(&self.shapes, self.velocity)));
            all.push(View::Figure(shape::figure(&self.shapes)));
        }
        all
    }
}
