//! Scenes of several bodies: shields, layers, oblique impact, combined shapes, voids; and what is refused of them.
mod common;
use common::{aluminium, copper, drift, run, s1};
use hvi_impact::result::Impact;
use hvi_impact::{ImpactStage, Params};
use hvi_kit::Stage;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A small sphere on a small plate in (r, z).
fn small() -> Value {
    json!({
        "projectile": { "shape": "sphere", "diameter": "4 mm", "material": aluminium() },
        "plate": { "thickness": "1 mm", "width": "10 mm", "material": aluminium() },
        "velocity": "6 km/s", "cells": 2,
    })
}

/// Sum over the particles of `body` of mass times velocity along `axis`, at the end [kg m/s].
fn momentum(impact: &Impact, body: u8, axis: usize) -> f64 {
    let p = &impact.snapshots.last().unwrap().particles;
    let of = |i: usize| f64::from(p.mass[i]) * f64::from(p.velocity[axis][i]);
    (0..p.mass.len()).filter(|&i| p.body[i] == body).map(of).sum()
}

/// A Whipple shield of three plates: each has the mass of its size, is at rest until the debris can be there (at the
/// impact speed), and is hit after; the ledger stays closed throughout.
#[test]
fn whipple_shield() {
    let mut params = small();
    params["plates"] = json!({
        "second": { "distance": "10 mm", "thickness": "1 mm", "material": copper() },
        "wall": { "distance": "20 mm", "thickness": "2 mm", "width": "16 mm", "material": aluminium() },
    });
    params["end"] = json!("9 us");
    let impact = run(params.clone());
    let names: Vec<&str> = impact.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["projectile", "plate", "second", "wall"]);
    let disc = |thickness: f64, width: f64| 0.25 * PI * width * width * thickness;
    for (body, mass) in [(2, 8930.0 * disc(1e-3, 10e-3)), (3, 2703.0 * disc(2e-3, 16e-3))] {
        assert!((impact.bodies[body].mass / mass - 1.0).abs() < 1e-12, "{}", impact.bodies[body].mass);
    }
    assert!(drift(&impact) <= 1e-11, "{:e}", drift(&impact));
    let start = impact.ledger[0].momentum;
    assert!((impact.ledger.last().unwrap().momentum / start - 1.0).abs() < 1e-11);
    assert!(momentum(&impact, 2, 0) > 0.05 * start && momentum(&impact, 3, 0) > 0.0);
    // Nothing moves faster than the sphere at first: 20 mm take 3.3 us and more.
    params["end"] = json!("3.4 us");
    let early = run(params);
    assert!(momentum(&early, 2, 0) > 0.0);
    assert_eq!(momentum(&early, 3, 0), 0.0);
}

/// A sphere that has torn on a first plate meets a second. Heat conduction is there for matter that shocks compress; a torn particle's
/// volume counts its void, at which its cold energy means nothing, so it must take no part. On one plate conduction moves the
/// molten share by a fifth; here, when torn matter took part, it was 2.6 times what it is without.
#[test]
fn torn_matter_takes_no_part_in_conduction() {
    let liquid = |conduction: f64| {
        let impact = run(json!({
            "projectile": { "shape": "sphere", "diameter": "3 mm", "material": "copper" },
            "plate": { "thickness": "1 mm", "width": "12 mm", "material": "copper" },
            "plates": { "rear": { "distance": "8 mm", "thickness": "2 mm", "material": "copper" } },
            "velocity": "2 km/s", "cells": 4, "end": "12 us", "conduction": conduction,
        }));
        assert!(drift(&impact) <= 1e-11, "{:e}", drift(&impact));
        impact.snapshots.last().unwrap().melt[0].liquid
    };
    let (without, with) = (liquid(0.0), liquid(80.0));
    assert!(without > 0.05 && (with / without - 1.0).abs() < 0.4, "{without} {with}");
}

/// Two plates of a material that touch are one of twice the thickness, particle by particle. Their edges are computed in another
/// order: rounding (1e-16), grown by the flow's own instabilities in 60 steps, and stored as f32 (6e-8).
#[test]
fn layers_are_one_plate() {
    let mut one = small();
    (one["velocity"], one["end"]) = (json!("3 km/s"), json!("2 us"));
    let mut two = one.clone();
    (one["plate"]["thickness"], one["cells"]) = (json!("2 mm"), json!(4));
    two["plates"] = json!({ "layer": { "distance": "1 mm", "thickness": "1 mm", "material": aluminium() } });
    let (one, two) = (run(one), run(two));
    let (a, b) = (&one.snapshots[0].particles, &two.snapshots[0].particles);
    assert_eq!(a.mass.len(), b.mass.len());
    for i in 0..a.mass.len() {
        for axis in 0..2 {
            assert!((a.position[axis][i] - b.position[axis][i]).abs() < 1e-8, "particle {i}");
            assert!((a.velocity[axis][i] - b.velocity[axis][i]).abs() < 1e-2, "particle {i}");
        }
    }
}

