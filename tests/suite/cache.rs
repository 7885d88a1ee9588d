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
    // But for the notes that save work.
    let is_shown = |path: &std::path::Path| !path.file_name().unwrap().to_string_lossy().starts_with('.');
    let shown = || project.files("out").into_iter().filter(|(path, _)| is_shown(path)).collect::<Vec<_>>();
    let before = shown();
    assert!(before.iter().any(|(path, _)| path.ends_with("report.html")));
    let second = project.run();
    assert!(second.err.contains("3 from the store, 0 computed"), "{}", second.err);
    assert!(shown() == before, "a file was written anew, with other bytes");
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
    assert!(project.run().err.contains("3 from the store, 0 computed"), "the index has a sealed copy");
    std::fs::remove_file(project.path("store/index")).unwrap();
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
    assert!(said.out.contains("it has no result yet"), "{}", said.out);
    assert!(project.files("out").is_empty(), "plan computes nothing");
    project.run();
    assert!(project.hvi(&["plan", "study.toml"]).out.contains("3 results: 3 known, 0 to run"));
    std::fs::remove_dir_all(project.path("store/results")).unwrap();
    std::fs::remove_file(project.path("store/index")).unwrap();
    let said = project.hvi(&["plan", "study.toml"]);
    assert!(said.out.contains("its result is no longer in the store"), "{}", said.out);
}

