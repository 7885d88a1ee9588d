//! Potentials from files and formulas: every copper and aluminium file of Debian's lammps-data, known lattices, mistakes.
use hvi_kit::{File, Stage};
use hvi_md::potential::{BuiltIn, Format, Structure, Tabulated};
use hvi_md::{Md, Params, Potential, lattice};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const FOLDER: &str = "/usr/share/lammps/potentials";

/// A file of Debian's lammps-data.
fn text(name: &str) -> String {
    std::fs::read_to_string(Path::new(FOLDER).join(name))
        .unwrap_or_else(|e| panic!("{FOLDER}/{name}: {e}; install lammps-data"))
}

fn read(name: &str, format: Format, element: Option<&str>) -> Potential {
    let table = Tabulated::read(&text(name), format, element).unwrap_or_else(|e| panic!("{name}: {e}"));
    Potential::Tabulated(Arc::new(table))
}

/// Every file with embedded atoms of copper or aluminium that the package has, and nothing else, is named here, each with
/// the lattice constant [angstrom] of its header and the cohesive energy [eV] of its source. Authors fit these, some with
/// more knots or another cut-off than their file has (Al_zhou is off by 0.8 %), or, as AlO, with charges beside.
#[test]
fn all_copper_and_aluminium_files_are_read() {
    use Format::{FinnisSinclair, Funcfl, Setfl};
    let known: [(&str, Format, Option<&str>, f64, f64); 19] = [
        ("Al_jnp.eam", Funcfl, None, 3.986, 3.39),
        ("Cu_smf7.eam", Funcfl, None, 3.615, 3.54),
        ("Cu_u3.eam", Funcfl, None, 3.615, 3.54),
        ("Cu_u6.eam", Funcfl, None, 3.615, 3.54),
        ("AlCu.eam.alloy", Setfl, Some("Al"), 4.05, 3.34),
        ("AlCu.eam.alloy", Setfl, Some("Cu"), 3.615, 3.54),
        ("AlO.eam.alloy", Setfl, Some("Al"), 4.05, 3.34),
        ("Al_zhou.eam.alloy", Setfl, None, 4.05, 3.58),
        ("CoAl.eam.alloy", Setfl, Some("Al"), 4.05, 3.36),
        ("CuNi.eam.alloy", Setfl, Some("Cu"), 3.615, 3.54),
        ("CuTa.eam.alloy", Setfl, Some("Cu"), 3.615, 3.54),
        ("Cu_mishin1.eam.alloy", Setfl, None, 3.615, 3.54),
        ("Cu_zhou.eam.alloy", Setfl, None, 3.615, 3.54),
        ("NiAlH_jea.eam.alloy", Setfl, Some("Al"), 4.05, 3.36),
        ("AlFe_mm.eam.fs", FinnisSinclair, Some("Al"), 4.045, 3.37),
        ("Al_mm.eam.fs", FinnisSinclair, None, 4.045, 3.41),
        ("CuZr_mm.eam.fs", FinnisSinclair, Some("Cu"), 3.639, 3.28),
        ("NiAlH_jea.eam.fs", FinnisSinclair, Some("Al"), 4.05, 3.36),
        ("NiAlH_jea.eam.fs", FinnisSinclair, Some("Ni"), 3.52, 4.45),
    ];
    for (name, format, element, edge, cohesion) in known {
        let potential = read(name, format, element);
        let found = lattice::equilibrium_edge(&potential).expect("it has a lattice");
        let energy = lattice::at_rest(&potential, found).energy;
        println!("{name} {element:?}: {found:.5} angstrom, {energy:.5} eV, to density {:.3}", potential.densest());
        assert!((found / edge - 1.0).abs() < 0.01, "{name}: {found}");
        assert!((energy + cohesion).abs() < 0.1, "{name}: {energy}");
    }
    let listed = std::fs::read_dir(FOLDER).unwrap_or_else(|e| panic!("{FOLDER}: {e}; install lammps-data"));
    for file in listed {
        let name = file.unwrap().file_name().into_string().unwrap();
        let embedded = [".eam", ".eam.alloy", ".eam.fs"].iter().any(|end| name.ends_with(end));
        if embedded && (name.contains("Cu") || name.contains("Al")) {
            assert!(known.iter().any(|k| k.0 == name), "{name} is not in the list");
        }
    }
}