/// At 30 deg the momentum starts as (cos, 0, sin), is kept along both (the plate is free), and the plate takes part of each; half of
/// the scene is the whole. Snapshots are f32: 1e-6 of sums of 1e4 terms.
#[test]
fn oblique_impact() {
    let at = |space: &str| {
        run(json!({
            "projectile": { "shape": "sphere", "diameter": "2 mm", "material": aluminium() },
            "plate": { "thickness": "1 mm", "width": "5 mm", "material": aluminium() },
            "velocity": "5 km/s", "angle": "30 deg", "cells": 2, "space": space, "end": "0.8 us",
        }))
    };
    let (half, full) = (at("half"), at("full"));
    let whole = full.bodies[0].mass * 5000.0;
    let (x, z) = (whole * 0.75f64.sqrt(), whole * 0.5);
    assert!((full.ledger[0].momentum / x - 1.0).abs() < 1e-12);
    for (impact, copies) in [(&half, 2.0), (&full, 1.0)] {
        let sum = |axis| copies * (momentum(impact, 0, axis) + momentum(impact, 1, axis));
        assert!((sum(0) / x - 1.0).abs() < 1e-5 && (sum(2) / z - 1.0).abs() < 1e-5, "{} {}", sum(0) / x, sum(2) / z);
        assert!(copies * momentum(impact, 1, 2) > 0.05 * z);
        assert!(drift(impact) <= 1e-12);
    }
    let (a, b) = (half.ledger.last().unwrap(), full.ledger.last().unwrap());
    assert!((a.kinetic / b.kinetic - 1.0).abs() < 1e-9 && half.ledger.len() == full.ledger.len());
}

/// Bodies of combined shapes, and a void, have the mass of their volumes (the lattice's round surfaces: 3 %); a ball that flies
/// at the plate from behind is stopped by it.
#[test]
fn combined_shapes_and_voids() {
    let mut params = small();
    params["bodies"] = json!({
        "ball": {
            "material": copper(), "velocity": ["-3 km/s", "0 m/s", "0 m/s"],
            "shape": { "shell": { "centre": ["9 mm", "0 mm", "0 mm"], "diameter": "6 mm", "thickness": "2 mm" } },
        },
        "tube": {
            "material": copper(),
            "shape": { "difference": [
                { "cylinder": { "from": ["20 mm", "0 mm", "0 mm"], "to": ["26 mm", "0 mm", "0 mm"], "diameter": "6 mm" } },
                { "cylinder": { "from": ["19 mm", "0 mm", "0 mm"], "to": ["27 mm", "0 mm", "0 mm"], "diameter": "3 mm" } },
            ] },
        },
    });
    params["voids"] = json!([{ "box": { "from": ["0 mm", "0 mm", "-1 m"], "to": ["0.5 mm", "2 mm", "1 m"] } }]);
    params["end"] = json!("3 us");
    let impact = run(params);
    let expected = [
        ("ball", 8930.0 * PI / 6.0 * (216e-9 - 8e-9)),
        ("tube", 8930.0 * 0.25 * PI * (36e-6 - 9e-6) * 6e-3),
        ("plate", 2703.0 * PI * (25e-6 * 1e-3 - 4e-6 * 0.5e-3)),
    ];
    for (name, mass) in expected {
        let body = impact.bodies.iter().find(|b| b.name == name).unwrap();
        assert!((body.mass / mass - 1.0).abs() < 0.03, "{name}: {} kg, expected {mass} kg", body.mass);
    }
    let ball = impact.bodies.iter().position(|b| b.name == "ball").unwrap() as u8;
    assert!(momentum(&impact, ball, 0) > -0.95 * 3000.0 * impact.bodies[ball as usize].mass);
    assert!(drift(&impact) <= 1e-11, "{:e}", drift(&impact));
}

