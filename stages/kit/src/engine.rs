//! Programs outside that a stage may call: their version is part of the key, their text output part of an error.
use crate::{Cancel, Cancelled};
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A program that does a stage's work for some of its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Engine {
    /// Its name, looked up in `PATH`.
    pub program: &'static str,
    /// Arguments that make it print its version.
    pub version: &'static [&'static str],
    /// Settings of its environment, which change how it starts, not what it computes.
    pub environment: &'static [(&'static str, &'static str)],
    /// How to get it, e.g. `apt install lammps`.
    pub install: &'static str,
}

/// Why a program outside gave no answer.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum EngineError {
    #[error("the program `{program}` is not here: {install}")]
    Missing { program: &'static str, install: &'static str },
    #[error("{0}")]
    Failed(String),
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What a program left behind.
pub struct Finished {
    /// Whether it ended with exit code 0.
    pub success: bool,
    /// What it printed, both streams.
    pub printed: String,
    /// The wanted files that exist, in the order they were asked for.
    pub files: Vec<Option<Vec<u8>>>,
}

impl Engine {
    fn command(&self) -> Command {
        let mut command = Command::new(self.program);
        // A group of its own: what it starts in turn ends with it.
        command.envs(self.environment.iter().copied()).stdin(Stdio::null()).process_group(0);
        command
    }

    /// The first line with a letter or digit that the program prints as its version.
    ///
    /// # Errors
    /// [`EngineError::Missing`] where it can't be started.
    pub fn version(&self) -> Result<String, EngineError> {
        let missing = |_| EngineError::Missing { program: self.program, install: self.install };
        let out = self.command().args(self.version).output().map_err(missing)?;
        let text = String::from_utf8_lossy(&out.stdout);
        let line = text.lines().map(str::trim).find(|l| l.contains(|c: char| c.is_ascii_alphanumeric()));
        Ok(line.unwrap_or("no version").to_string())
    }

    /// Runs the program in an empty folder of its own that holds `files`, until it ends or the stage is cancelled; the
    /// folder is removed afterwards.
    ///
    /// - `files` name and content of each
    /// - `wanted` names of the files to bring back
    ///
    /// # Errors
    /// [`EngineError`] where it can't be started, the folder can't be written, or a stop was asked for.
    pub fn run(
        &self,
        args: &[&str],
        files: &[(&str, &[u8])],
        wanted: &[&str],
        cancel: &Cancel,
    ) -> Result<Finished, EngineError> {
        let folder = tempfile::tempdir().map_err(|source| EngineError::Io { path: std::env::temp_dir(), source })?;
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).map_err(|source| EngineError::Io { path, source })?;
        }
        let mut command = self.command();
        command.args(args).current_dir(folder.path());
        let missing = |_| EngineError::Missing { program: self.program, install: self.install };
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(missing)?;
        let streams = (child.stdout.take(), child.stderr.take());
        let readers = [
            streams.0.map(|s| std::thread::spawn(move || read_all(s))),
            streams.1.map(|s| std::thread::spawn(move || read_all(s))),
        ];
        let status = loop {
            match child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if cancel.is_set() => {
                    end(&mut child);
                    return Err(Cancelled.into());
                }
                Ok(None) => std::thread::sleep(Duration::from_millis(10)),
                Err(source) => return Err(EngineError::Io { path: self.program.into(), source }),
            }
        };
        let printed = readers.into_iter().flatten().map(|r| r.join().unwrap_or_default()).collect();
        let files = wanted.iter().map(|name| std::fs::read(folder.path().join(name)).ok()).collect();
        Ok(Finished { success: status.success(), printed, files })
    }
}

/// Ends the program and all that it has started, which are a process group.
fn end(child: &mut Child) {
    let group = format!("-{}", child.id());
    let _ = Command::new("kill").args(["-KILL", "--", &group]).stdin(Stdio::null()).stderr(Stdio::null()).status();
    let _ = child.kill();
    let _ = child.wait();
}

fn read_all(mut stream: impl Read) -> String {
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHELL: Engine =
        Engine { program: "sh", version: &["-c", "echo; echo shell 1"], environment: &[], install: "it is everywhere" };

    #[test]
    fn a_program_gets_its_files_and_gives_its_answer() {
        assert_eq!(SHELL.version().unwrap(), "shell 1");
        let script: &[u8] = b"cat in > out; echo said; exit 3";
        let files = [("script", script), ("in", b"42".as_slice())];
        let done = SHELL.run(&["script"], &files, &["out", "absent"], &Cancel::default()).unwrap();
        assert!(!done.success);
        assert_eq!(done.printed, "said\n");
        assert_eq!(done.files, [Some(b"42".to_vec()), None]);
    }

    #[test]
    fn a_program_that_is_not_here_is_named_with_the_way_to_get_it() {
        let absent =
            Engine { program: "no-such-program-here", version: &[], environment: &[], install: "apt install nothing" };
        assert!(absent.version().unwrap_err().to_string().ends_with("apt install nothing"));
    }

    #[test]
    fn a_stop_ends_the_program() {
        let cancel = Cancel::default();
        cancel.set();
        let stopped = SHELL.run(&["-c", "exec sleep 600"], &[], &[], &cancel);
        assert!(matches!(stopped, Err(EngineError::Cancelled(_))));
    }
}