/// The table of Mishin's EAM1 is that of its formulas: the same lattice to the table's own rounding.
#[test]
fn formulas_and_their_tables_agree() {
    let (file, formula) = (read("Cu_mishin1.eam.alloy", Format::Setfl, None), Potential::Mishin2001);
    let a = 3.615;
    let (one, other) = (lattice::at_rest(&file, a), lattice::at_rest(&formula, a));
    assert!((one.energy - other.energy).abs() < 1e-4, "{} {}", one.energy, other.energy);
    // Copper of Zhou et al. 2004, tabled by its author with tantalum: cut at sqrt(5) r_e of tantalum and not shifted.
    let (file, formula) = (read("CuTa.eam.alloy", Format::Setfl, Some("Cu")), BuiltIn::ZhouCu.potential());
    for edge in [3.3, 3.615, 3.9] {
        let (one, other) = (lattice::at_rest(&file, edge), lattice::at_rest(&formula, edge));
        println!("{edge}: {} {} eV, {} {} eV/angstrom3", one.energy, other.energy, one.pressure, other.pressure);
        assert!((one.energy - other.energy).abs() < 1e-3, "{edge}: {} {}", one.energy, other.energy);
        assert!((one.pressure - other.pressure).abs() < 1e-4, "{edge}: {} {}", one.pressure, other.pressure);
    }
}

/// Energy of an atom [eV] in a close-packed hexagonal lattice with nearest atoms `a` apart along and across planes.
fn hexagonal(potential: &Potential, a: f64) -> f64 {
    let (height, row) = ((2f64 / 3.0).sqrt() * a, 0.75f64.sqrt() * a);
    let (mut pair, mut density) = (0.0, 0.0);
    for layer in -6i32..=6 {
        // every other plane is shifted by a third of the rhombus
        let odd = if layer.rem_euclid(2) == 1 { 1.0 } else { 0.0 };
        for y in -8..=8 {
            for x in -12..=12 {
                let at = [
                    (f64::from(x) + 0.5 * f64::from(y) + 0.5 * odd) * a,
                    (f64::from(y) + odd / 3.0) * row,
                    f64::from(layer) * height,
                ];
                let r = at.iter().map(|x| x * x).sum::<f64>().sqrt();
                if r > 1e-9 {
                    pair += 0.5 * potential.pair(r).value;
                    density += potential.density(r).value;
                }
            }
        }
    }
    pair + potential.embedding(density).value
}

/// Lattice constants (hexagonal: distance of neighbours) and cohesive energies that the 16 metals were fitted to, as the
/// file of parameters implies them: sqrt(2) r_e, 2/sqrt(3) r_e and r_e, and the handbook energies of X. W. Zhou et al.,
/// Acta Mater. 49, 4005 (2001), table 2. The formulas have a few more digits than the fit was good to.
#[test]
fn sixteen_metals_have_their_lattices() {
    let known = [
        (BuiltIn::ZhouCu, 3.615, 3.54),
        (BuiltIn::ZhouAg, 4.09, 2.85),
        (BuiltIn::ZhouAu, 4.08, 3.93),
        (BuiltIn::ZhouNi, 3.52, 4.45),
        (BuiltIn::ZhouPd, 3.89, 3.91),
        (BuiltIn::ZhouPt, 3.92, 5.77),
        (BuiltIn::ZhouAl, 4.05, 3.58),
        (BuiltIn::ZhouPb, 4.95, 2.04),
        (BuiltIn::ZhouFe, 2.866, 4.29),
        (BuiltIn::ZhouMo, 3.15, 6.81),
        (BuiltIn::ZhouTa, 3.3026, 8.089),
        (BuiltIn::ZhouW, 3.1648, 8.76),
        (BuiltIn::ZhouMg, 3.196, 1.55),
        (BuiltIn::ZhouCo, 2.506, 4.41),
        (BuiltIn::ZhouTi, 2.934, 4.85),
        (BuiltIn::ZhouZr, 3.2, 6.36),
    ];
    assert_eq!(known.len() + 1, BuiltIn::ALL.len());
    for (metal, edge, cohesion) in known {
        let potential = metal.potential();
        let (found, energy) = if potential.structure() == Structure::Hcp {
            let at = |a: f64| hexagonal(&potential, a);
            let edges = (0..400).map(|k| edge * (0.98 + 1e-4 * f64::from(k)));
            let best = edges.min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap();
            (best, at(best))
        } else {
            let edge = lattice::equilibrium_edge(&potential).expect("it has a lattice");
            (edge, lattice::at_rest(&potential, edge).energy)
        };
        println!("{}: {found:.4} ({edge}) angstrom, {energy:.4} ({cohesion}) eV", metal.name());
        assert!((found / edge - 1.0).abs() < 5e-4 && (energy + cohesion).abs() < 0.025, "{}", metal.name());
    }
}

