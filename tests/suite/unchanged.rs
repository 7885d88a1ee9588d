//! A run that has nothing to do is known without a plan; whatever of all that it would look at has changed, it is seen.
use super::project::{Project, assert_counts};
use std::fs;

const STUDY: &str = r#"# What does copper's Hugoniot look like?
include = ["metal.toml"]
[step.hugoniot]
use = "validate.hugoniot"
eos = "@metal"
shots = "shots.csv"
up_to = "50 GPa"
"#;
const METAL: &str = "[step.metal]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n";
const SHOTS: &str = "# rho0: 8.93 g/cm3\nset,V_over_V0,P\nmine,0.9,20\nmine,0.8,65\n";
const NOTES: &str = "out/study/.unchanged";

/// A study of two nodes that has been run until its runs are noted.
fn settled() -> Project {
    let project = Project::new(STUDY);
    project.write("metal.toml", METAL);
    project.write("shots.csv", SHOTS);
    assert_counts(&project.run(), 0, 2);
    assert!(!project.path(NOTES).exists(), "a run that computed something is not noted");
    assert_counts(&project.run(), 2, 0);
    assert!(project.path(NOTES).exists());
    project
}

/// Whether a run is one that has nothing to do: it makes no plan, so it writes no notes.
fn is_short(project: &Project) -> bool {
    let made = || fs::metadata(project.path(NOTES)).unwrap().modified().unwrap();
    let before = made();
    assert_counts(&project.run(), 2, 0);
    made() == before
}

#[test]
fn a_run_without_news_makes_no_plan() {
    let project = settled();
    assert!(is_short(&project));
    let json = project.hvi(&["run", "study.toml", "--json"]);
    assert_eq!(json.out.matches("\"hit\"").count(), 2, "events are told all the same: {}", json.out);
}

#[test]
fn what_was_read_is_read_again() {
    let project = settled();
    project.write("study.toml", &STUDY.replace("50 GPa", "60 GPa"));
    assert_counts(&project.run(), 1, 1);
    project.write("study.toml", STUDY);
    assert_counts(&project.run(), 2, 0);
    project.write("metal.toml", &METAL.replace("copper-royce", "copper-paper-md"));
    assert_counts(&project.run(), 0, 2);
    project.write("metal.toml", METAL);
    assert_counts(&project.run(), 2, 0);
    project.write("shots.csv", &SHOTS.replace("65", "66"));
    assert_counts(&project.run(), 1, 1);
    project.write("shots.csv", SHOTS);
    assert_counts(&project.run(), 2, 0);
    assert_counts(&project.hvi(&["run", "study.toml", "--set", "hugoniot.up_to=70 GPa"]), 1, 1);
    assert_counts(&project.run(), 2, 0);
    assert_counts(&project.hvi(&["run", "study.toml", "--only", "metal"]), 1, 0);
    assert_counts(&project.run(), 2, 0);
    project.write("study.toml", &STUDY.replace("What does", "How does"));
    assert!(!is_short(&project), "words that the page shows are no part of a key");
    assert!(fs::read_to_string(project.path("out/study/report.html")).unwrap().contains("How does"));
    assert!(is_short(&project));
    fs::remove_file(project.path("shots.csv")).unwrap();
    assert_eq!(project.run().code, 2);
}

#[test]
fn what_was_written_is_looked_at_again() {
    let project = settled();
    // The file that was read is there too, for the node that needs it.
    let results = project.files("store/objects").into_iter().filter(|(_, bytes)| !bytes.starts_with(b"file/"));
    for (path, good) in results {
        let mut bad = good.clone();
        bad[good.len() / 2] ^= 1;
        fs::write(&path, bad).unwrap();
        let said = project.run();
        assert!(said.err.contains("damaged or gone") && said.err.contains(" computed in"), "{}", said.err);
        assert_eq!(fs::read(&path).unwrap(), good);
        fs::remove_file(&path).unwrap();
        assert!(project.run().err.contains("damaged or gone"));
        assert_counts(&project.run(), 2, 0);
    }
    assert!(is_short(&project));
    for (path, good) in project.files("out") {
        if !path.file_name().unwrap().to_string_lossy().starts_with('.') {
            fs::write(&path, "edited by hand").unwrap();
            assert_counts(&project.run(), 2, 0);
            // The page also says what the last run computed.
            let back = fs::read(&path).unwrap();
            let is_page = path.ends_with("report.html") && back.len() > 1000;
            assert!(back == good || is_page, "{} is put back", path.display());
        }
    }
    assert!(is_short(&project));
    let index = project.path("store/index");
    let mut bytes = fs::read(&index).unwrap();
    bytes.iter_mut().skip(200).step_by(128).for_each(|byte| *byte ^= 1);
    fs::write(&index, bytes).unwrap();
    assert!(project.run().err.contains("index was damaged"));
    assert!(is_short(&project));
    fs::remove_dir_all(project.path("store/runs")).unwrap();
    assert!(!is_short(&project));
    assert!(project.path("store/runs/study").exists(), "the history begins anew");
    let notes = project.path(NOTES);
    let mut bytes = fs::read(&notes).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&notes, bytes).unwrap();
    assert!(!is_short(&project), "damaged notes are none");
    assert!(is_short(&project));
    fs::rename(project.path("store"), project.path("other")).unwrap();
    assert_counts(&project.run(), 0, 2);
}
