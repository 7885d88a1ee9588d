//! The JSON schema of pipeline files: it takes every good pipeline, and refuses the bad ones it can.
use std::path::{Path, PathBuf};

fn pipelines(folder: &str) -> Vec<(PathBuf, serde_json::Value)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let read = |path: PathBuf| {
        let table: toml::Table = std::fs::read_to_string(&path).unwrap().parse().ok()?;
        Some((path, serde_json::to_value(table).unwrap()))
    };
    paths.filter(|p| p.extension().is_some_and(|e| e == "toml")).filter_map(read).collect()
}

fn validator() -> jsonschema::Validator {
    let schema = hvi_flow::schema::pipeline();
    jsonschema::meta::validate(&schema).expect("it is a JSON schema");
    jsonschema::validator_for(&schema).unwrap()
}

#[test]
fn every_shipped_pipeline_is_valid() {
    let validator = validator();
    let mut all = pipelines("pipelines");
    all.extend(pipelines("pipelines/paper"));
    all.extend(pipelines("src/commands"));
    assert!(all.len() >= 2);
    for (path, value) in all {
        let wrong: Vec<String> = validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", path.display());
    }
}

/// What follows from names, kinds and units is in the schema; what needs other steps, files or numbers is `plan`'s.
#[test]
fn what_a_schema_can_refuse_is_refused() {
    let validator = validator();
    let bad = pipelines("tests/bad");
    let mut taken = Vec::new();
    for name in [
        "bare_number",
        "missing_port",
        "no_stage",
        "range_without_count",
        "unknown_key",
        "unknown_key_nested",
        "unknown_stage",
        "unknown_table",
        "unknown_unit",
        "unknown_variant",
        "value_where_a_result_belongs",
        "wrong_dimension",
        "wrong_type",
    ] {
        let found = bad.iter().find(|(path, _)| path.file_stem().is_some_and(|stem| stem == name));
        let (_, value) = found.unwrap_or_else(|| panic!("tests/bad/{name}.toml is gone"));
        if validator.is_valid(value) {
            taken.push(name);
        }
    }
    assert!(taken.is_empty(), "the schema takes {taken:?}");
}
