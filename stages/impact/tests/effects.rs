//! The planner: what it decides, by which numbers; and the guard on scenes that fool it.
mod common;
use common::{aluminium, copper, drift, run, try_run};
use hvi_eos::Eos;
use hvi_impact::effects::{self, Effect, Plan};
use hvi_impact::params::SpaceChoice;
use hvi_impact::result::{Decision, Impact};
use hvi_impact::{ImpactStage, Params};
use hvi_kit::{Cancel, Ctx, Host, Stage};
use serde_json::{Value, json};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A sphere of 4 mm on a plate of 1 mm, decided by estimates.
fn sphere(material: Value, velocity: &str) -> Value {
    json!({
        "projectile": { "shape": "sphere", "diameter": "4 mm", "material": material },
        "plate": { "thickness": "1 mm", "material": material },
        "velocity": velocity, "cells": 2, "effects": "auto",
    })
}

fn plan(params: Value) -> Plan {
    let params: Params = serde_json::from_value(params).expect("parameters");
    ImpactStage::check(&params).expect("in range");
    let eos: Vec<Eos> = {
        let layout = hvi_impact::scene::Layout::of(&params.settled());
        hvi_impact::bodies::pieces(&params, &layout).iter().map(|piece| piece.material.eos.clone()).collect()
    };
    effects::plan(&params, &eos)
}

fn line<'a>(decisions: &'a [Decision], effect: &str) -> &'a Decision {
    decisions.iter().find(|d| d.effect == effect).unwrap_or_else(|| panic!("no decision of {effect}"))
}

fn choice(params: Value, effect: &str) -> String {
    line(&plan(params).decisions, effect).choice.clone()
}

/// Without `effects = "auto"` nothing is decided: no line in the result, and what the keys say.
#[test]
fn nothing_is_decided_unasked() {
    let mut params = sphere(aluminium(), "5 km/s");
    params.as_object_mut().unwrap().remove("effects");
    params["end"] = json!("0.2 us");
    let found = plan(params.clone());
    assert!(found.decisions.is_empty() && found.off.is_empty());
    let impact = run(params);
    assert!(impact.decisions.is_empty() && impact.crossings.is_empty());
}

/// The dimension is that of the scene's symmetry, also just off it.
#[test]
fn dimension_by_symmetry() {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut params = sphere(aluminium(), "5 km/s");
        change(&mut params);
        let params: Params = serde_json::from_value(params).expect("parameters");
        params.settled().space()
    };
    let body = |shape: Value, velocity: [&'static str; 3]| {
        move |p: &mut Value| {
            p["bodies"] = json!({ "a": { "shape": shape, "material": copper(), "velocity": velocity } });
        }
    };
    let still = ["0 m/s"; 3];
    let ball = |y: &str, z: &str| json!({ "sphere": { "centre": ["9 mm", y, z], "diameter": "3 mm" } });
    let brick = |y: &str| json!({ "box": { "from": ["9 mm", y, "-2 mm"], "to": ["12 mm", "3 mm", "2 mm"] } });
    let bar = |a: [&str; 3], b: [&str; 3]| json!({ "cylinder": { "from": a, "to": b, "diameter": "2 mm" } });
    use SpaceChoice::{Axisymmetric, Full, Half, Quarter};
    assert_eq!(with(&|_| ()), Axisymmetric);
    assert_eq!(with(&|p| p["angle"] = json!("0.001 deg")), Half);
    assert_eq!(with(&body(ball("0 mm", "0 mm"), still)), Axisymmetric);
    assert_eq!(with(&body(ball("0 mm", "0.01 mm"), still)), Half);
    assert_eq!(with(&body(ball("0.01 mm", "0 mm"), still)), Full);
    assert_eq!(with(&body(ball("0 mm", "0 mm"), ["0 m/s", "0 m/s", "1 m/s"])), Half);
    assert_eq!(with(&body(brick("-3 mm"), still)), Quarter);
    assert_eq!(with(&body(brick("-2 mm"), still)), Full);
    assert_eq!(with(&body(bar(["9 mm", "0 mm", "0 mm"], ["12 mm", "0 mm", "0 mm"]), still)), Axisymmetric);
    assert_eq!(with(&body(bar(["9 mm", "-3 mm", "0 mm"], ["9 mm", "3 mm", "0 mm"]), still)), Quarter);
    assert_eq!(with(&body(bar(["9 mm", "0 mm", "-3 mm"], ["12 mm", "0 mm", "4 mm"]), still)), Half);
    let hole = |shape: Value| move |p: &mut Value| p["voids"] = json!([shape]);
    assert_eq!(with(&hole(json!({ "difference": [ball("0 mm", "0 mm"), brick("-3 mm")] }))), Quarter);
    assert_eq!(with(&|p| p["space"] = json!("full")), Full);
}

/// The numbers: impedance match of S1's aluminium at 6.7 km/s is 89.92 GPa (its specification), over 1.2 GPa of spall strength 74.9; the
/// work of strength `(A + B) / (rho v^2 / 2)` 438 MPa over 60.67 GPa.
#[test]
fn numbers_of_the_estimates() {
    let found = plan(sphere(aluminium(), "6.7 km/s"));
    let spall = line(&found.decisions, "spall");
    assert!((spall.number / 74.93 - 1.0).abs() < 1e-3 && spall.choice == "on", "{spall:?}");
    let strength = line(&found.decisions, "strength");
    assert!((strength.number / (438e6 / (0.5 * 2703.0 * 6700.0 * 6700.0)) - 1.0).abs() < 1e-9, "{strength:?}");
    // Copper on aluminium at 6 km/s: equal pressure on both sides, and velocities that add up.
    let read = |v: Value| -> Eos { serde_json::from_value(v["eos"].clone()).expect("an equation of state") };
    let shocks = effects::impedance_match([&read(copper()), &read(aluminium())], 6000.0).expect("in range");
    assert!((shocks[0].pressure / shocks[1].pressure - 1.0).abs() < 1e-3);
    assert!((shocks[0].particle_velocity + shocks[1].particle_velocity - 6000.0).abs() < 1.0);
}

