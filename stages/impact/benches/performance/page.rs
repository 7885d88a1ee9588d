//! What was measured as a page and a figure.
use super::blocks::Case;
use super::machine::Machine;
use super::scenes::Scene;
use std::fmt::Write;

/// All of it.
pub struct Measured {
    pub machine: Machine,
    pub methods: Vec<Case>,
    pub sizes: Vec<Case>,
    pub threads: f64,
    pub scenes: Vec<Scene>,
}

/// Operations of a particle's transfers in space with `n` nodes an axis, counted from the loops of `transfer.rs`: fused products of
/// eight numbers (two nodes), two operations each.
struct Transfers {
    n: f64,
    pairs: f64,
}

impl Transfers {
    fn new(n: u32) -> Transfers {
        Transfers { n: f64::from(n), pairs: f64::from(n.div_ceil(2)) }
    }
    /// `spread`: nodes, then planes, then rows; with what is linear in the place or without.
    fn spread(&self, linear: bool) -> f64 {
        let [nodes, planes, rows] = if linear { [2.0, 3.0, 4.0] } else { [1.0, 1.0, 1.0] };
        (nodes * self.n * self.n + planes * self.n + rows) * self.pairs
    }
    /// `gather`: the mean, and `kinds` of the slopes and the moments.
    fn gather(&self, kinds: f64) -> f64 {
        ((1.0 + kinds) * self.n * self.n + (1.0 + 2.0 * kinds) * self.n + 1.0 + 3.0 * kinds) * self.pairs
    }
}

/// Operations of a step's transfers of a particle: momentum to the grid, velocities back, forces to the grid, two velocities back, and
/// with `heat` its conduction there and back.
fn operations(nodes: u32, affine: bool, heat: bool) -> f64 {
    let t = Transfers::new(nodes);
    let more = f64::from(u8::from(affine));
    let motion = t.spread(affine) + t.gather(1.0 + more) + t.spread(true) + t.gather(more) + t.gather(1.0);
    16.0 * (motion + if heat { t.spread(false) + t.gather(0.0) } else { 0.0 })
}

/// Bytes that the passes of a step of the default method read and write of a particle in space, counted from what they load and
/// store, in numbers: momentum 16; force 41, 10 back; heat 9; update 44, 38 back.
const BYTES: f64 = 8.0 * (16.0 + 51.0 + 9.0 + 82.0);

