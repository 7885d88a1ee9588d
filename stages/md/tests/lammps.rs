//! Against LAMMPS (Debian's `lmp`): energies, forces and virials of single configurations, and whole states by both engines.
use hvi_kit::units::{Pressure, Temperature, Time};
use hvi_kit::{Cancel, Ctx, Stage};
use hvi_md::lanes::Isa;
use hvi_md::potential::{BuiltIn, Format, Named, Tabulated, setfl};
use hvi_md::{By, Md, Params, Potential, State, System, Tables, lammps, lattice, run};
use std::collections::BTreeMap;
use std::sync::Arc;

fn from_text(text: &str, format: Format) -> Potential {
    Potential::Tabulated(Arc::new(Tabulated::read(text, format, None).unwrap()))
}

fn from_package(name: &str, format: Format) -> Potential {
    let path = format!("/usr/share/lammps/potentials/{name}");
    from_text(&std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}; install lammps-data")), format)
}

/// A crystal of `cells`^3 cells at `ratio` of its volume, all sites shaken by up to `shake` angstrom.
fn shaken(potential: &Potential, cells: usize, ratio: f64, shake: f64) -> (Vec<[f64; 3]>, f64) {
    let edge = lattice::edge(potential, ratio).unwrap();
    let mut seed = 11u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let sites = lattice::sites(cells, edge).into_iter().map(|s| s.map(|x| x + shake * (2.0 * uniform() - 1.0)));
    (sites.collect(), edge * cells as f64)
}

/// Energy [eV], virial [eV] and forces [eV/angstrom] by LAMMPS.
fn by_lammps(potential: &Potential, sites: &[[f64; 3]], edge: f64, ranks: u32) -> (f64, f64, Vec<[f64; 3]>) {
    let script = lammps::opening("read_data data", 0.3)
        + "compute virial all pressure NULL virial\nfix sums all ave/time 1 1 1 c_thermo_pe c_virial file sums format \" %.17g\"\n\
           dump forces all custom 1 forces id fx fy fz\ndump_modify forces sort id format float %.17g\nthermo_modify lost error\nrun 0\n";
    let data = lammps::data(sites, &[], [edge; 3], potential.molar_mass());
    let files = [("data", data.as_bytes()), ("potential", lammps::potential(potential).into_bytes().leak() as &[u8])];
    let texts = lammps::run_as(ranks, &script, &files, &["sums", "forces"], &Cancel::default()).unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|w| w.parse::<f64>().unwrap()).collect::<Vec<f64>>();
    let sums = numbers(texts[0].lines().last().unwrap());
    let rows = texts[1].lines().skip_while(|l| !l.starts_with("ITEM: ATOMS")).skip(1).map(numbers);
    let volume = edge * edge * edge;
    (sums[1], sums[2] / lammps::BAR * 3.0 * volume, rows.map(|r| [r[1], r[2], r[3]]).collect())
}

/// The same files mean the same curves: both programs differ by the rounding of their sums alone. 1e-9 of the energy, of the
/// root mean square force and of the virial is asked for; 1e-12 is seen.
#[test]
fn energies_forces_and_virials_agree() {
    let cases = [
        (from_package("Cu_u3.eam", Format::Funcfl), [1.0, 0.85]),
        (from_package("Cu_mishin1.eam.alloy", Format::Setfl), [1.0, 0.9]),
        (from_package("Al_mm.eam.fs", Format::FinnisSinclair), [1.0, 0.8]),
        (from_text(&setfl(&Potential::Mishin2001, "Cu"), Format::Setfl), [1.0, 0.6]),
        (from_text(&setfl(&BuiltIn::ZhouAl.potential(), "Al"), Format::Setfl), [1.1, 0.7]),
    ];
    for (potential, ratios) in cases {
        for ratio in ratios {
            let (sites, edge) = shaken(&potential, 5, ratio, 0.25);
            let ours = System::new(Tables::new(potential.clone()), Isa::best(), &sites, edge).unwrap();
            let (energy, virial, forces) = by_lammps(&potential, &sites, edge, 1);
            let square = |f: &[[f64; 3]]| f.iter().flatten().map(|x| x * x).sum::<f64>();
            let apart: Vec<[f64; 3]> =
                ours.forces().iter().zip(&forces).map(|(a, b)| [0, 1, 2].map(|k| a[k] - b[k])).collect();
            let force = (square(&apart) / square(&forces)).sqrt();
            let (e, w) = (ours.energy() / energy - 1.0, ours.virial() / virial - 1.0);
            println!("{ratio}: energy {e:.1e}, virial {w:.1e}, forces {force:.1e}");
            assert!(e.abs() < 1e-9 && w.abs() < 1e-9 && force < 1e-9, "{ratio}: {e:e} {w:e} {force:e}");
        }
    }
}

