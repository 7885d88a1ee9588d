//! Slurm's own commands. No shell reads what they are given, but for the script of a job, whose words are quoted.
use super::Needs;
use super::batch::{self, Batch};
use crate::pipeline::Profile;
use hvi_kit::Store;
use std::collections::HashSet;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

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
    /// By batch and task.
    Jobs(HashSet<(String, usize)>),
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
    match Command::new("sbatch").arg("--version").stdin(Stdio::null()).output() {
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
    match with_input(&mut command, &script) {
        Ok(output) if output.status.success() => Submitted::Yes,
        Ok(output) if is_silent(&output) => Submitted::Unsure(format!("Slurm does not answer: {}", said(&output))),
        Ok(output) => Submitted::No(format!("Slurm refused the job: {}", said(&output))),
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

fn with_input(command: &mut Command, input: &str) -> std::io::Result<Output> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    if let Some(mut stdin) = child.stdin.take() {
        // One that doesn't read it says why itself.
        let _ = stdin.write_all(input.as_bytes());
    }
    child.wait_with_output()
}

/// Asks which of this user's jobs are queued or at work.
pub fn alive() -> Alive {
    let mut command = Command::new("squeue");
    let output = command.args(["--me", "--noheader", "--array", "--format=%j|%K"]).stdin(Stdio::null()).output();
    match output {
        Ok(output) if output.status.success() => {
            let text = String::from_utf8_lossy(&output.stdout);
            let job = |line: &str| {
                let (name, task) = line.trim().split_once('|')?;
                Some((name.strip_prefix(PREFIX)?.to_string(), task.parse().ok()?))
            };
            Alive::Jobs(text.lines().filter_map(job).collect())
        }
        Ok(output) => Alive::Unknown(format!("Slurm does not answer: {}", said(&output))),
        Err(e) => Alive::Unknown(format!("squeue can't be run: {e}")),
    }
}

/// Most cores that a machine of the profile's partition has: a job that asks for more would wait for ever. `None` where Slurm does not
/// say.
pub fn most_cores(profile: &Profile) -> Option<usize> {
    let mut command = Command::new("sinfo");
    command.args(["--noheader", "--format=%c"]).stdin(Stdio::null());
    command.args(
        profile
            .words
            .iter()
            .filter(|(option, _)| *option == "partition")
            .map(|(_, word)| format!("--partition={word}")),
    );
    let output = command.output().ok().filter(|output| output.status.success())?;
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
    let output = command.arg(format!("--name={PREFIX}{name}")).stdin(Stdio::null()).output();
    match output {
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
}
