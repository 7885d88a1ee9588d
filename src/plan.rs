//! Pipeline -> Plan: one node a point, references resolved, ports matched, parameters checked, in an order that works.
//!
//! Complete before the first stage runs: what can be known to be wrong without computing is found here.
use crate::mistake::{At, Mistake};
use crate::pipeline::{Pipeline, Step};
use crate::reference::{self, Reference, Selection};
use crate::sweep;
use crate::value::{Key, Node as Written, Table, Value};
use hvi_kit::engine::Engine;
use hvi_kit::{Arity, Artifact, Digest, File, Port, StageDef};
use std::collections::BTreeMap;
use std::path::Path;

/// Index of a node in [`Plan::nodes`].
pub type NodeId = usize;

/// What fills a port.
#[derive(Clone, Debug)]
pub enum Input {
    /// The result of a node.
    One(NodeId),
    /// The results of some nodes, in the order of their sweeps.
    Many(Vec<NodeId>),
    /// The content of a file, by digest: see [`Plan::files`].
    File(Digest),
}

/// One computation: one point of a step.
pub struct Node {
    /// Index in [`Plan::steps`].
    pub step: usize,
    /// `velocity=2.5 km/s, ...`; empty for the only point of a step without a sweep.
    pub point: String,
    /// What the sweep sets, as written.
    pub swept: Vec<(String, String)>,
    /// What it uses.
    pub stage: &'static StageDef,
    /// Parameters in canonical form.
    pub params: serde_json::Value,
    /// Inputs by dotted key.
    pub inputs: BTreeMap<String, Input>,
    /// Version of the program outside that computes it, if one does.
    pub engine: Option<String>,
    /// Predicted core-seconds.
    pub cost: f64,
}

/// A step of the plan.
pub struct PlannedStep {
    /// Its name.
    pub name: String,
    /// What it uses.
    pub stage: &'static StageDef,
    /// Its nodes, in sweep order.
    pub nodes: std::ops::Range<NodeId>,
    /// Names of the steps it needs.
    pub needs: Vec<String>,
}

/// What to run.
pub struct Plan {
    /// Steps in an order in which each comes after those it needs.
    pub steps: Vec<PlannedStep>,
    /// Nodes, step after step.
    pub nodes: Vec<Node>,
    /// Contents of the files named as inputs, encoded as artifacts.
    pub files: BTreeMap<Digest, Vec<u8>>,
    /// Versions of the programs outside that some node calls.
    pub engines: BTreeMap<&'static str, String>,
}

impl Plan {
    /// `states[volume_ratio=0.9, temperature=300 K]`.
    pub fn label(&self, id: NodeId) -> String {
        let node = &self.nodes[id];
        let name = &self.steps[node.step].name;
        if node.point.is_empty() { name.clone() } else { format!("{name}[{}]", node.point) }
    }
    /// Ids of the nodes that `id` needs.
    pub fn needs(&self, id: NodeId) -> impl Iterator<Item = NodeId> {
        self.nodes[id].inputs.values().flat_map(|input| match input {
            Input::One(n) => vec![*n],
            Input::Many(ns) => ns.clone(),
            Input::File(_) => vec![],
        })
    }
}

/// Makes the plan of a pipeline; with `only`, of these steps and what they need.
///
/// # Errors
/// The first [`Mistake`]: unknown names, cycles, ports that don't fit, parameters that are refused, files that can't be read.
pub fn plan(pipeline: &Pipeline, only: &[String]) -> Result<Plan, Mistake> {
    let order = order(pipeline, &wanted(pipeline, only)?)?;
    let mut plan = Plan { steps: Vec::new(), nodes: Vec::new(), files: BTreeMap::new(), engines: BTreeMap::new() };
    for i in order {
        let step = &pipeline.steps[i];
        let first = plan.nodes.len();
        for point in &step.points {
            let node = Builder { pipeline, step, plan: &mut plan }.node(point)?;
            plan.nodes.push(node);
        }
        let mut needs: Vec<String> = Vec::new();
        for id in first..plan.nodes.len() {
            for need in plan.needs(id) {
                let name = &plan.steps[plan.nodes[need].step].name;
                if !needs.contains(name) {
                    needs.push(name.clone());
                }
            }
        }
        let nodes = first..plan.nodes.len();
        plan.steps.push(PlannedStep { name: step.name.clone(), stage: step.stage, nodes, needs });
    }
    Ok(plan)
}

