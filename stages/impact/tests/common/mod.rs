//! What the tests of this folder share: runs by parameters, the materials of the yardstick scenes.
#![allow(dead_code, reason = "each test binary uses its part")]
use hvi_impact::result::{Impact, Particles};
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, File, Places, Stage, StageError};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Runs the stage as the executor would: parse, check, write back in canonical form, read again, run.
pub fn try_run(params: Value, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
    try_run_with(params, Default::default(), ctx)
}

/// The same, with files by key.
pub fn try_run_with(params: Value, files: BTreeMap<String, File>, ctx: &Ctx<'_>) -> Result<Impact, StageError> {
    let params: Params = serde_json::from_value(params).expect("parameters");
    ImpactStage::check(&params).expect("in range");
    ImpactStage::check_files(&params, &files).expect("in range");
    let canonical = serde_json::to_value(&params).expect("plain data");
    let params: Params = serde_json::from_value(canonical).expect("canonical parameters");
    ImpactStage::run(&params, ImpactInputs { eos: Places(Default::default()), file: Places(files) }, ctx)
}

pub fn run(params: Value) -> Impact {
    try_run(params, &Ctx::quiet()).expect("runs")
}

fn mie_gruneisen(density: f64, c0: f64, s: f64, gamma: f64, cp: f64) -> Value {
    json!({ "MieGruneisen": {
        "density": density, "sound_speed": c0, "slope": s, "gruneisen": gamma, "heat_capacity": cp,
        "reference_temperature": 293.0,
    } })
}

/// Aluminium of the yardstick scene S1.
pub fn aluminium() -> Value {
    json!({
        "name": "aluminium of S1", "young": "68.9 GPa", "poisson": 0.33,
        "strength": {
            "a": "324 MPa", "b": "114 MPa", "n": 0.42, "c": 0.002, "m": 1.34, "melting_temperature": "925 K",
        },
        "damage": { "d1": 1.0, "d2": 0.0, "d3": 0.0, "d4": 0.0, "d5": 0.0 },
        "spall": "1.2 GPa",
        "eos": mie_gruneisen(2703.0, 5240.0, 1.40, 1.97, 875.0),
    })
}

/// Copper of the planar scenes.
pub fn copper() -> Value {
    let mut copper = serde_json::to_value(hvi_impact::material::Material::named("copper").expect("shipped")).unwrap();
    copper["eos"] = mie_gruneisen(8930.0, 3940.0, 1.489, 2.02, 385.0);
    copper
}

/// Scene S1: aluminium sphere of 9.53 mm on a plate of 1.906 mm at 6.7 km/s.
pub fn s1(space: &str, cells: u32, end: &str) -> Value {
    json!({
        "projectile": { "shape": "sphere", "diameter": "9.53 mm", "material": aluminium() },
        "plate": { "thickness": "1.906 mm", "width": "38.12 mm", "material": aluminium() },
        "velocity": "6.7 km/s", "cells": cells, "space": space, "end": end,
    })
}

/// Two slabs of `cells` cells through 10 mm, strength and spall off, to time `end` [s], kept at `times` [s] too.
pub fn planar(flyer: Value, target: Value, velocity: f64, cells: u32, times: &[f64], end: f64) -> Value {
    let seconds = |t: &f64| format!("{t:?} s");
    json!({
        "projectile": { "shape": "slab", "length": "10 mm", "material": flyer },
        "plate": { "thickness": "10 mm", "material": target },
        "velocity": format!("{velocity:?} m/s"), "cells": cells, "space": "line",
        "times": times.iter().map(seconds).collect::<Vec<_>>(), "end": seconds(&end),
        "strength": false, "spall": false,
    })
}

/// Mean and relative scatter of `value` over the particles that `pick` takes.
pub fn mean(p: &Particles, value: impl Fn(usize) -> f64, pick: impl Fn(usize) -> bool) -> (f64, f64) {
    let picked: Vec<f64> = (0..p.mass.len()).filter(|&i| pick(i)).map(value).collect();
    assert!(picked.len() >= 20, "only {} particles", picked.len());
    let n = picked.len() as f64;
    let mean = picked.iter().sum::<f64>() / n;
    let variance = picked.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    (mean, variance.sqrt() / mean)
}

/// Largest drift of the energy in the ledger.
pub fn drift(impact: &Impact) -> f64 {
    impact.ledger.iter().map(|l| l.drift.abs()).fold(0.0, f64::max)
}

/// A valid scene at the least resolution: sizes, shapes, shipped materials (GRAY), 10 m/s to 30 km/s, effects on, off or decided by
/// estimates, one in eight oblique by up to 75 deg in half of three dimensions, one in five with friction. Steps `seed` on.
pub fn random_scene(seed: &mut u64) -> Value {
    let mut uniform = |from: f64, to: f64| {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        from + (to - from) * (*seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut pick = |names: [&'static str; 2]| names[(uniform(0.0, 2.0)) as usize];
    let (a, b, shape) = (pick(["copper", "aluminium"]), pick(["copper", "aluminium"]), pick(["sphere", "cylinder"]));
    let diameter = uniform(0.5, 8.0);
    let velocity = 10.0 * hvi_kit::math::pow(3000.0, uniform(0.0, 1.0));
    let mut params = json!({
        "projectile": { "shape": shape, "diameter": format!("{diameter:?} mm"), "material": a },
        "plate": {
            "thickness": format!("{:?} mm", diameter * uniform(0.3, 3.0)), "width": format!("{:?} mm", 2.5 * diameter),
            "material": b,
        },
        "velocity": format!("{velocity:?} m/s"), "cells": 2, "strength": uniform(0.0, 1.0) > 0.3,
        "damage": uniform(0.0, 1.0) > 0.3, "spall": uniform(0.0, 1.0) > 0.3,
    });
    if shape == "cylinder" {
        params["projectile"]["length"] = json!(format!("{:?} mm", diameter * uniform(0.3, 3.0)));
    }
    if uniform(0.0, 1.0) < 0.125 {
        (params["space"], params["angle"]) = (json!("half"), json!(format!("{:?} deg", uniform(0.0, 75.0))));
    }
    if uniform(0.0, 1.0) < 0.2 {
        params["friction"] = json!(uniform(0.0, 1.0));
    }
    if uniform(0.0, 1.0) < 0.2 {
        params["effects"] = json!("auto");
        params
            .as_object_mut()
            .expect("a table")
            .retain(|key, _| !["strength", "damage", "spall"].contains(&key.as_str()));
    }
    params
}

/// What is wrong with a run that ended: its ledger is open (rounding of 1e4 steps), or a particle's state is no number.
pub fn unsound(impact: &Impact) -> Option<String> {
    let (start, end) = (&impact.ledger[0], impact.ledger.last().expect("an end"));
    if drift(impact) > 1e-11 {
        return Some(format!("energy drift {:e}", drift(impact)));
    }
    let momentum = (end.momentum / start.momentum - 1.0).abs();
    if momentum >= 1e-10 {
        return Some(format!("momentum off by {momentum:e}"));
    }
    let p = &impact.snapshots.last().expect("an end").particles;
    (0..p.mass.len()).find_map(|i| {
        let sum = p.pressure[i] + p.temperature[i] + p.position[0][i] + p.velocity[0][i] + p.density[i];
        let sound = sum.is_finite() && p.energy[i] >= 0.0 && p.density[i] > 0.0;
        (!sound).then(|| format!("particle {i}: {sum}, {} J/kg, {} kg/m3", p.energy[i], p.density[i]))
    })
}
