//! Wrong input: every file of `tests/bad` says in its first lines what must be said of it.
use super::project::Project;
use std::path::Path;

#[test]
fn every_bad_pipeline_is_refused_with_the_place_and_what_was_expected() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    let (mut count, mut problems) = (0, Vec::new());
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        count += 1;
        let text = std::fs::read_to_string(&path).unwrap();
        let project = Project::new(&text);
        let said = project.run();
        let name = path.file_name().unwrap().to_string_lossy();
        let expected: Vec<_> = text.lines().filter_map(|l| l.strip_prefix("# expect: ")).collect();
        assert!(!expected.is_empty(), "{name} expects nothing");
        let lacking: Vec<_> = expected.into_iter().filter(|part| !said.err.contains(part)).collect();
        let ran = !project.files("out").is_empty() || !project.files("store/results").is_empty();
        if said.code != 2 || !lacking.is_empty() || ran || said.err.contains("panicked") {
            problems.push(format!("{name}: code {}, ran: {ran}, lacking {lacking:?} in\n{}", said.code, said.err));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(count >= 20, "{count} bad pipelines");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let project = Project::new("");
    let said = project.hvi(&["run", "absent.toml"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("can't read absent.toml"), "{}", said.err);
}

/// A pipe would be waited for without end, a device read without end.
#[test]
fn only_regular_files_are_read() {
    let project = Project::new("include = [\"/dev/zero\"]\n");
    let made = std::process::Command::new("mkfifo").arg(project.path("pipe.csv")).status();
    assert!(made.expect("this test needs mkfifo: apt-get install coreutils").success());
    std::fs::create_dir(project.path("folder.csv")).unwrap();
    let refused = |what: &str| {
        let said = project.run();
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains(what), "{}", said.err);
    };
    refused("can't read /dev/zero: not a regular file");
    for (name, what) in [("pipe.csv", "not a regular file"), ("folder.csv", "it is a folder")] {
        let step = |name: &str, body: &str| format!("[step.{name}]\nuse = {body}\n");
        let check = format!("\"validate.isotherm\"\ndata = \"{name}\"\neos = \"@metal\"\nstates = \"@metal\"");
        let metal = "\"eos.handbook\"\nset = \"copper-royce\"";
        project.write("study.toml", &(step("metal", metal) + &step("check", &check)));
        refused(&format!("can't read {name}: {what}"));
    }
}

#[test]
fn a_store_that_is_a_file_is_named() {
    let project = Project::new("[step.a]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
    for place in ["study.toml", "study.toml/store"] {
        let said = project.hvi(&["run", "study.toml", "--store", place]);
        assert_eq!(said.code, 1);
        assert!(said.err.contains(&format!("{place}: a store is a folder")), "{}", said.err);
        assert!(!project.path("out").exists());
    }
}

#[test]
fn settings_that_fit_nothing_are_named() {
    let project = Project::new("[step.a]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
    for (setting, part) in [
        ("b.set=1", "there is no step `b`"),
        ("a=1", "names no key"),
        ("a.set", "has no `=`"),
        ("a.sets=\"x\"", "unknown key `sets`"),
    ] {
        let said = project.hvi(&["run", "study.toml", "--set", setting]);
        assert_eq!(said.code, 2, "{setting}: {}", said.err);
        assert!(said.err.contains(part), "{setting}: {}", said.err);
    }
    assert_eq!(project.hvi(&["run", "study.toml", "--set", "a.set=aluminium-paper"]).code, 0);
}

#[test]
fn settings_reach_into_sweeps_and_never_vanish() {
    let project = Project::new("[step.a]\nuse = \"eos.handbook\"\nzip = { set = [\"copper-royce\"] }\n");
    let said = project.hvi(&["run", "study.toml", "--set", "a.set=aluminium-paper"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("`set` is set by `zip`") && said.err.contains("a.zip.set=[...]"), "{}", said.err);
    let said = project.hvi(&["run", "study.toml", "--set", "a.zip.set=[\"aluminium-paper\", \"copper-royce\"]"]);
    assert!(said.err.contains("2 computed"), "{}", said.err);
}

#[test]
fn names_that_leave_the_output_folder_are_refused() {
    let project = Project::new("");
    for name in ["...toml", "..toml"] {
        project.write(name, "[step.a]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
        let said = project.hvi(&["run", name]);
        assert_eq!(said.code, 2, "{name}: {}", said.err);
    }
    project.write("study.toml", "[step.\"../x\"]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n");
    assert_eq!(project.run().code, 2);
}