fn wanted(pipeline: &Pipeline, only: &[String]) -> Result<Vec<usize>, Mistake> {
    if only.is_empty() {
        return Ok((0..pipeline.steps.len()).collect());
    }
    let find = |name: &String| {
        pipeline.steps.iter().position(|s| s.name == *name).ok_or_else(|| {
            let mistake = Mistake::new(format!("--only {name}: there is no such step"));
            mistake.nearest(name, pipeline.steps.iter().map(|s| s.name.as_str()))
        })
    };
    only.iter().map(find).collect()
}

fn reference<'a>(text: &'a str, at: &At) -> Result<Reference<'a>, Mistake> {
    let body = text.strip_prefix('@').ok_or("it doesn't begin with `@`");
    body.and_then(reference::parse).map_err(|why| {
        let mistake = Mistake::new(format!("`{text}` is no reference: {why}")).at(at, "here");
        mistake.help("write \"@STEP\", \"@STEP[*]\" or \"@STEP[key=value]\"")
    })
}

/// Every reference in a value, by place.
fn references(value: &Value, found: &mut Vec<(String, At)>) {
    match &value.node {
        Written::Text(s) if s.starts_with('@') => found.push((s.clone(), value.at.clone())),
        Written::List(items) => items.iter().for_each(|v| references(v, found)),
        Written::Table(t) => t.0.iter().for_each(|(_, v)| references(v, found)),
        _ => {}
    }
}

fn find_step<'a>(pipeline: &'a Pipeline, name: &str, at: &At) -> Result<(usize, &'a Step), Mistake> {
    pipeline.steps.iter().enumerate().find(|(_, s)| s.name == name).ok_or_else(|| {
        let mistake = Mistake::new(format!("unknown step `{name}`")).at(at, "no step has this name");
        mistake.nearest(name, pipeline.steps.iter().map(|s| s.name.as_str()))
    })
}

/// Steps in an order in which each comes after those it needs: depth first from each wanted step.
fn order(pipeline: &Pipeline, wanted: &[usize]) -> Result<Vec<usize>, Mistake> {
    let mut needs: Vec<Vec<(usize, At)>> = Vec::new();
    for step in &pipeline.steps {
        let mut found = Vec::new();
        let values = step.params.0.iter().chain(step.points.iter().flatten());
        values.for_each(|(_, v)| references(v, &mut found));
        let mut of_step: Vec<(usize, At)> = Vec::new();
        for (text, at) in found {
            let (i, _) = find_step(pipeline, reference(&text, &at)?.step, &at)?;
            if !of_step.iter().any(|(j, _)| *j == i) {
                of_step.push((i, at));
            }
        }
        needs.push(of_step);
    }
    let (mut done, mut order) = (vec![false; needs.len()], Vec::new());
    for &start in wanted {
        let mut path: Vec<(usize, usize)> = if done[start] { vec![] } else { vec![(start, 0)] };
        while let Some((step, next)) = path.pop() {
            let Some((need, at)) = needs[step].get(next) else {
                done[step] = true;
                order.push(step);
                continue;
            };
            path.push((step, next + 1));
            if let Some(from) = path.iter().position(|(s, _)| s == need) {
                let names: Vec<_> = path[from..].iter().map(|(s, _)| pipeline.steps[*s].name.as_str()).collect();
                let title = format!("the steps need each other in a circle: {} -> {}", names.join(" -> "), names[0]);
                return Err(Mistake::new(title).at(at, "this closes the circle"));
            }
            if !done[*need] {
                path.push((*need, 0));
            }
        }
    }
    Ok(order)
}

/// Makes one node.
struct Builder<'a> {
    pipeline: &'a Pipeline,
    step: &'a Step,
    plan: &'a mut Plan,
}

