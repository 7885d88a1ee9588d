//! The moving atoms: forces against energies, conservation, reversal, the heat bath, the same bits on every processor.
use hvi_md::lanes::Isa;
use hvi_md::units::{BOLTZMANN, PRESSURE};
use hvi_md::{Chain, Fault, Potential, System, Tables, lattice};

const COPPER: Potential = Potential::Mishin2001;

/// `cells`^3 cubic cells at `ratio` of the ground state's volume, each site shaken by up to `shake` angstrom.
fn shaken(cells: usize, ratio: f64, shake: f64) -> (Vec<[f64; 3]>, f64) {
    let edge = lattice::edge(&COPPER, ratio).unwrap();
    let mut seed = 7u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let sites = lattice::sites(cells, edge).into_iter().map(|s| s.map(|x| x + shake * (2.0 * uniform() - 1.0)));
    (sites.collect(), edge * cells as f64)
}

fn system(sites: &[[f64; 3]], edge: f64) -> System {
    System::new(Tables::new(COPPER), Isa::best(), sites, edge).unwrap()
}

/// Energy and forces straight from the formulas, pair by pair: nothing of the tables, lists and lanes.
fn plain(sites: &[[f64; 3]], edge: f64) -> (f64, Vec<[f64; 3]>) {
    let apart =
        |i: usize, j: usize| [0, 1, 2].map(|k| sites[i][k] - sites[j][k]).map(|d| d - edge * (d / edge).round());
    let length = |d: [f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
    let n = sites.len();
    let (mut energy, mut density) = (0.0, vec![0.0; n]);
    for i in 0..n {
        for j in (0..n).filter(|&j| j != i) {
            let r = length(apart(i, j));
            energy += 0.5 * COPPER.pair(r).value;
            density[i] += COPPER.density(r).value;
        }
    }
    let embedded: Vec<_> = density.iter().map(|&d| COPPER.embedding(d)).collect();
    energy += embedded.iter().map(|e| e.value).sum::<f64>();
    let mut force = vec![[0.0; 3]; n];
    for i in 0..n {
        for j in (0..n).filter(|&j| j != i) {
            let d = apart(i, j);
            let r = length(d);
            let slope = COPPER.pair(r).slope + (embedded[i].slope + embedded[j].slope) * COPPER.density(r).slope;
            (0..3).for_each(|k| force[i][k] -= slope * d[k] / r);
        }
    }
    (energy, force)
}

/// The tables follow the formulas to 1e-9 eV and 3e-7 eV/angstrom a pair (their own test); 100 pairs an atom. The larger boxes
/// are passed over layer by layer.
#[test]
fn energy_and_forces_are_those_of_the_formulas() {
    for (cells, ratio, shake) in [(4, 1.0, 0.3), (4, 0.64, 0.2), (4, 1.3, 0.5), (8, 1.0, 0.3), (9, 0.8, 0.4)] {
        let (sites, edge) = shaken(cells, ratio, shake);
        let (system, (energy, forces)) = (system(&sites, edge), plain(&sites, edge));
        let atoms = sites.len() as f64;
        assert!((system.energy() - energy).abs() < 1e-8 * atoms, "{} {energy}", system.energy());
        let worst = system
            .forces()
            .iter()
            .flatten()
            .zip(forces.iter().flatten())
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-5, "{ratio}: {worst}");
    }
}

#[test]
fn lattice_is_the_same_by_both_ways() {
    for ratio in [1.0, 0.9, 0.7, 0.6] {
        let (sites, edge) = shaken(5, ratio, 0.0);
        let (system, exact) = (system(&sites, edge), lattice::at_rest(&COPPER, edge / 5.0));
        assert!((system.energy() / sites.len() as f64 - exact.energy).abs() < 1e-8);
        let pressure = system.virial() / (3.0 * system.volume());
        assert!(
            (pressure - exact.pressure).abs() * PRESSURE < 1e3,
            "within 1 kPa: {}",
            (pressure - exact.pressure) * PRESSURE
        );
        assert!(system.forces().iter().flatten().all(|f| f.abs() < 1e-12));
    }
}

/// A central difference of step d: wrong by d^2/6 times the third derivative (1e2 eV/angstrom^3) and by the kinks of the
/// tables' second derivative; 1e-6 eV/angstrom for d = 1e-4.
#[test]
fn force_is_minus_the_slope_of_the_energy() {
    let (sites, edge) = shaken(4, 0.85, 0.3);
    let (forces, d) = (system(&sites, edge).forces(), 1e-4);
    for (atom, axis) in [(0, 0), (17, 1), (100, 2), (255, 0)] {
        let energy = |by: f64| {
            let mut moved = sites.clone();
            moved[atom][axis] += by;
            system(&moved, edge).energy()
        };
        let slope = (energy(d) - energy(-d)) / (2.0 * d);
        assert!((slope + forces[atom][axis]).abs() < 2e-6, "{atom}: {slope} {}", forces[atom][axis]);
    }
}

