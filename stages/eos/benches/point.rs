//! Nanoseconds per (V, E) -> (P, T, c, phase), one core: `cargo bench -p hvi-eos`. With `HVI_WRITE=FILE` the page goes to that file,
//! and the curve of error against time beside it as SVG: `make eos-speed` makes docs/eos-speed.md and docs/eos-speed.svg so. CPU
//! time, on Linux only.
use hvi_eos::handbook::Set;
use hvi_eos::{Eos, Gray, Instructions, Patches, Points};
use std::fmt::Write;
use std::hint::black_box;

#[path = "../../impact/benches/performance/cpu.rs"]
mod cpu;

const NAMES: [&str; 6] = ["solid", "melting", "liquid", "hot liquid", "vapour", "70 % solid, 10 % each"];

struct States {
    volume: Vec<f64>,
    energy: Vec<f64>,
}

/// Rounds of which the median counts, and the least CPU time of each [s]: the kernel's clock of a thread moves by some ms.
const ROUNDS: usize = 9;
const LEAST: f64 = 0.05;
/// States a call: what a pass of the impact solver hands over at once.
const COUNT: usize = 2000;

fn main() {
    let gray = Gray::new(Set::CopperRoyce.parameters()).expect("a handbook set");
    let eos = Eos::Gray(gray.clone());
    let all = states(&gray);
    let mut text = format!(
        "# Speed of the equation of state\n\n\
         Made by `make eos-speed`. Copper (`copper-royce`), one core, nanoseconds of CPU time per (V, E) -> (P, T, c, phase, share of \
         liquid, T_m), median of {ROUNDS} rounds over {COUNT} random states; of solid to hot liquid V lies between 0.6 and 1.4 V0, of \
         the vapour between 1.5 and 11.5 V0. Machine: {}.\n\n",
        processor()
    );
    let built = seconds(|| {
        black_box(Gray::new(black_box(Set::CopperRoyce.parameters())).expect("a handbook set"));
    });
    let _ = writeln!(text, "Construction: {:.2} ms.\n", 1e3 * built);
    let _ = writeln!(text, "| formulas | {} |\n|---|{}", NAMES.join(" | "), "---|".repeat(NAMES.len()));
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
    let points = curve(&mut text, &gray, &all);
    print!("{text}");
    if let Some(path) = std::env::var_os("HVI_WRITE") {
        let path = std::path::PathBuf::from(path);
        std::fs::write(path.with_extension("svg"), picture(&points)).expect("the file can be written");
        std::fs::write(path, text).expect("the file can be written");
    }
}

/// The processor's name.
fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
    name.map_or("unknown", |(_, name)| name).to_string()
}

/// Error found and nanoseconds of the mixture.
type Measured = (f64, f64);

/// Error against time: the patches, from coarse to fine, and the formulas.
fn curve(text: &mut String, gray: &Gray, all: &[States]) -> (Vec<Measured>, f64) {
    let _ = writeln!(
        text,
        "\n## Error against time\n\n![error against time](eos-speed.svg)\n\nGRAY in patches of polynomials (`accuracy` of an \
         equation of state), built to a stated error: of P relative to the larger of |P| and rho0 C^2/100, of T to the larger of T and \
         T0, of the sound speed, of the share of liquid, of T_m. Nanoseconds as above, `evaluate` on {}; the vapour is GRAY's own formula \
         throughout.\n\n\
         | stated | found | patches | MB | built in ms | {} | one at a time, mixture |\n|---|---|---|---|---|{}---|",
        Instructions::best().name(),
        NAMES.join(" | "),
        "---|".repeat(NAMES.len())
    );
    let mut points = Vec::new();
    for accuracy in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let Ok(patches) = Patches::new(gray.clone(), accuracy) else { continue };
        let built = 1e3 * seconds(|| drop(black_box(Patches::new(gray.clone(), accuracy))));
        let (found, (count, bytes)) = (patches.errors().largest(), patches.size());
        let _ = write!(text, "| {accuracy:.0e} | {found:.1e} | {count} | {:.2} | {built:.1} |", bytes as f64 / 1e6);
        points.push((found, times(text, &Eos::Patches(patches), all)));
    }
    let _ = write!(text, "| formulas | 0 | | | |");
    let exact = times(text, &Eos::Gray(gray.clone()), all);
    (points, exact)
}

