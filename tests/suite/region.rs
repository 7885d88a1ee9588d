//! `region = "auto"`: of a sweep of states only those that the scenes come to, and what was left out is said.
use super::project::Project;

/// States from rest to 0.6 V0 and 6000 K, melting points to 200 GPa, and an impact of copper on copper with the fit of them.
fn project(velocity: &str, more: &str) -> Project {
    Project::new(&format!(
        r#"
[step.states]
use = "md"
potential = "mishin-2001"
region = "auto"
sweep = {{ volume_ratio = "1.05 .. 0.6 in 10", temperature = "300 K .. 6000 K in 20" }}

[step.melting]
use = "md.coexistence"
potential = "mishin-2001"
region = "auto"
sweep = {{ pressure = ["0 GPa", "50 GPa", "200 GPa"] }}

[step.copper]
use = "eos.gray"
states = "@states[*]"
melting = "@melting[*]"

[step.hit]
use = "impact"
projectile = {{ shape = "sphere", diameter = "5 mm", material = "copper", eos = "@copper" }}
plate = {{ material = "copper", thickness = "2.5 mm", eos = "@copper" }}
velocity = "{velocity}"
{more}"#
    ))
}

/// What is left out of the states and of the melting points.
fn left_out(project: &Project) -> [usize; 2] {
    let plan = project.hvi(&["plan", "study.toml"]);
    assert_eq!(plan.code, 0, "{}", plan.err);
    ["states", "melting"].map(|step| {
        let said = format!("{step}: region = \"auto\" leaves out ");
        let rest = plan.err.split(&said).nth(1).unwrap_or_else(|| panic!("{step} in {}", plan.err));
        rest.split(' ').next().unwrap().parse().unwrap()
    })
}

/// Copper at 1 km/s: Us = 3940 + 1.489 * 500 m/s, 21 GPa and .893 V0, some 500 K, and nothing is near melting: five of ten volumes
/// stay, which a fit needs, up to 3000 K, ten of twenty temperatures; and the melting point without pressure. At 9 km/s it goes to
/// .586 V0 and far beyond 6000 K.
#[test]
fn states_that_no_scene_comes_to_are_left_out() {
    let [slow, slow_melting] = left_out(&project("1 km/s", ""));
    assert_eq!((slow, slow_melting), (150, 2));
    let [middle, middle_melting] = left_out(&project("5 km/s", ""));
    assert!((10..slow).contains(&middle) && middle_melting < 3, "{middle} {middle_melting}");
    let [fast, fast_melting] = left_out(&project("9 km/s", ""));
    assert!(fast < middle && fast_melting == 0, "{fast} {fast_melting}");
}

/// The key does not enter a result's key: what stays has the key that it has in the whole sweep.
#[test]
fn what_stays_is_the_same_result() {
    let project = project("1 km/s", "");
    let keys = || {
        let plan = project.hvi(&["plan", "study.toml", "--only", "states", "--json"]);
        let plan: serde_json::Value = serde_json::from_str(&plan.out).unwrap();
        let key = |node: &serde_json::Value| (node["node"].to_string(), node["key"].to_string());
        plan["nodes"].as_array().unwrap().iter().map(key).collect::<std::collections::BTreeMap<_, _>>()
    };
    let some = keys();
    let study = std::fs::read_to_string(project.path("study.toml")).unwrap();
    std::fs::write(project.path("study.toml"), study.replace("region = \"auto\"", "")).unwrap();
    let all = keys();
    assert!(some.len() == 50 && all.len() == 200, "{} of {}", some.len(), all.len());
    assert!(some.iter().all(|(node, key)| all[node] == *key && key.len() > 20));
}

/// A point that is named by itself, a sweep that no scene follows, and a scene that no estimate can be made of stay whole.
#[test]
fn points_that_something_else_needs_stay() {
    let picked = "\n[step.table]\nuse = \"eos.table\"\nstates = \"@states[volume_ratio=0.6, temperature=6000 K]\"\n";
    assert_eq!(left_out(&self::project("1 km/s", picked)), [149, 2]);
    let named = "\n[step.look]\nuse = \"md\"\npotential = \"mishin-2001\"\nregion = \"auto\"\nvolume_ratio = 0.6\ntemperature = \"6000 K\"\n";
    let project = project("1 km/s", named);
    let plan = project.hvi(&["plan", "study.toml"]);
    assert!(
        plan.err.contains("look: region = \"auto\" leaves out 0 of 1 points: no scene comes after it"),
        "{}",
        plan.err
    );
}

#[test]
fn where_it_makes_no_sense_is_said() {
    let project = project("1 km/s", "region = \"auto\"\n");
    let plan = project.hvi(&["plan", "study.toml"]);
    assert!(plan.code == 2 && plan.err.contains("`impact` computes no state of matter"), "{}", plan.err);
    let study = std::fs::read_to_string(project.path("study.toml")).unwrap();
    std::fs::write(project.path("study.toml"), study.replace("region = \"auto\"", "region = \"all\"")).unwrap();
    let plan = project.hvi(&["plan", "study.toml"]);
    assert!(plan.code == 2 && plan.err.contains("unknown region `all`"), "{}", plan.err);
}
