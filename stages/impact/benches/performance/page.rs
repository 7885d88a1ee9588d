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

/// Numbers that a particle-step of the default method in space needs at least: counted from the inner loops (64 nodes; 3 fields to the
/// nodes, 9 sums back) and from what a particle keeps, read and written in each of four passes.
const FLOPS: f64 = 5000.0;
const BYTES: f64 = 2000.0;

/// The page, in Markdown.
pub fn text(m: &Measured) -> String {
    let mut out = String::from(
        "# Speed of the material point method\n\nMade by `cargo bench -p hvi-impact -- --write docs/performance.md` on a machine with nothing else \
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
        "\nA cubic particle-step in space takes some {FLOPS} operations and {BYTES} B of memory traffic: at least {:.0} ns here by arithmetic, \
         {:.0} ns by memory.\n\n## Methods\n\nTwo blocks of aluminium at 3 km/s, all particles in contact.\n\n\
         | space | method | particles | ns a particle-step |\n|---|---|---|---|",
        FLOPS / fastest,
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
             | run | particles | steps | CPU time, s | ns a particle-step | leading 1 %, m/s | highest rho/rho0 |\n|---|---|---|---|---|---|---|"
        );
    }
    for s in &m.scenes {
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.2} | {:.0} | {:.0} | {:.3} |",
            s.name, s.particles, s.steps, s.time, s.each, s.leading, s.compression
        );
    }
    out
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
