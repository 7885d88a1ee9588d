//! Time a particle-step by dimension and equation of state: `cargo bench -p hvi-impact`. Needs no library.
use hvi_impact::{ImpactInputs, ImpactStage, Params};
use hvi_kit::{Ctx, Places, Stage};
use std::time::Instant;

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
        let start = Instant::now();
        let made = ImpactStage::run(&params, ImpactInputs { eos: Places(Default::default()) }, &Ctx::quiet());
        let seconds = start.elapsed().as_secs_f64();
        let impact = made.expect("runs");
        let particles = impact.snapshots[0].particles.mass.len();
        let steps = impact.ledger.last().expect("an end").step;
        println!(
            "{name:26} {particles:7} particles {steps:5} steps {seconds:7.3} s  {:6.0} ns a particle-step  (predicted {:.2} s)",
            seconds * 1e9 / (particles as f64 * steps as f64),
            ImpactStage::cost(&params)
        );
    }
}
