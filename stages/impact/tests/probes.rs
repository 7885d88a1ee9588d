//! What is followed through a run, against what is known of it; bodies from STL files.
mod common;
use common::{aluminium, copper, planar, run, try_run_with};
use hvi_impact::result::{At, Impact, Passed, Track};
use hvi_impact::{ImpactStage, Params};
use hvi_kit::{Ctx, File, Stage};
use serde_json::{Value, json};
use std::collections::BTreeMap;

fn states<'a>(impact: &'a Impact, name: &str) -> &'a [At] {
    match &impact.probes.iter().find(|p| p.name == name).expect("a probe").track {
        Track::Point(all) | Track::Particle(all) => all,
        Track::Plane(_) => panic!("{name} is a plane"),
    }
}

/// Aluminium on aluminium at 6.7 km/s: Rankine-Hugoniot of S1's constants gives 89.92 GPa and 3350 m/s (the specification of S1), with
/// the shock at 9930 m/s. A place 5 mm into the target and the particle that was there see it, +-1 % (single particles scatter, the
/// battery has the means); the particle has moved on with the flow, +-1 cell.
#[test]
fn a_place_and_a_particle_in_a_plane_shock() {
    let arrival = 5e-3 / 9930.0;
    let mut params = planar(aluminium(), aluminium(), 6700.0, 100, &[], 1.5 * arrival);
    params["probes"] = json!({
        "points": { "place": ["5 mm", "0 mm", "0 mm"], "nowhere": ["50 mm", "0 mm", "0 mm"] },
        "particles": { "grain": ["5 mm", "0 mm", "0 mm"] },
        "samples": 60,
    });
    let impact = run(params);
    let (place, grain) = (states(&impact, "place"), states(&impact, "grain"));
    assert!((58..=61).contains(&place.len()) && grain.len() == place.len(), "{}", place.len());
    for track in [place, grain] {
        let (first, last) = (&track[0], track.last().unwrap());
        assert!(first.time == 0.0 && first.pressure.abs() < 1e6 && first.velocity == [0.0; 3]);
        assert!((last.pressure / 89.92e9 - 1.0).abs() < 0.01, "{:e} Pa", last.pressure);
        assert!((last.velocity[0] / 3350.0 - 1.0).abs() < 0.01 && (last.density / 2703.0 / 1.5091 - 1.0).abs() < 0.01);
        // Half way up the front.
        let passed = track.iter().find(|a| a.pressure > 45e9).unwrap().time;
        assert!((passed / arrival - 1.0).abs() < 0.05, "{passed:e} s, expected {arrival:e} s");
    }
    let moved = grain.last().unwrap().position[0] - grain[0].position[0];
    assert!((moved - 0.5 * arrival * 3350.0).abs() < 1e-4, "{moved:e} m");
    assert!(states(&impact, "nowhere").iter().all(|a| a.pressure.is_nan()));
    let own: f64 = impact.ledger.last().unwrap().by_phase.iter().flatten().sum();
    let sum: f64 = impact.ledger.last().unwrap().internal.iter().sum();
    assert!((own / sum - 1.0).abs() < 1e-12);
}

/// What has passed a plane in the debris' way is what lies beyond it, mirror images included: mass to the f32 of a snapshot,
/// momentum and energy to what they change after they have passed, 5 %.
#[test]
fn planes_count_what_passes() {
    for (space, copies) in [("axisymmetric", 1.0), ("quarter", 4.0)] {
        let impact = run(json!({
            "projectile": { "shape": "sphere", "diameter": "4 mm", "material": aluminium() },
            "plate": { "thickness": "1 mm", "width": "8 mm", "material": aluminium() },
            "velocity": "6 km/s", "cells": 2, "space": space, "end": "2 us",
            "probes": { "planes": { "behind": "4 mm", "before": "-60 mm" } },
        }));
        let last = |name: &str| -> Passed {
            match &impact.probes.iter().find(|p| p.name == name).expect("a probe").track {
                Track::Plane(all) => *all.last().unwrap(),
                _ => panic!("{name} is a plane"),
            }
        };
        let p = &impact.snapshots[0].particles;
        let beyond = |value: &dyn Fn(usize) -> f64| -> f64 {
            (0..p.mass.len()).filter(|&i| p.position[0][i] >= 4e-3).map(|i| copies * p.mass[i] as f64 * value(i)).sum()
        };
        let (found, mass) = (last("behind"), beyond(&|_| 1.0));
        assert!(found.mass > 1e-6 && (found.mass / mass - 1.0).abs() < 1e-5, "{space}: {} kg, {mass} kg", found.mass);
        let momentum = beyond(&|i| p.velocity[0][i] as f64);
        assert!((found.momentum / momentum - 1.0).abs() < 0.05, "{space}: {} {momentum}", found.momentum);
        let kinetic = beyond(&|i| (0..3).map(|d| 0.5 * f64::from(p.velocity[d][i]).powi(2)).sum());
        assert!((found.kinetic / kinetic - 1.0).abs() < 0.05, "{space}: {} {kinetic}", found.kinetic);
        assert_eq!(last("before"), Passed { time: 2e-6, ..Passed::default() });
    }
}