fn params(engine: By, volume_ratio: f64, temperature: f64) -> Params {
    Params {
        engine,
        potential: Named::BuiltIn(BuiltIn::Mishin2001),
        atoms: 256,
        volume_ratio,
        pressed: None,
        temperature: Temperature::new(temperature),
        time_step: Time::new(2e-15),
        equilibration: Time::new(1e-12),
        target_error: Pressure::new(2e8),
        shortest: Time::new(2e-12),
        longest: Time::new(20e-12),
        seed: 1,
        trajectory: None,
        ranks: 1,
    }
}

/// A crystal, mapped, and a liquid: pressures and energies within three standard errors of their difference.
#[test]
fn both_engines_give_the_same_states() {
    for (ratio, temperature) in [(0.9, 2000.0), (1.0, 4500.0)] {
        let of = |engine: By| -> State {
            let params = params(engine, ratio, temperature);
            match engine {
                By::Native => run::state(&params, &BTreeMap::new(), Isa::best(), &Ctx::quiet()).unwrap(),
                By::Lammps => lammps::state(&params, &BTreeMap::new(), &Ctx::quiet()).unwrap(),
            }
        };
        let (native, its) = (of(By::Native), of(By::Lammps));
        println!(
            "{:.3} +- {:.3} and {:.3} +- {:.3} GPa",
            native.pressure * 1e-9,
            native.pressure_error * 1e-9,
            its.pressure * 1e-9,
            its.pressure_error * 1e-9
        );
        assert!(native.phase == its.phase && native.mapped == its.mapped, "{native:?} {its:?}");
        let off = (native.pressure - its.pressure) / native.pressure_error.hypot(its.pressure_error);
        assert!(off.abs() < 3.0, "{off} standard errors: {} {}", native.pressure, its.pressure);
        let off = (native.energy - its.energy) / native.energy_error.hypot(its.energy_error);
        assert!(off.abs() < 3.0, "{off} standard errors: {} {}", native.energy, its.energy);
    }
}

/// Four processes part the atoms: the same energies and forces but for the order of sums, 1e-12 of them; and their states are the
/// same bits each time.
#[test]
fn processes_share_the_work() {
    let potential = from_package("Cu_mishin1.eam.alloy", Format::Setfl);
    let (sites, edge) = shaken(&potential, 6, 0.9, 0.25);
    let (one, four) = (by_lammps(&potential, &sites, edge, 1), by_lammps(&potential, &sites, edge, 4));
    assert!((one.0 - four.0).abs() < 1e-12 * one.0.abs() && (one.1 - four.1).abs() < 1e-10 * one.1.abs());
    let forces = |(_, _, all): (f64, f64, Vec<[f64; 3]>)| all.into_iter().flatten();
    assert!(forces(one).zip(forces(four)).all(|(a, b)| (a - b).abs() < 1e-10));
    let short =
        Params { ranks: 2, shortest: Time::new(4e-13), longest: Time::new(4e-13), ..params(By::Lammps, 0.9, 2000.0) };
    assert_eq!(Md::needs(&short).threads, 2);
    let state = || lammps::state(&short, &BTreeMap::new(), &Ctx::quiet()).unwrap();
    assert_eq!(state(), state());
    let wrong = |params: Params| params.check().unwrap_err().key;
    assert_eq!(wrong(Params { ranks: 2, ..params(By::Native, 0.9, 2000.0) }), "ranks");
    assert_eq!(wrong(Params { ranks: 0, ..short.clone() }), "ranks");
}

#[test]
fn its_own_words_are_shown() {
    let error = lammps::run("units metal\npair_style no/such\n", &[], &[], &Cancel::default()).unwrap_err().to_string();
    assert!(error.starts_with("LAMMPS: ERROR: Unrecognized pair style 'no/such'"), "{error}");
    assert_eq!(Md::engine(&params(By::Lammps, 1.0, 300.0)).unwrap().program, "lmp");
    assert!(Md::engine(&params(By::Native, 1.0, 300.0)).is_none());
}
