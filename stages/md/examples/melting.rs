//! Points of the melting curve: `cargo run --release -p hvi-md --example melting -- ACROSS ALONG SEED GPA...`.
use hvi_kit::{Artifact, Ctx, Stage};
use hvi_md::TwoPhases;
use hvi_md::coexistence::{Params, run};
use hvi_md::lanes::Isa;
use std::collections::BTreeMap;

fn main() {
    let arguments: Vec<f64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let (across, along, seed) = (arguments[0] as u32, arguments[1] as u32, arguments[2] as u64);
    for gigapascal in &arguments[3..] {
        let text = format!(
            r#"{{"potential":"mishin-2001","pressure":"{gigapascal} GPa","across":{across},"along":{along},"seed":{seed}}}"#
        );
        let params: Params = serde_json::from_str(&text).expect("it is what the stage takes");
        TwoPhases::check(&params).expect("it is in range");
        let start = std::time::Instant::now();
        match run(&params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()) {
            Ok(found) => {
                for s in found.scalars() {
                    println!("{}: {:?} {}", s.name, s.value, s.unit);
                }
                println!("{:?}\n{:?}", found.attempts, found.profile);
                let every = found.looks.iter().step_by(8);
                every.for_each(|l| println!("{:6.2} ps {:7.1} K {:.3}", l.time * 1e12, l.temperature, l.solid));
            }
            Err(e) => println!("{e}"),
        }
        println!("{:.1} s, predicted {:.1} s", start.elapsed().as_secs_f64(), TwoPhases::cost(&params));
    }
}
