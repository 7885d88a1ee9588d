//! Pipeline -> Plan: one node a point, references resolved, ports matched, parameters checked, in an order that works.
//!
//! Complete before the first stage runs: what can be known to be wrong without computing is found here.
use crate::mistake::{At, Mistake};
use crate::pipeline::{Care, Pipeline, Step};
use crate::reference::{self, Reference, Selection, Selector};
use crate::sweep;
use crate::value::{Key, Node as Written, Table, Value};
use hvi_kit::engine::Engine;
use hvi_kit::{Arity, Artifact, Checked, Digest, File, Port, StageDef};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Index of a node in [`Plan::nodes`].
pub type NodeId = usize;

/// What fills a port.
#[derive(Clone, Debug)]
pub enum Input {
    /// The result of a node.
    One(NodeId),
    /// The results of some nodes, in the order of their sweeps.
    Many(Arc<[NodeId]>),
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
    /// How its nodes are run.
    pub care: Care,
}

/// What to run.
#[derive(Default)]
pub struct Plan {
    /// Steps in an order in which each comes after those it needs.
    pub steps: Vec<PlannedStep>,
    /// Nodes, step after step.
    pub nodes: Vec<Node>,
    /// Contents of the files named as inputs, encoded as artifacts.
    pub files: BTreeMap<Digest, Vec<u8>>,
    /// Where these contents were read, with the digests of the bytes as they lie there.
    pub read: Vec<(PathBuf, Digest)>,
    /// Versions of the programs outside that some node calls.
    pub engines: BTreeMap<&'static str, String>,
}

impl Plan {
    /// `states[volume_ratio=0.9, temperature=300 K]`.
    pub fn label(&self, id: NodeId) -> String {
        let node = &self.nodes[id];
        let name = &self.steps[node.step].name;
        if node.point.is_empty() { name.clone() } else { [name, "[", &node.point, "]"].concat() }
    }
    /// Ids of the nodes that `id` needs, one that is named twice twice.
    pub fn needs(&self, id: NodeId) -> impl Iterator<Item = NodeId> {
        self.nodes[id].inputs.values().flat_map(|input| match input {
            Input::One(n) => std::slice::from_ref(n).iter().copied(),
            Input::Many(ns) => ns.iter().copied(),
            Input::File(_) => [].iter().copied(),
        })
    }
}

/// Makes the plan of a pipeline; with `only`, of these steps and what they need.
///
/// # Errors
/// The first [`Mistake`]: unknown names, cycles, ports that don't fit, parameters that are refused, files that can't be read.
pub fn plan(pipeline: &Pipeline, only: &[String]) -> Result<Plan, Mistake> {
    let names: Names = pipeline.steps.iter().enumerate().map(|(i, s)| (s.name.as_str(), i)).collect();
    let order = order(pipeline, &names, &wanted(&names, pipeline, only)?)?;
    let mut plan = Plan::default();
    let (mut placed, mut read) = (vec![None; pipeline.steps.len()], HashMap::new());
    let mut selector = Selector::default();
    for i in order {
        let step = &pipeline.steps[i];
        let first = plan.nodes.len();
        plan.nodes.reserve(step.points.len());
        let around = Around { pipeline, names: &names, placed: &placed };
        let mut builder =
            Builder { around, step, plan: &mut plan, read: &mut read, selector: &mut selector, pattern: None };
        for point in &step.points {
            let node = builder.node(point)?;
            builder.plan.nodes.push(node);
        }
        placed[i] = Some(plan.steps.len());
        let nodes = first..plan.nodes.len();
        let needs = needed_steps(&plan, nodes.clone());
        plan.steps.push(PlannedStep { name: step.name.clone(), stage: step.stage, nodes, needs, care: step.care });
    }
    Ok(plan)
}

/// Places of the steps in the pipeline, by name.
type Names<'a> = HashMap<&'a str, usize>;

/// Names of the steps that `nodes` need, in the order in which they are first named.
fn needed_steps(plan: &Plan, nodes: std::ops::Range<NodeId>) -> Vec<String> {
    let mut seen = vec![false; plan.steps.len()];
    let mut names = Vec::new();
    for need in nodes.flat_map(|id| plan.needs(id)) {
        let step = plan.nodes[need].step;
        if !std::mem::replace(&mut seen[step], true) {
            names.push(plan.steps[step].name.clone());
        }
    }
    names
}