#[test]
fn two_runs_at_once_agree() {
    for _ in 0..5 {
        let project = Project::new(STUDY);
        let spawn = || project.command(&["run", "study.toml"]).stderr(std::process::Stdio::piped()).spawn().unwrap();
        let (a, b) = (spawn(), spawn());
        for child in [a, b] {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        assert!(project.run().err.contains("3 from the store, 0 computed"));
    }
}

/// Wherever the program is killed, the next run ends with the same bytes. Real work, so that kills meet it: six states of
/// molecular dynamics, some tenths of a second in all.
#[test]
fn killed_anywhere_it_goes_on() {
    const WORK: &str = "[step.states]\nuse = \"md\"\npotential = \"mishin-2001\"\natoms = 256\nlongest = \"2 ps\"\n\
        sweep = { volume_ratio = [0.9, 0.8, 0.7], temperature = [\"300 K\", \"600 K\"] }\n";
    let whole = Project::new(WORK);
    assert_eq!(whole.run().code, 0);
    let objects = |p: &Project| -> Vec<(std::ffi::OsString, Vec<u8>)> {
        let named = |(path, bytes): (std::path::PathBuf, Vec<u8>)| (path.file_name().unwrap().to_owned(), bytes);
        p.files("store/objects").into_iter().map(named).collect()
    };
    let project = Project::new(WORK);
    for milliseconds in [1, 3, 10, 30, 60, 100, 150, 200] {
        let mut child =
            project.command(&["run", "study.toml", "-q"]).stderr(std::process::Stdio::null()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        let _ = child.kill();
        child.wait().unwrap();
    }
    assert_eq!(project.run().code, 0);
    assert_eq!(objects(&project), objects(&whole));
}

/// A record that was moved to another key's place, or belongs to another kind, is no result of that key.
#[test]
fn records_prove_whose_they_are() {
    let project = Project::new(STUDY);
    project.run();
    let before = std::fs::read(project.path("out/study/metal.csv")).unwrap();
    let results = project.files("store/results");
    std::fs::write(&results[0].0, &results[1].1).unwrap();
    std::fs::write(&results[1].0, &results[0].1).unwrap();
    std::fs::remove_file(project.path("store/index")).unwrap();
    let again = project.run();
    assert!(again.err.contains("1 from the store, 2 computed"), "{}", again.err);
    assert_eq!(std::fs::read(project.path("out/study/metal.csv")).unwrap(), before);
}

/// What a run did not touch stays: `--only`, and the results of another pipeline with the same name.
#[test]
fn results_of_other_steps_and_pipelines_stay() {
    let two = format!("{STUDY}\n[step.other]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
    let project = Project::new(&two);
    project.run();
    assert_eq!(project.hvi(&["run", "study.toml", "--only", "metal"]).code, 0);
    assert!(project.path("out/study/other.csv").exists());
    std::fs::create_dir(project.path("sub")).unwrap();
    project.write("sub/study.toml", &two);
    let said = project.hvi(&["run", "sub/study.toml"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("holds the results of"), "{}", said.err);
    project.write("study.toml", STUDY);
    project.run();
    assert!(!project.path("out/study/other.csv").exists(), "a step that is gone takes its files along");
}

/// A report that somebody else wrote stays; one of ours that was edited is put back, also where the manifest is lost.
#[test]
fn a_foreign_report_is_not_overwritten() {
    let project = Project::new(STUDY);
    let page = project.path("out/study/report.html");
    std::fs::create_dir_all(project.path("out/study")).unwrap();
    std::fs::write(&page, "<html>mine</html>").unwrap();
    let said = project.run();
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("out/study/report.html was not made by hvi-flow"), "{}", said.err);
    assert_eq!(std::fs::read_to_string(&page).unwrap(), "<html>mine</html>");
    assert!(!project.path("store").exists(), "nothing ran");
    std::fs::remove_file(&page).unwrap();
    assert_eq!(project.run().code, 0);
    std::fs::write(&page, "<html>edited</html>").unwrap();
    assert_eq!(project.run().code, 0);
    assert!(std::fs::read_to_string(&page).unwrap().contains("content=\"hvi-flow\""));
    std::fs::remove_file(project.path("out/study/.manifest.json")).unwrap();
    assert_eq!(project.run().code, 0);
}

/// Of a wide sweep only what changed is read again; files and page are those of a run that reads everything.
#[test]
fn a_changed_point_of_a_wide_sweep_leaves_the_same_files() {
    let study = |last: f64| {
        let slopes: Vec<String> = (0..250).map(|i| format!("{}", 1.2 + 0.001 * f64::from(i))).collect();
        super::project::MANY.replace("\"1.2 .. 1.6 in 40\"", &format!("[{}, {last}]", slopes.join(", ")))
    };
    let project = Project::new(&study(2.0));
    assert_eq!(project.run().code, 0);
    project.write("study.toml", &study(2.1));
    super::project::assert_counts(&project.run(), 250, 1);
    let shown = || {
        let page = std::fs::read_to_string(project.path("out/study/report.html")).unwrap();
        let left_out = page.find("tables and figures of 227 of 251 points").expect("24 points are shown");
        (left_out > 0, std::fs::read(project.path("out/study/metal.csv")).unwrap())
    };
    let short_cut = shown();
    std::fs::remove_dir_all(project.path("out")).unwrap();
    project.run();
    assert!(short_cut == shown());
}

/// Two points whose labels begin alike have folders of their own.
#[test]
fn long_names_do_not_meet() {
    let long = "x".repeat(120);
    let set = "{ density = \"8930 kg/m3\", sound_speed = \"3940 m/s\", slope = 1.489, gruneisen = GAMMA, heat_capacity = \"385 J/kg/K\" }";
    let sets = [set.replace("GAMMA", "2.02"), set.replace("GAMMA", "1.99")].join(", ");
    let project =
        Project::new(&format!("# {long}\n[step.a]\nuse = \"eos.handbook\"\nsweep = {{ mie_gruneisen = [{sets}] }}\n"));
    let said = project.run();
    assert_eq!(said.code, 0, "{}", said.err);
    let views = project.files("out/study/a");
    let folders: std::collections::BTreeSet<_> = views.iter().map(|(path, _)| path.parent().unwrap()).collect();
    assert_eq!(folders.len(), 2, "{folders:?}");
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

/// One machine pushes, another one pulls, or reads through: nothing is computed twice.
#[test]
fn results_travel_by_a_shared_store() {
    let project = Project::new(STUDY);
    project.run();
    let shared = tempfile::tempdir().unwrap();
    let folder = shared.path().join("shared");
    let folder = folder.to_str().unwrap();
    assert_eq!(project.hvi(&["cache", "pull", folder]).code, 2, "there is no store yet");
    let said = project.hvi(&["cache", "push", folder]);
    assert!(said.code == 0 && said.out.contains("3 results"), "{}{}", said.out, said.err);
    let said = project.hvi(&["cache", "push", folder]);
    assert!(said.out.contains("0 results") && said.out.contains("3 were there"), "{}", said.out);
    for pulled in [true, false] {
        let other = Project::new(STUDY);
        let said = if pulled {
            assert_eq!(other.hvi(&["cache", "pull", folder]).code, 0);
            other.run()
        } else {
            other.hvi(&["run", "study.toml", "--second-store", folder])
        };
        assert!(said.err.contains("3 from the store, 0 computed"), "{}", said.err);
        assert!(super::project::objects(&other) == super::project::objects(&project));
        assert!(other.run().err.contains("3 from the store, 0 computed"), "it needs the other one no longer");
    }
}
