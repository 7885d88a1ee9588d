//! What `run` would do with each node, and why: follows the plan through the store, runs nothing.
//!
//! The reasons are the differences of two recipes, found by the walk that makes the key.
use crate::execute::{self, Outcome, Report};
use crate::history::Last;
use crate::plan::{Input, NodeId, Plan};
use hvi_cache::{Change, Entry, Found};
use hvi_kit::{Digest, Recipe, Store};
use serde_json::json;

/// What `run` would do with a node.
pub struct Forecast {
    /// Its key, where all its inputs exist.
    pub key: Option<Digest>,
    /// What becomes of it.
    pub fate: Fate,
}

/// What becomes of a node.
pub enum Fate {
    /// Its result is in the store.
    Known(Entry),
    /// It runs, and why.
    Run(Why),
    /// It depends on results that don't exist yet.
    Unknown(Until),
}

/// Why a node runs.
pub enum Why {
    /// It never had a result here.
    New,
    /// It had this key at its last run, but the store has its result no longer.
    Gone,
    /// Its stored result is damaged.
    Damaged,
    /// It differs from its last run in these fields.
    Changed(Vec<Change>),
    /// It differs from its last run, whose recipe is no longer in the store.
    Forgotten,
}

/// What a node waits for, and what is known of it already.
pub struct Until {
    /// The first node it needs that has no result.
    pub first: NodeId,
    /// The fields in which it differs from its last run, whatever its missing inputs will be.
    pub changes: Vec<Change>,
    /// Whether it ran before: without changes, it stays as it is if its inputs come out as they were.
    pub ran_before: bool,
}

impl Forecast {
    /// The result, where it is in the store.
    pub fn entry(&self) -> Option<&Entry> {
        match &self.fate {
            Fate::Known(entry) => Some(entry),
            _ => None,
        }
    }

    /// `known`, `run` or `unknown`.
    pub fn word(&self) -> &'static str {
        match self.fate {
            Fate::Known(_) => "known",
            Fate::Run(_) => "run",
            Fate::Unknown(_) => "unknown",
        }
    }
}

/// Follows a plan through the store.
pub fn forecast(plan: &Plan, store: &Store, last: &Last) -> Vec<Forecast> {
    let mut all: Vec<Forecast> = Vec::with_capacity(plan.nodes.len());
    for id in 0..plan.nodes.len() {
        let output = |n: NodeId| all[n].entry().map(|e| e.output);
        let next = match execute::recipe(plan, id, &output) {
            None => Forecast { key: None, fate: Fate::Unknown(until(plan, id, store, last, &output)) },
            Some(recipe) => {
                let key = recipe.key();
                let fate = match execute::stored(store, key, plan.nodes[id].stage) {
                    Found::Whole(entry) => Fate::Known(entry),
                    Found::Damaged(_) => Fate::Run(Why::Damaged),
                    Found::Nothing => Fate::Run(why(&recipe, key, store, last.key(&plan.label(id)))),
                };
                Forecast { key: Some(key), fate }
            }
        };
        all.push(next);
    }
    all
}

fn why(recipe: &Recipe, key: Digest, store: &Store, last: Option<Digest>) -> Why {
    match last {
        None => Why::New,
        Some(old) if old == key => Why::Gone,
        Some(old) => store.recipe(old).map_or(Why::Forgotten, |old| Why::Changed(recipe.changes_since(&old))),
    }
}

/// What can be said of a node before its inputs exist: the ports that wait are left out of both recipes.
fn until(plan: &Plan, id: NodeId, store: &Store, last: &Last, output: &dyn Fn(NodeId) -> Option<Digest>) -> Until {
    let waits = |input: &Input| match input {
        Input::One(n) => output(*n).is_none(),
        Input::Many(ns) => ns.iter().any(|n| output(*n).is_none()),
        Input::File(_) => false,
    };
    let first = plan.needs(id).find(|n| output(*n).is_none()).unwrap_or(id);
    let old = last.key(&plan.label(id)).and_then(|key| store.recipe(key));
    let ran_before = old.is_some();
    let changes = old.and_then(|mut old| {
        let mut recipe = execute::recipe(plan, id, &|n| output(n).or(Some(Digest::of(b""))))?;
        for (port, _) in plan.nodes[id].inputs.iter().filter(|(_, input)| waits(input)) {
            recipe.inputs.remove(port);
            old.inputs.remove(port);
        }
        Some(recipe.changes_since(&old))
    });
    Until { first, changes: changes.unwrap_or_default(), ran_before }
}

/// Core-seconds foretold for each node that isn't in the store, from what such nodes took before; 0 for the others.
pub fn foretell(plan: &Plan, forecasts: &[Forecast], store: &Store) -> Vec<f64> {
    let outcomes: Vec<_> = forecasts.iter().map(|f| f.entry().map(|entry| Outcome::Hit(*entry))).collect();
    execute::foretell(plan, &outcomes, store)
}

/// The results that are in the store, as a run that computed nothing would report them.
pub fn report(forecasts: &[Forecast]) -> Report {
    let outcome = |f: &Forecast| match f.entry() {
        Some(entry) => Outcome::Hit(*entry),
        None => Outcome::Skipped("its result is not in the store".into()),
    };
    Report {
        outcomes: forecasts.iter().map(outcome).collect(),
        keys: forecasts.iter().map(|f| f.key).collect(),
        seconds: 0.0,
        hold: None,
    }
}

