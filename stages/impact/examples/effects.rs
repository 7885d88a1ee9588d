//! What `effects = "auto"` leaves out, against runs with everything on: `make effects` writes docs/effects.md and its figure.
use hvi_impact::effects;
use hvi_impact::result::{Impact, Space};
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, Places, Stage};
use serde_json::{Value, json};
use std::fmt::Write;
use std::time::Instant;

/// Name, projectile, plate, speed, angle [deg], diameter and thickness [mm].
type Scene = (&'static str, &'static str, &'static str, &'static str, f64, f64, f64);

/// 0.3 to 12 km/s; copper and aluminium; normal and oblique; thick and thin.
const SCENES: &[Scene] = &[
    ("slow", "copper", "copper", "0.3 km/s", 0.0, 4.0, 2.0),
    ("slow, unlike", "aluminium", "copper", "1 km/s", 0.0, 4.0, 2.0),
    ("moderate", "aluminium", "aluminium", "2 km/s", 0.0, 4.0, 2.0),
    ("moderate, thick", "copper", "copper", "2.5 km/s", 0.0, 3.0, 4.0),
    ("fast", "copper", "copper", "4.2 km/s", 0.0, 4.0, 2.0),
    ("fast, unlike", "copper", "aluminium", "5 km/s", 0.0, 4.0, 2.0),
    ("paper's eta", "copper", "copper", "5.9 km/s", 0.0, 4.0, 1.0),
    ("yardstick", "aluminium", "aluminium", "6.7 km/s", 0.0, 4.0, 0.8),
    ("very fast", "aluminium", "copper", "9 km/s", 0.0, 4.0, 1.0),
    ("fastest", "aluminium", "aluminium", "12 km/s", 0.0, 4.0, 1.0),
    ("oblique", "aluminium", "aluminium", "5 km/s", 30.0, 3.0, 1.5),
    ("oblique, steep", "copper", "aluminium", "6 km/s", 60.0, 3.0, 1.5),
];

/// A scene's parameters, decided by estimates.
fn params(&(_, projectile, plate, velocity, angle, diameter, thickness): &Scene, cells: u32) -> Params {
    let mut value = json!({
        "projectile": { "shape": "sphere", "diameter": format!("{diameter} mm"), "material": projectile },
        "plate": { "thickness": format!("{thickness} mm"), "width": format!("{} mm", 3.0 * diameter), "material": plate },
        "velocity": velocity, "cells": cells, "effects": "auto",
    });
    // Until the projectile has passed through three of its lengths: early enough for a plate that narrow.
    let speed: f64 = velocity.trim_end_matches(" km/s").parse().expect("a speed");
    let end = (3.0 * diameter / speed).min(0.4 * 3.0 * diameter);
    value["end"] = Value::from(format!("{end} us"));
    if angle > 0.0 {
        value["angle"] = Value::from(format!("{angle} deg"));
    }
    serde_json::from_value(value).expect("parameters")
}

/// What is asked of a run.
struct Asked {
    eta: f64,
    leading: f64,
    hole: f64,
    debris: f64,
    pressure: f64,
    seconds: f64,
    impact: Impact,
}

fn run(params: &Params) -> Asked {
    let began = Instant::now();
    let inputs = ImpactInputs { eos: Places(Default::default()), file: Places(Default::default()) };
    let impact = ImpactStage::run(params, inputs, &Ctx::quiet()).expect("runs");
    let seconds = began.elapsed().as_secs_f64();
    let last = impact.snapshots.last().expect("an end");
    let p = &last.particles;
    let copies = match impact.space {
        Space::Full { mirror_y, mirror_z } => f64::from(1 << (mirror_y as u32 + mirror_z as u32)),
        _ => 1.0,
    };
    let flown: Vec<usize> = (0..p.mass.len())
        .filter(|&i| p.velocity[0][i] > 0.05 * impact.velocity as f32 && f64::from(p.position[0][i]) > impact.thickness)
        .collect();
    let debris = flown.iter().map(|&i| copies * f64::from(p.mass[i]) * f64::from(p.velocity[0][i])).sum();
    Asked {
        eta: last.melt[0].liquid,
        leading: impact.leading[1],
        hole: hole(&impact),
        debris,
        pressure: impact.ledger.last().expect("an end").highest_pressure,
        seconds,
        impact,
    }
}

