//! Hits and misses, early cutoff, damage, hand-edited results, two runs at once, kills.
use super::project::Project;

/// Cheap and real: handbook equations of state, a sweep over the sets.
const STUDY: &str = r#"
# Handbook sets side by side.
[step.metal]
use = "eos.handbook"
sweep = { set = ["copper-royce", "copper-paper-md", "aluminium-paper"] }
"#;

#[test]
fn a_second_run_computes_nothing() {
    let project = Project::new(STUDY);
    let first = project.run();
    assert_eq!(first.code, 0, "{}", first.err);
    assert!(first.err.contains("0 from the store, 3 computed"), "{}", first.err);
    let before = project.files("out");
    assert!(before.iter().any(|(path, _)| path.ends_with("report.html")));
    let second = project.run();
    assert!(second.err.contains("3 from the store, 0 computed"), "{}", second.err);
    assert_eq!(project.files("out"), before);
}

#[test]
fn only_what_changed_is_computed() {
    let project = Project::new(STUDY);
    project.run();
    project
        .write("study.toml", &STUDY.replace("# Handbook", "# Comments and\n# blank lines don't count\n\n# Handbook"));
    assert!(project.run().err.contains("3 from the store, 0 computed"));
    project.write("study.toml", &STUDY.replace("\"copper-royce\", ", ""));
    assert!(project.run().err.contains("2 from the store, 0 computed"), "a point less needs no work");
    project.write("study.toml", &STUDY.replace("step.metal", "step.renamed"));
    assert!(project.run().err.contains("3 from the store, 0 computed"), "a name is no part of the key");
    let moved = tempfile::tempdir().unwrap();
    let target = moved.path().join("elsewhere");
    std::fs::rename(project.path("study.toml"), &target).unwrap();
    let said = project.hvi(&["run", target.to_str().unwrap()]);
    assert!(said.err.contains("3 from the store, 0 computed"), "a path is no part of the key: {}", said.err);
}

#[test]
fn a_damaged_object_is_computed_again_and_an_edited_result_put_back() {
    let project = Project::new(STUDY);
    project.run();
    let before = project.files("out");
    let (object, bytes) = project.files("store/objects").pop().unwrap();
    let mut bad = bytes.clone();
    bad[20] ^= 1;
    std::fs::write(&object, bad).unwrap();
    let csv = project.path("out/study/metal.csv");
    std::fs::write(&csv, "edited by hand").unwrap();
    let again = project.run();
    assert!(again.err.contains("2 from the store, 1 computed"), "{}", again.err);
    assert_eq!(std::fs::read(&object).unwrap(), bytes, "the same bytes again");
    assert_ne!(std::fs::read_to_string(csv).unwrap(), "edited by hand");
    assert_eq!(project.files("out").len(), before.len());
}

#[test]
fn damaged_records_and_recipes_are_no_obstacle() {
    let project = Project::new(STUDY);
    project.run();
    for (path, _) in project.files("store/results").into_iter().chain(project.files("store/recipes")) {
        std::fs::write(path, "{").unwrap();
    }
    let said = project.hvi(&["plan", "study.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(project.run().err.contains("0 from the store, 3 computed"));
    assert!(project.run().err.contains("3 from the store, 0 computed"));
}

#[test]
fn plan_says_what_would_run_and_why() {
    let project = Project::new(STUDY);
    let said = project.hvi(&["plan", "study.toml"]);
    assert!(said.out.contains("3 results: 0 known, 3 to run"), "{}", said.out);
    assert!(said.out.contains("it never ran"), "{}", said.out);
    assert!(project.files("out").is_empty(), "plan computes nothing");
    project.run();
    assert!(project.hvi(&["plan", "study.toml"]).out.contains("3 results: 3 known, 0 to run"));
    std::fs::remove_dir_all(project.path("store/results")).unwrap();
    let said = project.hvi(&["plan", "study.toml"]);
    assert!(said.out.contains("its result is no longer in the store"), "{}", said.out);
}

#[test]
fn two_runs_at_once_agree() {
    let project = Project::new(STUDY);
    let spawn = |out: &str| {
        project.command(&["run", "study.toml", "--out", out]).stderr(std::process::Stdio::piped()).spawn().unwrap()
    };
    let (a, b) = (spawn("a"), spawn("b"));
    for child in [a, b] {
        assert!(child.wait_with_output().unwrap().status.success());
    }
    assert!(project.run().err.contains("3 from the store, 0 computed"));
}

/// Wherever the program is killed, the next run ends with the same bytes.
#[test]
fn killed_anywhere_it_goes_on() {
    let whole = Project::new(STUDY);
    whole.run();
    let names = |p: &Project| -> Vec<String> {
        let name = |(path, _): &(std::path::PathBuf, Vec<u8>)| path.file_name().unwrap().to_string_lossy().into_owned();
        p.files("store/objects").iter().map(name).collect()
    };
    let project = Project::new(STUDY);
    for microseconds in (0..12_000).step_by(600) {
        let mut child = project.command(&["run", "study.toml", "-q"]).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_micros(microseconds));
        let _ = child.kill();
        child.wait().unwrap();
    }
    assert_eq!(project.run().code, 0);
    assert_eq!(names(&project), names(&whole));
}

#[test]
fn a_store_of_another_format_is_refused() {
    let project = Project::new(STUDY);
    project.run();
    project.write("store/format", "hvi-store/99");
    let said = project.run();
    assert_eq!(said.code, 1);
    assert!(said.err.contains("hvi-store/99") && said.err.contains("--store"), "{}", said.err);
}