/// The same for all lengths scaled: -dE/dV = W/3V.
#[test]
fn virial_is_minus_the_slope_of_the_energy_by_volume() {
    for ratio in [1.2, 0.9, 0.65] {
        let (sites, edge) = shaken(4, ratio, 0.3);
        let at = |by: f64| system(&sites.iter().map(|s| s.map(|x| x * by)).collect::<Vec<_>>(), edge * by);
        let (here, up, down) = (at(1.0), at(1.0 + 1e-5), at(1.0 - 1e-5));
        let slope = (up.energy() - down.energy()) / (up.volume() - down.volume());
        let pressure = here.virial() / (3.0 * here.volume());
        assert!((slope + pressure).abs() < 1e-7 * (1.0 + pressure.abs()), "{ratio}: {slope} {pressure}");
    }
}

#[test]
fn momentum_is_conserved() {
    let (sites, edge) = shaken(4, 0.9, 0.0);
    let mut system = system(&sites, edge);
    system.heat(4000.0, 3);
    for _ in 0..1000 {
        system.advance(0.002, None).unwrap();
    }
    for k in 0..3 {
        let velocities = system.velocities();
        let (sum, size): (f64, f64) =
            (velocities.iter().map(|v| v[k]).sum(), velocities.iter().map(|v| v[k].abs()).sum());
        // 1000 steps of rounding 256 forces: 1e-16 sqrt(256000) of each force, where force times step is 1 % of a velocity
        assert!(sum.abs() < 1e-12 * size, "{sum} of {size}");
    }
}

/// Slope of the total energy over 20 ps at 2 fs by least squares: < 1e-5 eV/atom/ps at 300, 1200 (solid) and 4000 K (liquid).
#[test]
fn energy_does_not_drift() {
    for heat in [600.0, 2400.0, 9000.0] {
        let (sites, edge) = shaken(4, 1.0, 0.0);
        let (mut system, dt, steps) = (system(&sites, edge), 0.002, 10_000);
        system.heat(heat, 1);
        let (mut tt, mut te) = (0.0, 0.0);
        let start = system.energy() + 0.5 * system.twice_kinetic();
        for k in 0..steps {
            system.advance(dt, None).unwrap();
            let (t, e) = ((k as f64 - 0.5 * steps as f64) * dt, system.energy() + 0.5 * system.twice_kinetic() - start);
            tt += t * t;
            te += t * e;
        }
        let drift = te / tt / sites.len() as f64;
        println!("{:.0} K: {drift:.1e} eV/atom/ps", system.temperature());
        assert!(drift.abs() < 1e-5, "{heat} K at the start, {:.0} K at the end: {drift:e}", system.temperature());
    }
}