/// The nanoseconds of one equation of state: each kind of states, then the mixture one at a time. Returns those of the mixture.
fn times(text: &mut String, eos: &Eos, all: &[States]) -> f64 {
    let mut out = Points::default();
    let mut last = 0.0;
    for s in all {
        last = 1e9 / s.volume.len() as f64 * seconds(|| eos.evaluate(black_box(&s.volume), &s.energy, &mut out));
        let _ = write!(text, " {last:.1} |");
    }
    let mixture = &all[all.len() - 1];
    let single = seconds(|| {
        for i in 0..mixture.volume.len() {
            out.set(i, eos.point(black_box(mixture.volume[i]), mixture.energy[i]));
        }
    });
    let _ = writeln!(text, " {:.1} |", single / mixture.volume.len() as f64 * 1e9);
    last
}

/// The curve, and the formulas' time as a line; both axes logarithmic.
fn picture((points, exact): &(Vec<Measured>, f64)) -> String {
    let (width, height) = (640.0, 400.0);
    let x = |error: f64| 70.0 + (width - 100.0) * (error.log10() + 6.0) / 5.5;
    let y = |ns: f64| height - 50.0 - (height - 80.0) * (ns / 5.0).log10() / (200.0f64 / 5.0).log10();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let mut line = |a: [f64; 2], b: [f64; 2], style: &str| {
        let _ = writeln!(
            svg,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" {style}/>",
            a[0], a[1], b[0], b[1]
        );
    };
    let ends = [x(1e-6), x(10f64.powf(-0.5))];
    for ns in [5.0, 10.0, 20.0, 50.0, 100.0, 200.0] {
        line([ends[0], y(ns)], [ends[1], y(ns)], "stroke=\"#ddd\"");
    }
    for power in -6..0 {
        let at = x(10f64.powi(power));
        line([at, y(5.0)], [at, y(200.0)], "stroke=\"#ddd\"");
    }
    line([ends[0], y(*exact)], [ends[1], y(*exact)], "stroke=\"#c33\" stroke-dasharray=\"6 4\"");
    for pair in points.windows(2) {
        line([x(pair[0].0), y(pair[0].1)], [x(pair[1].0), y(pair[1].1)], "stroke=\"#36c\" stroke-width=\"2\"");
    }
    let mut write = |at: [f64; 2], anchor: &str, words: &str| {
        let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{words}</text>", at[0], at[1]);
    };
    for ns in [5.0, 10.0, 20.0, 50.0, 100.0, 200.0] {
        write([ends[0] - 6.0, y(ns) + 4.0], "end", &format!("{ns}"));
    }
    for power in -6..0 {
        write([x(10f64.powi(power)), height - 32.0], "middle", &format!("1e{power}"));
    }
    write([0.5 * width, height - 10.0], "middle", "largest relative error found");
    write([ends[0], 20.0], "start", "ns a state (mixture): blue the patches, red the formulas");
    for (error, ns) in points {
        let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"#36c\"/>", x(*error), y(*ns));
    }
    svg + "</svg>\n"
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
        let (volume, energy) = (0..COUNT).map(|i| one(pick(i))).unzip();
        States { volume, energy }
    };
    let mut all: Vec<States> = (0..5).map(|regime| of(&|_| regime)).collect();
    all.push(of(&|i| [0, 0, 0, 1, 0, 2, 0, 0, 3, 0][i % 10]));
    all
}

/// Median CPU seconds of a call of `work`.
fn seconds(mut work: impl FnMut()) -> f64 {
    let round = |_| {
        let (start, mut calls) = (cpu::thread(), 0.0);
        loop {
            (0..8).for_each(|_| work());
            calls += 8.0;
            let spent = cpu::thread() - start;
            if spent >= LEAST {
                return spent / calls;
            }
        }
    };
    cpu::median((0..ROUNDS).map(round).collect())
}

/// One line of the table.
fn row(text: &mut String, name: &str, all: &[States], mut work: impl FnMut(&States, &mut Points)) {
    let mut out = Points::default();
    let _ = write!(text, "| {name} |");
    for s in all {
        out.resize(s.volume.len());
        let _ = write!(text, " {:.1} |", seconds(|| work(s, &mut out)) / s.volume.len() as f64 * 1e9);
    }
    let _ = writeln!(text);
    black_box(&out);
}
