//! Nodes as jobs of a real Slurm cluster of one node, which these tests start and which ends with them.
use super::project::{MANY, Project, SLOW, Said, assert_counts, objects, said};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A path to the tests' own script.
fn script() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/slurm.sh")
}

/// The configuration of the cluster that the tests share.
fn cluster() -> &'static str {
    static CLUSTER: OnceLock<String> = OnceLock::new();
    CLUSTER.get_or_init(|| up("slurm"))
}

/// Starts a cluster, which watches this process and ends with it; its configuration.
fn up(name: &str) -> String {
    let folder = std::env::temp_dir().join(format!("hvi-{name}-{}", std::process::id()));
    let mut command = Command::new("bash");
    let up = command.arg(script()).arg("up").arg(&folder).arg(std::process::id().to_string()).output().unwrap();
    let text = String::from_utf8_lossy(&up.stdout);
    let line = text.lines().find_map(|line| line.strip_prefix("export SLURM_CONF="));
    line.unwrap_or_else(|| panic!("no cluster: {}", String::from_utf8_lossy(&up.stderr))).to_string()
}

/// The script's other commands on the running cluster.
fn control(what: &str) {
    let folder = PathBuf::from(cluster()).parent().unwrap().to_path_buf();
    let done = Command::new("bash").arg(script()).arg(what).arg(folder).output().unwrap();
    assert!(done.status.success(), "{what}: {}", String::from_utf8_lossy(&done.stderr));
}

fn command(project: &Project, arguments: &[&str]) -> Command {
    let mut command = project.command(arguments);
    command.env("SLURM_CONF", cluster());
    command
}

fn run(project: &Project, more: &[&str]) -> Said {
    let arguments = [&["run", "study.toml", "--executor", "slurm"], more].concat();
    said(command(project, &arguments).output().unwrap())
}

