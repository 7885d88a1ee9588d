//! Slurm's own commands. No shell reads what they are given, but for the script of a job, whose words are quoted.
use super::Needs;
use super::batch::{self, Batch};
use crate::pipeline::Profile;
use hvi_kit::Store;
use std::collections::HashSet;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// How long a command may take to answer. Slurm's own patience is 10 s, unless a cluster says otherwise.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why a job waits in the ordinary way of things.
const ORDINARY: [&str; 8] =
    ["None", "Priority", "Resources", "Dependency", "BeginTime", "JobArrayTaskLimit", "Cleaning", "Prolog"];

/// What came of a submission.
pub enum Submitted {
    /// It is queued.
    Yes,
    /// Slurm did not answer, or not in time: it may be queued.
    Unsure(String),
    /// It was refused, and why.
    No(String),
}

/// Which jobs are queued or at work.
pub enum Alive {
    /// By batch and task; and why none is at work and none will be soon, where Slurm says such a thing.
    Jobs(HashSet<(String, usize)>, Option<String>),
    /// Slurm did not answer.
    Unknown(String),
}

/// What Slurm's commands say where the cluster doesn't answer: another try may do better.
const SILENT: [&str; 6] =
    ["Unable to contact", "timed out", "Connection refused", "Connection reset", "temporarily", "not responding"];

/// Slurm's version.
///
/// # Errors
/// What is missing, in one line.
pub fn version() -> Result<String, String> {
    match answer(Command::new("sbatch").arg("--version"), "") {
        Ok(output) if output.status.success() => Ok(String::from_utf8_lossy(&output.stdout).trim().into()),
        Ok(output) => Err(format!("sbatch --version failed: {}", said(&output))),
        Err(e) => Err(format!(
            "`sbatch` can't be run here ({e}): --executor slurm needs a machine of a Slurm cluster; --executor local runs here"
        )),
    }
}

/// Name of a job in Slurm's lists.
pub fn job_name(batch: &str, task: usize) -> String {
    format!("{PREFIX}{batch}_{task}")
}

const PREFIX: &str = "hvi-";

/// Submits a batch as one array.
pub fn submit(store: &Store, name: &str, batch: &Batch, needs: Needs, profile: &Profile) -> Submitted {
    let script = match script(store, name, profile) {
        Ok(script) => script,
        Err(why) => return Submitted::No(why),
    };
    let logs = batch::folder(store).join("logs");
    let mut command = Command::new("sbatch");
    command.args(["--parsable", "--nodes=1", "--ntasks=1", "--no-requeue"]);
    command.arg(format!("--job-name={PREFIX}{name}"));
    command.arg(format!("--array=0-{}", batch.tasks.len() - 1));
    command.arg(format!("--cpus-per-task={}", needs.threads));
    command.arg(format!("--mem={}M", needs.memory.div_ceil(1 << 20)));
    command.arg(format!("--output={}", logs.join(format!("{name}_%a.log")).display()));
    if let Some(time) = profile.time {
        command.arg(format!("--time={}", time.as_secs().div_ceil(60).max(1)));
    }
    command.args(profile.words.iter().map(|(option, word)| format!("--{option}={word}")));
    match answer(&mut command, &script) {
        Ok(output) if output.status.success() => Submitted::Yes,
        Ok(output) if is_silent(&output) => Submitted::Unsure(format!("Slurm does not answer: {}", said(&output))),
        Ok(output) => Submitted::No(format!("Slurm refused the job: {}", said(&output))),
        Err(e) if e.kind() == io::ErrorKind::TimedOut => Submitted::Unsure(format!("Slurm does not answer: {e}")),
        Err(e) => Submitted::No(format!("sbatch can't be run: {e}")),
    }
}

/// What a job runs.
fn script(store: &Store, name: &str, profile: &Profile) -> Result<String, String> {
    let full = |path: &Path| path.canonicalize().map_err(|e| format!("{}: {e}", path.display()));
    let program = std::env::current_exe().map_err(|e| format!("the program's own path is not known: {e}"))?;
    let modules: String = profile.modules.iter().map(|m| format!("module load {}\n", quoted(m))).collect();
    Ok(format!(
        "#!/bin/sh\n{modules}exec {} exec --store {} --batch {} --task \"$SLURM_ARRAY_TASK_ID\"\n",
        quoted(&program.to_string_lossy()),
        quoted(&full(store.folder())?.to_string_lossy()),
        quoted(name)
    ))
}

/// A word as a shell takes it as it is.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Runs a command that is given `input`; one that does not come to its end in time is killed.
fn answer(command: &mut Command, input: &str) -> io::Result<Output> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    if let Some(mut stdin) = child.stdin.take() {
        // One that doesn't read it says why itself.
        let _ = stdin.write_all(input.as_bytes());
    }
    let (out, err) = (collect(child.stdout.take()), collect(child.stderr.take()));
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().and_then(|()| child.wait())?;
            let name = command.get_program().to_string_lossy();
            return Err(io::Error::new(io::ErrorKind::TimedOut, format!("{name} said nothing in {PATIENCE:?}")));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let bytes = |reader: std::thread::JoinHandle<Vec<u8>>| reader.join().unwrap_or_default();
    Ok(Output { status, stdout: bytes(out), stderr: bytes(err) })
}