impl Builder<'_> {
    fn node(mut self, point: &sweep::Point) -> Result<Node, Mistake> {
        let mut params = self.step.params.clone();
        for (key, value) in point {
            params.set(key, value.clone())?;
        }
        let mut inputs = BTreeMap::new();
        let mut plain = params.clone();
        self.extract("", &mut plain, &mut inputs)?;
        let stage = self.step.stage;
        for port in stage.ports.iter().filter(|p| p.arity == Arity::One || p.arity == Arity::Many) {
            if !inputs.contains_key(port.name) {
                let title = format!("step `{}` lacks `{}`", self.step.name, port.name);
                let mistake = Mistake::new(title).at(&self.step.at, format!("add {} = {}", port.name, example(port)));
                return Err(mistake.help(makers(port.kind)));
            }
        }
        let value = Value { node: Written::Table(plain), at: self.step.at.clone() };
        let written = params;
        let params = (stage.check)(&value.json()).map_err(|e| self.refused(&written, &e.key, &e.why))?;
        let files = self.files(&inputs);
        (stage.check_files)(&params, &files).map_err(|e| self.refused(&written, &e.key, &e.why))?;
        let cost = (stage.cost)(&params);
        let swept = point.iter().map(|(k, v)| (k.text.clone(), v.label())).collect();
        let engine = (stage.engine)(&params).map(|engine| self.version(engine)).transpose()?;
        Ok(Node { step: self.plan.steps.len(), point: sweep::label(point), swept, stage, params, inputs, engine, cost })
    }

    /// The files among `inputs`, by dotted key.
    fn files(&self, inputs: &BTreeMap<String, Input>) -> BTreeMap<String, File> {
        let content = |digest: &Digest| File::decode(&self.plan.files[digest]).expect("encoded when it was read");
        let file = |(key, input): (&String, &Input)| match input {
            Input::File(digest) => Some((key.clone(), content(digest))),
            Input::One(_) | Input::Many(_) => None,
        };
        inputs.iter().filter_map(file).collect()
    }

    /// The version of a program outside, asked once a plan.
    fn version(&mut self, engine: &'static Engine) -> Result<String, Mistake> {
        if let Some(known) = self.plan.engines.get(engine.program) {
            return Ok(known.clone());
        }
        let of = format!("step `{}` ({})", self.step.name, self.step.stage.name);
        let version =
            engine.version().map_err(|e| Mistake::new(format!("{of}: {e}")).at(&self.step.at, "needs this program"))?;
        self.plan.engines.insert(engine.program, version.clone());
        Ok(version)
    }

    /// Takes references and input files out of `table` into `inputs`.
    fn extract(
        &mut self,
        prefix: &str,
        table: &mut Table,
        inputs: &mut BTreeMap<String, Input>,
    ) -> Result<(), Mistake> {
        let mut kept = Vec::new();
        for (key, mut value) in std::mem::take(&mut table.0) {
            let path = if prefix.is_empty() { key.text.clone() } else { format!("{prefix}.{}", key.text) };
            let port = self.step.stage.ports.iter().find(|p| match p.arity {
                // A table in such a place is a value: a material that brings its own.
                Arity::Places => p.name == key.text && !matches!(value.node, Written::Table(_)),
                _ => p.name == path,
            });
            let mut refs = Vec::new();
            if !matches!(value.node, Written::Table(_)) {
                references(&value, &mut refs);
            }
            match (port, refs.is_empty()) {
                (Some(port), _) => {
                    let input = self.plug(port, &key, &value)?;
                    inputs.insert(path, input);
                    continue;
                }
                (None, false) => {
                    let title = format!("`{path}` of `{}` takes a value, not a result", self.step.stage.name);
                    return Err(Mistake::new(title).at(&refs[0].1, "a reference").help(self.ports_help()));
                }
                (None, true) => {}
            }
            if let Written::Table(t) = &mut value.node {
                self.extract(&path, t, inputs)?;
            }
            kept.push((key, value));
        }
        table.0 = kept;
        Ok(())
    }

    fn ports_help(&self) -> String {
        let names: Vec<_> = self.step.stage.ports.iter().map(|p| p.name).collect();
        if names.is_empty() { "it takes no results".into() } else { format!("results go to: {}", names.join(", ")) }
    }

    fn plug(&mut self, port: &Port, key: &Key, value: &Value) -> Result<Input, Mistake> {
        if port.kind == File::KIND {
            return self.file(value);
        }
        let texts: Vec<(&str, &At)> = match &value.node {
            Written::Text(s) => vec![(s, &value.at)],
            Written::List(items) => {
                items.iter().map(|v| Ok((v.text("a reference")?, &v.at))).collect::<Result<_, _>>()?
            }
            _ => vec![("", &value.at)],
        };
        let mut nodes = Vec::new();
        for (text, at) in texts {
            if !text.starts_with('@') {
                let mistake = Mistake::new(format!("`{}` takes a result, {}", key.text, example(port)));
                return Err(mistake.at(at, format!("this is {}", value.kind())).help(makers(port.kind)));
            }
            nodes.extend(self.resolve(port, text, at)?);
        }
        if matches!(port.arity, Arity::Many | Arity::Any) {
            return Ok(Input::Many(nodes));
        }
        match nodes[..] {
            [one] => Ok(Input::One(one)),
            _ => {
                let title = format!("`{}` takes one result, this names {}", key.text, nodes.len());
                Err(Mistake::new(title).at(&value.at, "here").help("select one: \"@STEP[key=value]\""))
            }
        }
    }

    fn resolve(&self, port: &Port, text: &str, at: &At) -> Result<Vec<NodeId>, Mistake> {
        let reference = reference(text, at)?;
        let (_, step) = find_step(self.pipeline, reference.step, at)?;
        if step.stage.output != port.kind {
            let title = format!("`{}` takes {}, but `{}` makes {}", port.name, port.kind, step.name, step.stage.output);
            return Err(Mistake::new(title).at(at, "does not fit").help(makers(port.kind)));
        }
        let planned = self.plan.steps.iter().find(|s| s.name == step.name).expect("planned before: the order says so");
        let all: Vec<NodeId> = planned.nodes.clone().collect();
        match reference.selection {
            Selection::None if all.len() == 1 || matches!(port.arity, Arity::Many | Arity::Any) => Ok(all),
            Selection::None => {
                let title = format!("`{}` has {} points, `{}` takes one", step.name, all.len(), port.name);
                Err(Mistake::new(title).at(at, "which one?").help(format!("select one: \"@{}[key=value]\"", step.name)))
            }
            Selection::All => Ok(all),
            Selection::Where(pairs) => reference::select(self.plan, planned, &pairs).map_err(|m| m.at(at, "here")),
        }
    }

    fn file(&mut self, value: &Value) -> Result<Input, Mistake> {
        let name = value.text("a file name")?;
        let path = self.step.folder.join(Path::new(name));
        let bytes = std::fs::read(&path)
            .map_err(|e| Mistake::new(format!("can't read {}: {e}", path.display())).at(&value.at, "named here"))?;
        let encoded = File(bytes).encode();
        let digest = Digest::of(&encoded);
        self.plan.files.insert(digest, encoded);
        Ok(Input::File(digest))
    }

    /// A parameter that the stage refused, shown where it was written.
    fn refused(&self, params: &Table, key: &str, why: &str) -> Mistake {
        let quoted: Vec<&str> = why.split('`').skip(1).step_by(2).collect();
        let unknown = why.starts_with("unknown field");
        let key = key.trim_start_matches('.').trim_end_matches(".?").replace("?", "");
        let deepest = match quoted.first() {
            Some(field) if unknown && key.rsplit('.').next() != Some(field) => format!("{key}.{field}"),
            _ => key.clone(),
        };
        let at = params.place(deepest.trim_start_matches('.'), unknown).unwrap_or_else(|| self.step.at.clone());
        let of = format!("step `{}` ({})", self.step.name, self.step.stage.name);
        if let (true, [wrong, known @ ..]) = (unknown || why.starts_with("unknown variant"), &quoted[..]) {
            let what = if unknown { "key" } else { "value" };
            let ports = self.step.stage.ports.iter().map(|p| p.name).filter(|p| unknown && !known.contains(p));
            let known: Vec<&str> = known.iter().copied().chain(ports).collect();
            let mistake = Mistake::new(format!("{of}: unknown {what} `{wrong}`")).at(&at, "not known here");
            return mistake.nearest(wrong, known.iter().copied()).help(format!("known here: {}", known.join(", ")));
        }
        let named = if key.is_empty() { of } else { format!("{of}: `{key}`") };
        Mistake::new(format!("{named}: {why}")).at(&at, "this is refused")
    }
}

fn example(port: &Port) -> &'static str {
    match (port.kind == File::KIND, port.arity) {
        (true, _) => "\"a-file.csv\"",
        (_, Arity::Many | Arity::Any) => "\"@STEP[*]\"",
        _ => "\"@STEP\"",
    }
}

fn makers(kind: &str) -> String {
    let names: Vec<_> = crate::registry::STAGES.iter().filter(|s| s.output == kind).map(|s| s.name).collect();
    if names.is_empty() { format!("it is a {kind}") } else { format!("{kind} is made by: {}", names.join(", ")) }
}
