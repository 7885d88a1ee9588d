//! CPU time a particle-step by dimension and size, least of three runs: `cargo bench -p hvi-impact`. Linux only.
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, Places, Stage};

/// CPU time of this thread [s]; other work on the machine doesn't count.
fn cpu() -> f64 {
    let text =
        std::fs::read_to_string("/proc/thread-self/schedstat").expect("a Linux kernel with scheduler statistics");
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

fn main() {
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
            let made = ImpactStage::run(&params, ImpactInputs { eos: Places(Default::default()) }, &Ctx::quiet());
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