/// With friction all bodies but the projectile share a field: the ledger is as closed as without, also where a body has no matter
/// beside the axis and the other has. Energy to 1e-12; momentum, a sum of 1e4 terms of both signs after 100 steps, to 1e-11.
#[test]
fn friction_leaks_nothing() {
    let mut params = small();
    params["end"] = json!("2 us");
    let wall = json!({ "wall": { "distance": "4 mm", "thickness": "1 mm", "material": copper() } });
    for friction in [0.0, 0.2, 1.0] {
        params["friction"] = json!(friction);
        for (space, plates) in [("axisymmetric", json!({})), ("axisymmetric", wall.clone()), ("quarter", json!({}))] {
            (params["space"], params["plates"]) = (json!(space), plates);
            let impact = run(params.clone());
            let (start, end) = (&impact.ledger[0], impact.ledger.last().unwrap());
            assert!(drift(&impact) <= 1e-12, "{friction} {space}: {:e}", drift(&impact));
            let momentum = (end.momentum / start.momentum - 1.0).abs();
            assert!(momentum <= 1e-11, "{friction} {space}: {momentum:e}");
        }
    }
}

#[test]
fn wrong_scenes_are_named() {
    type Change<'a> = &'a dyn Fn(&mut Value);
    let plates = |p: &mut Value, distance: &str, thickness: &str| {
        p["plates"] = json!({ "rear": { "distance": distance, "thickness": thickness, "material": copper() } });
    };
    let ball = |p: &mut Value, x: &str, diameter: &str, velocity: [&str; 3]| {
        let shape = json!({ "sphere": { "centre": [x, "0 mm", "0 mm"], "diameter": diameter } });
        p["bodies"] = json!({ "ball": { "shape": shape, "velocity": velocity, "material": copper() } });
    };
    let still = ["0 m/s"; 3];
    let cases: [(&str, &[&str], Change); 16] = [
        ("plates.rear.distance", &["overlaps `plate`", "x 1.500 .. 1.906 mm"], &|p| plates(p, "1.5 mm", "2 mm")),
        ("plates.rear.thickness", &["1.57 cells of 0.6353 mm", "cells = 4"], &|p| plates(p, "5 mm", "1 mm")),
        ("plates.rear.thickness", &["above 0"], &|p| plates(p, "5 mm", "-1 mm")),
        ("end", &["14.9254 us", "plates.rear", "100 mm"], &|p| plates(p, "100 mm", "2 mm")),
        ("bodies.ball.shape", &["overlaps `projectile`"], &|p| ball(p, "-11 mm", "5 mm", still)),
        ("bodies.ball.shape", &["cells of"], &|p| ball(p, "11 mm", "1 mm", still)),
        ("bodies.ball.velocity", &["meets no other"], &|p| ball(p, "11 mm", "2 mm", ["9 km/s", "0 m/s", "0 m/s"])),
        ("bodies.ball.velocity", &["along y", "axisymmetric"], &|p| {
            ball(p, "11 mm", "2 mm", ["0 m/s", "1 km/s", "0 m/s"])
        }),
        ("end", &["bodies.ball", "needs 1.3400 us to `projectile`"], &|p| {
            ball(p, "11 mm", "2 mm", ["-1 km/s", "0 m/s", "0 m/s"])
        }),
        ("bodies.plate", &["name of another"], &|p| {
            p["bodies"] = json!({ "plate": { "shape": { "sphere": { "centre": ["9 mm", "0 mm", "0 mm"], "diameter": "2 mm" } }, "material": copper() } });
        }),
        ("bodies.empty.shape", &["no particle"], &|p| {
            let cube = |x: &str, y: &str| json!({ "box": { "from": [x, "0 mm", "0 mm"], "to": [y, "3 mm", "3 mm"] } });
            let shape = json!({ "difference": [cube("4 mm", "7 mm"), cube("3 mm", "8 mm")] });
            p["bodies"] = json!({ "empty": { "shape": shape, "material": copper() } });
        }),
        ("angle", &["half"], &|p| p["angle"] = json!("20 deg")),
        ("angle", &["80 deg"], &|p| (p["angle"], p["space"]) = (json!("90 deg"), json!("half"))),
        ("voids", &["above 0"], &|p| {
            p["voids"] = json!([{ "sphere": { "centre": ["0 m", "0 m", "0 m"], "diameter": "0 m" } }])
        }),
        ("plate.material", &["no damage", "d1 to d5", "leave damage out"], &|p| {
            p["plate"]["material"].as_object_mut().unwrap().remove("damage");
            p["damage"] = json!(true);
        }),
        ("projectile.material", &["no spall strength"], &|p| {
            p["projectile"]["material"].as_object_mut().unwrap().remove("spall");
            p["spall"] = json!(true);
        }),
    ];
    for (key, parts, change) in cases {
        let mut params = s1("axisymmetric", 3, "1 us");
        change(&mut params);
        let params: Params = serde_json::from_value(params).expect("parameters");
        let invalid = ImpactStage::check(&params).expect_err(key);
        assert_eq!(invalid.key, key, "{}", invalid.why);
        assert!(parts.iter().all(|part| invalid.why.contains(part)), "{}", invalid.why);
    }
}
