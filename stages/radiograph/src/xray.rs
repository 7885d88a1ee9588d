//! A physical X-ray film: attenuation along the line of sight by material and photon energy, blur, motion, response of the film.
use crate::attenuation;
use crate::camera::{Camera, Raster};
use crate::project::Plate;
use crate::scale_bar;
use hvi_impact::result::{Impact, Particles, Snapshot, Space};
use hvi_kit::units::{Energy, Length, Time};
use hvi_kit::view::Picture;
use hvi_kit::{Ctx, Invalid, StageError, math};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The source, and the film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Xray {
    /// Photon energy, 10 keV to 1 MeV: a flash tube's spectrum as one energy, its effective one.
    pub energy: Energy,
    /// Full width at half maximum of the blur in the plane of the cloud: focal spot and screen together. Default: 0.3 mm.
    #[serde(default = "blur")]
    pub blur: Length,
    /// How long a flash lasts. Default: 20 ns.
    #[serde(default = "pulse")]
    pub pulse: Time,
    /// Optical density of film that one flash reaches unhindered, above `fog` and below `darkest`. Default: 1.5.
    #[serde(default = "clear")]
    pub clear: f64,
    /// Optical density of unexposed film. Default: 0.2.
    #[serde(default = "fog")]
    pub fog: f64,
    /// Optical density that no exposure exceeds. Default: 3.5.
    #[serde(default = "darkest")]
    pub darkest: f64,
}

fn blur() -> Length {
    Length::new(0.3e-3)
}
fn pulse() -> Time {
    Time::new(20e-9)
}
fn clear() -> f64 {
    1.5
}
fn fog() -> f64 {
    0.2
}
fn darkest() -> f64 {
    3.5
}

/// A Gaussian's full width at half maximum over its standard deviation, `2 sqrt(2 ln 2)`.
const WIDTH: f64 = 2.354_820_045_030_949;
/// Instants that a flash is made of, at most.
const MOST_INSTANTS: usize = 8;

impl Xray {
    /// Checks ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(&self) -> Result<(), Invalid> {
        let energy = self.energy.si() / attenuation::KEV;
        if !(10.0..=1000.0).contains(&energy) {
            return Err(Invalid::new("xray.energy", format!("is {energy} keV, must lie between 10 keV and 1 MeV")));
        }
        if !(self.blur.si() >= 0.0 && self.blur.si() <= 0.1) {
            return Err(Invalid::new("xray.blur", "must lie between 0 and 100 mm"));
        }
        if !(self.pulse.si() >= 0.0 && self.pulse.si() <= 1e-5) {
            return Err(Invalid::new("xray.pulse", "must lie between 0 and 10 us"));
        }
        if !(self.fog >= 0.0 && self.fog < self.clear && self.clear < self.darkest && self.darkest <= 10.0) {
            let why = "optical densities must rise from `fog` over `clear` to `darkest`, from 0 to 10";
            return Err(Invalid::new("xray.clear", why));
        }
        Ok(())
    }

    /// Optical density of film after the exposure `flashes`, in units of one unhindered flash.
    ///
    /// `D = fog + (darkest - fog) (1 - exp(-k E))`: each silver grain needs one photon of a direct X-ray film, so the curve is that of
    /// random hits (L. Silberstein, Philos. Mag. 44, 257 (1922)); k makes one flash leave `clear`.
    pub fn density(&self, flashes: f64) -> f64 {
        let span = self.darkest - self.fog;
        let rate = -math::log(1.0 - (self.clear - self.fog) / span);
        self.fog + span * (1.0 - math::exp(-rate * flashes))
    }
}

/// The exposed film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exposed {
    /// How it was exposed.
    pub by: Xray,
    /// Number of flashes.
    pub flashes: u32,
    /// Optical density, `[height][width]`, the top row first.
    pub density: Vec<f32>,
    /// Least share of a flash that came through anywhere.
    pub least: f64,
}

/// Exposes one film to a flash at each of `shots`; `sides` says how far each particle is smeared, a list a shot.
///
/// # Errors
/// [`StageError::Physics`] for a material of unknown attenuation; [`StageError::Cancelled`].
pub fn expose(
    xray: Xray,
    run: &Impact,
    shots: &[&Snapshot],
    sides: &[Vec<f64>],
    camera: &Camera,
    raster: Raster,
    ctx: &Ctx<'_>,
) -> Result<Exposed, StageError> {
    let of = |name: &str| attenuation::of(name, xray.energy.si()).map_err(StageError::physics);
    let coefficients: Vec<f64> = run.bodies.iter().map(|b| of(&b.material)).collect::<Result<_, _>>()?;
    let mut light = vec![0.0; raster.pixels()];
    let mut least: f64 = 1.0;
    for (shot, sides) in shots.iter().zip(sides) {
        let mut flash = vec![0.0; raster.pixels()];
        let instants = instants(&shot.particles, xray.pulse.si(), raster.pixel);
        for &instant in &instants {
            let moved = moved(run.space, &shot.particles, instant);
            let mut depth = vec![0.0; raster.pixels()];
            for (body, coefficient) in coefficients.iter().enumerate() {
                let mut plate = Plate::new(raster);
                plate.expose_body(run, &moved, sides, camera, Some(body), ctx)?;
                let share = coefficient / (raster.pixel * raster.pixel);
                depth.iter_mut().zip(&plate.mass).for_each(|(d, m)| *d += share * m);
            }
            let part = 1.0 / instants.len() as f64;
            flash.iter_mut().zip(&depth).for_each(|(f, d)| *f += part * math::exp(-d));
        }
        let flash = blurred(flash, raster, xray.blur.si() / WIDTH / raster.pixel);
        least = flash.iter().copied().fold(least, f64::min);
        light.iter_mut().zip(&flash).for_each(|(l, f)| *l += f);
    }
    let density = light.iter().map(|&l| xray.density(l) as f32).collect();
    Ok(Exposed { by: xray, flashes: shots.len() as u32, density, least })
}

