//! `hvi-flow eos`: answers and curves from a name or a file, and what wrong input gets.
use super::project::Project;

const ALUMINIUM: &str = r#"# Table 3 of the paper
source = "test"

[gray]
volume = "0.359 cm3/g"
sound_speed = "5.33 km/s"
slope = 1.338
gruneisen = 2.18
gruneisen_slope = 1.7
electronic = "32.245 mJ/kg/K2"
melting_temperature = "1220 K"
molar_mass = "26.9815 g/mol"
cohesive_energy = "12.0 MJ/kg"
"#;

fn project() -> Project {
    let project = Project::new("");
    project.write("al.toml", ALUMINIUM);
    project.write("states.csv", "V [cm3/g],T\n0.08944,1000\n0.07155,6000\n1.118,6000\n");
    project
}

/// The spot values of copper: P = 57.603 GPa at .8 V0 and 1000 K, then the melting band and vapour.
#[test]
fn eval_answers_for_a_published_set() {
    let said = project().hvi(&["eos", "eval", "copper-royce", "--states", "states.csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<Vec<&str>> = said.out.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(lines[0].join(","), "V [m3/kg],T [K],E [J/kg],P [Pa],phase,liquid_fraction,c [m/s]");
    assert!((lines[1][3].parse::<f64>().unwrap() / 57.603064e9 - 1.0).abs() < 1e-7, "{}", said.out);
    let phases: Vec<&str> = lines[1..].iter().map(|l| l[4]).collect();
    assert_eq!(phases, ["solid", "melting", "vapour"]);
}

/// Copper's cold curve follows the Hugoniot up to x = .6: .4 V0 is 0.04472 cm3/g.
#[test]
fn states_beyond_the_formulas_are_told() {
    let project = project();
    assert!(project.hvi(&["eos", "eval", "copper-royce", "--states", "states.csv"]).err.is_empty());
    project.write("dense.csv", "V [cm3/g],T\n0.08944,1000\n0.0446,6000\n0.04,6000\n");
    let said = project.hvi(&["eos", "eval", "copper-royce", "--states", "dense.csv"]);
    assert_eq!((said.code, said.out.lines().count()), (0, 4), "{}", said.err);
    assert!(
        said.err.contains("2 of 3 states, the first of them number 2, are denser than V/V0 = 0.400"),
        "{}",
        said.err
    );
}

#[test]
fn curves_come_from_files_and_files_from_names() {
    let project = project();
    for kind in ["hugoniot", "isotherm", "isobar", "isentrope", "release", "melting", "critical"] {
        let said = project.hvi(&["eos", "curve", "al.toml", kind]);
        assert_eq!(said.code, 0, "{kind}: {}", said.err);
        assert!(said.out.lines().count() > if kind == "critical" { 1 } else { 50 }, "{kind}: {}", said.out);
    }
    let shown = project.hvi(&["eos", "show", "copper-paper-md"]);
    assert!(shown.out.contains("[gray]") && shown.out.contains(" m3/kg\""), "{}", shown.out);
    project.write("again.toml", &shown.out);
    let curve = |of: &str| project.hvi(&["eos", "curve", of, "hugoniot", "--up-to", "100 GPa"]).out;
    assert_eq!(curve("again.toml"), curve("copper-paper-md"));
    let table = project.hvi(&["eos", "table", "al.toml"]);
    project.write("al.ses", &table.out);
    let isotherm = project.hvi(&["eos", "curve", "al.ses", "isotherm", "--up-to", "50 GPa"]);
    assert_eq!(isotherm.code, 0, "{}", isotherm.err);
}

#[test]
fn wrong_input_is_marked() {
    let project = project();
    let refused = |arguments: &[&str], expected: &[&str]| {
        let said = project.hvi(arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {} {}", said.out, said.err);
        expected.iter().for_each(|e| assert!(said.err.contains(e), "{e} is not in: {}", said.err));
    };
    refused(&["eos", "show", "copper-roice"], &["did you mean `copper-royce`?"]);
    project.write("bad.toml", &ALUMINIUM.replace("slope = 1.338", "slop = 1.338"));
    refused(&["eos", "show", "bad.toml"], &["bad.toml", "slop"]);
    project.write("bad.toml", &ALUMINIUM.replace("gruneisen_slope = 1.7", "gruneisen_slope = 9.0"));
    refused(&["eos", "show", "bad.toml"], &["[gray]", "gruneisen_slope is 9"]);
    project.write("bad.csv", "V,T\n1e-4,300\n1e-4,warm\n");
    refused(&["eos", "eval", "copper-royce", "--states", "bad.csv"], &["bad.csv:3", "warm", "positive number"]);
    refused(&["eos", "curve", "copper-royce", "hugoniot", "--up-to", "4"], &["--up-to", "has no unit"]);
    project.write("gas.toml", "[ideal_gas]\ndensity = \"1.2 kg/m3\"\ngamma = 1.4\nheat_capacity = \"718 J/kg/K\"\n");
    refused(&["eos", "curve", "gas.toml", "melting"], &["knows no melting"]);
}
