//! Gas of constant gamma: Noh's implosion, Sod's tube, even and free expansion.
use super::Row;
use hvi_eos::{Eos, IdealGas};
use hvi_impact::material::{Law, Material, Switches};
use hvi_impact::particle::Particle;
use hvi_impact::step::{Setting, State};

/// A gas as a law without strength.
pub fn law(density: f64, gamma: f64) -> Law {
    let off = Switches { strength: false, damage: false, spall: false };
    let eos = Eos::IdealGas(IdealGas::new(density, gamma, 700.0, 300.0).expect("a gas"));
    Law::new(&Material::named("copper").expect("shipped"), eos, off)
}

/// Sets each particle's energy [J/kg] and its state by it.
pub fn heat<const D: usize>(state: &mut State<D>, setting: &Setting<D>, energy: impl Fn(&Particle<D>) -> f64) {
    state.alter(|p| {
        p.energy = energy(p);
        setting.laws[p.body as usize].evaluate(p);
    });
}

/// Kinetic and internal energy, less what the floor put in [J].
pub fn energy<const D: usize>(state: &State<D>, setting: &Setting<D>) -> f64 {
    let moment = setting.method.moment(setting.cell);
    state.particles().map(|p| p.kinetic(moment) + p.mass * p.energy).sum::<f64>() - state.totals.floored
}

/// Steps to `end` [s].
pub fn go<const D: usize>(state: &mut State<D>, setting: &Setting<D>, end: f64) {
    while state.time < end {
        state.step(setting, end).expect("a step");
    }
}