/// Fields that a line names; the rest is counted.
const MOST: usize = 4;

/// What becomes of node `id`, in one line.
pub fn line(plan: &Plan, id: NodeId, forecast: &Forecast) -> String {
    match &forecast.fate {
        Fate::Known(_) => "known".into(),
        Fate::Run(why) => format!("to run: {}", reason(plan, id, why)),
        Fate::Unknown(until) => {
            let step = &plan.steps[plan.nodes[until.first].step].name;
            match (until.changes.is_empty(), until.ran_before) {
                (false, _) => format!("unknown until {step}; differs in {}", list(plan, id, &until.changes)),
                (true, true) => format!("unknown until {step}: stays if that gives the same bytes as before"),
                (true, false) => format!("unknown until {step}"),
            }
        }
    }
}

/// Why node `id` runs, in words.
pub fn reason(plan: &Plan, id: NodeId, why: &Why) -> String {
    match why {
        Why::New => "it has no result yet".into(),
        Why::Gone => "its result is no longer in the store".into(),
        Why::Damaged => "its stored result is damaged or gone".into(),
        Why::Changed(changes) => list(plan, id, changes),
        Why::Forgotten => "it changed, and the old recipe is no longer in the store".into(),
    }
}

fn list(plan: &Plan, id: NodeId, changes: &[Change]) -> String {
    let mut texts: Vec<String> = changes.iter().take(MOST).map(|c| words(plan, id, c)).collect();
    if changes.len() > MOST {
        texts.push(format!("and {} more", changes.len() - MOST));
    }
    texts.join("; ")
}

/// A changed field in words: old -> new.
pub fn words(plan: &Plan, id: NodeId, change: &Change) -> String {
    let text = |value: &Option<String>| value.as_deref().map_or_else(|| "nothing".into(), short);
    let both = format!("{} -> {}", text(&change.old), text(&change.new));
    match change.field.as_str() {
        "code" => {
            format!("code: that of the stage `{}` or of a crate it uses changed, {both}", plan.nodes[id].stage.name)
        }
        "engine" => format!("engine: another version of the program outside, {both}"),
        "format" => format!("format: the program makes keys in another way, {both}"),
        field => match source(plan, id, field) {
            Some(whose) => format!("{field}: {whose} changed, {both}"),
            None => format!("{field}: {both}"),
        },
    }
}

/// What fills the input that `field` names: `inputs.eos`, `inputs.states[3]`.
fn source(plan: &Plan, id: NodeId, field: &str) -> Option<String> {
    Some(match supplier(plan, id, field)? {
        Supplier::Node(n) => format!("the result of {}", plan.label(n)),
        Supplier::File => "the file".into(),
        Supplier::Number => "the number of results".into(),
    })
}

/// What stands behind an input field of a recipe.
pub enum Supplier {
    /// A node's result.
    Node(NodeId),
    /// A file's content.
    File,
    /// The length of a list of results.
    Number,
}

/// What stands behind the field `inputs.PORT` or `inputs.PORT[i]` of node `id`.
pub fn supplier(plan: &Plan, id: NodeId, field: &str) -> Option<Supplier> {
    let (port, index) = match field.strip_prefix("inputs.")?.strip_suffix(']').and_then(|f| f.rsplit_once('[')) {
        Some((port, index)) => (port, index.parse::<usize>().ok()),
        None => (field.strip_prefix("inputs.")?, None),
    };
    match (plan.nodes[id].inputs.get(port)?, index) {
        (Input::One(n), _) => Some(Supplier::Node(*n)),
        (Input::Many(ns), Some(i)) => ns.get(i).map(|n| Supplier::Node(*n)),
        (Input::Many(_), None) => Some(Supplier::Number),
        (Input::File(_), _) => Some(Supplier::File),
    }
}

/// A value as a line shows it: digests are cut.
pub fn short(text: &str) -> String {
    let is_digest = text.len() == 64 && text.chars().all(|c| c.is_ascii_hexdigit());
    if is_digest { text[..12].into() } else { text.into() }
}

/// A forecast for machines.
pub fn json(plan: &Plan, id: NodeId, forecast: &Forecast) -> serde_json::Value {
    let node = &plan.nodes[id];
    let (reason, changes) = match &forecast.fate {
        Fate::Known(_) => ("known", &[][..]),
        Fate::Run(Why::New) => ("new", &[][..]),
        Fate::Run(Why::Gone) => ("gone", &[][..]),
        Fate::Run(Why::Damaged) => ("damaged", &[][..]),
        Fate::Run(Why::Forgotten) => ("forgotten", &[][..]),
        Fate::Run(Why::Changed(changes)) => ("changed", &changes[..]),
        Fate::Unknown(until) => ("inputs", &until.changes[..]),
    };
    let until = match &forecast.fate {
        Fate::Unknown(until) => Some(plan.label(until.first)),
        _ => None,
    };
    let changes: Vec<_> = changes.iter().map(|c| json!({ "field": c.field, "old": c.old, "new": c.new })).collect();
    json!({
        "node": plan.label(id),
        "step": plan.steps[node.step].name,
        "stage": node.stage.name,
        "state": forecast.word(),
        "reason": reason,
        "changes": changes,
        "until": until,
        "key": forecast.key.map(|k| k.to_string()),
        "result": forecast.entry().map(|e| e.output.to_string()),
        "cost_s": node.cost,
    })
}