/// Radius within which half the plate's volume under the projectile is gone [m]: that of a round hole of the missing mass at mid-plane.
fn hole(impact: &Impact) -> f64 {
    let p = &impact.snapshots.last().expect("an end").particles;
    let inside =
        |i: &usize| p.body[*i] == 1 && p.position[0][*i] > 0.0 && f64::from(p.position[0][*i]) < impact.thickness;
    let mut radii: Vec<(f64, f64)> = (0..p.mass.len())
        .filter(inside)
        .map(|i| {
            let (y, z) = (f64::from(p.position[1][i]), f64::from(p.position[2][i]));
            ((y * y + z * z).sqrt(), f64::from(p.mass[i]))
        })
        .collect();
    radii.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted = 0.02 * radii.iter().map(|r| r.1).sum::<f64>();
    let mut sum = 0.0;
    radii
        .iter()
        .find(|r| {
            sum += r.1;
            sum >= wanted
        })
        .map_or(f64::NAN, |r| r.0)
}

fn main() {
    let cells: u32 = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(3);
    let mut table = String::new();
    let mut decisions = String::new();
    let mut ratios = Vec::new();
    let (mut met, mut judged) = (0, 0);
    for scene in SCENES {
        let auto = params(scene, cells);
        let (pruned, full) = (run(&auto), run(&auto.everything_on()));
        let ratio = full.seconds / pruned.seconds;
        ratios.push((ratio, scene.4 == 0.0));
        let bound = if pruned.impact.space == full.impact.space { 1.0 } else { 3.0 };
        let _ = write!(
            table,
            "| {} | {}-{}, {}, {:.0} deg, D/t {:.1} |",
            scene.0,
            scene.1,
            scene.2,
            scene.3,
            scene.4,
            scene.5 / scene.6
        );
        let pairs = [
            (pruned.eta, full.eta, 1.0),
            (pruned.leading, full.leading, full.leading),
            (pruned.hole, full.hole, full.hole),
            (pruned.debris, full.debris, full.debris),
            (pruned.pressure, full.pressure, full.pressure),
        ];
        for (a, b, scale) in pairs {
            let difference = if scale == 0.0 { 0.0 } else { 100.0 * (a - b) / scale };
            let mark = if difference.abs() <= bound { "" } else { " **missed**" };
            (judged, met) = (judged + 1, met + (difference.abs() <= bound) as usize);
            let _ = write!(table, " {difference:+.2}{mark} |");
        }
        let _ = writeln!(table, " {bound} | {:.1} |", ratio);
        let _ = write!(decisions, "| {} |", scene.0);
        for effect in ["dimension", "strength", "softening", "rate", "damage", "spall", "contact", "conduction"] {
            let line = pruned.impact.decisions.iter().find(|d| d.effect == effect);
            let turned = pruned.impact.crossings.iter().any(|c| c.effect.name() == effect);
            let _ = write!(
                decisions,
                " {}{} |",
                line.map_or("-", |d| d.choice.as_str()),
                if turned { ", then on" } else { "" }
            );
        }
        decisions.push('\n');
        eprintln!("{}: {ratio:.1}", scene.0);
    }
    print(cells, &table, &decisions, &ratios, met, judged);
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    let n = x.len();
    if n % 2 == 1 { x[n / 2] } else { 0.5 * (x[n / 2 - 1] + x[n / 2]) }
}

fn print(cells: u32, table: &str, decisions: &str, ratios: &[(f64, bool)], met: usize, judged: usize) {
    let all = median(ratios.iter().map(|r| r.0).collect());
    let least = ratios.iter().filter(|r| r.1).map(|r| r.0).fold(f64::INFINITY, f64::min);
    println!("# Effects\n");
    println!(
        "What `effects = \"auto\"` leaves out, against the same scene with everything on: a quarter of three dimensions (half where oblique), \
         strength, rate, softening, damage, spall, contact with a coefficient of friction of {}, heat conduction; on the same {cells} cells \
         through the thinner body, plate and end time. Made by `make effects`; one core, single runs.\n",
        effects::FRICTION
    );
    println!(
        "Times are full over pruned, reruns by the guard included: median {all:.1} (at least 5 is wanted), least of the normal impacts {least:.1} \
         (at least 30). {met} of {judged} differences are within their bound: 1 %, or 3 % where the dimension changes; eta in shares of \
         the projectile's mass (1 = 100 %), the others relative.\n"
    );
    println!("| scene | | eta | leading 1 % | hole | debris momentum | peak pressure | bound [%] | times cheaper |");
    println!("|---|---|---|---|---|---|---|---|---|");
    println!("{table}");
    println!("What was decided:\n");
    println!("| scene | dimension | strength | softening | rate | damage | spall | contact | conduction |");
    println!("|---|---|---|---|---|---|---|---|---|");
    print!("{decisions}");
}
