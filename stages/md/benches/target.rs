//! What a state costs by this program and by plain averaging with LAMMPS: `cargo bench -p hvi-md --bench target -- 7 3` for every
//! seventh volume and third temperature of the copper pipeline's 15 x 10 grid (1 1 for all of it).
//!
//! Asked for: standard errors of 0.1 GPa and of 0.5 % in E. 256 atoms; steps of 5 fs here, of 2 fs there, where plain averages
//! feel the step; 1 ps of equilibration. This program runs until the errors are reached. LAMMPS (`-sf opt`, the fix `nvt`, total
//! energy and pressure of each step) runs 4 ps, and from its errors by blocks follows the time it would need: their squares.
use hvi_kit::math::block_mean;
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Cancel, Ctx};
use hvi_md::lanes::Isa;
use hvi_md::potential::{BuiltIn, Named};
use hvi_md::units::SPECIFIC_ENERGY;
use hvi_md::{By, Params, Phase, lammps, lattice, run};
use std::collections::BTreeMap;

const PRESSURE_ERROR: f64 = 1e8;
const ENERGY_ERROR: f64 = 0.005;
const ITS_STEP: f64 = 2e-15;
const ITS_STEPS: usize = 2000;

fn main() {
    let strides: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let (by_volume, by_temperature) = (strides.first().copied().unwrap_or(7), strides.get(1).copied().unwrap_or(3));
    let here = lammps::ENGINE.version();
    match &here {
        Ok(version) => println!("{version}, -sf opt"),
        Err(why) => println!("without LAMMPS: {why}"),
    }
    println!(" V/V0     T   phase   ps  +- GPa    +- E   core-s | LAMMPS ps  core-s  ratio");
    let mut totals = BTreeMap::new();
    for v in (0..15).step_by(by_volume) {
        for t in (0..10).step_by(by_temperature) {
            let (ratio, temperature) = (1.06 - 0.03 * v as f64, 300.0 + 4200.0 / 9.0 * t as f64);
            let (phase, ours) = measure(ratio, temperature, here.is_ok());
            let total: &mut [f64; 2] = totals.entry(phase).or_default();
            (0..2).for_each(|k| total[k] += ours[k]);
        }
    }
    for (phase, [ours, its]) in totals {
        println!("{phase}: {ours:.2} and {its:.2} core-seconds, ratio {:.4}", ours / its);
    }
}

/// One line of the table: core-seconds of both.
fn measure(volume_ratio: f64, temperature: f64, lammps: bool) -> (&'static str, [f64; 2]) {
    let params = Params {
        engine: By::Native,
        potential: Named::BuiltIn(BuiltIn::Mishin2001),
        atoms: 256,
        volume_ratio,
        pressed: None,
        temperature: Temperature::new(temperature),
        time_step: Time::new(5e-15),
        equilibration: Time::new(1e-12),
        target_error: Pressure::new(PRESSURE_ERROR),
        shortest: Time::new(0.5e-12),
        longest: Time::new(60e-12),
        seed: 1,
        trajectory: None,
        ranks: 1,
    };
    let start = cpu_time();
    let state = run::state(&params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()).expect("a state");
    let ours = (cpu_time() - start) * 1e-9;
    let phase = if state.phase == Phase::Solid { "solid" } else { "liquid" };
    print!(
        "{volume_ratio:5.2} {temperature:5.0}  {phase:6} {:5.2}  {:6.3}  {:6.4}  {ours:7.4}",
        state.averaged * 1e12,
        state.pressure_error * 1e-9,
        state.energy_error / state.energy
    );
    if !lammps {
        println!();
        return (phase, [ours, f64::NAN]);
    }
    let (pressure_error, energy_error, per_step) = plain(&params);
    let (p, e) = (pressure_error / PRESSURE_ERROR, energy_error / (ENERGY_ERROR * state.energy));
    let time = ITS_STEPS as f64 * ITS_STEP * p.max(e) * p.max(e);
    let its = (params.equilibration.si() + time) / ITS_STEP * per_step;
    println!(" |   {:7.2} {its:7.3} {:6.4}", time * 1e12, ours / its);
    (phase, [ours, its])
}

/// Standard errors of pressure [Pa] and energy [J/kg] of a plain run of LAMMPS, and its core-seconds a step.
fn plain(params: &Params) -> (f64, f64, f64) {
    let asked = params.asked(&BTreeMap::new()).expect("a built-in potential");
    let sites = lattice::sites(params.cells(), asked.lattice);
    let molar = asked.potential.molar_mass();
    let atoms = lammps::data(&sites, &[], [asked.lattice * params.cells() as f64; 3], molar);
    let (t, equilibration) = (params.temperature.si(), (params.equilibration.si() / ITS_STEP) as usize);
    let script = lammps::opening("read_data data", 0.8)
        + &format!(
            "timestep 0.002\nthermo 100000\nvelocity all create {} 1 mom yes rot no dist gaussian\nfix bath all nvt temp {t} {t} 0.1\n\
             run {equilibration}\nreset_timestep 0\nvariable e equal etotal\n\
             fix series all ave/time 1 1 1 c_thermo_press v_e file series\nrun {ITS_STEPS}\n",
            2.0 * t
        );
    let potential = lammps::potential(&asked.potential);
    let files = [("data", atoms.as_bytes()), ("potential", potential.as_bytes())];
    let texts = lammps::run(&script, &files, &["series"], &Cancel::default()).unwrap_or_else(|e| panic!("{e}"));
    let column = |k: usize| -> Vec<f64> {
        let rows = texts[0].lines().filter(|l| !l.starts_with('#'));
        rows.map(|l| l.split_whitespace().nth(k).and_then(|w| w.parse().ok()).expect("three numbers")).collect()
    };
    let energy = block_mean(&column(2)).1 * SPECIFIC_ENERGY / (molar * sites.len() as f64);
    (block_mean(&column(1)).1 * 1e5, energy, lammps::loop_time(&texts[1]).expect("it tells") / ITS_STEPS as f64)
}

/// CPU time of this thread so far [ns], as Linux counts it.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts the time of threads");
    text.split(' ').next().and_then(|t| t.parse().ok()).expect("its first field is a time")
}
