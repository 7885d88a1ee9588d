//! What a GRAY says of melting, in a few numbers that experiments know: at no pressure, on the Hugoniot, after release.
use crate::model::gray::Gray;
use crate::{Eos, curve::Shock};
use hvi_kit::math::bisect;
use serde::{Deserialize, Serialize};

/// One number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Landmark {
    /// What it is.
    pub name: String,
    /// Its unit, for people.
    pub unit: String,
    /// Its value; `None` where the model's range ends before it.
    pub value: Option<f64>,
}

/// Highest pressure looked at [Pa].
const HIGHEST: f64 = 500e9;

/// The landmarks of `gray`, in a fixed order.
pub fn landmarks(gray: &Gray) -> Vec<Landmark> {
    let eos = Eos::Gray(gray.clone());
    let melting = [0, 1].map(|k| free_border(gray, k));
    let latent = match melting {
        [Some((_, solid)), Some((_, liquid))] => Some((liquid - solid) * gray.parameters().molar_mass / 1e3),
        _ => None,
    };
    let shock = [1e-9, 1.0 - 1e-9].map(|level| crossing(&eos, |s| s.liquid - level, 1e6));
    let release =
        [1e-7, 1.0 - 1e-7].map(|level| crossing(&eos, |s| eos.release(s).map_or(1.0, |r| r.liquid) - level, 2e7));
    let pressure = |s: Option<Shock>| s.map(|s| s.pressure / 1e9);
    let speed = |s: Option<Shock>| s.map(|s| 2.0 * s.particle_velocity / 1e3);
    let mark = |name: &str, unit: &str, value| Landmark { name: name.into(), unit: unit.into(), value };
    vec![
        mark("melting at P = 0 begins", "K", melting[0].map(|m| m.0)),
        mark("melting at P = 0 ends", "K", melting[1].map(|m| m.0)),
        mark("latent heat at P = 0", "kJ/mol", latent),
        mark("Hugoniot enters melting", "GPa", pressure(shock[0])),
        mark("Hugoniot leaves melting", "GPa", pressure(shock[1])),
        mark("release to P = 0 begins to melt, shocked to", "GPa", pressure(release[0])),
        mark("release to P = 0 melts wholly, shocked to", "GPa", pressure(release[1])),
        mark("symmetric impact that begins to melt on release", "km/s", speed(release[0])),
        mark("symmetric impact that melts wholly on release", "km/s", speed(release[1])),
    ]
}

/// Temperature [K] and energy [J/kg] of border `k` of the melting band (0 begins, 1 ends) at P = 0.
fn free_border(gray: &Gray, k: usize) -> Option<(f64, f64)> {
    let v0 = gray.parameters().volume;
    let at = |v: f64| gray.at(v, gray.borders(v)[k]).0;
    let v = bisect(0.95 * v0, 1.3 * v0, 1e-14 * v0, |v| at(v).pressure)?;
    Some((gray.borders(v)[k], at(v).energy))
}

/// The shock between 10 GPa and [`HIGHEST`] at which `measure` passes zero, to `tolerance` [Pa].
fn crossing(eos: &Eos, measure: impl Fn(&Shock) -> f64, tolerance: f64) -> Option<Shock> {
    let at = |p: f64| eos.hugoniot_at_pressure(p).map_or(1.0, |s| measure(&s));
    let pressure = bisect(10e9, HIGHEST, tolerance, at)?;
    eos.hugoniot_at_pressure(pressure).ok()
}