/// Reads all of a pipe on a thread of its own.
fn collect(pipe: Option<impl Read + Send + 'static>) -> std::thread::JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
        bytes
    })
}

/// Asks which of this user's jobs are queued or at work.
pub fn alive() -> Alive {
    let mut command = Command::new("squeue");
    match answer(command.args(["--me", "--noheader", "--array", "--format=%j|%K|%T|%r"]), "") {
        Ok(output) if output.status.success() => listed(&String::from_utf8_lossy(&output.stdout)),
        Ok(output) => Alive::Unknown(format!("Slurm does not answer: {}", said(&output))),
        Err(e) if e.kind() == io::ErrorKind::TimedOut => Alive::Unknown(format!("Slurm does not answer: {e}")),
        Err(e) => Alive::Unknown(format!("squeue can't be run: {e}")),
    }
}

/// What `squeue` says, one job a line: name, number in its array, state, why it waits. Jobs of other names are others' business.
fn listed(text: &str) -> Alive {
    let (mut jobs, mut waits, mut others) = (HashSet::new(), None, false);
    for line in text.lines() {
        let mut words = line.trim().splitn(4, '|');
        let mut word = || words.next().unwrap_or_default();
        let (name, task, state, why) = (word(), word(), word(), word());
        let Some(batch) = name.strip_prefix(PREFIX).filter(|batch| batch::is_name(batch)) else { continue };
        let Ok(task) = task.parse() else { continue };
        jobs.insert((batch.to_string(), task));
        if state == "PENDING" && !why.is_empty() && !ORDINARY.contains(&why) {
            waits = Some(why.replace('_', " "));
        } else {
            others |= state != "PENDING";
        }
    }
    Alive::Jobs(jobs, waits.filter(|_| !others))
}

/// Most cores that a machine of the profile's partition has: a job that asks for more would wait for ever. `None` where Slurm does not
/// say.
pub fn most_cores(profile: &Profile) -> Option<usize> {
    let mut command = Command::new("sinfo");
    command.args(["--noheader", "--format=%c"]);
    command.args(
        profile
            .words
            .iter()
            .filter(|(option, _)| *option == "partition")
            .map(|(_, word)| format!("--partition={word}")),
    );
    let output = answer(&mut command, "").ok().filter(|output| output.status.success())?;
    // `16+` where machines differ.
    let cores = |line: &str| line.trim().trim_end_matches('+').parse().ok();
    String::from_utf8_lossy(&output.stdout).lines().filter_map(cores).max()
}

/// Ends the jobs of a batch.
///
/// # Errors
/// What Slurm says to it.
pub fn cancel(name: &str) -> Result<(), String> {
    let mut command = Command::new("scancel");
    match answer(command.arg("--me").arg(format!("--name={PREFIX}{name}")), "") {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(said(&output)),
        Err(e) => Err(format!("scancel can't be run: {e}")),
    }
}

fn is_silent(output: &Output) -> bool {
    let text = String::from_utf8_lossy(&output.stderr);
    SILENT.iter().any(|words| text.contains(words))
}

/// What a command printed to standard error, in one line.
fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.is_empty() { output.status.to_string() } else { words.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_reach_a_shell_as_they_are() {
        let word = "a b'; echo $HOME \"`x`";
        let output = Command::new("sh").args(["-c", &format!("printf %s {}", quoted(word))]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stdout), word);
    }

    #[test]
    fn jobs_are_known_by_their_names_and_waits_out_of_the_ordinary_are_said() {
        let (one, two) = (format!("{:020x}", 7), format!("{:020x}", 8));
        let jobs = |text: &str| match listed(text) {
            Alive::Jobs(jobs, why) => (jobs.len(), why),
            Alive::Unknown(why) => panic!("{why}"),
        };
        // Neither a job of another name nor one that only begins like ours counts.
        let text = format!(
            "hvi-{one}|3|PENDING|Priority\nhvi-mine|1|RUNNING|None\nother|0|RUNNING|None\nhvi-{two}|N/A|RUNNING|\n"
        );
        assert_eq!(jobs(&text), (1, None));
        let drained = format!("hvi-{one}|3|PENDING|Nodes_required_for_job_are_DOWN\n");
        assert_eq!(jobs(&drained), (1, Some("Nodes required for job are DOWN".into())));
        assert_eq!(jobs(&format!("{drained}hvi-{two}|0|RUNNING|None\n")), (2, None), "some are at work");
    }

    #[test]
    fn a_command_says_what_it_says() {
        let output = answer(Command::new("sh").args(["-c", "cat; echo no >&2; exit 3"]), "in").unwrap();
        assert_eq!((output.status.code(), output.stdout.as_slice(), said(&output)), (Some(3), &b"in"[..], "no".into()));
    }
}
