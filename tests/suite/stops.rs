//! Runs that stop or meet each other: signals, limits, failures, two runs at once, a store that can't be written.
use super::project::{MANY, Project, SLOW, Said, assert_counts, objects};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How often each event came in a `run --json`.
fn events(out: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for line in out.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        *counts.entry(line["event"].as_str().unwrap().to_string()).or_default() += 1;
    }
    counts
}

/// Starts a run that keeps a checkpoint every few steps.
fn start(project: &Project) -> Child {
    let run = ["run", "study.toml", "--json", "--checkpoint", "1ms"];
    project.command(&run).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[track_caller]
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} never came");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[track_caller]
fn wait_for_checkpoint(project: &Project) {
    wait_until("a checkpoint", || !project.files("store/partial").is_empty());
}

/// Runs the study to its end and asserts that it went on from a checkpoint to the bytes of a straight run.
#[track_caller]
fn assert_goes_on(project: &Project, straight: &Project) {
    let said = project.hvi(&["run", "study.toml", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(events(&said.out).get("resumed"), Some(&1), "{}", said.out);
    assert_eq!(objects(project), objects(straight));
    assert!(project.files("store/partial").is_empty(), "a checkpoint goes when its result is there");
}

fn straight() -> Project {
    let project = Project::new(SLOW);
    assert_counts(&project.run(), 0, 1);
    project
}

#[test]
fn a_signal_keeps_what_was_done() {
    let straight = straight();
    for name in ["-TERM", "-INT"] {
        let project = Project::new(SLOW);
        let child = start(&project);
        // The run handles signals before it computes, and a checkpoint comes from computing.
        wait_for_checkpoint(&project);
        assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(events(&String::from_utf8_lossy(&output.stdout)).get("cancelled"), Some(&1));
        assert_goes_on(&project, &straight);
    }
}

#[test]
fn a_node_out_of_time_fails_and_goes_on_later() {
    let project = Project::new(SLOW);
    project.write("hurry.toml", &format!("[run]\ntimeout = \"200 ms\"\n{SLOW}"));
    for run in [&["run", "study.toml", "--timeout", "200ms"][..], &["run", "hurry.toml"]] {
        let said = project.hvi(run);
        assert_eq!(said.code, 1, "{}", said.err);
        assert!(said.err.contains("FAILED slow: stopped after 0.2 s, its timeout"), "{}", said.err);
    }
    assert_goes_on(&project, &straight());
    assert_eq!(project.hvi(&["run", "study.toml", "--timeout", "soon"]).code, 2);
}

/// What a step says goes before what the command line and `[run]` say, and enters no key.
#[test]
fn a_step_has_a_time_and_tries_of_its_own() {
    let project = Project::new(&format!("[run]\ntimeout = \"1 ms\"\n{SLOW}timeout = \"1 h\"\nretry = 1\n"));
    assert_counts(&project.hvi(&["run", "study.toml", "--timeout", "1ms"]), 0, 1);
    project.write("study.toml", SLOW);
    assert_counts(&project.run(), 1, 0);
    for (wrong, part) in [("timeout = 3", "a time"), ("timeout = \"soon\"", "soon"), ("retry = -1", "0 to 100")] {
        project.write("study.toml", &format!("{SLOW}{wrong}\n"));
        let said = project.run();
        assert!(said.code == 2 && said.err.contains(part), "{wrong}: {}", said.err);
    }
    // A store that can't take results, for no reason that it knows: tried again as the step says.
    let project = Project::new(&format!("{FAILING}retry = 2\n").replace("velocity", "retry = 1\nvelocity"));
    std::fs::create_dir(project.path("store")).unwrap();
    project.write("store/objects", "a file where a folder should be");
    let events = events(&project.hvi(&["run", "study.toml", "--json"]).out);
    assert_eq!((events.get("retrying"), events.get("failed")), (Some(&1), Some(&1)));
}

/// What a node took foretells the next one of its stage, also in another study.
#[test]
fn records_foretell_times() {
    let project = Project::new(SLOW);
    let foretold = |out: &str| -> f64 {
        let lines = out.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        lines.filter(|line| line["event"] == "started").map(|line| line["foretold"].as_f64().unwrap()).sum()
    };
    let ran = |out: &str| -> f64 {
        let lines = out.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        lines.filter(|line| line["event"] == "ran").map(|line| line["seconds"].as_f64().unwrap()).sum()
    };
    let first = project.hvi(&["run", "study.toml", "--json"]);
    project.write("other.toml", &SLOW.replace("2 km/s", "2.001 km/s"));
    let second = project.hvi(&["run", "other.toml", "--json"]);
    // Both predict the same cost, to a thousandth; then what the first took is what is foretold.
    assert!((foretold(&second.out) / ran(&first.out) - 1.0).abs() < 0.01, "{}{}", first.out, second.out);
}

/// Many runs at once: each result is computed by one of them.
#[test]
fn runs_at_once_share_the_work() {
    let study = format!("{MANY}{SLOW}");
    let project = Project::new(&study);
    let out = |i: usize| format!("out{i}");
    let spawn = |i: usize| {
        let mut command = project.command(&["run", "study.toml", "--json", "--out", &out(i)]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let children: Vec<Child> = (0..4).map(spawn).collect();
    let mut ran = 0;
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        ran += events(&String::from_utf8_lossy(&output.stdout)).get("ran").copied().unwrap_or(0);
    }
    assert_eq!(ran, 41, "41 results, none of them twice");
    assert!(project.files("store/locks").iter().all(|(path, _)| path.ends_with("store")), "no lock stays");
}

#[test]
fn a_run_that_waits_for_one_that_dies_takes_over() {
    let project = Project::new(SLOW);
    let mut first = start(&project);
    wait_for_checkpoint(&project);
    let mut second = start(&project);
    let mut lines = BufReader::new(second.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("\"waiting\"")), "the second run waits for the first");
    first.kill().unwrap();
    first.wait().unwrap();
    let rest: String = lines.map(|line| line + "\n").collect();
    assert!(second.wait().unwrap().success());
    let events = events(&rest);
    assert_eq!((events.get("resumed"), events.get("ran")), (Some(&1), Some(&1)), "{rest}");
    assert_eq!(objects(&project), objects(&straight()));
}

/// The film asks for a time at which there is no snapshot: it fails. The others don't need it.
pub const FAILING: &str = r#"
[step.hit]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper" }
plate = { material = "copper", thickness = "0.5 mm", width = "2 mm" }
cells = 2
end = "0.1 us"
velocity = "2 km/s"
[step.film]
use = "radiograph"
run = "@hit"
exposures = ["0.05 us"]
"#;

#[test]
fn a_failure_ends_the_run_unless_it_is_to_keep_going() {
    let study = format!("{FAILING}{MANY}");
    // Known results are served whatever fails.
    let project = Project::new(&study);
    let said = project.hvi(&["run", "study.toml", "--jobs", "1"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("1 failed") && said.err.contains("skipped"), "{}", said.err);
    let said = project.hvi(&["run", "study.toml", "--keep-going"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("1 failed") && !said.err.contains("skipped"), "{}", said.err);
    assert!(project.hvi(&["run", "study.toml"]).err.contains("41 from the store, 0 computed, 1 failed"));
}

#[test]
fn only_what_may_pass_is_tried_again() {
    let project = Project::new(FAILING);
    let said = project.hvi(&["run", "study.toml", "--json", "--retry", "2"]);
    assert_eq!(events(&said.out).get("retrying"), None, "{}", said.out);
    assert!(said.out.contains("not tried again"), "{}", said.out);
    // A store that can't take results, for no reason that it knows.
    let project = Project::new(FAILING);
    std::fs::create_dir(project.path("store")).unwrap();
    project.write("store/objects", "a file where a folder should be");
    let said = project.hvi(&["run", "study.toml", "--json", "--retry", "1"]);
    assert_eq!(said.code, 1, "{}", said.err);
    let events = events(&said.out);
    assert_eq!((events.get("retrying"), events.get("failed"), events.get("skipped")), (Some(&1), Some(&1), Some(&1)));
}

/// Runs a script in which file systems can be mounted, and are gone at its end.
fn with_mounts(project: &Project, script: &str) -> Said {
    let program = env!("CARGO_BIN_EXE_hvi-flow");
    let own = ["--mount", "--propagation", "private"];
    let user: &[&str] = if is_root() { &[] } else { &["--user", "--map-root-user"] };
    let mut command = Command::new("unshare");
    command.args(own).args(user).args(["sh", "-euc", script]).current_dir(project.folder.path());
    let output = command.env("HVI_STORE", project.path("store")).env("HVI", program).output();
    let said = super::project::said(output.expect("this test needs unshare: apt-get install util-linux"));
    assert!(said.out.contains("mounted"), "this test needs to mount: root, or user namespaces: {}", said.err);
    said
}

fn is_root() -> bool {
    String::from_utf8_lossy(&Command::new("id").arg("-u").output().unwrap().stdout).trim() == "0"
}

#[test]
fn a_store_that_can_only_be_read_serves_what_it_has() {
    let project = Project::new(MANY);
    assert_counts(&project.run(), 0, 40);
    project.write("more.toml", &MANY.replace("in 40", "in 79"));
    let before = project.files("store");
    let said = with_mounts(
        &project,
        "mount --bind store store; mount -o remount,bind,ro store; echo mounted
         $HVI run study.toml || echo failed
         $HVI run more.toml --keep-going || echo more failed",
    );
    assert!(said.err.contains("40 from the store, 0 computed"), "{}", said.err);
    assert!(said.err.contains("40 from the store, 0 computed, 39 failed"), "{}", said.err);
    assert!(said.err.contains("can't be written") && said.err.contains("--store"), "{}", said.err);
    assert_eq!(said.out, "mounted\nmore failed\n");
    assert_eq!(project.files("store"), before);
}

#[test]
fn a_full_disk_is_named_and_harms_nothing() {
    let project = Project::new(MANY);
    std::fs::create_dir(project.path("store")).unwrap();
    let said = with_mounts(
        &project,
        "mount -t tmpfs -o size=256k tmpfs store; echo mounted
         $HVI run study.toml --keep-going || echo failed
         find store/tmp -type f
         $HVI run study.toml --keep-going || echo failed
         mount -o remount,size=8m store
         $HVI run study.toml
         cp -r store whole",
    );
    assert_eq!(said.out, "mounted\nfailed\nfailed\n", "nothing is left in tmp/: {}", said.err);
    assert!(said.err.contains("make room with `hvi-flow cache gc`"), "{}", said.err);
    let ends: Vec<(usize, usize)> = said.err.lines().filter_map(counts).collect();
    let (first, last) = (ends[0], *ends.last().unwrap());
    assert!(first.1 > 0, "what there was room for was kept: {}", said.err);
    assert_eq!(last.0 + last.1, 40);
    assert!(last.0 >= first.1, "{}", said.err);
    std::fs::rename(project.path("whole"), project.path("store/..store")).unwrap();
    let whole = Project::new(MANY);
    whole.run();
    let digests = |p: &Project, folder: &str| -> Vec<Vec<u8>> {
        let mut all: Vec<_> = p.files(folder).into_iter().map(|(_, bytes)| bytes).collect();
        all.sort();
        all
    };
    assert_eq!(digests(&project, "store/..store/objects"), digests(&whole, "store/objects"));
}

/// `A` and `B` of `A from the store, B computed`.
fn counts(line: &str) -> Option<(usize, usize)> {
    let number = |text: &str| text.split_whitespace().next_back()?.parse().ok();
    let (hits, rest) = line.split_once(" from the store, ")?;
    Some((number(hits)?, number(rest.split_once(" computed")?.0)?))
}