/// Effects turn with speed the way they must; what the user sets stays.
#[test]
fn decisions_turn_with_speed() {
    let gray = || json!("copper");
    for (effect, slow, fast) in [("conduction", "1 km/s", "6 km/s"), ("spall", "20 m/s", "1 km/s")] {
        assert_eq!(
            (choice(sphere(gray(), slow), effect), choice(sphere(gray(), fast), effect)),
            ("off".into(), "on".into())
        );
    }
    for (effect, slow, fast) in [("strength", "1 km/s", "20 km/s"), ("contact", "1 km/s", "20 km/s")] {
        assert_eq!(
            (choice(sphere(gray(), slow), effect), choice(sphere(gray(), fast), effect)),
            ("on".into(), "off".into())
        );
    }
    let mut params = sphere(gray(), "20 km/s");
    (params["strength"], params["damage"], params["conduction"]) = (json!(true), json!(false), json!(0.0));
    let found = plan(params);
    assert_eq!(
        (found.params.strength, found.params.damage, found.params.conduction),
        (Some(true), Some(false), Some(0.0))
    );
    assert!(line(&found.decisions, "strength").source.starts_with("set by hand"));
    assert!(!found.off.contains(&Effect::Damage) && !found.off.contains(&Effect::Conduction));
    let mut oblique = sphere(gray(), "6 km/s");
    (oblique["angle"], oblique["plate"]["width"]) = (json!("30 deg"), json!("8 mm"));
    assert_eq!(choice(oblique, "contact"), "on");
}

/// Whether the run began again with `effect`, and its ledger is closed.
fn caught(params: Value, effect: Effect) -> Impact {
    let mut stops = params.clone();
    stops["guard"] = json!("error");
    let why = try_run(stops, &Ctx::quiet()).expect_err("stops").to_string();
    assert!(why.contains("guard = \"rerun\"") && why.contains("is allowed"), "{why}");
    let impact = run(params);
    let crossing = impact.crossings.iter().find(|c| c.effect == effect);
    let crossing = crossing.unwrap_or_else(|| panic!("{effect:?} not caught: {:?}", impact.crossings));
    assert!(crossing.number > crossing.threshold && crossing.time > 0.0, "{crossing:?}");
    assert!(drift(&impact) <= 1e-11, "{:e}", drift(&impact));
    impact
}

/// A slow impact whose plane shock leaves copper cold (373 K of 1356 K), but whose plastic work heats it beyond half its melting
/// temperature; a blast so fast that strength looks like nothing, run until it is slow; a fast shock that outruns the sound
/// by which the plate was made wide enough.
#[test]
fn scenes_that_fool_the_estimates_are_caught() {
    caught(sphere(json!("copper"), "2 km/s"), Effect::Conduction);
    let mut long = sphere(aluminium(), "14 km/s");
    long["end"] = json!("8 us");
    let impact = caught(long, Effect::Strength);
    assert_eq!(line(&impact.decisions, "strength").choice, "off");
}

/// Debris of a first plate hits a second one faster than any body moved at first; closing gaps in a pierced block.
#[test]
fn scenes_of_several_bodies_stay_closed() {
    let mut shield = sphere(json!("copper"), "3 km/s");
    shield["plates"] = json!({ "wall": { "distance": "6 mm", "thickness": "1 mm", "material": "aluminium" } });
    let impact = run(shield);
    assert!(drift(&impact) <= 1e-11 && line(&impact.decisions, "dimension").choice == "axisymmetric");
    let mut porous = sphere(json!("copper"), "2.5 km/s");
    porous["voids"] = json!([
        { "sphere": { "centre": ["-2 mm", "0 mm", "0 mm"], "diameter": "2 mm" } },
    ]);
    caught(porous, Effect::Conduction);
}

/// Keeps what it is given; asks for a stop once it has been told of `stop` steps.
struct Keeper {
    kept: Mutex<Option<Vec<u8>>>,
    told: AtomicUsize,
    stop: usize,
    cancel: Cancel,
}
impl Host for Keeper {
    fn advance(&self, _: f64, _: f64, _: &str) {
        if self.told.fetch_add(1, Ordering::Relaxed) + 1 == self.stop {
            self.cancel.set();
        }
    }
    fn keep(&self, bytes: &[u8]) {
        *self.kept.lock().unwrap() = Some(bytes.to_vec());
    }
    fn kept(&self) -> Option<Vec<u8>> {
        self.kept.lock().unwrap().clone()
    }
}

/// A run that began again and was stopped after that leaves the bits of a straight one.
#[test]
fn a_rerun_resumes_to_the_same_bits() {
    use hvi_kit::Artifact;
    let params = sphere(json!("copper"), "2 km/s");
    let straight = run(params.clone());
    let steps = straight.ledger.last().unwrap().step as usize;
    assert_eq!(straight.crossings.len(), 1);
    for stop in [5, steps / 4, steps] {
        let keeper = Keeper { kept: Mutex::new(None), told: AtomicUsize::new(0), stop, cancel: Cancel::default() };
        let ctx = Ctx { host: &keeper, cancel: &keeper.cancel, threads: 1 };
        assert!(try_run(params.clone(), &ctx).is_err(), "stopped after {stop} steps");
        let resumed = try_run(params.clone(), &Ctx { host: &keeper, ..Ctx::quiet() }).expect("runs on");
        assert!(resumed.encode() == straight.encode(), "other bits after a stop at step {stop}");
    }
}
