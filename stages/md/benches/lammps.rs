//! Time of a step per atom, this program's and LAMMPS', on the same atoms: `cargo bench -p hvi-md --bench lammps`.
//!
//! Copper by Mishin et al. at constant volume and temperature with a chain of three, steps of 2 fs, one core, CPU time:
//! crystals at 300 K and liquids at 5000 K. LAMMPS runs `-sf opt` on lammps-data's table with the fastest of three skins, and
//! goes on from the very atoms that the other has at that moment. Medians of alternated pairs. `-- 500` takes one size.
use hvi_kit::Cancel;
use hvi_md::lanes::Isa;
use hvi_md::units::BOLTZMANN;
use hvi_md::{Chain, Potential, System, Tables, lammps, lattice};

const TABLE: &str = "/usr/share/lammps/potentials/Cu_mishin1.eam.alloy";
/// Steps times atoms of one measurement.
const WORK: usize = 400_000;
const PAIRS: usize = 5;
const SKINS: [f64; 3] = [0.5, 0.8, 1.0];

fn main() {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let sizes = if sizes.is_empty() { vec![500, 4000, 32_000] } else { sizes };
    let version = lammps::ENGINE.version();
    let table = std::fs::read(TABLE);
    match (&version, &table) {
        (Ok(version), Ok(_)) => println!("{version}, -sf opt"),
        (Err(why), _) => println!("without LAMMPS: {why}"),
        (_, Err(why)) => println!("without LAMMPS: {TABLE}: {why}: install lammps-data"),
    }
    println!(" atoms     T  isa     ns/atom/step  rebuilt every  LAMMPS  skin  ratio");
    for atoms in sizes {
        for temperature in [300.0, 5000.0] {
            for isa in Isa::all().into_iter().filter(|i| i.name() != "portable") {
                let table = if version.is_ok() { table.as_deref().ok() } else { None };
                measure(atoms, temperature, isa, table);
            }
        }
    }
}

/// One line of the table.
fn measure(atoms: usize, temperature: f64, isa: Isa, table: Option<&[u8]>) {
    let potential = Potential::Mishin2001;
    let cells = (1..).find(|n| 4 * n * n * n >= atoms).expect("some number is large enough");
    let edge = lattice::edge(&potential, 1.0).expect("copper has a lattice");
    let sites = lattice::sites(cells, edge);
    let mut system = System::new(Tables::new(potential.clone()), isa, &sites, edge * cells as f64).expect("a crystal");
    system.heat(2.0 * temperature, 1);
    let mut chain = Chain::new(BOLTZMANN * temperature, system.freedom(), 0.1);
    let mut run = |system: &mut System, steps: usize| {
        (0..steps).for_each(|_| system.advance(0.002, Some(&mut chain)).expect("it runs"));
    };
    for _ in 0..30 {
        run(&mut system, 10);
        system.scale(temperature);
    }
    let steps = (WORK / sites.len()).max(25);
    let per = 1.0 / (steps * sites.len()) as f64;
    let skin = table.map(|table| {
        let time = |skin: &f64| its_time(&system, &sites, &potential, temperature, steps, *skin, table);
        let mut tried: Vec<(f64, f64)> = SKINS.iter().map(|s| (time(s), *s)).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        tried[0].1
    });
    let (mut ours, mut its, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (first, built) = (system.steps(), system.rebuilds());
    for _ in 0..PAIRS {
        let start = cpu_time();
        run(&mut system, steps);
        ours.push((cpu_time() - start) * per);
        if let (Some(table), Some(skin)) = (table, skin) {
            its.push(its_time(&system, &sites, &potential, temperature, steps, skin, table) * per);
            ratios.push(ours[ours.len() - 1] / its[its.len() - 1]);
        }
    }
    let every = (system.steps() - first) as f64 / (system.rebuilds() - built).max(1) as f64;
    let name = isa.name();
    print!("{:6} {temperature:5}  {name:7} {:12.1}  {every:13.1}", sites.len(), median(ours));
    match skin {
        Some(skin) => println!("  {:6.0}  {skin:4}  {:5.3}", median(its), median(ratios)),
        None => println!(),
    }
}

/// CPU time that LAMMPS takes for `steps` steps from the present atoms on [ns].
fn its_time(
    system: &System,
    sites: &[[f64; 3]],
    potential: &Potential,
    temperature: f64,
    steps: usize,
    skin: f64,
    table: &[u8],
) -> f64 {
    let edges = system.edges();
    let moved = sites.iter().zip(system.displacements());
    let positions: Vec<[f64; 3]> = moved.map(|(s, d)| [s[0] + d[0], s[1] + d[1], s[2] + d[2]]).collect();
    let atoms = lammps::data(&positions, &system.velocities(), edges, potential.molar_mass());
    let script = lammps::opening("read_data data", skin).replace("potential X", "potential Cu")
        + &format!(
            "timestep 0.002\nthermo 100000\nfix bath all nvt temp {temperature} {temperature} 0.1\nrun 0\nrun {steps}\n"
        );
    let log = lammps::run(&script, &[("data", atoms.as_bytes()), ("potential", table)], &[], &Cancel::default());
    let log = log.unwrap_or_else(|e| panic!("{e}")).pop().expect("the log is the last");
    lammps::loop_time(&log).expect("LAMMPS tells its time") * 1e9
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

/// CPU time of this thread so far [ns], as Linux counts it.
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts the time of threads");
    text.split(' ').next().and_then(|t| t.parse().ok()).expect("its first field is a time")
}
