//! `ro-crate-metadata.json` of exported results: RO-Crate 1.1 with the Process Run Crate profile 0.5
//! (<https://w3id.org/ro/wfrun/process>): each result names its recipe, code, host, compiler, time and cores.
use crate::history;
use hvi_cache::{Digest, Recipe, Record};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// One computation and the files that show its result.
pub struct Action {
    /// Its label: `states[temperature=300 K]`.
    pub label: String,
    /// What its sweep sets.
    pub swept: Vec<(String, String)>,
    /// Its key.
    pub key: Digest,
    /// What was asked.
    pub recipe: Recipe,
    /// What came of it.
    pub record: Record,
    /// Its files, by their paths in the crate; the recipe's comes first.
    pub files: Vec<String>,
}

/// A file of the crate.
pub struct Part {
    /// Digest of its bytes.
    pub digest: Digest,
    /// Their number.
    pub bytes: u64,
}

const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";

/// The metadata of a crate.
///
/// - `name`, `about` what the crate is, for people
/// - `parts` all files by path
/// - `shared` paths of files that sum up all actions
pub fn metadata(
    name: &str,
    about: &str,
    parts: &BTreeMap<String, Part>,
    shared: &[String],
    actions: &[Action],
) -> Value {
    // The latest result's time: the same results give the same crate.
    let published = actions.iter().map(|a| a.record.finished).max().unwrap_or(0);
    let id = |id: &str| json!({ "@id": id });
    let files: Vec<Value> = parts.keys().map(|path| id(&reference(path))).collect();
    let done: Vec<Value> = actions.iter().map(|a| id(&action_id(a))).collect();
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": [id("https://w3id.org/ro/crate/1.1")],
            "about": id("./"),
        }),
        json!({
            "@id": "./",
            "@type": "Dataset",
            "name": name,
            "description": about,
            "datePublished": history::iso(1000 * published),
            "license": "Not stated here: ask those who made these results.",
            "conformsTo": [id(PROFILE)],
            "hasPart": files,
            "mentions": done,
        }),
        json!({ "@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5" }),
    ];
    graph.extend(parts.iter().map(|(path, part)| file(path, part)));
    let mut software: BTreeMap<String, Value> = BTreeMap::new();
    for action in actions {
        let (id, tool) = tool(action);
        graph.extend(action_entities(action, &id, shared));
        software.insert(id, tool);
    }
    graph.extend(software.into_values());
    json!({
        "@context": ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"],
        "@graph": graph,
    })
}

fn file(path: &str, part: &Part) -> Value {
    let kind = match path.rsplit('.').next().unwrap_or_default() {
        "csv" => "text/csv",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "h5" | "vtkhdf" => "application/x-hdf5",
        "json" => "application/json",
        _ => "application/octet-stream",
    };
    json!({
        "@id": reference(path),
        "@type": "File",
        "name": path,
        "encodingFormat": kind,
        "contentSize": part.bytes.to_string(),
        "identifier": format!("blake3:{}", part.digest),
    })
}

fn action_id(action: &Action) -> String {
    format!("#run-{}", action.key.short())
}

/// The program with the stage that computed a result, and its id.
fn tool(action: &Action) -> (String, Value) {
    let (stage, code) = (&action.recipe.stage, action.recipe.code);
    let id = format!("#{stage}-{}", code.short());
    let engine = action.recipe.engine.as_ref().map(|version| format!(", computed by {version}")).unwrap_or_default();
    let tool = json!({
        "@id": id,
        "@type": "SoftwareApplication",
        "name": format!("hvi-flow, stage {stage}{engine}"),
        "version": format!("{}, code {code}", action.record.program),
    });
    (id, tool)
}

/// The action and the values it refers to.
fn action_entities(action: &Action, tool: &str, shared: &[String]) -> Vec<Value> {
    let own = action_id(action);
    let record = &action.record;
    let value = |name: &str, value: String| json!({ "@id": format!("{own}/{}", reference(name)), "@type": "PropertyValue", "name": name, "value": value });
    let swept: Vec<Value> = action.swept.iter().map(|(k, v)| value(k, v.clone())).collect();
    let environment = [
        value("host", record.host.clone()),
        value("compiler", record.compiler.clone()),
        value("cores of the host", record.cores.to_string()),
        value("threads used", record.threads.to_string()),
    ];
    let used = [
        value("wall time, s", record.wall_s.to_string()),
        value("CPU time, s", record.cpu_s.to_string()),
        value("bytes of the result", record.bytes.to_string()),
    ];
    let ids = |values: &[Value]| values.iter().map(|v| json!({ "@id": v["@id"] })).collect::<Vec<_>>();
    let paths = |paths: &[String]| paths.iter().map(|p| json!({ "@id": reference(p) })).collect::<Vec<_>>();
    let recipe = &action.files[..action.files.len().min(1)];
    let shown = action.files.get(1..).unwrap_or_default();
    let began = (1000 * record.finished).saturating_sub((1e3 * record.wall_s) as u64);
    let (object, result) = ([paths(recipe), ids(&swept)].concat(), [paths(shown), paths(shared)].concat());
    let mut entities = vec![json!({
        "@id": own,
        "@type": "CreateAction",
        "name": format!("computing {}", action.label),
        "description": format!("key {}, result {} ({})", action.key, record.output, record.kind),
        "instrument": { "@id": tool },
        "object": object,
        "result": result,
        "startTime": history::iso(began),
        "endTime": history::iso(1000 * record.finished),
        "actionStatus": "http://schema.org/CompletedActionStatus",
        "environment": ids(&environment),
        "resourceUsage": ids(&used),
    })];
    entities.extend(swept);
    entities.extend(environment);
    entities.extend(used);
    entities
}

/// A path or name as a relative reference: what a URI doesn't take is written as %XX (RFC 3986).
fn reference(path: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'/' | b'.' | b'-' | b'_' | b'~');
    path.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_uris() {
        assert_eq!(reference("film/t=[1 us]/Film.png"), "film/t%3D%5B1%20us%5D/Film.png");
        assert_eq!(reference("µ"), "%C2%B5");
    }
}
