//! The symmetric planar impact in closed form, and how far a run is from it.
use crate::Measure;
use hvi_eos::Eos;
use hvi_impact::result::{Impact, Space};

/// Quantities of the run at its end against the closed form; nothing where it is not a planar impact of one metal on itself with
/// both shocks on their way, or the metal's Hugoniot does not reach so far.
///
/// With the impact speed v at x = 0, t = 0, matter between the shocks at `Us t` and `(v - Us) t` moves at `up = v/2` and has the
/// pressure and density of the Hugoniot at `up` (Rankine and Hugoniot); all else is as it was. Strength is not in it.
pub fn planar(run: &Impact, eos: &Eos) -> Vec<Measure> {
    let (Some(end), [projectile, plate]) = (run.snapshots.last(), run.bodies.as_slice()) else { return Vec::new() };
    if run.space != Space::Line || projectile.material != plate.material {
        return Vec::new();
    }
    let Ok(shock) = eos.hugoniot_at_velocity(0.5 * run.velocity) else { return Vec::new() };
    let reach = (run.velocity - shock.shock_velocity) * end.time;
    let ahead = shock.shock_velocity * end.time;
    let p = &end.particles;
    let rows = || (0..p.mass.len()).map(|i| [p.position[0][i], p.mass[i], p.pressure[i], p.density[i]].map(f64::from));
    let ends = rows().fold((f64::INFINITY, f64::NEG_INFINITY), |e, r| (e.0.min(r[0]), e.1.max(r[0])));
    if !(reach > ends.0 && ahead < ends.1) {
        return Vec::new();
    }
    let shocked = |x: f64| x > reach && x < ahead;
    let off: f64 = rows().map(|r| r[1] * (r[2] - if shocked(r[0]) { shock.pressure } else { 0.0 }).abs()).sum();
    let mass: f64 = rows().filter(|r| shocked(r[0])).map(|r| r[1]).sum();
    // The plateau: the middle half of each shocked layer, away from the contact, where the first cells err for good, and the front.
    let middle = 0.5 * run.velocity * end.time;
    let plateau = |x: f64| {
        let share = if x > middle { (x - middle) / (ahead - middle) } else { (middle - x) / (middle - reach) };
        (0.25..0.75).contains(&share)
    };
    let mean = |of: usize| {
        let sums = rows().filter(|r| plateau(r[0])).fold((0.0, 0.0), |s, r| (s.0 + r[1] * r[of], s.1 + r[1]));
        sums.0 / sums.1
    };
    vec![
        Measure::exact("pressure behind the shock", "GPa", mean(2) / 1e9, shock.pressure / 1e9),
        Measure::exact("density behind the shock", "kg/m3", mean(3), 1.0 / shock.volume),
        Measure::deviation("pressure profile", off / (mass * shock.pressure)),
    ]
}