/// The page, in Markdown.
pub fn text(m: &Measured) -> String {
    let mut out = String::from(
        "# Speed of the material point method\n\nMade by `make performance`, best on a machine with nothing else \
         to do. CPU time on one core, f64, Johnson-Cook strength and damage, spall, GRAY, artificial viscosity, sorting included; \
         medians over steps.\n\n## The machine\n\n",
    );
    let fastest = m.machine.flops.iter().map(|f| f.1).fold(1e-9, f64::max);
    let _ = writeln!(out, "{}, one core: memory {:.1} GB/s", m.machine.name, m.machine.memory);
    for (set, flops) in &m.machine.flops {
        let _ = writeln!(out, "- {set}: {flops:.1} GFLOP/s in fused products");
    }
    let _ = writeln!(
        out,
        "\nThe transfers of a particle-step in space take {:.0} operations with cubic weights and heat conduction, {:.0} with linear ones, \
         counted from the loops: at least {:.0} and {:.0} ns here, to which the material's share comes. The particles of a cubic \
         step are {BYTES} B of traffic: {:.0} ns where no cache holds them.\n\n## Methods\n\nTwo blocks of aluminium at 3 km/s, all \
         particles in contact.\n\n| space | method | particles | ns a particle-step |\n|---|---|---|---|",
        operations(4, true, true),
        operations(2, false, false),
        operations(4, true, true) / fastest,
        operations(2, false, false) / fastest,
        BYTES / m.machine.memory
    );
    let space = |axes: usize| ["line", "plane", "space"][axes - 1];
    for c in &m.methods {
        let _ = writeln!(out, "| {} | {} | {} | {:.0} |", space(c.axes), c.name, c.count, c.time);
    }
    let _ = writeln!(
        out,
        "\n## Sizes\n\n![ns a particle-step by number of particles](pictures/performance.svg)\n\n\
         | particles | ns a particle-step |\n|---|---|"
    );
    for c in &m.sizes {
        let _ = writeln!(out, "| {} | {:.0} |", c.count, c.time);
    }
    let _ = writeln!(out, "\nTwo threads are {:.2} times as fast as one (1e5 particles, wall-clock time).", m.threads);
    if !m.scenes.is_empty() {
        let _ = writeln!(
            out,
            "\n## Scene S1 to 10 us\n\nAluminium sphere of 9.53 mm on 1.906 mm at 6.7 km/s, Mie-Grueneisen. The peer, MPM3D-F90, takes 66 to 86 s \
             linear and 123 s with B-splines for the full scene.\n\n\
             Differences are from the full scene with the same method.\n\n\
             | run | particles | steps | CPU time, s | ns a particle-step | leading .1 / 1 / 5 %, m/s | differences | highest rho/rho0 |\n\
             |---|---|---|---|---|---|---|---|"
        );
    }
    for s in &m.scenes {
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.2} | {:.0} | {:.0} / {:.0} / {:.0} | {} | {:.3} |",
            s.name,
            s.particles,
            s.steps,
            s.time,
            s.each,
            s.leading[0],
            s.leading[1],
            s.leading[2],
            differences(s, &m.scenes),
            s.compression
        );
    }
    out
}

/// Of the leading velocities from those of the full scene with the same method [%].
fn differences(s: &Scene, all: &[Scene]) -> String {
    let method = |s: &Scene| s.name.contains("linear");
    let Some(full) = all.iter().find(|other| method(other) == method(s)).filter(|full| full.name != s.name) else {
        return "-".into();
    };
    let each = s.leading.iter().zip(full.leading).map(|(x, known)| format!("{:+.2} %", 100.0 * (x / known - 1.0)));
    each.collect::<Vec<_>>().join(" / ")
}

/// Time a particle-step by number of particles, as SVG.
pub fn figure(sizes: &[Case]) -> String {
    let (left, bottom, wide, high) = (60.0, 260.0, 400.0, 220.0);
    let top = 1.2 * sizes.iter().map(|c| c.time).fold(0.0, f64::max);
    let x = |count: f64| left + wide * (count.log10() - 4.0) / 3.0;
    let y = |time: f64| bottom - high * time / top;
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 500 310\" font-family=\"sans-serif\" font-size=\"12\">\n",
    );
    let _ = writeln!(out, "<path d=\"M{left} 40V{bottom}H{}\" fill=\"none\" stroke=\"black\"/>", left + wide);
    for power in 4..=7 {
        let at = x(10f64.powi(power));
        let _ = writeln!(out, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">1e{power}</text>", bottom + 18.0);
    }
    for k in 0..=4 {
        let time = top * f64::from(k) / 4.0;
        let _ =
            writeln!(out, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{time:.0}</text>", left - 6.0, y(time) + 4.0);
    }
    let line: Vec<String> = sizes.iter().map(|c| format!("{:.1},{:.1}", x(c.count as f64), y(c.time))).collect();
    let _ =
        writeln!(out, "<polyline points=\"{}\" fill=\"none\" stroke=\"#1f77b4\" stroke-width=\"2\"/>", line.join(" "));
    for c in sizes {
        let _ =
            writeln!(out, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"#1f77b4\"/>", x(c.count as f64), y(c.time));
    }
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">particles</text>",
        left + 0.5 * wide,
        bottom + 38.0
    );
    let _ =
        writeln!(out, "<text x=\"{left}\" y=\"28\">ns a particle-step, cubic APIC in space, one core</text>\n</svg>");
    out
}