/// There and back over 1 ps: rounding, 1e-15 angstrom, grows with the chain's chaos, by 1e3 or so; a step that isn't
/// reversible is off by 1e-5 at least. The atoms are in equilibrium first: far from it the chain is stiff.
#[test]
fn motion_goes_back_the_way_it_came() {
    let (sites, edge) = shaken(4, 0.9, 0.0);
    let mut system = system(&sites, edge);
    system.heat(2000.0, 1);
    (0..500).for_each(|_| system.advance(0.002, None).unwrap());
    system.scale(1000.0);
    let mut chain = Chain::new(BOLTZMANN * 1000.0, system.freedom(), 0.1);
    let start = system.displacements();
    let moved = |system: &System| {
        let apart =
            system.displacements().into_iter().flatten().zip(start.iter().flatten()).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    for _ in 0..500 {
        system.advance(0.002, Some(&mut chain)).unwrap();
    }
    let out = moved(&system);
    system.reverse();
    chain.reverse();
    for _ in 0..500 {
        system.advance(0.002, Some(&mut chain)).unwrap();
    }
    let left = moved(&system);
    assert!(out > 0.3 && left < 1e-9, "{out} {left}");
}

/// Energy of atoms and chain together: its wobble shrinks with the square of the time step and it doesn't drift.
#[test]
fn chain_and_atoms_conserve_energy_together() {
    let wobble = |dt: f64| {
        let (sites, edge) = shaken(4, 0.9, 0.0);
        let mut system = system(&sites, edge);
        system.heat(2000.0, 1);
        let mut chain = Chain::new(BOLTZMANN * 1000.0, system.freedom(), 0.1);
        let mut values = Vec::new();
        for _ in 0..(4.0 / dt) as usize {
            system.advance(dt, Some(&mut chain)).unwrap();
            values.push(system.energy() + 0.5 * system.twice_kinetic() + chain.energy());
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64).sqrt() / sites.len() as f64
    };
    let (coarse, fine) = (wobble(0.004), wobble(0.002));
    assert!(coarse < 1e-4, "{coarse} eV/atom");
    assert!((3.0..5.5).contains(&(coarse / fine)), "second order: {coarse} {fine}");
}

/// In the canonical ensemble the kinetic energy of g degrees of freedom is gamma distributed: mean g kT/2, variance
/// g (kT)^2/2. 60 ps with a correlation time of 0.05 ps: 600 independent values or so; the mean is good to
/// sqrt(2/g/600) = 0.2 %, the variance to sqrt(2/600) = 6 %; 3 times that is allowed.
#[test]
fn kinetic_energy_has_its_distribution() {
    let (sites, edge) = shaken(4, 1.0, 0.0);
    let mut system = system(&sites, edge);
    let temperature = 3500.0;
    system.heat(2.0 * temperature, 1);
    let mut chain = Chain::new(BOLTZMANN * temperature, system.freedom(), 0.1);
    let mut values = Vec::new();
    for k in 0..21_000 {
        system.advance(0.003, Some(&mut chain)).unwrap();
        if k >= 1000 {
            values.push(system.temperature());
        }
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
    assert!((mean / temperature - 1.0).abs() < 0.006, "{mean}");
    let expected = 2.0 * temperature * temperature / system.freedom();
    assert!((variance / expected - 1.0).abs() < 0.18, "{variance} {expected}");
}

/// Every bit of positions, velocities, energy and virial after lists were rebuilt many times; in one layer and in many.
#[test]
fn every_instruction_set_gives_the_same_bits() {
    let bits = |isa: Isa, cells: usize, steps: usize| {
        let (sites, edge) = shaken(cells, 0.9, 0.1);
        let mut system = System::new(Tables::new(COPPER), isa, &sites, edge).unwrap();
        system.heat(8000.0, 1);
        let mut chain = Chain::new(BOLTZMANN * 6000.0, system.freedom(), 0.1);
        (0..steps).for_each(|_| system.advance(0.003, Some(&mut chain)).unwrap());
        assert!(system.rebuilds() > 2);
        let sums = [system.energy(), system.virial(), system.site_virial(), system.temperature()];
        let motion = [system.displacements(), system.velocities(), system.forces()].concat();
        sums.into_iter().chain(motion.into_iter().flatten()).map(f64::to_bits).collect::<Vec<u64>>()
    };
    for (cells, steps) in [(4, 150), (8, 20)] {
        let expected = bits(Isa::best(), cells, steps);
        for isa in Isa::all() {
            assert!(bits(isa, cells, steps) == expected, "{} {cells}", isa.name());
        }
    }
}

#[test]
fn atoms_on_top_of_each_other_are_named() {
    let (mut sites, edge) = shaken(4, 1.0, 0.0);
    sites[200] = [sites[3][0] + 0.3, sites[3][1] + 0.4, sites[3][2]];
    let error = System::new(Tables::new(COPPER), Isa::best(), &sites, edge).err().unwrap();
    assert!(matches!(error, Fault::Close { step: 0, atoms: [3, 200], .. }), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("atoms 3 and 200 are 0.5000 angstrom apart") && text.contains("1.000 angstrom"), "{text}");
}

/// A crystal at 0.11 of its volume, nearest atoms still 1.2 angstrom apart.
#[test]
fn densities_off_the_table_are_errors() {
    let edge = lattice::edge(&COPPER, 0.11).unwrap();
    let error = System::new(Tables::new(COPPER), Isa::best(), &lattice::sites(8, edge), 8.0 * edge).err().unwrap();
    assert!(matches!(error, Fault::Dense { step: 0, .. }), "{error}");
}

#[test]
fn a_box_too_small_is_refused() {
    let (sites, edge) = shaken(3, 1.0, 0.0);
    let error = System::new(Tables::new(COPPER), Isa::best(), &sites, edge).err().unwrap();
    assert!(error.to_string().contains("at least"), "{error}");
}

/// A time step of 30 fs tears the metal apart: a fault with its step, not a number.
#[test]
fn a_run_that_blows_up_says_so() {
    let (sites, edge) = shaken(4, 0.7, 0.0);
    let mut system = system(&sites, edge);
    system.heat(20_000.0, 1);
    let fault = (0..2000).find_map(|_| system.advance(0.03, None).err()).expect("it can't survive");
    assert!(fault.to_string().starts_with("step "), "{fault}");
}
