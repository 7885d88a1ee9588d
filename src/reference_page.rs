//! `docs/stages.md`: every stage with its inputs, keys, units and defaults, from the code's own types and docs.
use crate::registry::STAGES;
use crate::schema::{self, Parameters};
use hvi_kit::units;
use hvi_kit::{Arity, Artifact, File, Port, StageDef};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The page.
pub fn markdown() -> String {
    let mut page = String::from(
        "# Stages\n\nWhat a `[step.NAME]` can `use`, with all its keys. Made by `hvi-flow stages --markdown`; a test keeps it current.\n\n\
         | stage | makes |\n|---|---|\n",
    );
    for s in STAGES {
        let _ = writeln!(page, "| [`{}`](#{}) | {} |", s.name, s.name.replace('.', ""), cell(s.summary));
    }
    let mut quantities = BTreeMap::new();
    for s in STAGES {
        page += &stage(s, &mut quantities);
    }
    page += STEPS;
    page += "\n## Quantities\n\nWritten as a text with a unit, `\"6.7 km/s\"`; a bare number is refused. All are turned into SI, so \
             `\"2.5 mm\"` and `\"0.0025 m\"` are the same value.\n\n| quantity | SI unit | units | example |\n|---|---|---|---|\n";
    for (name, q) in &quantities {
        let units: Vec<&str> = q["units"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let (si, example) = (text(&q["unit"]), text(&q["examples"][0]));
        let _ = writeln!(page, "| {name} | {si} | {} | `\"{example}\"` |", units.join(", "));
    }
    page
}

/// Keys that any step may have, beside those of its stage.
const STEPS: &str = r#"
## Every step

| key | value | what |
|---|---|---|
| `use` | a stage's name | the stage that makes the result |
| `sweep` | `{ velocity = ["1 km/s", "2 km/s"], "projectile.diameter" = "1 mm .. 3 mm in 5" }` | one result for each combination; `in 5` means five values, both ends included |
| `zip` | as `sweep` | lists of the same length, side by side |
| `points` | `[{ velocity = "1 km/s" }, { velocity = "2 km/s", angle = "30 deg" }]` | one result for each table |
| `timeout` | a time: `"10 min"` | the longest one node may take; goes before `--timeout` and that of `[run]` |
| `retry` | a whole number, 0 to 100 | how often to try again what failed for a reason that may pass; goes before `--retry` and that of `[run]` |
| `region` | `"auto"` | of a sweep over states of matter only those that the pipeline's scenes bring it to, by estimate; what was left out is said |

`timeout`, `retry` and `region` never enter a key.
"#;

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn stage(stage: &StageDef, quantities: &mut BTreeMap<String, Value>) -> String {
    let parameters = schema::parameters(stage);
    let mut part = format!("\n## {}\n\n{}. Gives `{}`.\n", stage.name, capital(stage.summary), stage.output);
    if !stage.ports.is_empty() {
        part += "\n| input | takes | what |\n|---|---|---|\n";
        for port in stage.ports {
            let _ = writeln!(part, "| `{}` | {} | {} |", port.name, takes(port), cell(port.about));
        }
    }
    let mut table = Rows { parameters: &parameters, shared: shared(&parameters), quantities, text: String::new() };
    table.object("", &parameters.object, 0);
    if table.text.is_empty() {
        return part + "\nIt has no other keys.\n";
    }
    part = part + HEAD + &table.text;
    for name in table.shared.clone() {
        table.text.clear();
        let found = parameters.types[&name].clone();
        table.value(&found).1.iter().for_each(|object| table.object("", object, 0));
        let _ = write!(
            part,
            "\n### {}: {}\n\n{}\n{HEAD}{}",
            stage.name,
            name,
            prose(text(&found["description"])),
            table.text
        );
    }
    part
}

const HEAD: &str = "\n| key | value | default | what |\n|---|---|---|---|\n";

/// Types with keys of their own that stand in several places: they get a table of their own.
fn shared(parameters: &Parameters) -> Vec<String> {
    let all = format!("{}{}", parameters.object, serde_json::Value::from(parameters.types.clone()));
    let has_keys = |schema: &Value| {
        schema.get("properties").is_some()
            || schema["oneOf"].as_array().is_some_and(|o| o.iter().any(|c| c.get("properties").is_some()))
    };
    let is_shared = |name: &&String| all.matches(&format!("\"#/$defs/{name}\"")).count() > 1;
    parameters
        .types
        .iter()
        .filter(|(_, schema)| has_keys(schema))
        .map(|(name, _)| name)
        .filter(is_shared)
        .cloned()
        .collect()
}

fn takes(port: &Port) -> String {
    if port.kind == File::KIND {
        return "a file".into();
    }
    match port.arity {
        Arity::One => format!("one `{}`: `\"@STEP\"`", port.kind),
        Arity::Many => format!("one or more `{}`: `\"@STEP[*]\"`", port.kind),
        Arity::Any => format!("any number of `{}`, or none", port.kind),
        Arity::Places => format!("a `{}` in each table that has the key", port.kind),
    }
}

/// Rows of a table of keys.
struct Rows<'a> {
    parameters: &'a Parameters,
    /// Types that have tables of their own.
    shared: Vec<String>,
    quantities: &'a mut BTreeMap<String, Value>,
    text: String,
}