/// A binary STL of the box between `low` and `high`, without its first `skip` triangles.
fn stl(low: [f32; 3], high: [f32; 3], skip: usize) -> File {
    let corner = |k: usize| -> [f32; 3] { std::array::from_fn(|d| if k >> d & 1 == 1 { high[d] } else { low[d] }) };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[usize; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let mut out = vec![b' '; 80];
    out.extend((triangles.len() as u32 - skip as u32).to_le_bytes());
    for t in &triangles[skip..] {
        out.extend([0; 12]);
        t.iter().flat_map(|&k| corner(k)).for_each(|x| out.extend(x.to_le_bytes()));
        out.extend([0; 2]);
    }
    File(out)
}

fn with_mesh() -> Value {
    json!({
        "projectile": { "shape": "sphere", "diameter": "2 mm", "material": aluminium() },
        "plate": { "thickness": "1 mm", "width": "4 mm", "material": aluminium() },
        "velocity": "5 km/s", "cells": 2, "space": "half", "end": "0.8 us",
        "meshes": { "part": { "unit": "1 mm" } },
        "bodies": { "block": {
            "shape": { "difference": [
                { "mesh": { "name": "part", "at": ["2 mm", "0 mm", "0 mm"] } },
                { "sphere": { "centre": ["2 mm", "0 mm", "0 mm"], "diameter": "1 mm" } },
            ] },
            "material": copper(),
        } },
    })
}

fn files(file: File) -> BTreeMap<String, File> {
    [("meshes.part.file".to_string(), file)].into()
}

/// A box of triangles is the box, bit by bit, also inside a combined shape.
#[test]
fn a_mesh_is_its_shape() {
    let params = with_mesh();
    let mesh =
        try_run_with(params.clone(), files(stl([0.0, -1.0, -1.5], [1.5, 1.0, 1.5], 0)), &Ctx::quiet()).expect("runs");
    let mut plain = params;
    plain["meshes"] = json!({});
    plain["bodies"]["block"]["shape"]["difference"][0] =
        json!({ "box": { "from": ["2 mm", "-1 mm", "-1.5 mm"], "to": ["3.5 mm", "1 mm", "1.5 mm"] } });
    let plain = run(plain);
    assert!(mesh.bodies[2].mass > 0.9 * 8930.0 * 9e-9 && mesh.bodies == plain.bodies);
    assert_eq!(mesh.snapshots, plain.snapshots);
}

/// Surfaces that can't be used are refused before the run, with the key and the numbers.
#[test]
fn what_is_wrong_with_a_mesh_is_named() {
    let cube = || stl([0.0, -1.0, -1.5], [1.5, 1.0, 1.5], 0);
    let refused = |change: &dyn Fn(&mut Value), files: BTreeMap<String, File>| {
        let mut params = with_mesh();
        change(&mut params);
        let params: Params = serde_json::from_value(params).expect("parameters");
        let checked = ImpactStage::check(&params).and_then(|()| ImpactStage::check_files(&params, &files));
        let invalid = checked.expect_err("refused");
        (invalid.key, invalid.why)
    };
    let none: &dyn Fn(&mut Value) = &|_| ();
    let (key, why) = refused(none, files(stl([0.0; 3], [1.0; 3], 1)));
    assert!(key == "meshes.part.file" && why.contains("not closed: 3 of 18 edges"), "{key} {why}");
    let (key, why) = refused(none, BTreeMap::new());
    assert!(key == "meshes.part.file" && why.contains("missing"), "{key} {why}");
    let (key, why) = refused(none, [("projectile.file".to_string(), cube())].into());
    assert!(key == "projectile.file" && why.contains("meshes.NAME.file"), "{key} {why}");
    let other: &dyn Fn(&mut Value) = &|p| p["bodies"]["block"]["shape"] = json!({ "mesh": { "name": "pat" } });
    let (key, why) = refused(other, files(cube()));
    assert!(key == "bodies.block.shape" && why.contains("`pat`") && why.contains("part"), "{key} {why}");
    let near: &dyn Fn(&mut Value) =
        &|p| p["bodies"]["block"]["shape"]["difference"][0]["mesh"]["at"][0] = json!("0.5 mm");
    let (key, why) = refused(near, files(cube()));
    assert!(key == "bodies.block.shape" && why.contains("overlaps `plate`"), "{key} {why}");
    let small: &dyn Fn(&mut Value) = &|p| p["meshes"]["part"]["unit"] = json!("0.1 mm");
    let (key, why) = refused(small, files(cube()));
    assert!(key == "bodies.block.shape" && why.contains("cells of 0.5000 mm"), "{key} {why}");
    let (key, why) = refused(
        &|p| p["probes"] = json!({ "points": { "a": ["0 mm", "1 mm", "0 mm"] } }),
        [("plate.file".to_string(), cube())].into(),
    );
    assert!(key == "plate.file" && why.contains("no place"), "{key} {why}");
    let (key, why) = refused(
        &|p| {
            p["space"] = json!("axisymmetric");
            p["probes"] = json!({ "points": { "a": ["0 mm", "1 mm", "2 mm"] } });
        },
        files(cube()),
    );
    assert!(key == "probes.points.a" && why.contains("z = 2 mm"), "{key} {why}");
}