fn wanted(names: &Names<'_>, pipeline: &Pipeline, only: &[String]) -> Result<Vec<usize>, Mistake> {
    if only.is_empty() {
        return Ok((0..pipeline.steps.len()).collect());
    }
    let find = |name: &String| {
        names.get(name.as_str()).copied().ok_or_else(|| {
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
pub fn references(value: &Value, found: &mut Vec<(String, At)>) {
    match &value.node {
        Written::Text(s) if s.starts_with('@') => found.push((s.clone(), value.at.clone())),
        Written::List(items) => items.iter().for_each(|v| references(v, found)),
        Written::Table(t) => t.0.iter().for_each(|(_, v)| references(v, found)),
        _ => {}
    }
}

fn find_step(pipeline: &Pipeline, names: &Names<'_>, name: &str, at: &At) -> Result<usize, Mistake> {
    names.get(name).copied().ok_or_else(|| {
        let mistake = Mistake::new(format!("unknown step `{name}`")).at(at, "no step has this name");
        mistake.nearest(name, pipeline.steps.iter().map(|s| s.name.as_str()))
    })
}

/// Steps in an order in which each comes after those it needs: depth first from each wanted step.
fn order(pipeline: &Pipeline, names: &Names<'_>, wanted: &[usize]) -> Result<Vec<usize>, Mistake> {
    let mut needs: Vec<Vec<(usize, At)>> = Vec::new();
    for step in &pipeline.steps {
        let mut found = Vec::new();
        let values = step.params.0.iter().chain(step.points.iter().flatten());
        values.for_each(|(_, v)| references(v, &mut found));
        let mut of_step: Vec<(usize, At)> = Vec::new();
        for (text, at) in found {
            let i = find_step(pipeline, names, reference(&text, &at)?.step, &at)?;
            if !of_step.iter().any(|(j, _)| *j == i) {
                of_step.push((i, at));
            }
        }
        needs.push(of_step);
    }
    let (mut done, mut on_path, mut order) = (vec![false; needs.len()], vec![false; needs.len()], Vec::new());
    for &start in wanted {
        let mut path: Vec<(usize, usize)> = if done[start] { vec![] } else { vec![(start, 0)] };
        on_path[start] = true;
        while let Some((step, next)) = path.pop() {
            let Some((need, at)) = needs[step].get(next) else {
                (done[step], on_path[step]) = (true, false);
                order.push(step);
                continue;
            };
            path.push((step, next + 1));
            if on_path[*need] {
                let from = path.iter().position(|(s, _)| s == need).unwrap_or(0);
                let names: Vec<_> = path[from..].iter().map(|(s, _)| pipeline.steps[*s].name.as_str()).collect();
                let title = format!("the steps need each other in a circle: {} -> {}", names.join(" -> "), names[0]);
                return Err(Mistake::new(title).at(at, "this closes the circle"));
            }
            if !done[*need] {
                on_path[*need] = true;
                path.push((*need, 0));
            }
        }
        on_path[start] = false;
    }
    Ok(order)
}

/// The pipeline, and where its steps stand in the plan.
#[derive(Clone, Copy)]
struct Around<'a> {
    pipeline: &'a Pipeline,
    names: &'a Names<'a>,
    placed: &'a [Option<usize>],
}

/// Makes the nodes of one step.
struct Builder<'a> {
    around: Around<'a>,
    step: &'a Step,
    plan: &'a mut Plan,
    /// Digests of the files that were read, by path: one file in many points is read once.
    read: &'a mut HashMap<PathBuf, Digest>,
    selector: &'a mut Selector,
    pattern: Option<Pattern>,
}

/// A node of a sweep whose points differ in plain values at the same keys: only these are put in for the next one.
struct Pattern {
    keys: Vec<String>,
    written: serde_json::Value,
    inputs: BTreeMap<String, Input>,
    files: BTreeMap<String, File>,
}

impl Pattern {
    /// Puts a point's values in; whether they fit.
    fn fill(&mut self, point: &sweep::Point) -> bool {
        if self.keys.len() != point.len() {
            return false;
        }
        self.keys.iter().zip(point).all(|(key, (k, value))| {
            let place = key.split('.').try_fold(&mut self.written, |table, part| table.get_mut(part));
            match place {
                Some(place) if *key == k.text && is_plain(value) => {
                    *place = value.json();
                    true
                }
                _ => false,
            }
        })
    }
}

/// Whether a value is one value, and names no result.
fn is_plain(value: &Value) -> bool {
    match &value.node {
        Written::Text(text) => !text.starts_with('@'),
        Written::List(_) | Written::Table(_) => false,
        Written::Bool(_) | Written::Integer(_) | Written::Float(_) => true,
    }
}

impl Builder<'_> {
    fn node(&mut self, point: &sweep::Point) -> Result<Node, Mistake> {
        if let Some(pattern) = self.pattern.as_mut().filter(|_| point.iter().all(|(_, v)| is_plain(v)))
            && pattern.fill(point)
            && let Ok(checked) = (self.step.stage.check)(&pattern.written, &pattern.files)
        {
            let inputs = pattern.inputs.clone();
            return self.checked(point, checked, inputs);
        }
        self.whole_node(point)
    }

    /// A node from all that is written, with a mistake shown at its place.
    fn whole_node(&mut self, point: &sweep::Point) -> Result<Node, Mistake> {
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
        let written = Value { node: Written::Table(plain), at: self.step.at.clone() }.json();
        let files = self.files(&inputs);
        let checked = (stage.check)(&written, &files).map_err(|e| self.refused(&params, &e.key, &e.why))?;
        let is_value = |(key, value): &(Key, Value)| is_plain(value) && self.port(&key.text, value).is_none();
        if self.step.points.len() > 1 && point.iter().all(is_value) {
            let keys = point.iter().map(|(k, _)| k.text.clone()).collect();
            self.pattern = Some(Pattern { keys, written, inputs: inputs.clone(), files });
        }
        self.checked(point, checked, inputs)
    }

    fn checked(
        &mut self,
        point: &sweep::Point,
        checked: Checked,
        inputs: BTreeMap<String, Input>,
    ) -> Result<Node, Mistake> {
        let Checked { params, cost, engine } = checked;
        let engine = engine.map(|engine| self.version(engine)).transpose()?;
        let swept = point.iter().map(|(k, v)| (k.text.clone(), v.label())).collect();
        let (step, stage) = (self.plan.steps.len(), self.step.stage);
        Ok(Node { step, point: sweep::label(point), swept, stage, params, inputs, engine, cost })
    }

    /// The port that takes the value at the dotted key `path`.
    fn port(&self, path: &str, value: &Value) -> Option<&'static Port> {
        let last = path.rsplit('.').next().unwrap_or(path);
        self.step.stage.ports.iter().find(|p| match p.arity {
            // A table in such a place is a value: a material that brings its own.
            Arity::Places => p.name == last && !matches!(value.node, Written::Table(_)),
            _ => p.name == path,
        })
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
            let port = self.port(&path, &value);
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
            return Ok(Input::Many(nodes.into()));
        }
        match nodes[..] {
            [one] => Ok(Input::One(one)),
            _ => {
                let title = format!("`{}` takes one result, this names {}", key.text, nodes.len());
                Err(Mistake::new(title).at(&value.at, "here").help("select one: \"@STEP[key=value]\""))
            }
        }
    }

    fn resolve(&mut self, port: &Port, text: &str, at: &At) -> Result<Vec<NodeId>, Mistake> {
        let reference = reference(text, at)?;
        let Around { pipeline, names, placed } = self.around;
        let i = find_step(pipeline, names, reference.step, at)?;
        let step = &pipeline.steps[i];
        if step.stage.output != port.kind {
            let title = format!("`{}` takes {}, but `{}` makes {}", port.name, port.kind, step.name, step.stage.output);
            return Err(Mistake::new(title).at(at, "does not fit").help(makers(port.kind)));
        }
        let planned = placed[i].expect("planned before: the order says so");
        let all = self.plan.steps[planned].nodes.clone();
        match reference.selection {
            Selection::None if all.len() == 1 || matches!(port.arity, Arity::Many | Arity::Any) => Ok(all.collect()),
            Selection::None => {
                let title = format!("`{}` has {} points, `{}` takes one", step.name, all.len(), port.name);
                Err(Mistake::new(title).at(at, "which one?").help(format!("select one: \"@{}[key=value]\"", step.name)))
            }
            Selection::All => Ok(all.collect()),
            Selection::Where(pairs) => self.selector.select(self.plan, planned, &pairs).map_err(|m| m.at(at, "here")),
        }
    }

    fn file(&mut self, value: &Value) -> Result<Input, Mistake> {
        let name = value.text("a file name")?;
        let path = self.step.folder.join(Path::new(name));
        if let Some(digest) = self.read.get(&path) {
            return Ok(Input::File(*digest));
        }
        let bytes = crate::named_file::read(&path)
            .map_err(|e| Mistake::new(format!("can't read {}: {e}", path.display())).at(&value.at, "named here"))?;
        self.plan.read.push((path.clone(), Digest::of(&bytes)));
        let encoded = File(bytes).encode();
        let digest = Digest::of(&encoded);
        self.plan.files.insert(digest, encoded);
        self.read.insert(path, digest);
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
