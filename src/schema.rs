//! The pipeline file's JSON schema, for editors: made from the stages' parameter types and ports.
//!
//! A step's keys follow from the stage it uses. What a sweep may set later is not asked for, so the schema takes every
//! pipeline that `plan` takes; `plan` checks more than a schema can.
use crate::registry::STAGES;
use hvi_kit::{Arity, Artifact, File, Port, StageDef};
use schemars::{SchemaGenerator, generate::SchemaSettings};
use serde_json::{Map, Value, json};

/// The parameters of a stage as an object schema, and the types it refers to.
pub struct Parameters {
    /// `{"type": "object", "properties": ...}`.
    pub object: Value,
    /// By name, as in `#/$defs/NAME`.
    pub types: Map<String, Value>,
}

/// The parameters of one stage.
pub fn parameters(stage: &StageDef) -> Parameters {
    let mut generator = generator();
    let object = (stage.schema)(&mut generator).into();
    Parameters { object, types: generator.take_definitions(true) }
}

fn generator() -> SchemaGenerator {
    SchemaSettings::draft2020_12().into_generator()
}

/// The schema of the whole pipeline file.
pub fn pipeline() -> Value {
    let mut generator = generator();
    let mut stages: Vec<(&StageDef, Value)> =
        STAGES.iter().map(|stage| (stage, (stage.schema)(&mut generator).into())).collect();
    let mut types = generator.take_definitions(true);
    // What a sweep sets by a dotted key (`projectile.diameter`) need not be there.
    types.values_mut().for_each(|t| drop(t.as_object_mut().and_then(|t| t.remove("required"))));
    for (stage, object) in &mut stages {
        places(stage, object, &mut types);
        step(stage, object);
    }
    let mut material = types.get("Material").cloned().unwrap_or_else(|| json!({ "type": "object" }));
    material["description"] = "A material of your own; its name is what `material = \"NAME\"` refers to.".into();
    let names: Vec<&str> = STAGES.iter().map(|s| s.name).collect();
    let by_stage = STAGES.iter().map(|s| {
        let uses = json!({ "properties": { "use": { "const": s.name } }, "required": ["use"] });
        json!({ "if": uses, "then": { "$ref": format!("#/$defs/{}", definition(s)) } })
    });
    let any_step = json!({
        "type": "object",
        "required": ["use"],
        "properties": { "use": { "enum": names, "description": "The stage that makes the result." } },
        "allOf": by_stage.collect::<Vec<_>>(),
    });
    types.extend(stages.into_iter().map(|(stage, object)| (definition(stage), object)));
    types.insert("step".into(), any_step);
    types.insert("written-material".into(), material);
    let named = |of: &str| {
        json!({
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z0-9_-]+$" },
            "additionalProperties": { "$ref": format!("#/$defs/{of}") },
        })
    };
    let mut materials = named("written-material");
    materials.as_object_mut().map(|m| m.remove("propertyNames"));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "hvi-flow pipeline",
        "description": "Steps, each a stage with parameters and inputs; made by `hvi-flow schema`.",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "include": {
                "type": "array",
                "items": { "type": "string" },
                "description": "Pipeline files whose steps and materials this one shares, relative to it.",
            },
            "step": named("step"),
            "tradeoff": {
                "type": "object",
                "description": "What accuracy costs, for `hvi-flow tradeoff`: sets of runs along one key.",
                "additionalProperties": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["of", "along"],
                    "properties": {
                        "of": { "type": "string", "description": "The runs, as in \"@ball[*]\"." },
                        "along": { "type": "string", "description": "The swept key that is refined." },
                        "finer": { "enum": ["larger", "smaller"], "description": "Which of its values are finer." },
                        "eos": { "type": "string", "description": "The equation of state that the closed form of a planar impact is of." },
                        "check": { "type": "string", "description": "Another block, whose choices these runs check." },
                        "spread": { "type": "boolean", "description": "Whether the runs along the key are as likely as each other, and what counts is how far apart they lie." },
                        "first": { "type": "boolean", "description": "Whether its choices belong on the first screen of the page." },
                        "about": { "type": "string", "description": "What the runs are, in a sentence." },
                    },
                },
            },
            "choose": {
                "type": "object",
                "description": "Settings taken from a front that `hvi-flow tradeoff` measured.",
                "additionalProperties": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["of", "front", "block", "quantity"],
                    "properties": {
                        "of": { "type": "array", "items": { "type": "string" }, "description": "Steps that get the front's setting." },
                        "front": { "type": "string", "description": "The pipeline that measured it, relative to this file." },
                        "block": { "type": "string", "description": "Its [tradeoff.NAME]." },
                        "quantity": { "type": "string", "description": "What the error is of." },
                        "accuracy": { "type": "string", "description": "The cheapest setting within this error, as in \"2 %\"." },
                        "budget": { "type": "string", "description": "The most accurate setting within this CPU time, as in \"10 min\"." },
                    },
                },
            },
            "material": materials,
            "run": {
                "type": "object",
                "additionalProperties": false,
                "description": "Resources; they never change a result.",
                "properties": {
                    "jobs": { "type": "integer", "minimum": 1, "maximum": 4096, "description": "Threads at work at once." },
                    "memory": { "type": "string", "description": "Most that nodes at work may ask for, as in \"8 GB\"." },
                    "timeout": timeout(),
                    "retry": retry(),
                    "executor": { "enum": ["local", "slurm"], "description": "Where nodes are computed." },
                    "slurm": slurm(),
                },
            },
        },
        "$defs": types,
    })
}

