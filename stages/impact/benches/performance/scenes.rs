//! Whole runs of the stage: the yardstick scene S1, and the eta sweep.
#[path = "../../tests/common/mod.rs"]
mod common;
use super::cpu;
use hvi_impact::result::Impact;
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, Places, Stage};
use serde_json::{Value, json};

/// One run.
pub struct Scene {
    /// What it is.
    pub name: &'static str,
    /// CPU time [s].
    pub time: f64,
    /// Time over particles and steps [ns].
    pub each: f64,
    /// Particles at the end.
    pub particles: usize,
    /// Steps.
    pub steps: u64,
    /// Velocities of the leading .1, 1 and 5 % of the projectile [m/s].
    pub leading: [f64; 3],
    /// Highest density over the initial one.
    pub compression: f64,
}

fn run(name: &'static str, params: Value) -> (Scene, Impact) {
    let params: Params = serde_json::from_value(params).expect("parameters");
    let inputs = ImpactInputs { eos: Places(Default::default()), file: Places(Default::default()) };
    let start = cpu::thread();
    let impact = ImpactStage::run(&params, inputs, &Ctx::quiet()).expect("runs");
    let time = cpu::thread() - start;
    let end = impact.ledger.last().expect("an end");
    let particles = impact.snapshots[0].particles.mass.len();
    let scene = Scene {
        name,
        time,
        each: 1e9 * time / (particles as f64 * end.step as f64),
        particles,
        steps: end.step,
        leading: impact.leading,
        compression: end.highest_compression,
    };
    (scene, impact)
}

/// S1 to 10 us: whole, as a quarter, in (r, z).
pub fn yardstick() -> Vec<Scene> {
    let linear = |mut params: Value| {
        (params["kernel"], params["transfer"]) = (json!("linear"), json!("flip"));
        params
    };
    [
        ("full, cubic APIC", common::s1("full", 3, "10 us")),
        ("full, linear FLIP", linear(common::s1("full", 3, "10 us"))),
        ("quarter, cubic APIC", common::s1("quarter", 3, "10 us")),
        ("quarter, linear FLIP", linear(common::s1("quarter", 3, "10 us"))),
        ("(r, z), cubic APIC, 3 cells", common::s1("axisymmetric", 3, "10 us")),
        ("(r, z), cubic APIC, 12 cells", common::s1("axisymmetric", 12, "10 us")),
    ]
    .map(|(name, params)| run(name, params).0)
    .into()
}

/// Copper spheres on copper plates at every speed and diameter of the eta study, 6 cells through the thinner body.
pub fn sweep() {
    let (start, mut runs) = (cpu::thread(), 0);
    let plates =
        [("2.5 mm", &[1.0, 2.5, 4.2, 4.6, 5.0, 5.4, 5.9, 6.7, 7.5, 8.0][..]), ("5.0 mm", &[2.5, 4.2, 5.9, 7.5][..])];
    for (thickness, speeds) in plates {
        for speed in speeds {
            for diameter in ["1.6 mm", "3.2 mm", "6.4 mm", "12.6 mm"] {
                let params = json!({
                    "projectile": { "shape": "sphere", "diameter": diameter, "material": "copper" },
                    "plate": { "thickness": thickness, "material": "copper" },
                    "velocity": format!("{speed} km/s"),
                });
                let (scene, impact) = run("", params);
                println!(
                    "t {thickness} D {diameter} v {speed} km/s: liquid {:.3}, {} steps, {} particles, {:.2} s, {:.0} ns a particle-step",
                    impact.snapshots[0].melt[0].liquid, scene.steps, scene.particles, scene.time, scene.each
                );
                runs += 1;
            }
        }
    }
    println!("{runs} runs: {:.1} core-seconds", cpu::thread() - start);
}
