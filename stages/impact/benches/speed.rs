//! CPU time a particle-step by dimension and size, least of three runs: `cargo bench -p hvi-impact`; `-- sweep`: the
//! whole eta sweep of pipelines/copper.toml instead, one run each. Linux only.
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, Places, Stage};

/// CPU time of this thread [s]; other work on the machine doesn't count.
fn cpu() -> f64 {
    let text =
        std::fs::read_to_string("/proc/thread-self/schedstat").expect("a Linux kernel with scheduler statistics");
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

fn main() {
    if std::env::args().any(|a| a == "sweep") {
        return sweep();
    }
    let cases = [
        (
            "line, Al-Al 6.7 km/s",
            r#"{"projectile":{"shape":"slab","length":"10 mm","material":"aluminium"},"plate":{"thickness":"10 mm","material":"aluminium"},"velocity":"6.7 km/s","cells":400,"space":"line","end":"1.5 us","strength":false}"#,
        ),
        (
            "(r, z), Cu-Cu 5.9 km/s",
            r#"{"projectile":{"shape":"sphere","diameter":"6.4 mm","material":"copper"},"plate":{"thickness":"2.5 mm","material":"copper"},"velocity":"5.9 km/s"}"#,
        ),
        (
            "(r, z), Cu-Cu 2.5 km/s",
            r#"{"projectile":{"shape":"sphere","diameter":"12.6 mm","material":"copper"},"plate":{"thickness":"2.5 mm","material":"copper"},"velocity":"2.5 km/s"}"#,
        ),
        (
            "(r, z), 12 cells",
            r#"{"projectile":{"shape":"sphere","diameter":"6.4 mm","material":"copper"},"plate":{"thickness":"2.5 mm","material":"copper"},"velocity":"5.9 km/s","cells":12}"#,
        ),
        (
            "quarter, Al-Al 6.7 km/s",
            r#"{"projectile":{"shape":"sphere","diameter":"9.53 mm","material":"aluminium"},"plate":{"thickness":"1.906 mm","width":"38.12 mm","material":"aluminium"},"velocity":"6.7 km/s","cells":3,"space":"quarter","end":"2.5 us"}"#,
        ),
    ];
    for (name, text) in cases {
        let params: Params = serde_json::from_str(text).expect("parameters");
        let mut seconds = f64::INFINITY;
        let mut last = None;
        for _ in 0..3 {
            let start = cpu();
            let made = ImpactStage::run(
                &params,
                ImpactInputs { eos: Places(Default::default()), file: Places(Default::default()) },
                &Ctx::quiet(),
            );
            seconds = seconds.min(cpu() - start);
            last = Some(made.expect("runs"));
        }
        let impact = last.expect("three runs");
        let particles = impact.snapshots[0].particles.mass.len();
        let steps = impact.ledger.last().expect("an end").step;
        println!(
            "{name:26} {particles:7} particles {steps:5} steps {seconds:7.3} s  {:6.0} ns a particle-step  (predicted {:.2} s)",
            seconds * 1e9 / (particles as f64 * steps as f64),
            ImpactStage::cost(&params)
        );
    }
}

/// Copper spheres on copper plates at every speed and diameter of the eta study, 6 cells.
fn sweep() {
    let (start, mut predicted, mut runs) = (cpu(), 0.0, 0);
    let plates =
        [("2.5 mm", &[1.0, 2.5, 4.2, 4.6, 5.0, 5.4, 5.9, 6.7, 7.5, 8.0][..]), ("5.0 mm", &[2.5, 4.2, 5.9, 7.5][..])];
    for (thickness, speeds) in plates {
        for speed in speeds {
            for diameter in ["1.6 mm", "3.2 mm", "6.4 mm", "12.6 mm"] {
                let params = serde_json::json!({
                    "projectile": { "shape": "sphere", "diameter": diameter, "material": "copper" },
                    "plate": { "thickness": thickness, "material": "copper" },
                    "velocity": format!("{speed} km/s"),
                });
                let params: Params = serde_json::from_value(params).expect("parameters");
                let before = cpu();
                let made = ImpactStage::run(
                    &params,
                    ImpactInputs { eos: Places(Default::default()), file: Places(Default::default()) },
                    &Ctx::quiet(),
                );
                let impact = made.expect("runs");
                let melt = &impact.snapshots[0].melt[0];
                println!(
                    "t {thickness} D {diameter} v {speed} km/s: liquid {:.3}, own volume {:.3}, {} steps, {} particles, \
                     {:.2} s (predicted {:.2} s)",
                    melt.liquid,
                    melt.by_phase_own_volume[2..].iter().sum::<f64>(),
                    impact.ledger.last().expect("an end").step,
                    impact.snapshots[0].particles.mass.len(),
                    cpu() - before,
                    ImpactStage::cost(&params)
                );
                predicted += ImpactStage::cost(&params);
                runs += 1;
            }
        }
    }
    println!("{runs} runs: {:.1} core-seconds (predicted {predicted:.1})", cpu() - start);
}