fn start(project: &Project) -> Child {
    let arguments = ["run", "study.toml", "--executor", "slurm", "--json", "--checkpoint", "10ms"];
    command(project, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn local(study: &str) -> Project {
    let project = Project::new(study);
    assert_eq!(project.run().code, 0);
    project
}

#[track_caller]
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(120), "{what} never came");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Names of the jobs that Slurm lists in the states given, of the batches of this project's store.
fn jobs(project: &Project, states: &str) -> Vec<String> {
    let mut squeue = Command::new("squeue");
    squeue.env("SLURM_CONF", cluster()).args(["-h", "-r", "--format=%j", &format!("--states={states}")]);
    let listed = String::from_utf8_lossy(&squeue.output().unwrap().stdout).into_owned();
    let batches = project.files("store/slurm");
    let own = |name: &&str| {
        batches.iter().any(|(path, _)| path.file_stem().is_some_and(|stem| name.ends_with(stem.to_str().unwrap())))
    };
    listed.lines().filter(own).map(str::to_string).collect()
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// Names of the jobs that a `run --json` was told of.
fn queued(out: &str) -> Vec<String> {
    let lines = out.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    lines.filter(|line| line["event"] == "queued").map(|line| line["job"].as_str().unwrap().to_string()).collect()
}

#[test]
fn arrays_of_short_nodes_give_the_digests_of_a_local_run() {
    let study = format!(
        "[run]\nexecutor = \"slurm\"\n[run.slurm]\npack = \"10 ms\"\narray = 3\n{}",
        MANY.replace("in 40", "in 120")
    );
    let project = Project::new(&study);
    let said = said(command(&project, &["run", "study.toml", "--json"]).output().unwrap());
    assert_eq!(said.code, 0, "{}", said.err);
    let mut jobs = queued(&said.out);
    assert_eq!(jobs.len(), 120);
    jobs.dedup();
    assert!(jobs.len() >= 10, "a job takes ten nodes foretold to take 1 ms: {jobs:?}");
    let batches: std::collections::BTreeSet<&str> = jobs.iter().map(|job| job.rsplit_once('_').unwrap().0).collect();
    assert!(batches.len() >= 4, "an array has three jobs: {batches:?}");
    assert!(objects(&project) == objects(&local(&study.replace("\"slurm\"", "\"local\""))));
    assert!(project.files("store/slurm").is_empty(), "what was submitted is forgotten once all is there");
    assert_counts(&run(&project, &[]), 120, 0);
}

#[test]
fn what_fails_in_a_job_fails_in_the_run_and_is_tried_again_by_the_next() {
    let failing = super::stops::FAILING;
    let project = Project::new(&format!("{failing}{MANY}"));
    for hits in [0, 41] {
        let said = run(&project, &["--keep-going"]);
        assert_eq!(said.code, 1, "{}", said.err);
        assert!(said.err.contains("FAILED film: no snapshot"), "{}", said.err);
        assert!(said.err.contains(&format!("{hits} from the store, {} computed, 1 failed", 41 - hits)), "{}", said.err);
    }
}

#[test]
fn a_job_that_ends_without_a_result_goes_on_in_another() {
    let project = Project::new(SLOW);
    let child = start(&project);
    wait_until("a checkpoint", || !project.files("store/partial").is_empty());
    let mut scancel = Command::new("scancel");
    let name = jobs(&project, "running").pop().expect("it runs");
    assert!(
        scancel
            .env("SLURM_CONF", cluster())
            .args(["--signal=KILL", "--batch", "--name", &name])
            .status()
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(queued(&String::from_utf8_lossy(&output.stdout)).len(), 2, "submitted twice");
    assert_eq!(objects(&project), objects(&local(SLOW)));
}

#[test]
fn a_controller_that_dies_delays_and_loses_nothing() {
    let project = Project::new(&format!("[run.slurm]\npack = \"100 ms\"\n{SLOW}{MANY}"));
    let child = start(&project);
    wait_until("a job", || !jobs(&project, "all").is_empty());
    control("kill");
    std::thread::sleep(Duration::from_secs(3));
    control("again");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(objects(&project), objects(&local(&format!("{SLOW}{MANY}"))));
}

#[test]
fn two_studies_at_once_share_their_jobs() {
    let study = format!("{SLOW}{MANY}");
    let project = Project::new(&study);
    project.write("other.toml", &study);
    let spawn = |file: &str| {
        let arguments = ["run", file, "--executor", "slurm", "--json"];
        command(&project, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let outs = [spawn("study.toml"), spawn("other.toml")].map(|child| {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        queued(&String::from_utf8_lossy(&output.stdout))
    });
    let mut all = outs.concat();
    all.sort();
    all.dedup();
    assert!(all.len() <= 2, "one array has all: a job for the long node, one for the short ones: {all:?}");
    assert_eq!(objects(&project), objects(&local(&study)));
}

#[test]
fn an_interrupt_leaves_jobs_to_which_the_next_run_returns() {
    let project = Project::new(SLOW);
    let child = start(&project);
    wait_until("a checkpoint", || !project.files("store/partial").is_empty());
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("jobs go on") && err.contains("hvi-flow cancel study.toml"), "{err}");
    let again = run(&project, &["--json"]);
    assert_eq!(again.code, 0, "{}", again.err);
    let (first, second) = (queued(&out), queued(&again.out));
    assert!(second.is_empty() || first == second, "the same job, or its result: {first:?} {second:?}");
    assert_eq!(objects(&project), objects(&local(SLOW)));
}

#[test]
fn cancel_ends_the_jobs_of_a_study() {
    let project = Project::new(&SLOW.replace("3 us", "30 us"));
    let child = start(&project);
    wait_until("a job at work", || !jobs(&project, "running").is_empty());
    signal(&child, "-INT");
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(130));
    let listed = jobs(&project, "running,pending");
    assert_eq!(listed.len(), 1);
    let done = said(command(&project, &["cancel", "study.toml"]).output().unwrap());
    assert!(done.out.contains("1 jobs in 1 batches cancelled"), "{}{}", done.out, done.err);
    let mut squeue = Command::new("squeue");
    squeue.env("SLURM_CONF", cluster()).args(["-h", "--states=running,pending", "--name", &listed[0]]);
    wait_until("the end of the job", || squeue.output().unwrap().stdout.is_empty());
}

/// It is said why nothing starts, and the run goes on once somebody has seen to it.
#[test]
fn a_drained_machine_is_named_and_waited_for() {
    // One of its own: no other test need wait for it.
    let cluster = up("drained");
    let scontrol = |words: &[&str]| {
        let mut command = Command::new("scontrol");
        command.env("SLURM_CONF", &cluster).args(["update", "nodename=localhost"]).args(words);
        assert!(command.status().unwrap().success(), "{words:?}");
    };
    scontrol(&["state=drain", "reason=by hand"]);
    let project = Project::new(SLOW);
    let said = std::fs::File::create(project.path("said")).unwrap();
    let mut run = project.command(&["run", "study.toml", "--executor", "slurm"]);
    let mut child = run.env("SLURM_CONF", &cluster).stderr(said).spawn().unwrap();
    let read = || std::fs::read_to_string(project.path("said")).unwrap();
    wait_until("word of the machine", || {
        assert!(child.try_wait().unwrap().is_none(), "{}", read());
        read().contains("Slurm starts none of the jobs")
    });
    scontrol(&["state=resume"]);
    assert!(child.wait().unwrap().success(), "{}", read());
    assert_eq!(read().matches("Slurm starts none of the jobs").count(), 1, "{}", read());
    assert_eq!(objects(&project), objects(&local(SLOW)));
}

/// What lies in a store may come from others: only names that this program gives become those of jobs.
#[test]
fn batches_of_other_names_cancel_nothing() {
    let project = local(MANY);
    let batch = r#"{"study": "study", "threads": 1, "checkpoint_s": 1.0, "tasks": [[]]}"#;
    std::fs::create_dir_all(project.path("store/slurm")).unwrap();
    for name in ["0123456789abcdef0123,other", "x", "0123456789ABCDEF0123", "0123456789abcdef012\n"] {
        project.write(&format!("store/slurm/{name}.json"), batch);
    }
    let done = said(command(&project, &["cancel", "study.toml"]).output().unwrap());
    assert!(done.code == 0 && done.out.contains("0 jobs in 0 batches"), "{}{}", done.out, done.err);
}

/// A node that could use more cores than any machine has gets those that there are, and does not wait for ever.
#[test]
fn no_job_asks_for_more_cores_than_a_machine_has() {
    let study = SLOW.replace("cells = 8", "cells = 64").replace("3 us", "0.01 us");
    let project = Project::new(&study);
    let said = run(&project, &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(objects(&project), objects(&local(&study)));
}

#[test]
fn what_the_cluster_refuses_is_said_in_one_line() {
    // A profile of the cluster, in a file of its own.
    let project = Project::new(&format!("include = [\"cluster.toml\"]\n{SLOW}"));
    project.write("cluster.toml", "[run.slurm]\npartition = \"nowhere\"\n");
    let said = run(&project, &[]);
    assert_eq!(said.code, 1);
    let line = said.err.lines().find(|line| line.contains("FAILED slow")).expect(&said.err);
    assert!(line.contains("Slurm refused the job") && line.contains("partition"), "{line}");
}

#[test]
fn without_slurm_one_line_says_so() {
    let project = Project::new(SLOW);
    let mut command = project.command(&["run", "study.toml", "--executor", "slurm"]);
    let said = said(command.env("PATH", "/nonexistent").output().unwrap());
    assert_eq!((said.code, said.err.lines().count()), (1, 1), "{}", said.err);
    assert!(said.err.contains("`sbatch`") && said.err.contains("--executor local"), "{}", said.err);
}

#[test]
fn a_node_is_computed_by_its_key() {
    let project = local(MANY);
    let (result, _) = project.files("store/results").pop().unwrap();
    let parts: Vec<_> = result.iter().rev().take(2).map(|part| part.to_string_lossy().into_owned()).collect();
    let key = format!("{}{}", parts[1], parts[0]);
    let before = objects(&project);
    std::fs::remove_file(&result).unwrap();
    std::fs::remove_file(project.path("store/index")).unwrap();
    std::fs::remove_dir_all(project.path("store/objects")).unwrap();
    let said = project.hvi(&["exec", &key]);
    assert_eq!(said.code, 0, "{}", said.err);
    let now = objects(&project);
    assert_eq!(now.len(), 1);
    assert!(now.iter().all(|(name, bytes)| before.get(name) == Some(bytes)));
    let said = project.hvi(&["exec", &"0".repeat(64)]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("not in the store"), "{}", said.err);
}
