//! `explain`: why a result would be computed again or not, field by field, and what counts in its key.
use super::{Done, StudyArgs};
use crate::console::{duration, say, warn};
use crate::execute;
use crate::forecast::{self, Fate, Forecast, Supplier, Why};
use crate::history::{self, Last};
use crate::plan::{NodeId, Plan};
use crate::reference;
use hvi_cache::Change;
use hvi_kit::Store;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;

/// What `explain` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Which results: STEP, or 'STEP[key=value, ...]' [default: all that are not in the store]
    #[arg(value_name = "STEP[POINT]")]
    of: Option<String>,
    /// One JSON object a line and result on standard output
    #[arg(long)]
    json: bool,
}

/// Explains.
///
/// # Errors
/// [`super::Stop`] where the pipeline or the reference is wrong, or the store can't be used.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let of = args.of.as_deref().map(|text| reference::nodes(&plan, text)).transpose()?;
    let store = args.study.store()?;
    let last = Last::of(&store, &pipeline.name);
    let forecasts = forecast::forecast(&plan, &store, &last);
    store.notices().iter().for_each(|text| warn(format_args!("{text}")));
    let waiting = |id: &NodeId| forecasts[*id].entry().is_none();
    let nodes = of.unwrap_or_else(|| (0..plan.nodes.len()).filter(waiting).collect());
    let told = Told { plan: &plan, store: &store, last: &last, forecasts: &forecasts };
    if args.json {
        nodes.iter().for_each(|&id| say(format_args!("{}", told.json(id))));
    } else if nodes.is_empty() {
        say(format_args!("{}: all {} results are in the store", pipeline.name, plan.nodes.len()));
    } else {
        told.explain(&nodes);
    }
    Ok(ExitCode::SUCCESS)
}

struct Told<'a> {
    plan: &'a Plan,
    store: &'a Store,
    last: &'a Last,
    forecasts: &'a [Forecast],
}

impl Told<'_> {
    fn explain(&self, nodes: &[NodeId]) {
        let mut groups: BTreeMap<(usize, Vec<String>), Vec<NodeId>> = BTreeMap::new();
        for &id in nodes {
            groups.entry((self.plan.nodes[id].step, self.lines(id))).or_default().push(id);
        }
        for ((step, lines), ids) in &groups {
            let step = &self.plan.steps[*step];
            let whose = match ids[..] {
                [one] => self.plan.label(one),
                [first, ..] => format!("{} ({} points, such as {})", step.name, ids.len(), self.plan.label(first)),
                [] => continue,
            };
            say(format_args!("{whose}, by {}: {}", step.stage.name, lines[0]));
            lines[1..].iter().for_each(|line| say(format_args!("  {line}")));
        }
        self.causes(nodes);
        if let [one] = nodes {
            self.counted(*one);
        }
    }

    /// What becomes of a node, then one line a reason.
    fn lines(&self, id: NodeId) -> Vec<String> {
        let fields =
            |changes: &[Change]| -> Vec<String> { changes.iter().map(|c| forecast::words(self.plan, id, c)).collect() };
        let mut lines = match &self.forecasts[id].fate {
            Fate::Known(_) => vec![self.origin(id)],
            Fate::Run(Why::Changed(changes)) => {
                let mut lines = vec!["to run, it differs from its last run".to_string()];
                lines.extend(fields(changes));
                lines.extend(changes.iter().filter_map(|c| self.earlier(id, c)));
                lines
            }
            Fate::Run(why) => vec![format!("to run, {}", forecast::reason(self.plan, id, why))],
            Fate::Unknown(until) => {
                let first = self.plan.label(until.first);
                let mut lines = vec![format!("unknown until {first} has a result")];
                if !until.changes.is_empty() {
                    lines.push("it differs from its last run already:".into());
                    lines.extend(fields(&until.changes));
                } else if until.ran_before {
                    lines.push(
                        "nothing else differs from its last run: it stays if its inputs come out as they were".into(),
                    );
                }
                lines
            }
        };
        lines.dedup();
        lines
    }

    /// `in the store, computed ...`.
    fn origin(&self, id: NodeId) -> String {
        let record = self.forecasts[id].key.and_then(|key| self.store.lookup(key));
        let Some(r) = record else { return "in the store".into() };
        format!(
            "in the store, computed {} on {} in {} with {} thread(s), version {}",
            history::time(r.finished * 1000),
            if r.host.is_empty() { "an unnamed host" } else { &r.host },
            duration(r.wall_s),
            r.threads,
            r.program
        )
    }

    /// Why the input behind a change has another content: what its own key differs in since the run compared with.
    fn earlier(&self, id: NodeId, change: &Change) -> Option<String> {
        let Some(Supplier::Node(source)) = forecast::supplier(self.plan, id, &change.field) else { return None };
        let label = self.plan.label(source);
        let old = self.last.key_beside(&self.plan.label(id), &label)?;
        let now = self.store.recipe(self.forecasts[source].key?)?;
        let changes = now.changes_since(&self.store.recipe(old)?);
        let texts: Vec<_> = changes.iter().map(|c| forecast::words(self.plan, source, c)).collect();
        (!texts.is_empty()).then(|| format!("because of {label}: {}", texts.join("; ")))
    }

    /// The nodes that run and that the given ones wait for, each step's reasons once.
    fn causes(&self, nodes: &[NodeId]) {
        let (mut seen, mut todo) = (BTreeSet::new(), nodes.to_vec());
        let mut causes: BTreeMap<(usize, String), usize> = BTreeMap::new();
        while let Some(id) = todo.pop() {
            for need in self.plan.needs(id).collect::<BTreeSet<_>>() {
                if self.forecasts[need].entry().is_none() && !nodes.contains(&need) && seen.insert(need) {
                    let line = forecast::line(self.plan, need, &self.forecasts[need]);
                    *causes.entry((self.plan.nodes[need].step, line)).or_default() += 1;
                    todo.push(need);
                }
            }
        }
        if !causes.is_empty() {
            say(format_args!("what it waits for:"));
        }
        for ((step, line), count) in causes {
            say(format_args!("  {} ({count}): {line}", self.plan.steps[step].name));
        }
    }

    /// Everything that enters the key of a node, by the walk that makes the key.
    fn counted(&self, id: NodeId) {
        let output = |n: NodeId| self.forecasts[n].entry().map(|e| e.output);
        let whole = execute::recipe(self.plan, id, &output);
        let known = |n: NodeId| output(n).or(Some(hvi_kit::Digest::of(b"")));
        let Some(recipe) = whole.clone().or_else(|| execute::recipe(self.plan, id, &known)) else { return };
        match self.forecasts[id].key {
            Some(key) => say(format_args!("its key {key} is made of:")),
            None => say(format_args!("its key will be made of:")),
        }
        for (field, value) in recipe.fields() {
            let from = forecast::supplier(self.plan, id, &field);
            match from {
                Some(Supplier::Node(n)) if output(n).is_none() => {
                    say(format_args!("  {field} = unknown until {}", self.plan.label(n)));
                }
                Some(Supplier::Node(n)) => {
                    say(format_args!("  {field} = {} (the result of {})", forecast::short(&value), self.plan.label(n)));
                }
                Some(Supplier::File) => {
                    say(format_args!("  {field} = {} (the file's content)", forecast::short(&value)))
                }
                _ => say(format_args!("  {field} = {}", forecast::short(&value))),
            }
        }
    }

    fn json(&self, id: NodeId) -> serde_json::Value {
        let mut value = forecast::json(self.plan, id, &self.forecasts[id]);
        value["lines"] = json!(self.lines(id));
        value
    }
}
