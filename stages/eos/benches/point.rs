//! Nanoseconds per `Eos::point`, one core, over states as an impact meets them: `cargo bench -p hvi-eos`.
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).expect("a handbook set");
    let started = Instant::now();
    for _ in 0..100 {
        black_box(Gray::new(black_box(Set::CopperRoyce.parameters())).expect("a handbook set"));
    }
    println!("construction              {:7.1} us", started.elapsed().as_secs_f64() * 1e4);
    let eos = Eos::Gray(gray.clone());
    let v0 = eos.reference_volume();
    let mut seed = 1u64;
    let mut uniform = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    // (V, E) by regime, from V and T.
    let mut regimes: [Vec<(f64, f64)>; 5] = Default::default();
    for i in 0..200_000 {
        let regime = i % 5;
        let v = v0 * if regime == 4 { 1.5 + 10.0 * uniform() } else { 0.6 + 0.8 * uniform() };
        let [start, end, hot] = gray.borders(v);
        let range = [(200.0, start), (start, end), (end, hot), (hot, 2.0 * hot), (1e3, 3e4)][regime];
        let t = range.0 + (range.1 - range.0) * uniform();
        regimes[regime].push((v, eos.energy_at(v, t)));
    }
    let mixed: Vec<_> =
        (0..100_000).map(|i| regimes[[0, 0, 0, 0, 0, 0, 0, 1, 2, 3][i % 10]][i / 10 % 40_000]).collect();
    let near: Vec<_> = (0..100_000).map(|i| (v0 * (0.98 + 0.0000003 * i as f64), 1e4)).collect();
    let names = ["solid", "melting", "liquid", "hot liquid", "vapour"];
    for (name, states) in names.iter().zip(&regimes) {
        time(name, &eos, states);
    }
    time("70 % solid, 10 % each", &eos, &mixed);
    for set in hvi_eos::Instructions::all() {
        for (name, states) in names.iter().zip(&regimes).chain([(&"mixed", &mixed)]) {
            let (v, e): (Vec<f64>, Vec<f64>) = states.iter().copied().unzip();
            let mut out = hvi_eos::Points::default();
            let mut best = f64::INFINITY;
            for _ in 0..20 {
                let started = Instant::now();
                eos.evaluate_with(set, black_box(&v), &e, &mut out);
                best = best.min(started.elapsed().as_secs_f64() / v.len() as f64);
            }
            println!("{} {name:25} {:7.1} ns", set.name(), best * 1e9);
        }
    }
    time("solid, neighbouring V", &eos, &near);
}

fn time(name: &str, eos: &Eos, states: &[(f64, f64)]) {
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let started = Instant::now();
        let mut sum = 0.0;
        for &(v, e) in states {
            let at = eos.point(black_box(v), e);
            sum += at.pressure + at.temperature + at.sound_speed + f64::from(at.phase as u8);
        }
        black_box(sum);
        best = best.min(started.elapsed().as_secs_f64() / states.len() as f64);
    }
    println!("{name:25} {:7.1} ns", best * 1e9);
}
