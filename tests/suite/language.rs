//! The pipeline language end to end: include, materials, selections, lists of references.
use super::project::Project;

const MATERIAL: &str = r#"
[material.soft]
source = "a test"
young = "117 GPa"
poisson = 0.3
strength = { a = "90 MPa", b = "292 MPa", n = 0.31, c = 0.025, m = 1.09, rate = "1 1/s", reference_temperature = "293 K", melting_temperature = "1356 K" }
eos = { MieGruneisen = { density = 8930.0, sound_speed = 3940.0, slope = 1.489, gruneisen = 2.02, heat_capacity = 385.0, reference_temperature = 293.0 } }
"#;

const SCENE: &str = r#"
include = ["materials.toml"]
[step.metal]
use = "eos.handbook"
sweep = { set = ["copper-royce", "copper-paper-md"] }
[step.hit]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "soft" }
plate = { material = "copper", thickness = "0.5 mm", width = "3 mm", eos = "@metal[set=copper-royce]" }
cells = 2
end = "0.3 us"
sweep = { velocity = ["2 km/s", "3 km/s"] }
[step.film]
use = "radiograph"
run = "@hit[velocity=3000 m/s]"
width = 64
"#;

#[test]
fn an_included_material_a_selection_and_a_film() {
    let project = Project::new(SCENE);
    project.write("materials.toml", MATERIAL);
    let said = project.run();
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("0 from the store, 5 computed"), "{}", said.err);
    assert!(project.files("out/study/film").iter().any(|(path, _)| path.extension().is_some_and(|e| e == "png")));
    project.write("materials.toml", &MATERIAL.replace("90 MPa", "91 MPa"));
    let said = project.hvi(&["plan", "study.toml"]);
    assert!(said.out.contains("params.projectile.material.strength.a: 90000000.0 Pa -> 91000000.0 Pa"), "{}", said.out);
    let said = project.run();
    assert!(
        said.err.contains("2 from the store, 3 computed"),
        "what the constant enters, and nothing else: {}",
        said.err
    );
}

/// Two files may share a third: its steps are there once.
#[test]
fn a_file_that_two_others_include_counts_once() {
    let project = Project::new("include = [\"a.toml\", \"b.toml\"]\n");
    project.write("common.toml", "[step.metal]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
    for (file, step) in [("a.toml", "one"), ("b.toml", "two")] {
        let text = format!("include = [\"common.toml\"]\n[step.{step}]\nuse = \"eos.curves\"\neos = \"@metal\"\n");
        project.write(file, &text);
    }
    let said = project.hvi(&["plan", "study.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("3 results"), "{}", said.out);
}

#[test]
fn a_material_that_no_step_uses_is_named() {
    let (used, unused) =
        ("no step uses [material.soft]", SCENE.replace("material = \"soft\"", "material = \"copper\""));
    let project = Project::new(&unused);
    project.write("materials.toml", MATERIAL);
    assert!(!project.hvi(&["plan", "study.toml"]).err.contains(used), "a file that is shared may hold more");
    project.write("study.toml", &format!("{}{MATERIAL}", unused.replace("include", "#")));
    assert!(project.hvi(&["plan", "study.toml"]).err.contains(used));
    project.write("study.toml", &format!("{}{MATERIAL}", SCENE.replace("include", "#")));
    let said = project.hvi(&["plan", "study.toml"]);
    assert!(said.code == 0 && said.err.is_empty(), "{}", said.err);
}

#[test]
fn a_mistake_in_an_included_file_is_shown_there() {
    let project = Project::new(SCENE);
    project.write("materials.toml", &MATERIAL.replace("young", "yong"));
    let said = project.run();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("materials.toml:4:1") && said.err.contains("did you mean `young`?"), "{}", said.err);
}

#[test]
fn a_failed_point_leaves_the_others_running() {
    let project = Project::new(SCENE);
    project.write("materials.toml", MATERIAL);
    // No snapshot is kept at this time: the film fails, and says which there are.
    project.write("study.toml", &format!("{SCENE}exposures = [\"0.1 us\"]\n"));
    let said = project.run();
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("FAILED film"), "{}", said.err);
    assert!(said.err.contains("4 computed, 1 failed"), "{}", said.err);
    let page = std::fs::read_to_string(project.path("out/study/report.html")).unwrap();
    assert!(page.contains("film"));
}

/// A point can be selected by what its label shows, whatever its values hold.
#[test]
fn a_selection_takes_values_with_commas() {
    let swept = SCENE
        .replace(
            "sweep = { velocity = [\"2 km/s\", \"3 km/s\"] }",
            "velocity = \"2 km/s\"\nsweep = { times = [[\"0.1 us\"], [\"0.1 us\", \"0.2 us\"]] }",
        )
        .replace("@hit[velocity=3000 m/s]", "@hit[times=[100 ns, 0.2 us]]");
    let project = Project::new(&swept);
    project.write("materials.toml", MATERIAL);
    let said = project.hvi(&["plan", "study.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    project.write("study.toml", &swept.replace("[100 ns, 0.2 us]", "[100 ns, 0.3 us]"));
    let said = project.hvi(&["plan", "study.toml"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("it has: times=[0.1 us] | times=[0.1 us, 0.2 us]"), "{}", said.err);
}
