//! `hvi-flow tradeoff`: errors against costs, what to choose, and what wrong questions get.
use super::project::Project;

/// A planar impact of copper on copper as a fluid, whose shocked state is known; and the blocks on it.
const STUDY: &str = r#"[step.planar]
use = "impact"
projectile = { shape = "slab", length = "6 mm", material = "copper" }
plate = { material = "copper", thickness = "6 mm" }
velocity = "4 km/s"
space = "line"
strength = false
damage = false
spall = false
end = "0.6 us"
sweep = { cells = [12, 24, 48, 96] }

[tradeoff.cells]
of = "@planar[*]"
along = "cells"
about = "Cells through 6 mm."
"#;

fn read(project: &Project, name: &str) -> String {
    std::fs::read_to_string(project.path(name)).unwrap()
}

#[test]
fn errors_fall_with_cost_and_the_cheapest_setting_is_named() {
    let project = Project::new(STUDY);
    let said = project.hvi(&["tradeoff", "study.toml", "--page", "accuracy.md"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("| pressure profile |"), "{}", said.out);
    let runs = read(&project, "out/study/tradeoff/cells/runs.csv");
    let rows: Vec<Vec<&str>> = runs.lines().map(|l| l.split(',').collect()).collect();
    let column = rows[0].iter().position(|c| c.starts_with("pressure profile")).unwrap();
    let errors: Vec<f64> = rows[1..5].iter().map(|r| r[column].parse().unwrap()).collect();
    // A shock is spread over a fixed number of cells: its profile converges at first order, each halving of cells by about 2.
    assert!(errors.windows(2).all(|e| e[0] / e[1] > 1.5 && e[0] / e[1] < 2.8), "{errors:?}");
    let page = read(&project, "accuracy.md");
    assert!(page.starts_with("# What accuracy costs") && page.contains("closed form"), "{page}");
    assert!(!project.files("out/study/tradeoff/cells").is_empty());
    assert!(read(&project, "out/study/tradeoff.html").contains("Error of the pressure profile against time"));

    let ask =
        |more: &[&str]| project.hvi(&[&["tradeoff", "study.toml", "--quantity", "pressure profile"], more].concat());
    // which of those within it is cheapest is a matter of milliseconds here; the finest is never
    let chosen = ask(&["--accuracy", "50 %"]);
    let coarse = ["take cells 12:", "take cells 24:", "take cells 48:"].iter().any(|c| chosen.out.contains(c));
    assert!(chosen.code == 0 && coarse, "{} {}", chosen.out, chosen.err);
    let unreachable = ask(&["--accuracy", "0.0001 %"]);
    assert!(unreachable.code == 2 && unreachable.out.contains("the nearest is cells 96"), "{}", unreachable.out);
    assert!(ask(&["--budget", "10min"]).out.contains("take cells 96"));
    assert!(unreachable.err.contains("0 computed"), "{}", unreachable.err);
}

#[test]
fn wrong_questions_are_marked_and_nothing_runs() {
    for (from, to, expected) in [
        ("along = \"cells\"", "along = \"cell\"", "did you mean `cells`?"),
        ("@planar[*]", "@planer[*]", "did you mean `planar`?"),
        ("about =", "abut =", "did you mean `about`?"),
        ("along = \"cells\"\n", "", "lacks `along`"),
        ("about =", "finer = \"less\"\nabout =", "`finer` is \"larger\" or \"smaller\""),
        ("about =", "eos = \"@planar[cells=12]\"\nabout =", "`eos` is one equation of state"),
    ] {
        let project = Project::new(&STUDY.replace(from, to));
        let said = project.hvi(&["tradeoff", "study.toml"]);
        assert_eq!(said.code, 2, "{to}: {}", said.err);
        assert!(said.err.contains(expected), "{to}: {}", said.err);
        assert!(project.files("store/results").is_empty());
    }
    let project = Project::new(&STUDY.replace("12, 24, 48, 96", "12, 24"));
    let none = project.hvi(&["tradeoff", "study.toml", "--quantity", "weight", "--accuracy", "2 %"]);
    assert!(none.code == 2 && none.err.contains("cells.pressure profile"), "{}", none.err);
    let bare = project.hvi(&["tradeoff", "study.toml", "--quantity", "energy drift", "--accuracy", "2"]);
    assert!(bare.code == 2 && bare.err.contains("as in \"2 %\""), "{}", bare.err);
}
