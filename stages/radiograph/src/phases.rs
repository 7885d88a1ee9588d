//! The phase map: a cut along the impact axis, every particle coloured by its phase.
use crate::camera::{Camera, Raster};
use crate::film::microseconds;
use crate::project::{covered, images, place};
use crate::scale_bar;
use hvi_impact::result::{Impact, PHASES, Snapshot, Space};
use hvi_kit::view::Picture;
use serde::{Deserialize, Serialize};

/// Colours of the phases 0-4: told apart by lightness as well as hue, so also without red-green vision and in grey print.
pub const COLOURS: [[u8; 3]; 5] = [[190, 198, 206], [0, 92, 171], [0, 158, 115], [240, 170, 0], [160, 0, 90]];

/// No matter here.
const NOTHING: u8 = 255;

/// A cut through a run at one time, by phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseMap {
    /// Time [s].
    pub time: f64,
    /// Where the pixels lie, in (x, r) or (x, y).
    pub raster: Raster,
    /// Phase code, 255 where there is nothing; `[height][width]`, the top row first.
    pub code: Vec<u8>,
    /// Share of the whole scene's mass in each phase.
    pub shares: [f64; 5],
}

impl PhaseMap {
    /// The cut z = 0 through `run` at the time of `snapshot`; both halves of an axisymmetric run.
    pub fn new(run: &Impact, snapshot: &Snapshot, sides: &[f64], raster: Raster) -> PhaseMap {
        let p = &snapshot.particles;
        let camera = Camera { right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] };
        let mut map = PhaseMap { time: snapshot.time, raster, code: vec![NOTHING; raster.pixels()], shares: [0.0; 5] };
        let images = match run.space {
            Space::Full { .. } => images(run.space),
            Space::Line | Space::Axisymmetric => vec![[1.0; 3], [1.0, -1.0, 1.0]],
        };
        let mut total = 0.0;
        for i in 0..p.mass.len() {
            let phase = p.phase[i].min(4);
            map.shares[usize::from(phase)] += f64::from(p.mass[i]);
            total += f64::from(p.mass[i]);
            for &sign in &images {
                let at = place(p, i, sign);
                if at[2].abs() <= 0.5 * run.cell {
                    map.paint(camera.project(at), sides[i].min(run.cell), phase);
                }
            }
        }
        map.shares = map.shares.map(|m| m / total);
        map
    }

    /// A square of `side`, at least three pixels wide so that single particles show.
    fn paint(&mut self, at: [f64; 2], side: f64, phase: u8) {
        let r = self.raster;
        let half = (0.5 * side / r.pixel).max(1.5);
        for (row, share) in covered((r.top - at[1]) / r.pixel, half, r.height) {
            for (column, part) in covered((at[0] - r.left) / r.pixel, half, r.width) {
                // Only pixels that the square covers by half or more, or neighbours would overwrite each other's edges.
                if share.min(part) >= 0.49 * (0.5 / half) {
                    self.code[row * r.width as usize + column] = phase;
                }
            }
        }
    }

    /// The map as a picture with its legend.
    pub fn picture(&self) -> Picture {
        let colour = |&code: &u8| if code == NOTHING { [255; 3] } else { COLOURS[usize::from(code)] };
        let legend = (0..5)
            .map(|k| (COLOURS[k], format!("{k} {} ({:.1} % of the mass)", PHASES[k], 100.0 * self.shares[k])))
            .collect();
        let picture = Picture {
            title: format!("Phases at {}", microseconds(self.time)),
            width: self.raster.width,
            height: self.raster.height,
            rgb: self.code.iter().flat_map(colour).collect(),
            legend,
            note: "Cut along the impact axis. Phase at the volume of the intact matter: separated matter keeps the phase that its \
                   heat gives it. The shares are of the whole scene."
                .into(),
        };
        scale_bar::add(picture, self.raster.pixel)
    }
}
