//! Nanoseconds per (V, E) -> (P, T, c, phase), one core: `cargo bench -p hvi-eos`. With `HVI_WRITE=FILE` the tables go to that file:
//! `HVI_WRITE=$PWD/docs/eos-speed.md cargo bench -p hvi-eos --bench point` makes docs/eos-speed.md.
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray, Instructions, Patches, Points};
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const NAMES: [&str; 6] = ["solid", "melting", "liquid", "hot liquid", "vapour", "70 % solid, 10 % each"];

struct States {
    volume: Vec<f64>,
    energy: Vec<f64>,
}

fn main() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).expect("a handbook set");
    let eos = Eos::Gray(gray.clone());
    let all = states(&gray);
    let mut text = String::from(
        "# Speed of the equation of state\n\n\
         Made by `HVI_WRITE=$PWD/docs/eos-speed.md cargo bench -p hvi-eos --bench point`. Copper (`copper-royce`), one core, nanoseconds \
         per (V, E) -> (P, T, c, phase, share of liquid), best of 30 rounds over 20,000 random states; of solid to hot liquid V lies \
         between 0.6 and 1.4 V0, of the vapour between 1.5 and 11.5 V0.\n\n",
    );
    let _ = writeln!(
        text,
        "Construction: {:.2} ms.\n",
        1e3 * best(10, || {
            black_box(Gray::new(black_box(Set::CopperRoyce.parameters())).expect("a handbook set"));
        })
    );
    let _ = writeln!(text, "| | {} |\n|---|{}", NAMES.join(" | "), "---|".repeat(NAMES.len()));
    row(&mut text, "one at a time (`point`)", &all, |s, out| {
        for i in 0..s.volume.len() {
            out.set(i, eos.point(black_box(s.volume[i]), s.energy[i]));
        }
    });
    for set in Instructions::all() {
        row(&mut text, &format!("`evaluate`, {}", set.name()), &all, |s, out| {
            eos.evaluate_with(set, black_box(&s.volume), &s.energy, out);
        });
    }
    curve(&mut text, &gray, &all);
    print!("{text}");
    if let Some(path) = std::env::var_os("HVI_WRITE") {
        std::fs::write(path, text).expect("the file can be written");
    }
}

/// Error against time: the patches, from coarse to fine, and the formulas.
fn curve(text: &mut String, gray: &Gray, all: &[States]) {
    let _ = writeln!(
        text,
        "\n## Error against time\n\nGRAY in patches of polynomials (`accuracy` of an equation of state), built to a stated error: of P relative to \
         the larger of |P| and rho0 C^2/100, of T to the larger of T and T0, of the sound speed, of the share of liquid. Nanoseconds as \
         above, `evaluate` on {}; the vapour is GRAY's own formula throughout.\n\n\
         | stated | found | patches | MB | built in ms | {} | one at a time, mixture |\n|---|---|---|---|---|{}---|",
        Instructions::best().name(),
        NAMES.join(" | "),
        "---|".repeat(NAMES.len())
    );
    for accuracy in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let Ok(patches) = Patches::new(gray.clone(), accuracy) else { continue };
        let built = 1e3 * best(3, || drop(black_box(Patches::new(gray.clone(), accuracy))));
        let (found, (count, bytes)) = (patches.errors().largest(), patches.size());
        let _ = write!(text, "| {accuracy:.0e} | {found:.1e} | {count} | {:.2} | {built:.1} |", bytes as f64 / 1e6);
        times(text, &Eos::Patches(patches), all);
    }
    let _ = write!(text, "| formulas | 0 | | | |");
    times(text, &Eos::Gray(gray.clone()), all);
}

/// The nanoseconds of one equation of state: each kind of states, then the mixture one at a time.
fn times(text: &mut String, eos: &Eos, all: &[States]) {
    let mut out = Points::default();
    for s in all {
        let seconds = best(30, || eos.evaluate(black_box(&s.volume), &s.energy, &mut out));
        let _ = write!(text, " {:.1} |", seconds / s.volume.len() as f64 * 1e9);
    }
    let mixture = &all[all.len() - 1];
    let seconds = best(30, || {
        for i in 0..mixture.volume.len() {
            out.set(i, eos.point(black_box(mixture.volume[i]), mixture.energy[i]));
        }
    });
    let _ = writeln!(text, " {:.1} |", seconds / mixture.volume.len() as f64 * 1e9);
}

/// States by regime, from V and T, and the mixture.
fn states(gray: &Gray) -> Vec<States> {
    let v0 = gray.parameters().volume;
    let mut seed = 1u64;
    let mut uniform = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut one = |regime: usize| {
        let v = v0 * if regime == 4 { 1.5 + 10.0 * uniform() } else { 0.6 + 0.8 * uniform() };
        let [start, end, hot] = gray.borders(v);
        let range = [(200.0, start), (start, end), (end, hot), (hot, 2.0 * hot), (1e3, 3e4)][regime];
        (v, gray.at(v, range.0 + (range.1 - range.0) * uniform()).0.energy)
    };
    let mut of = |pick: &dyn Fn(usize) -> usize| {
        let (volume, energy) = (0..20_000).map(|i| one(pick(i))).unzip();
        States { volume, energy }
    };
    let mut all: Vec<States> = (0..5).map(|regime| of(&|_| regime)).collect();
    all.push(of(&|i| [0, 0, 0, 1, 0, 2, 0, 0, 3, 0][i % 10]));
    all
}

/// Least seconds of `rounds` calls.
fn best(rounds: usize, mut work: impl FnMut()) -> f64 {
    (0..rounds)
        .map(|_| {
            let started = Instant::now();
            work();
            started.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// One line of the table.
fn row(text: &mut String, name: &str, all: &[States], mut work: impl FnMut(&States, &mut Points)) {
    let mut out = Points::default();
    let _ = write!(text, "| {name} |");
    for s in all {
        out.resize(s.volume.len());
        let _ = write!(text, " {:.1} |", best(30, || work(s, &mut out)) / s.volume.len() as f64 * 1e9);
    }
    let _ = writeln!(text);
    black_box(&out);
}