/// `[run.slurm]`.
fn slurm() -> Value {
    let text = |about: &str| json!({ "type": "string", "description": about });
    json!({
        "type": "object",
        "additionalProperties": false,
        "description": "What jobs ask of a Slurm cluster.",
        "properties": {
            "partition": text("Passed on to sbatch."),
            "account": text("Passed on to sbatch."),
            "qos": text("Passed on to sbatch."),
            "constraint": text("Passed on to sbatch."),
            "time": text("The longest that a job may take, as in \"12 h\"."),
            "memory": text("Least memory that a job asks for, as in \"4 GB\"."),
            "cores": { "type": "integer", "minimum": 1, "maximum": 4096, "description": "Most cores of one node of the study." },
            "modules": { "type": "array", "items": { "type": "string" }, "description": "Modules that a job loads first." },
            "pack": text("Short nodes go into one job together, up to this time, as in \"5 min\"."),
            "array": { "type": "integer", "minimum": 1, "maximum": 100_000, "description": "Most jobs of one array." },
        },
    })
}

fn timeout() -> Value {
    json!({ "type": "string", "description": "The longest that one node may take, as in \"10 min\"." })
}

fn retry() -> Value {
    let about =
        "How often to try again what failed for a reason that may pass: files, programs outside; never the physics.";
    json!({ "type": "integer", "minimum": 0, "maximum": 100, "description": about })
}

fn definition(stage: &StageDef) -> String {
    format!("stage-{}", stage.name)
}

/// Turns the parameters of a stage into a step: the ports, `use` and the sweeps beside them.
fn step(stage: &StageDef, object: &mut Value) {
    let asked = object.as_object_mut().and_then(|o| o.remove("required"));
    let mut asked: Vec<Value> = asked.and_then(|r| r.as_array().cloned()).unwrap_or_default();
    let ports = stage.ports.iter().filter(|p| p.arity != Arity::Places);
    asked.extend(ports.clone().filter(|p| p.arity != Arity::Any).map(|p| p.name.into()));
    object["type"] = "object".into();
    object["title"] = stage.name.into();
    object["description"] = stage.summary.into();
    object["additionalProperties"] = false.into();
    if object.get("properties").is_none() {
        object["properties"] = json!({});
    }
    let keys = &mut object["properties"];
    ports.for_each(|p| keys[p.name] = plug(p));
    keys["use"] = json!({ "const": stage.name });
    keys["timeout"] = timeout();
    keys["retry"] = retry();
    keys["region"] = json!({
        "const": "auto",
        "description": "Of a sweep over states of matter only those that the pipeline's scenes come to.",
    });
    keys["sweep"] = json!({
        "type": "object",
        "description": "One result for each combination: key = [values], or \"FIRST .. LAST in COUNT\", or \"@STEP[*]\" for each of that step's points; keys may be dotted.",
        "additionalProperties": { "anyOf": [
            { "type": "array", "minItems": 1 },
            { "type": "string", "pattern": "\\.\\..* in " },
            { "type": "string", "pattern": "^@.*\\[.*\\]$" },
        ] },
    });
    keys["zip"] = keys["sweep"].clone();
    keys["zip"]["description"] = "Lists of the same length, side by side: one result for each place.".into();
    keys["points"] = json!({
        "type": "array",
        "minItems": 1,
        "items": { "type": "object" },
        "description": "One result for each table of keys.",
    });
    let swept = json!({ "anyOf": [{ "required": ["sweep"] }, { "required": ["zip"] }, { "required": ["points"] }] });
    object["if"] = json!({ "not": swept });
    object["then"] = json!({ "required": asked });
}

/// What goes into a port.
fn plug(port: &Port) -> Value {
    let one = json!({ "type": "string", "pattern": "^\\s*@" });
    let mut schema = match (port.kind == File::KIND, port.arity) {
        (true, _) => json!({ "type": "string", "description": "A file, relative to the pipeline's." }),
        (false, Arity::Many | Arity::Any) => json!({ "anyOf": [one, { "type": "array", "items": one }] }),
        (false, Arity::One | Arity::Places) => one,
    };
    schema["description"] = port.about.trim().into();
    schema
}

/// Adds a port that stands in tables (`plate.eos`) to the types of these tables.
fn places(stage: &StageDef, object: &mut Value, types: &mut Map<String, Value>) {
    for port in stage.ports.iter().filter(|p| p.arity == Arity::Places) {
        let keys = object["properties"].as_object_mut().into_iter().flat_map(Map::values_mut);
        keys.for_each(|schema| place(port, schema, types));
    }
}

/// Adds a port to the keys of a table, where `schema` is one, refers to one, or leaves the choice of one.
fn place(port: &Port, schema: &mut Value, types: &mut Map<String, Value>) {
    if let Some(keys) = schema.get_mut("properties") {
        keys[port.name] = plug(port);
    }
    let name = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")).map(str::to_string);
    // Taken out meanwhile: a type that refers to itself ends here.
    if let Some((name, mut found)) = name.and_then(|name| types.remove_entry(&name)) {
        place(port, &mut found, types);
        types.insert(name, found);
    }
    // A table of tables, each under its name.
    if let Some(each) = schema.get_mut("additionalProperties").filter(|each| each.is_object()) {
        place(port, each, types);
    }
    for choice in ["anyOf", "oneOf"] {
        let options = schema.get_mut(choice).and_then(Value::as_array_mut);
        options.into_iter().flatten().for_each(|option| place(port, option, types));
    }
}