fn radius<const D: usize>(p: &Particle<D>) -> f64 {
    p.position.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Cold gas of gamma 5/3 falling in at speed 1: density 4^D behind a shock that leaves the centre at 1/3.
///
/// Returns the mean density at .06 < r < .16 at time .6, the shock at .2.
fn noh<const D: usize>(cells: usize) -> (f64, f64) {
    let mut setting = Setting::<D>::new(1.0 / cells as f64, vec![law(1.0, 5.0 / 3.0)]);
    setting.mirrors = [true; D];
    let n = 2 * cells;
    let h = 1.0 / n as f64;
    let mut particles = Vec::new();
    for number in 0..n.pow(D as u32) {
        let x: [f64; D] = std::array::from_fn(|d| ((number / n.pow((D - 1 - d) as u32) % n) as f64 + 0.5) * h);
        let r = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        if r < 1.0 {
            let volume = h.powi(D as i32);
            particles.push(Particle::new(x, x.map(|x| -x / r), volume, volume, number as u32, 0));
        }
    }
    let mut state = State::new(particles, &setting);
    heat(&mut state, &setting, |_| 1e-8);
    let start = energy(&state, &setting);
    go(&mut state, &setting, 0.6);
    let (mut mass, mut volume) = (0.0, 0.0);
    for p in state.particles().filter(|p| (0.06..0.16).contains(&radius(p))) {
        (mass, volume) = (mass + p.mass, volume + p.volume * p.ratio);
    }
    (mass / volume, energy(&state, &setting) / start - 1.0)
}

/// The three geometries, the round ones at the size that fits.
pub fn noh_rows(cylindrical: usize, spherical: usize) -> Vec<Row> {
    let case = "viscosity heat, wall heating";
    let (line, drift) = noh::<1>(200);
    let (disc, _) = noh::<2>(cylindrical);
    let (ball, _) = noh::<3>(spherical);
    vec![
        Row::within(case, "Noh, planar, 200 cells: density", line, "", 4.0, 2e-3),
        // Rounding of the flow's energy, 5e7 times that of the cold gas, over some thousand steps.
        Row::most(case, "Noh, planar, 200 cells: energy drift", drift.abs(), "", 1e-10),
        Row::within(case, format!("Noh, cylindrical, {cylindrical} cells: density"), disc, "", 16.0, 0.1),
        Row::reported(case, format!("Noh, spherical, {spherical} cells: density (64 is exact)"), ball, ""),
    ]
}

/// Density, velocity and pressure of Sod's tube (gamma 1.4, 1 / 1 and .125 / .1) at x / t: Riemann's exact solution.
fn sod(z: f64) -> f64 {
    let pow = hvi_kit::math::pow;
    let (g, pl, rl, pr, rr): (f64, f64, f64, f64, f64) = (1.4, 1.0, 1.0, 0.1, 0.125);
    let (cl, cr) = ((g * pl / rl).sqrt(), (g * pr / rr).sqrt());
    let speed = |p: f64| 2.0 * cl / (g - 1.0) * (pow(p / pl, (g - 1.0) / (2.0 * g)) - 1.0);
    let balance = |p: f64| (p - pr) * (2.0 / ((g + 1.0) * rr) / (p + (g - 1.0) / (g + 1.0) * pr)).sqrt() + speed(p);
    let p = hvi_kit::math::bisect(0.1, 1.0, 1e-14, balance).expect("a root");
    let u = -speed(p);
    let left = rl * pow(p / pl, 1.0 / g);
    let right = rr * (p / pr + (g - 1.0) / (g + 1.0)) / ((g - 1.0) / (g + 1.0) * p / pr + 1.0);
    let shock = cr * ((g + 1.0) / (2.0 * g) * p / pr + (g - 1.0) / (2.0 * g)).sqrt();
    match z {
        z if z < -cl => rl,
        z if z < u - (g * p / left).sqrt() => {
            let c = cl - 0.5 * (g - 1.0) * 2.0 / (g + 1.0) * (cl + z);
            rl * pow(c / cl, 2.0 / (g - 1.0))
        }
        z if z < u => left,
        z if z < shock => right,
        _ => rr,
    }
}

/// Sod's tube at t = .2, 200 cells over the unit length (and half as much again on either side, which no wave leaves).
pub fn sod_rows() -> Vec<Row> {
    let cells = 200;
    let setting = Setting::<1>::new(1.0 / cells as f64, vec![law(1.0, 1.4), law(0.125, 1.4)]);
    let h = 0.5 / cells as f64;
    let n = 4 * cells;
    let particles = (0..n).map(|i| {
        let x = (i as f64 + 0.5) * h - 1.0;
        let body = (x > 0.0) as u8;
        Particle::new([x], [0.0], [1.0, 0.125][body as usize] * h, h, i as u32, body)
    });
    let mut state = State::new(particles.collect(), &setting);
    heat(&mut state, &setting, |p| if p.body == 0 { 2.5 } else { 2.0 });
    go(&mut state, &setting, 0.2);
    let (mut error, mut length) = (0.0, 0.0);
    for p in state.particles().filter(|p| p.position[0].abs() < 0.5) {
        let volume = p.volume * p.ratio;
        error += volume * (p.mass / volume - sod(p.position[0] / 0.2)).abs();
        length += volume;
    }
    let row = Row::most(
        "viscosity heat, wall heating",
        "Sod, 200 cells: mean error of the density",
        error / length,
        "",
        0.01,
    );
    vec![row]
}

/// A block of gas that expands evenly, v = x / s: no shock, so no heat of viscosity or conduction. By t = 1 s to eight times its
/// volume: pressure by the equation of state of what it has lost in work, momentum zero.
pub fn expansion_rows() -> Vec<Row> {
    let setting = Setting::<3>::new(0.1, vec![law(1.0, 1.4)]);
    let (n, h) = (10, 0.05);
    let particles = (0..n * n * n).map(|i| {
        let x: [f64; 3] = [i / (n * n), i / n % n, i % n].map(|k| (k as f64 + 0.5 - 0.5 * n as f64) * h);
        let mut p = Particle::new(x, x, h * h * h, h * h * h, i as u32, 0);
        (0..3).for_each(|d| p.affine[d][d] = 1.0);
        p
    });
    let mut state = State::new(particles.collect(), &setting);
    // So cold that its pressure moves nothing: sound at 1e-3 of the flow.
    heat(&mut state, &setting, |_| 1e-8);
    let start = energy(&state, &setting);
    go(&mut state, &setting, 1.0);
    let momentum: f64 = (0..3).map(|d| state.particles().map(|p| p.mass * p.velocity[d]).sum::<f64>().abs()).sum();
    let kept: f64 = state.particles().map(|p| p.mass * p.velocity[0].abs()).sum();
    // The corner's neighbours on the outside are missing: the inner half of the block is what the answer is known for.
    let inner: Vec<Particle<3>> = state.particles().filter(|p| p.position.iter().all(|x| x.abs() < 0.25)).collect();
    let worst = inner.iter().map(|p| (p.ratio / 8.0 - 1.0).abs()).fold(0.0, f64::max);
    let pressure = inner.iter().map(|p| (p.pressure() * p.ratio / (0.4 * p.energy) - 1.0).abs()).fold(0.0, f64::max);
    let fracture = "numerical fracture";
    vec![
        Row::most("viscosity heat, wall heating", "even expansion: heat of viscosity", state.totals.viscous, "J", 0.0),
        Row::most(fracture, "gas expanded 8 times: error of P by the equation of state", pressure, "", 1e-12),
        Row::most(fracture, "gas expanded 8 times: error of V/V0 inside", worst, "", 0.01),
        Row::most(fracture, "gas expanded 8 times: momentum over that of one side", momentum / kept, "", 1e-13),
        Row::most(
            fracture,
            "gas expanded 8 times: energy drift",
            (energy(&state, &setting) / start - 1.0).abs(),
            "",
            1e-12,
        ),
    ]
}