/// Each mistake: what replaces which part of a good file, and what is said of it.
#[test]
fn mistakes_in_files_are_named_with_their_line() {
    let good = "made up\n 29 63.5 3.6 fcc\n 5 0.1 5 1.0 4.0\n 0 -1 -2 -3 -4\n 5 4 3 2 1\n 5 4 3 2 1\n";
    assert!(Tabulated::read(good, Format::Funcfl, None).is_ok());
    let cases = [
        ("63.5", "-63.5", "line 2: expected an element"),
        ("5 0.1 5 1.0 4.0", "5 0.1 5 1.0", "line 3: expected n_rho d_rho n_r d_r cutoff"),
        ("5 0.1 5 1.0 4.0", "5 0.1 5 1.0 7.0", "a length within the table, found ` 5 0.1 5 1.0 7.0`"),
        ("-2 -3", "-2 x", "line 4: expected value 4 of F(rho), found `x`"),
        ("-2 -3", "-2 inf", "line 4: expected value 4 of F(rho), found `inf`"),
        ("-2 -3", "-2 -3 -3", "line 4: expected the last of 5 values of F(rho) at the end of a line, found `1 more`"),
        (
            "\n 5 4 3 2 1\n 5 4 3 2 1\n",
            "\n 5 4 3 2 1\n",
            "line 6: expected 5 values of f(r), 0 of which came, found the end of the file",
        ),
        ("made up\n", "", "line 2: expected an element"),
    ];
    for (from, to, said) in cases {
        let error = Tabulated::read(&good.replacen(from, to, 1), Format::Funcfl, None).err().map(|e| e.to_string());
        assert!(error.as_ref().is_some_and(|e| e.contains(said)), "{to}: {error:?}");
    }
    let error = Tabulated::read(&text("AlCu.eam.alloy"), Format::Setfl, None).unwrap_err();
    assert_eq!(error.to_string(), "line 4: expected `element` to name one of several, found `Al Cu`");
    let error = Tabulated::read(&text("Cu_u3.eam"), Format::Setfl, None).unwrap_err();
    assert!(error.to_string().starts_with("line 4: expected the number of elements and their names"), "{error}");
}

/// As a pipeline says it: what is wrong is known before anything runs, and where.
#[test]
fn files_are_checked_with_the_parameters() {
    let params = |potential: serde_json::Value, atoms: u32| -> Params {
        let json =
            serde_json::json!({ "potential": potential, "volume_ratio": 1.0, "temperature": "300 K", "atoms": atoms });
        serde_json::from_value(json).unwrap()
    };
    let check = |params: &Params, file: Option<&str>| {
        let files: BTreeMap<String, File> =
            file.map(|name| ("potential.file".into(), File(text(name).into_bytes()))).into_iter().collect();
        Md::check(params).and_then(|()| Md::check_files(params, &files)).map_err(|e| format!("{}: {}", e.key, e.why))
    };
    let funcfl = params(serde_json::json!({ "format": "funcfl" }), 256);
    assert_eq!(check(&funcfl, Some("Cu_u3.eam")), Ok(()));
    assert!(check(&funcfl, None).unwrap_err().starts_with("potential: it needs `file`"));
    assert!(
        check(&funcfl, Some("AlCu.eam.alloy"))
            .unwrap_err()
            .starts_with("potential.file: not a potential file of format funcfl: line 2")
    );
    let small = params(serde_json::json!({ "format": "funcfl" }), 32);
    assert!(check(&small, Some("Cu_u3.eam")).unwrap_err().starts_with("atoms: 32 atoms at volume_ratio 1"));
    let mishin = params("mishin-2001".into(), 256);
    assert_eq!(check(&mishin, None), Ok(()));
    assert!(check(&mishin, Some("Cu_u3.eam")).unwrap_err().contains("a built-in potential takes no file"));
    let tungsten = params("zhou-2004-W".into(), 256);
    assert!(check(&tungsten, None).unwrap_err().contains("no face-centred cubic lattice"));
    // and what isn't a potential at all
    let wrong =
        |potential: serde_json::Value| serde_json::from_value::<hvi_md::Named>(potential).unwrap_err().to_string();
    assert!(wrong("mishin".into()).contains("unknown variant `mishin`, expected one of `mishin-2001`"));
    assert!(wrong(serde_json::json!({ "format": "meam" })).contains("unknown variant `meam`"));
    assert!(wrong(serde_json::json!({ "kind": "x" })).contains("unknown field `kind`"));
    assert!(wrong(7.into()).contains("the name of a potential"));
}
