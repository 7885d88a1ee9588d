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
    let figure = std::fs::read(project.path("out/study/tradeoff/cells/error-of-the-pressure-profile-against-time.png"));
    assert!(figure.unwrap().starts_with(b"\x89PNG"));
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
    assert!(project.files("store/results").is_empty(), "it is said before anything runs");
    let bare = project.hvi(&["tradeoff", "study.toml", "--quantity", "energy drift", "--accuracy", "2"]);
    assert!(bare.code == 2 && bare.err.contains("as in \"2 %\""), "{}", bare.err);
}

/// Repeats leave the results as they are, to the bit, and put medians of their times on record.
#[test]
fn repeats_change_nothing_but_times() {
    let project = Project::new(STUDY);
    assert_eq!(project.hvi(&["tradeoff", "study.toml"]).code, 0);
    let records = || -> Vec<serde_json::Value> {
        let files = project.files("store/results");
        let record = |bytes: &[u8]| {
            let text = std::str::from_utf8(bytes).unwrap();
            serde_json::from_str(text.split_once('\n').unwrap().1).unwrap()
        };
        files.iter().map(|(_, bytes)| record(bytes)).collect()
    };
    let before = records();
    let said = project.hvi(&["tradeoff", "study.toml", "--repeat", "3"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let after = records();
    assert_eq!((before.len(), after.len()), (4, 4));
    let same = |key: &str| before.iter().zip(&after).all(|(a, b)| a[key] == b[key]);
    assert!(same("output") && same("finished") && !same("cpu_s"), "{before:?} {after:?}");
    let folders = std::fs::read_dir(project.path("store")).unwrap();
    let names: Vec<_> = folders.map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().all(|name| !name.starts_with(".tmp")), "{names:?}");
}

/// A block on the page's first screen, one whose runs check its choices, and one whose runs are as likely as each other.
#[test]
fn blocks_come_first_check_each_other_and_show_how_far_runs_lie_apart() {
    let other = STUDY.split("\n\n").next().unwrap().replace("step.planar", "step.slower").replace("4 km/s", "3 km/s");
    let states = "[step.states]\nuse = \"md\"\npotential = \"mishin-2001\"\natoms = 256\nvolume_ratio = 0.9\ntemperature = \"900 K\"\n\
                  shortest = \"0.5 ps\"\nlongest = \"0.5 ps\"\nsweep = { seed = [1, 2, 3, 4] }\n";
    let blocks = "[tradeoff.slower]\nof = \"@slower[*]\"\nalong = \"cells\"\ncheck = \"cells\"\n\n\
                  [tradeoff.seeds]\nof = \"@states[*]\"\nalong = \"seed\"\nspread = true\n";
    let study = STUDY.replace("about =", "first = true\nabout =");
    let project = Project::new(&format!("{study}\n{other}\n\n{states}\n{blocks}"));
    let said = project.hvi(&["tradeoff", "study.toml", "--page", "accuracy.md"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let page = read(&project, "accuracy.md");
    let first = page.split("\n## cells").next().unwrap();
    assert!(first.contains("## In short") && first.contains("| cells | pressure profile |"), "{first}");
    let of = |name: &str| page.split(&format!("\n## {name}")).nth(1).unwrap().split("\n## ").next().unwrap();
    assert!(of("slower").contains("**Choices checked.** Settings chosen on the front of `cells`"), "{}", of("slower"));
    // Four short runs of the same state differ, by some tenths of a GPa at most.
    let row =
        of("seeds").lines().find(|l| l.starts_with("| pressure | GPa |")).unwrap_or_else(|| panic!("{}", of("seeds")));
    assert!(row.contains("±"), "{row}");
}
