//! Time a particle-step of one block of metal driven into another: every particle in contact with others, all of the material model at
//! work, sorting included.
use super::cpu;
use hvi_impact::kernel::Kernel;
use hvi_impact::material::{Law, Material, Switches};
use hvi_impact::method::{Method, Transfer};
use hvi_impact::particle::Particle;
use hvi_impact::step::{Setting, State};

/// One case.
pub struct Case {
    /// Axes of space.
    pub axes: usize,
    /// What it is.
    pub name: String,
    /// Particles.
    pub count: usize,
    /// Median CPU time of a step over the number of particles [ns].
    pub time: f64,
}

/// Two blocks of aluminium at 3 km/s, `n` cells long and across, 2 particles a cell and axis.
fn blocks<const D: usize>(n: usize, method: Method) -> (State<D>, Setting<D>) {
    let aluminium = Material::named("aluminium").expect("shipped");
    let on = Switches { strength: true, damage: true, spall: true };
    let law = Law::new(&aluminium, aluminium.eos.clone(), on);
    let (cell, density) = (1e-4, 1.0 / law.eos.reference_volume());
    let mut setting = Setting::<D>::new(cell, vec![law.clone(), law]);
    setting.method = method;
    let (h, across) = (0.5 * cell, 2 * n);
    let volume = (0..D).map(|_| h).product::<f64>();
    let particles = (0..across.pow(D as u32)).map(|number| {
        let mut rest = number;
        let position: [f64; D] = std::array::from_fn(|_| {
            let i = rest % across;
            rest /= across;
            (i as f64 + 0.5 - n as f64) * h
        });
        let first = position[0] < 0.0;
        // A little shear keeps the strength at work everywhere.
        let mut velocity = [0.0; D];
        velocity[0] = if first { 3000.0 } else { 0.0 };
        velocity[D - 1] += 200.0 * hvi_kit::math::sin(position[0] / (8.0 * cell));
        Particle::new(position, velocity, density * volume, volume, number as u32, !first as u8)
    });
    (State::new(particles.collect(), &setting), setting)
}

fn time<const D: usize>(count: f64, method: Method, steps: usize) -> (usize, f64) {
    let n = (0.5 * count.powf(1.0 / D as f64)).round() as usize;
    let (mut state, setting) = blocks::<D>(n, method);
    let mut take = || {
        let start = cpu::thread();
        state.step(&setting, 1.0).expect("a step");
        cpu::thread() - start
    };
    for _ in 0..5 {
        take();
    }
    let all = (0..steps).map(|_| take()).collect();
    (state.count(), 1e9 * cpu::median(all) / state.count() as f64)
}

fn case(axes: usize, name: String, count: f64, method: Method, steps: usize) -> Case {
    let (count, time) = match axes {
        1 => time::<1>(count, method, steps),
        2 => time::<2>(count, method, steps),
        _ => time::<3>(count, method, steps),
    };
    Case { axes, name, count, time }
}

/// Every kernel with its transfer, on a line, in the plane and in space, and what heat conduction costs.
pub fn methods() -> Vec<Case> {
    let all = [
        ("linear, FLIP", Kernel::Linear, Transfer::Flip),
        ("quadratic, APIC", Kernel::Quadratic, Transfer::Apic),
        ("cubic, APIC", Kernel::Cubic, Transfer::Apic),
    ];
    let mut cases = Vec::new();
    for axes in 1..=3 {
        for (name, kernel, transfer) in all {
            for (with, conduction) in [("", 0.0), (", heat conduction", Method::default().conduction)] {
                let method = Method { kernel, transfer, conduction, ..Method::default() };
                let count = [2e3, 4e4, 1e5][axes - 1];
                cases.push(case(axes, format!("{name}{with}"), count, method, 15));
            }
        }
    }
    cases
}

/// The default method in space by number of particles.
pub fn sizes(counts: &[f64]) -> Vec<Case> {
    let steps = |count: f64| if count > 2e6 { 3 } else { 9 };
    counts.iter().map(|&n| case(3, "cubic, APIC, heat conduction".into(), n, Method::default(), steps(n))).collect()
}

/// Wall-clock time of steps with one thread over that with two, the default method in space with 1e5 particles: alternated, medians.
pub fn threads() -> f64 {
    let (mut state, mut setting) = blocks::<3>(23, Method::default());
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..24 {
        setting.threads = 1 + round % 2;
        let start = std::time::Instant::now();
        state.step(&setting, 1.0).expect("a step");
        if round >= 4 {
            times[round % 2].push(start.elapsed().as_secs_f64());
        }
    }
    let [one, two] = times;
    cpu::median(one) / cpu::median(two)
}
