//! The states of the copper pipeline, one line each, and what they cost: `cargo run --release -p hvi-md --example grid -- ATOMS`.
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Ctx, Stage};
use hvi_md::lanes::Isa;
use hvi_md::potential::{BuiltIn, Named};
use hvi_md::{By, Md, Params, Phase, run};
use std::collections::BTreeMap;

fn main() {
    let arg = |k: usize, or: f64| std::env::args().nth(k).and_then(|a| a.parse().ok()).unwrap_or(or);
    println!(
        " V/V0     T |     P       +- GPa |        E   +- kJ/kg | phase    ps  mapped  order  rms/d | core-s  predicted"
    );
    let (mut total, mut predicted) = (0.0, 0.0);
    for v in 0..15 {
        for t in 0..10 {
            let params = Params {
                engine: By::Native,
                potential: Named::BuiltIn(BuiltIn::Mishin2001),
                atoms: arg(1, 500.0) as u32,
                volume_ratio: 1.06 - 0.03 * f64::from(v),
                pressed: None,
                temperature: Temperature::new(300.0 + 4200.0 / 9.0 * f64::from(t)),
                time_step: Time::new(arg(2, 3.0) * 1e-15),
                equilibration: Time::new(1e-12),
                target_error: Pressure::new(arg(3, 0.1) * 1e9),
                shortest: Time::new(2e-12),
                longest: Time::new(60e-12),
                seed: arg(4, 1.0) as u64,
                trajectory: None,
                ranks: 1,
            };
            let start = cpu_time();
            let state = run::state(&params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()).expect("a state");
            let spent = (cpu_time() - start) * 1e-9;
            total += spent;
            predicted += Md::cost(&params);
            println!(
                "{:5.3} {:5.0} | {:8.3} {:6.3} | {:8.2} {:6.2} | {} {:6.2} {:6} {:6.3} {:6.3} | {:5.2} {:5.2}",
                params.volume_ratio,
                state.temperature,
                state.pressure * 1e-9,
                state.pressure_error * 1e-9,
                state.energy * 1e-3,
                state.energy_error * 1e-3,
                if state.phase == Phase::Solid { "solid " } else { "liquid" },
                state.averaged * 1e12,
                state.mapped,
                state.order,
                state.displacement,
                spent,
                Md::cost(&params),
            );
        }
    }
    println!("150 states: {total:.1} core-seconds, {predicted:.1} predicted");
}

/// CPU time of this thread so far [ns], as Linux counts it.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts the time of threads");
    text.split(' ').next().and_then(|t| t.parse().ok()).expect("its first field is a time")
}
