//! What enters a key and what doesn't, as a user meets it; the fields that no pipeline can change (format, stage, code,
//! version of a program outside) have their tests beside `Recipe` and the build script.
use super::project::Project;

const STUDY: &str = r#"
[step.metal]
use = "eos.handbook"
mie_gruneisen = { density = "8930 kg/m3", sound_speed = "3940 m/s", slope = 1.489, gruneisen = 2.02, heat_capacity = "385 J/kg/K" }
[step.check]
use = "validate.isotherm"
eos = "@metal"
data = "data.csv"
"#;

const DATA: &str = "# source: a test\nP_revised,V_over_V0\n1.0,0.99\n5.0,0.96\n10.0,0.94\n";

fn project() -> Project {
    let project = Project::new(STUDY);
    project.write("data.csv", DATA);
    let said = project.run();
    assert!(said.err.contains("0 from the store, 2 computed"), "{}", said.err);
    project
}

fn computed(project: &Project, arguments: &[&str]) -> String {
    let said = project.hvi(arguments);
    assert_eq!(said.code, 0, "{}", said.err);
    let words: Vec<&str> = said.err.split([' ', ',']).collect();
    let at = words.iter().position(|w| *w == "computed").unwrap_or_else(|| panic!("{}", said.err));
    words[at - 1].into()
}

/// Each parameter of the first step, and the content of the second one's file. The second step's input changes with the
/// first one's output.
#[test]
fn what_a_result_depends_on_is_a_miss() {
    let project = project();
    for (from, to) in [
        ("8930 kg/m3", "8931 kg/m3"),
        ("3940 m/s", "3941 m/s"),
        ("slope = 1.489", "slope = 1.490"),
        ("gruneisen = 2.02", "gruneisen = 2.03"),
        ("385 J/kg/K", "386 J/kg/K"),
        ("K\" }", "K\", reference_temperature = \"300 K\" }"),
    ] {
        assert!(STUDY.contains(from));
        project.write("study.toml", &STUDY.replace(from, to));
        assert_eq!(computed(&project, &["run", "study.toml"]), "2", "{from} -> {to}");
    }
    project.write("study.toml", STUDY);
    project.write("data.csv", &DATA.replace("5.0", "5.1"));
    assert_eq!(computed(&project, &["run", "study.toml"]), "1", "content of the file");
    project.write("data.csv", DATA);
    assert_eq!(computed(&project, &["run", "study.toml"]), "0", "and back");
}

#[test]
fn what_a_result_does_not_depend_on_is_a_hit() {
    let project = project();
    let same = [
        ("units", STUDY.replace("8930 kg/m3", "8.930 g/cm3").replace("3940 m/s", "3.94e0 km/s")),
        ("numbers", STUDY.replace("2.02", "2.020").replace("1.489", "1489e-3")),
        ("comments and blank lines", STUDY.replace("use =", "# why\n\n  use  =  ")),
        ("names of steps", STUDY.replace("metal", "renamed").replace("step.check", "step.\"other-name\"")),
        ("a default written out", STUDY.replace("K\" }", "K\", reference_temperature = \"293 K\" }")),
        ("dotted keys", STUDY.replace("density = \"8930 kg/m3\", ", "").replace("[step.check]", "mie_gruneisen.density = \"8930 kg/m3\"\n[step.check]").replace("mie_gruneisen = {", "mie_gruneisen.sound_speed = \"3940 m/s\"\nmie_gruneisen.heat_capacity = \"385 J/kg/K\"\nmie_gruneisen.slope = 1.489\nmie_gruneisen.gruneisen = 2.02\n#")),
        ("order of keys", STUDY.replace("slope = 1.489, gruneisen = 2.02", "gruneisen = 2.02, slope = 1.489")),
        ("a sweep of one", STUDY.replace("slope = 1.489, ", "").replace("[step.check]", "sweep = { \"mie_gruneisen.slope\" = [1.489] }\n[step.check]")),
        ("resources", format!("[run]\njobs = 1\n{STUDY}")),
        ("the file's name", STUDY.replace("data.csv", "./moved.csv")),
    ];
    project.write("moved.csv", DATA);
    for (what, text) in &same {
        assert_ne!(text, STUDY);
        project.write("study.toml", text);
        assert_eq!(computed(&project, &["run", "study.toml"]), "0", "{what}");
    }
    project.write("study.toml", STUDY);
    assert_eq!(computed(&project, &["run", "study.toml", "--jobs", "1"]), "0");
    assert_eq!(computed(&project, &["run", "study.toml", "--set", "metal.mie_gruneisen.slope=1.489"]), "0");
    assert_eq!(computed(&project, &["run", "study.toml", "--out", "elsewhere"]), "0");
    project.write("other.toml", STUDY);
    assert_eq!(computed(&project, &["run", "other.toml"]), "0", "another pipeline with the same step");
}

/// The points of a sweep are as if each were written alone: what is shared by them is made once, and checked for each.
#[test]
fn a_point_of_a_sweep_is_what_it_is_alone() {
    let project = project();
    let sweep = |values: &str| {
        STUDY
            .replace("slope = 1.489, ", "")
            .replace("[step.check]", &format!("sweep = {{ \"mie_gruneisen.slope\" = [{values}] }}\n[step.check]"))
            .replace("\"@metal\"", "\"@metal[mie_gruneisen.slope=1.489]\"")
    };
    project.write("study.toml", &sweep("1.3, 1.489, 1.5"));
    assert_eq!(computed(&project, &["run", "study.toml"]), "2", "one of the three is known");
    project.write("study.toml", &sweep("1.3, 1.489, 1.4, 1.5"));
    assert_eq!(computed(&project, &["run", "study.toml"]), "1", "one new point");
    project.write("study.toml", &sweep("1.3, 1.489, -1.4, 1.5"));
    let said = project.run();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("-1.4") && said.err.contains("study.toml"), "{}", said.err);
}

#[test]
fn a_sweep_of_a_billion_points_is_refused_with_the_count() {
    let axis = |name: &str| format!("\"mie_gruneisen.{name}\" = \"1 .. 2 in 31623\"");
    let sweep = format!("sweep = {{ {}, {} }}\n[step.check]", axis("slope"), axis("gruneisen"));
    let project = Project::new(&STUDY.replace("[step.check]", &sweep));
    let said = project.run();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("1000014129 points"), "{}", said.err);
}
