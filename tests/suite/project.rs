//! A throw-away folder with a pipeline, a store and results, and the program run in it.
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder that goes away with the value.
pub struct Project {
    pub folder: tempfile::TempDir,
}

/// What a run said.
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Project {
    pub fn new(pipeline: &str) -> Project {
        let project = Project { folder: tempfile::tempdir().unwrap() };
        project.write("study.toml", pipeline);
        project
    }
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }
    /// Runs the program in the folder, with its own store there.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hvi-flow"));
        command.current_dir(self.folder.path()).args(arguments).env("HVI_STORE", self.path("store"));
        command
    }
    pub fn hvi(&self, arguments: &[&str]) -> Said {
        said(self.command(arguments).output().unwrap())
    }
    pub fn run(&self) -> Said {
        self.hvi(&["run", "study.toml"])
    }
    /// Files below `name`, with their bytes.
    pub fn files(&self, name: &str) -> Vec<(PathBuf, Vec<u8>)> {
        let mut all = Vec::new();
        collect(&self.path(name), &mut all);
        all.sort();
        all
    }
}

pub fn said(output: Output) -> Said {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Said { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) }
}

fn collect(folder: &Path, all: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, all);
        } else {
            all.push((path.clone(), std::fs::read(&path).unwrap()));
        }
    }
}

/// Forty results that cost next to nothing.
pub const MANY: &str = r#"
[step.metal]
use = "eos.handbook"
mie_gruneisen = { density = "8930 kg/m3", sound_speed = "3940 m/s", slope = 1.5, gruneisen = 2.02, heat_capacity = "385 J/kg/K" }
sweep = { "mie_gruneisen.slope" = "1.2 .. 1.6 in 40" }
"#;

/// A node that takes about a second.
pub const SLOW: &str = r#"
[step.slow]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper" }
plate = { material = "copper", thickness = "0.5 mm", width = "3 mm" }
cells = 12
end = "3 us"
velocity = "2 km/s"
"#;

/// Asserts how many results came from the store and how many were computed.
#[track_caller]
pub fn assert_counts(said: &Said, hits: usize, ran: usize) {
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains(&format!("{hits} from the store, {ran} computed")), "{}", said.err);
}

/// Stored bytes by name.
pub fn objects(project: &Project) -> BTreeMap<String, Vec<u8>> {
    let named = |(path, bytes): (std::path::PathBuf, Vec<u8>)| (path.to_string_lossy().into_owned(), bytes);
    let short = |(path, bytes): (String, Vec<u8>)| (path.rsplit("objects").next().unwrap().to_string(), bytes);
    project.files("store/objects").into_iter().map(named).map(short).collect()
}