/// Times about the middle of a flash, as many as the fastest matter passes pixels [s].
fn instants(p: &Particles, pulse: f64, pixel: f64) -> Vec<f64> {
    let fastest = p.velocity.iter().flatten().fold(0.0, |a: f64, &v| a.max(f64::from(v).abs()));
    let n = ((fastest * pulse / pixel).ceil() as usize).clamp(1, MOST_INSTANTS);
    (0..n).map(|k| pulse * ((k as f64 + 0.5) / n as f64 - 0.5)).collect()
}

/// The particles `by` seconds later.
fn moved(space: Space, p: &Particles, by: f64) -> Particles {
    let mut moved = p.clone();
    if by == 0.0 {
        return moved;
    }
    for (x, v) in moved.position.iter_mut().zip(&p.velocity) {
        x.iter_mut().zip(v).for_each(|(x, &v)| *x = (f64::from(*x) + by * f64::from(v)) as f32);
    }
    if space == Space::Axisymmetric {
        // What has crossed the axis is a ring on its other side.
        moved.position[1].iter_mut().for_each(|r| *r = r.abs().max(f32::MIN_POSITIVE));
    }
    moved
}

/// `light` convolved with a Gaussian of `sigma` pixels, as if it went on beyond the edges as it is there.
fn blurred(light: Vec<f64>, raster: Raster, sigma: f64) -> Vec<f64> {
    if sigma < 0.1 {
        return light;
    }
    let reach = (3.5 * sigma).ceil() as i64;
    let weights: Vec<f64> =
        (-reach..=reach).map(|k| math::exp(-0.5 * (k as f64 / sigma) * (k as f64 / sigma))).collect();
    let sum: f64 = weights.iter().sum();
    let (width, height) = (raster.width as usize, raster.height as usize);
    let pass = |from: &[f64], count: usize, stride: usize, lines: usize, step: usize| {
        let mut to = vec![0.0; from.len()];
        for line in 0..lines {
            for i in 0..count {
                let at = |k: i64| line * step + (i as i64 + k).clamp(0, count as i64 - 1) as usize * stride;
                let total: f64 = weights.iter().zip(-reach..).map(|(w, k)| w * from[at(k)]).sum();
                to[line * step + i * stride] = total / sum;
            }
        }
        to
    };
    let rows = pass(&light, width, 1, height, width);
    pass(&rows, height, width, width, 1)
}

impl Exposed {
    /// A print of the film, as papers show them: dark where matter held the flash back.
    pub fn picture(&self, raster: Raster, title: String) -> Picture {
        let (low, high) = (self.by.fog, self.by.density(f64::from(self.flashes)));
        let grey = |d: &f32| (255.0 * ((f64::from(*d) - low) / (high - low)).clamp(0.0, 1.0)).round() as u8;
        let rgb = self.density.iter().flat_map(|d| [grey(d); 3]).collect();
        let energy = self.by.energy.si() / attenuation::KEV;
        let note = format!(
            "X-ray film at {} keV, printed: white is film that all {} reached unhindered, of optical density {}, black unexposed film \
             of {}. Attenuation: {}. Blurred by {} mm; flashes of {} ns. At the darkest {} % of a flash came through.",
            crate::film::digits(energy),
            if self.flashes == 1 { "of the flash".into() } else { format!("{} flashes", self.flashes) },
            crate::film::digits(high),
            crate::film::digits(low),
            attenuation::SOURCE,
            crate::film::digits(self.by.blur.si() * 1e3),
            crate::film::digits(self.by.pulse.si() * 1e9),
            crate::film::digits(100.0 * self.least),
        );
        let picture = Picture { title, width: raster.width, height: raster.height, rgb, legend: Vec::new(), note };
        scale_bar::add(picture, raster.pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xray() -> Xray {
        Xray {
            energy: Energy::new(100.0 * attenuation::KEV),
            blur: blur(),
            pulse: pulse(),
            clear: clear(),
            fog: fog(),
            darkest: darkest(),
        }
    }

    #[test]
    fn the_film_darkens_and_saturates() {
        let x = xray();
        assert!((x.density(0.0) - 0.2).abs() < 1e-12 && (x.density(1.0) - 1.5).abs() < 1e-12);
        assert!(x.density(3.0) < 3.5 && x.density(3.0) > x.density(2.0));
        // Unlike light on silver, the first photons count as much as any: the curve starts straight.
        assert!((x.density(2e-4) - 0.2) / (x.density(1e-4) - 0.2) > 1.999);
    }

    /// A point becomes a Gaussian of the width asked for; no light is lost. The sum over pixels is the integral to 1e-3 here.
    #[test]
    fn blur_has_its_width_and_loses_nothing() {
        let raster = Raster { left: 0.0, top: 0.0, pixel: 1.0, width: 81, height: 61 };
        let mut light = vec![0.0; raster.pixels()];
        light[30 * 81 + 40] = 1.0;
        let sigma = 4.0;
        let out = blurred(light, raster, sigma);
        assert!((out.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let half = out[30 * 81 + 40] / 2.0;
        let reach = (0..40).find(|k| out[30 * 81 + 40 + k] < half).unwrap();
        assert!((2.0 * reach as f64 - WIDTH * sigma).abs() < 2.0, "{reach}");
        assert!(blurred(vec![1.0; 81 * 61], raster, 3.0).iter().all(|x| (x - 1.0).abs() < 1e-12), "edges");
    }
}
