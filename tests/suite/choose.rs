//! `[choose.NAME]`: settings from a measured front, said before anything runs and held against what it took.
use super::project::Project;

/// What both studies share: a planar impact of copper on copper as a fluid.
const PLANAR: &str = r#"use = "impact"
projectile = { shape = "slab", length = "6 mm", material = "copper" }
plate = { material = "copper", thickness = "6 mm" }
space = "line"
strength = false
damage = false
spall = false
end = "0.6 us"
"#;

fn project(goal: &str, quantity: &str) -> Project {
    let study = format!(
        "[step.wave]\n{PLANAR}sweep = {{ velocity = [\"3 km/s\", \"3.5 km/s\"] }}\n\n[choose.cells]\nof = [\"wave\"]\n\
         front = \"front.toml\"\nblock = \"cells\"\nquantity = \"{quantity}\"\n{goal}\n"
    );
    let project = Project::new(&study);
    let front = format!(
        "[step.planar]\n{PLANAR}velocity = \"4 km/s\"\nsweep = {{ cells = [12, 24, 48, 96, 192] }}\n\n\
         [tradeoff.cells]\nof = \"@planar[*]\"\nalong = \"cells\"\n"
    );
    std::fs::write(project.path("front.toml"), front).unwrap();
    project
}

/// The profile's error falls at first order from some 6 % at 12 cells: at half of 5 %, so that the choice holds elsewhere, takes
/// more than 24 cells.
#[test]
fn the_cheapest_setting_within_an_error_is_taken() {
    let project = project("accuracy = \"5 %\"", "pressure profile");
    let unmeasured = project.hvi(&["plan", "study.toml"]);
    assert!(
        unmeasured.code == 2 && unmeasured.err.contains("isn't measured: 5 of its 5 runs are missing"),
        "{}",
        unmeasured.err
    );
    assert!(unmeasured.err.contains("hvi-flow tradeoff"), "{}", unmeasured.err);
    assert_eq!(project.hvi(&["tradeoff", "front.toml"]).code, 0);

    let plan = project.hvi(&["plan", "study.toml"]);
    let chosen = ["cells = 48 for wave", "cells = 96 for wave", "cells = 192 for wave"];
    assert!(plan.code == 0 && chosen.iter().any(|c| plan.err.contains(c)), "{}", plan.err);
    assert!(plan.out.contains("2 to run"), "{}", plan.out);
    let run = project.hvi(&["run", "study.toml"]);
    assert!(run.code == 0 && run.err.contains("; taken: "), "{}", run.err);
    let page = std::fs::read_to_string(project.path("out/study/report.html")).unwrap();
    assert!(page.contains("[choose.cells]") && page.contains("taken: "), "the page compares");
}

#[test]
fn a_budget_buys_the_most_accurate_setting() {
    let project = project("budget = \"10 min\"", "pressure profile");
    assert_eq!(project.hvi(&["tradeoff", "front.toml"]).code, 0);
    let plan = project.hvi(&["plan", "study.toml"]);
    assert!(plan.err.contains("cells = 192 for wave"), "{}", plan.err);
}

#[test]
fn what_cannot_be_chosen_is_said_and_nothing_runs() {
    let unreachable = project("accuracy = \"0.001 %\"", "pressure profile");
    assert_eq!(unreachable.hvi(&["tradeoff", "front.toml"]).code, 0);
    for (goal, quantity, expected) in [
        ("accuracy = \"0.001 %\"", "pressure profile", "the nearest is [choose.cells]: cells = 192"),
        ("accuracy = \"5 %\"", "pressure profil", "did you mean `pressure profile`?"),
        ("accuracy = \"5\"", "pressure profile", "is no share above 0 and below 100 %"),
        ("budget = \"soon\"", "pressure profile", "soon"),
        ("accuracy = \"5 %\"\nbudget = \"1 s\"", "pressure profile", "either `accuracy` or `budget`"),
        ("acuracy = \"5 %\"", "pressure profile", "did you mean `accuracy`?"),
    ] {
        let other = project(goal, quantity);
        std::fs::copy(other.path("study.toml"), unreachable.path("study.toml")).unwrap();
        let said = unreachable.hvi(&["run", "study.toml"]);
        assert!(said.code == 2 && said.err.contains(expected), "{goal}: {}", said.err);
        assert!(!unreachable.path("out/study").exists(), "{goal}: nothing runs");
    }
}

/// A choice for no step, and a front whose settings are results of its own pipeline.
#[test]
fn choices_that_can_not_be_taken_over_are_refused() {
    let project = project("accuracy = \"5 %\"", "pressure profile");
    let study = std::fs::read_to_string(project.path("study.toml")).unwrap();
    std::fs::write(project.path("study.toml"), study.replace("of = [\"wave\"]", "of = []")).unwrap();
    let none = project.hvi(&["plan", "study.toml"]);
    assert!(none.code == 2 && none.err.contains("no step gets the setting"), "{}", none.err);

    std::fs::write(project.path("study.toml"), study).unwrap();
    let front = format!(
        "[step.metal]\nuse = \"eos.handbook\"\nsweep = {{ set = [\"copper-royce\", \"copper-paper-md\"] }}\n\n\
         [step.planar]\n{}velocity = \"4 km/s\"\nsweep = {{ \"plate.eos\" = \"@metal[*]\" }}\n\n\
         [tradeoff.cells]\nof = \"@planar[*]\"\nalong = \"plate.eos\"\n",
        PLANAR
    );
    std::fs::write(project.path("front.toml"), front).unwrap();
    assert_eq!(project.hvi(&["tradeoff", "front.toml"]).code, 0);
    let named = project.hvi(&["plan", "study.toml"]);
    assert!(named.code == 2 && named.err.contains("no setting of it can be taken over"), "{}", named.err);
}
