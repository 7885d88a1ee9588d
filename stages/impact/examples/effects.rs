//! What `effects = "auto"` leaves out, against runs with everything on: `make effects` writes docs/effects.md and its figure.
use hvi_impact::effects;
use hvi_impact::result::{Impact, Space, Track};
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

/// A scene's parameters, decided by estimates, with `across` cells across the projectile.
fn params(&(_, projectile, plate, velocity, angle, diameter, thickness): &Scene, across: f64) -> Params {
    let cells = (across * thickness.min(diameter) / diameter).round().max(2.0) as u32;
    let mut value = json!({
        "projectile": { "shape": "sphere", "diameter": format!("{diameter} mm"), "material": projectile },
        "plate": { "thickness": format!("{thickness} mm"), "width": format!("{} mm", 3.0 * diameter), "material": plate },
        "velocity": velocity, "cells": cells, "effects": "auto",
    });
    // Until the projectile has passed through three of its lengths: early enough for a plate that narrow.
    let speed: f64 = velocity.trim_end_matches(" km/s").parse().expect("a speed");
    let end = (3.0 * diameter / speed).min(0.4 * 3.0 * diameter);
    value["end"] = Value::from(format!("{end} us"));
    // On the axis, halfway through the plate: the highest pressure of all is one particle's, at the first touch of a sphere and a plane.
    let middle = format!("{} mm", 0.5 * thickness);
    value["probes"] = json!({ "points": { "plate": [middle, "0 mm", "0 mm"] }, "samples": 400 });
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

impl Asked {
    /// Each quantity with that of `known`, and what their difference is measured by.
    fn against(&self, known: &Asked) -> [(f64, f64, f64); 5] {
        [
            (self.eta, known.eta, 1.0),
            (self.leading, known.leading, known.leading),
            (self.hole, known.hole, known.hole),
            (self.debris, known.debris, known.debris),
            (self.pressure, known.pressure, known.pressure),
        ]
    }
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
    // The hole is that of the disc of plate with the mass of what has left it.
    let gone: f64 = flown.iter().filter(|&&i| p.body[i] == 1).map(|&i| copies * f64::from(p.mass[i])).sum();
    let hole = (4.0 * gone / (std::f64::consts::PI * impact.bodies[1].density * impact.thickness)).sqrt();
    Asked {
        eta: last.melt[0].liquid,
        leading: impact.leading[1],
        hole,
        debris,
        pressure: peak(&impact),
        seconds,
        impact,
    }
}

/// The highest pressure that the probe in the plate has seen [Pa].
fn peak(impact: &Impact) -> f64 {
    match impact.probes.first().map(|probe| &probe.track) {
        Some(Track::Point(all)) => all.iter().map(|at| at.pressure).fold(0.0, f64::max),
        _ => f64::NAN,
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let across: f64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(12.0);
    let figure = arguments.next();
    let mut table = String::new();
    let mut decisions = String::new();
    let mut ratios = Vec::new();
    let (mut met, mut judged) = (0, 0);
    for scene in SCENES {
        let auto = params(scene, across);
        let everything = auto.everything_on();
        // What the change of dimension does, and what the effects left out do, apart.
        let flat = Params { space: auto.settled().space, ..everything.clone() };
        let (pruned, full) = (run(&auto), run(&everything));
        let same = if pruned.impact.space == full.impact.space { None } else { Some(run(&flat)) };
        let ratio = full.seconds / pruned.seconds;
        ratios.push((scene.0, ratio, scene.4 == 0.0));
        let head = format!("{}-{}, {}, {:.0} deg, D/t {:.1}", scene.1, scene.2, scene.3, scene.4, scene.5 / scene.6);
        let mut line = |what: &str, found: &Asked, known: &Asked, bound: f64, last: &str| {
            let _ = write!(table, "| {} | {head} | {what} |", scene.0);
            for (a, b, scale) in found.against(known) {
                let difference = if scale == 0.0 && a == b { 0.0 } else { 100.0 * (a - b) / scale };
                let is_met = difference.abs() <= bound;
                (judged, met) = (judged + 1, met + is_met as usize);
                let _ = write!(table, " {difference:+.2}{} |", if is_met { "" } else { " **missed**" });
            }
            let _ = writeln!(table, " {bound} | {last} |");
        };
        let times = format!("{ratio:.1}");
        if let Some(same) = &same {
            line("effects left out", &pruned, same, 1.0, &times);
            line("dimension", same, &full, 3.0, "");
        } else {
            line("effects left out", &pruned, &full, 1.0, &times);
        }
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
    if let Some(path) = figure {
        std::fs::write(path, bars(&ratios)).expect("the figure's folder is there");
    }
    print(across, &table, &decisions, &ratios, met, judged);
}

/// How many times cheaper each scene is, as bars on a logarithmic scale from 1 to 100.
fn bars(ratios: &[(&str, f64, bool)]) -> String {
    let (left, row, decade) = (120.0, 22.0, 220.0);
    let height = row * ratios.len() as f64 + 40.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\">\n",
        left + 2.0 * decade + 60.0
    );
    for (power, name) in ["1", "10", "100"].iter().enumerate() {
        let x = left + power as f64 * decade;
        let _ = writeln!(svg, "<line x1=\"{x}\" y1=\"0\" x2=\"{x}\" y2=\"{}\" stroke=\"#bbb\"/>", height - 36.0);
        let _ = writeln!(svg, "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{name}</text>", height - 22.0);
    }
    for (k, (name, ratio, _)) in ratios.iter().enumerate() {
        let (y, width) = (row * k as f64, (decade * hvi_kit::math::log(*ratio) / hvi_kit::math::log(10.0)).max(1.0));
        let _ =
            writeln!(svg, "<rect x=\"{left}\" y=\"{}\" width=\"{width:.1}\" height=\"14\" fill=\"#4477aa\"/>", y + 4.0);
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>", left - 6.0, y + 15.0);
        let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{}\">{ratio:.1}</text>", left + width + 4.0, y + 15.0);
    }
    let _ =
        writeln!(svg, "<text x=\"{left}\" y=\"{}\">time with everything on over time as decided</text>", height - 6.0);
    svg + "</svg>\n"
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    let n = x.len();
    if n % 2 == 1 { x[n / 2] } else { 0.5 * (x[n / 2 - 1] + x[n / 2]) }
}

fn print(across: f64, table: &str, decisions: &str, ratios: &[(&str, f64, bool)], met: usize, judged: usize) {
    let all = median(ratios.iter().map(|r| r.1).collect());
    let least = ratios.iter().filter(|r| r.2).map(|r| r.1).fold(f64::INFINITY, f64::min);
    println!("# Effects\n");
    println!(
        "What `effects = \"auto\"` leaves out, against the same scene with everything on: a quarter of three dimensions (half where oblique), \
         strength, rate, softening, damage, spall, contact with a coefficient of friction of {}, heat conduction; on the same cells, {across} \
         across the projectile, plate and end time. Made by `make effects`; one core, single runs.\n",
        effects::FRICTION
    );
    println!(
        "Times are full over pruned, reruns by the guard included: median {all:.1} (at least 5 is wanted), least of the normal impacts {least:.1} \
         (at least 30). {met} of {judged} differences are within their bound: 1 % for effects left out in the same dimension, 3 % for the change of \
         dimension with everything on; all in %, eta of the projectile's mass, the others of themselves. The hole is that of a disc of plate with \
         the mass of the debris; the peak pressure that at half the plate's depth on the axis.\n"
    );
    println!(
        "| scene | | what changes | eta | leading 1 % | hole | debris momentum | peak pressure | bound [%] | times cheaper |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    println!("{table}");
    println!("![How many times cheaper each scene is](effects.svg)\n");
    println!("What was decided:\n");
    println!("| scene | dimension | strength | softening | rate | damage | spall | contact | conduction |");
    println!("|---|---|---|---|---|---|---|---|---|");
    print!("{decisions}");
}
