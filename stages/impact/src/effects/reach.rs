//! The states that a scene brings its bodies' matter to, before there is an equation of state of theirs: by the handbook's.
use super::estimate::{impedance_match, melting};
use crate::bodies::pieces;
use crate::material::Material;
use crate::params::Params;
use crate::scene::Layout;
use hvi_eos::Eos;
use hvi_eos::curve::Shock;
use hvi_kit::{ByInput, Reach, Reached};

/// States on a way of shock, and as many of release.
const STATES: usize = 16;
/// Steps of the release between two of them.
const STEPS: usize = 20;

/// By the key of each body's equation of state: the shock into it from the impedance match with each body that it can meet, and
/// release from there to where pressure is gone; two bodies that rest meet as debris of one of them, at the highest speed of all.
/// Nothing where the handbook knows no such shock.
///
/// Left out: shocks after the first, which heat less for the same volume; jets; what strength and viscosity heat.
pub fn reach(params: &Params) -> ByInput {
    let settled = params.settled();
    let layout = Layout::of(&settled);
    let all = pieces(&settled, &layout);
    let between = |i: usize, j: usize| {
        let squares = (0..3).map(|d| all[i].velocity[d] - all[j].velocity[d]).map(|v| v * v);
        squares.sum::<f64>().sqrt()
    };
    let fastest =
        (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| between(i, j)).fold(0.0, f64::max);
    let of = |i: usize| {
        let others = (0..all.len()).filter(|&j| j != i).map(|j| {
            // Two that rest may still meet: the first one's debris flies at up to the impact's speed.
            let speed = if between(i, j) > 0.0 { between(i, j) } else { fastest };
            way([all[i].material, all[j].material], speed)
        });
        others.collect::<Option<Vec<_>>>().map(|ways| Reach { ways })
    };
    (0..all.len()).map(|i| (format!("{}.eos", all[i].key), of(i))).collect()
}

/// The way of the first of two materials that meet at `speed` [m/s].
fn way(materials: [&Material; 2], speed: f64) -> Option<Vec<Reached>> {
    let [first, second] = materials.map(|m| &m.eos);
    let shock = impedance_match([first, second], speed)?[0];
    let mut way = Vec::with_capacity(2 * STATES + 1);
    let rest = first.reference_volume();
    for i in 0..=STATES {
        let volume = rest + (shock.volume - rest) * i as f64 / STATES as f64;
        let on = first.hugoniot(volume).ok()?;
        way.push(reached(materials[0], first, on.volume, on.energy));
    }
    way.extend(release(materials[0], first, &shock)?);
    Some(way)
}

fn release(material: &Material, eos: &Eos, shock: &Shock) -> Option<Vec<Reached>> {
    let end = eos.release(shock).ok()?;
    let step = (end.volume - shock.volume) / STATES as f64;
    let (mut volume, mut energy) = (shock.volume, shock.energy);
    let mut states = Vec::with_capacity(STATES);
    for _ in 0..STATES {
        energy = eos.isentrope(volume, energy, volume + step, STEPS);
        volume += step;
        states.push(reached(material, eos, volume, energy));
    }
    Some(states)
}

fn reached(material: &Material, eos: &Eos, volume: f64, energy: f64) -> Reached {
    let at = eos.point(volume, energy);
    let melts = eos.melting_temperature(volume).unwrap_or_else(|| melting(material, eos));
    Reached {
        volume_ratio: volume / eos.reference_volume(),
        temperature: at.temperature,
        pressure: at.pressure,
        homologous: at.temperature / melts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn reach_at(velocity: f64) -> ByInput {
        let copper = |more: serde_json::Value| {
            let mut body = json!({ "material": "copper" });
            body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            body
        };
        let written = json!({
            "projectile": copper(json!({ "shape": "sphere", "diameter": "5 mm" })),
            "plate": copper(json!({ "thickness": "2.5 mm" })),
            "velocity": format!("{velocity} m/s"),
        });
        reach(&serde_json::from_value(written).unwrap())
    }

    /// Like on like, u_p is half the speed; copper's Us = 3940 + 1.489 u_p (Marsh 1980) gives pressure and volume. The handbook's
    /// equation of state is not that line, hence 3 %.
    #[test]
    fn the_shock_is_that_of_the_impedance_match() {
        for v in [2000.0, 5000.0] {
            let all = reach_at(v);
            let keys: Vec<&str> = all.iter().map(|(key, _)| key.as_str()).collect();
            assert_eq!(keys, ["projectile.eos", "plate.eos"]);
            let reach = all[0].1.as_ref().unwrap();
            assert_eq!(all[0].1, all[1].1);
            let (up, us) = (0.5 * v, 3940.0 + 1.489 * 0.5 * v);
            assert!((reach.highest_pressure() / (8930.0 * us * up) - 1.0).abs() < 0.03, "{}", reach.words());
            assert!((reach.volume_ratios()[0] / (1.0 - up / us) - 1.0).abs() < 0.03, "{}", reach.words());
            assert!(reach.volume_ratios()[1] > 1.0);
        }
    }

    /// Copper begins to melt on release from 4.30 km/s on, by the handbook's release states: far below it comes nowhere near.
    #[test]
    fn slow_copper_does_not_come_near_melting_and_fast_copper_does() {
        let melting = |v: f64| reach_at(v)[0].1.as_ref().unwrap().melting_pressure(0.8);
        assert_eq!(melting(1000.0), None);
        assert!(melting(6000.0).unwrap() > 5e9);
    }
}