/// Tables in tables in tables.
const DEEPEST: usize = 6;

impl Rows<'_> {
    fn object(&mut self, prefix: &str, object: &Value, depth: usize) {
        let asked: Vec<&str> = object["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, key) in object["properties"].as_object().into_iter().flatten() {
            let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            let default = match key.get("default") {
                Some(Value::Null) | None if asked.contains(&name.as_str()) => "must be given".into(),
                Some(Value::Null) | None => "none".into(),
                Some(value) => format!("`{}`", shown(value)),
            };
            let (value, inner) = self.value(key);
            let about = self.about(key);
            let _ = writeln!(self.text, "| `{path}` | {} | {} | {} |", cell(&value), cell(&default), cell(&about));
            for inner in inner.iter().filter(|_| depth < DEEPEST) {
                self.object(&path, inner, depth + 1);
            }
        }
    }

    /// What the key is for: its own docs, else those of its type, and those of the values it can have.
    fn about(&self, key: &Value) -> String {
        let (own, found) = (text(&key["description"]), self.resolved(key));
        let own = if own.is_empty() { text(&found["description"]) } else { own };
        let option = |o: &Value| match (&o["const"], text(&o["description"])) {
            (Value::Null, _) | (_, "") => None,
            (value, about) => Some(format!(" `{}`: {about}", shown(value))),
        };
        let options: String = found["oneOf"].as_array().into_iter().flatten().filter_map(option).collect();
        format!("{own}{options}")
    }

    /// A schema, followed to what it refers to.
    fn resolved(&self, schema: &Value) -> Value {
        let name = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/"));
        name.and_then(|n| self.parameters.types.get(n)).unwrap_or(schema).clone()
    }

    /// What may be written, and the tables of keys in it.
    fn value(&mut self, schema: &Value) -> (String, Vec<Value>) {
        let found = self.resolved(schema);
        let name = text(&schema["$ref"]).rsplit('/').next().unwrap_or_default().to_string();
        if self.shared.contains(&name) {
            return (format!("a table, see {name} below"), Vec::new());
        }
        if found.get("units").is_some() {
            let words = spaced(&name);
            self.quantities.insert(words.clone(), found.clone());
            return (format!("{words} [{}]", text(&found["unit"])), Vec::new());
        }
        for choice in ["anyOf", "oneOf"] {
            if let Some(options) = found[choice].as_array() {
                return self.choice(options);
            }
        }
        if let Some(options) = found["enum"].as_array() {
            return (options.iter().map(|o| format!("`{}`", shown(o))).collect::<Vec<_>>().join(", "), Vec::new());
        }
        let kinds: Vec<&str> = match &found["type"] {
            Value::Array(kinds) => kinds.iter().map(text).filter(|k| *k != "null").collect(),
            kind => vec![text(kind)],
        };
        let word = match kinds.first().copied().unwrap_or_default() {
            "object" => return ("a table".into(), vec![found]),
            "array" => format!("a list: {}", self.value(&found["items"]).0),
            "boolean" => "true or false".into(),
            "integer" => "a whole number".into(),
            "number" => "a number".into(),
            "string" => "a text".into(),
            _ => "anything".into(),
        };
        (format!("{word}{}", range(&found)), Vec::new())
    }

    fn choice(&mut self, options: &[Value]) -> (String, Vec<Value>) {
        let mut inner = Vec::new();
        let mut words = Vec::new();
        for option in options.iter().filter(|o| o["type"] != "null") {
            if let Some(value) = option.get("const") {
                words.push(format!("`{}`", shown(value)));
                continue;
            }
            let (word, table) = self.value(option);
            let examples: Vec<String> =
                option["examples"].as_array().into_iter().flatten().map(|e| format!("`{}`", shown(e))).collect();
            words.push(if examples.is_empty() { word } else { format!("{word} ({})", examples.join(", ")) });
            inner.extend(table);
        }
        words.dedup();
        (words.join(" or "), inner)
    }
}

/// ` 1 to 4` where a schema has limits.
fn range(schema: &Value) -> String {
    match (&schema["minimum"], &schema["maximum"]) {
        (Value::Number(a), Value::Number(b)) => format!(", {a} to {b}"),
        (Value::Number(a), _) if a.as_f64() > Some(0.0) => format!(", {a} or more"),
        _ => String::new(),
    }
}

/// A JSON value as TOML has it; a quantity with no more digits than it needs.
fn shown(value: &Value) -> String {
    match value {
        Value::String(s) => match units::split(s) {
            Some((number, unit)) if !unit.is_empty() => {
                let x: f64 = number.parse().unwrap_or_default();
                let (plain, short) = (x.to_string(), format!("{x:e}"));
                format!("\"{} {unit}\"", if short.len() < plain.len() { short } else { plain })
            }
            _ => value.to_string(),
        },
        Value::Array(items) => format!("[{}]", items.iter().map(shown).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// `SpecificHeat` as `specific heat`.
fn spaced(name: &str) -> String {
    let mut words = String::new();
    for (i, c) in name.chars().enumerate() {
        if c.is_uppercase() && i > 0 {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// Docs as prose: in one line, links to code as code.
fn prose(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace("[`", "`").replace("`]", "`")
}

/// Prose that stands in a table's cell.
fn cell(text: &str) -> String {
    prose(text).replace('|', "\\|")
}
