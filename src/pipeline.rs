//! A pipeline file as written: TOML -> steps with their sweeps, `include`, `--set` and `[material.NAME]` applied.
use crate::amount;
use crate::choose::Choice;
use crate::mistake::{At, Mistake, Source};
use crate::named_file;
use crate::region::Region;
use crate::registry;
use crate::sweep::{self, Point};
use crate::value::{self, Key, Node, Table, Value};
use hvi_kit::{Digest, StageDef};
use std::cell::Cell;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

mod cluster;
pub use cluster::Profile;

/// A pipeline: what to run, before references are resolved.
pub struct Pipeline {
    /// File it was read from.
    pub path: PathBuf,
    /// Name of the study: the file's stem.
    pub name: String,
    /// The comment lines that open the file: question, sources, expected time.
    pub question: String,
    /// Steps in the order written, included ones first.
    pub steps: Vec<Step>,
    /// Resources; they never enter a key.
    pub settings: Settings,
    /// What was written to no effect, one sentence each.
    pub remarks: Vec<String>,
    /// The tables `[tradeoff.NAME]`, as written: see [`crate::tradeoff`].
    pub tradeoff: Table,
    /// The tables `[choose.NAME]`, as written: see [`crate::choose`].
    pub choose: Table,
    /// What came of them, once they are settled.
    pub chosen: Vec<Choice>,
    /// What came of `region = "auto"`, once it is settled: see [`crate::region`].
    pub regions: Vec<Region>,
    /// The files it was read from, included ones too, with the digests of their bytes.
    pub files: Vec<(PathBuf, Digest)>,
}

/// `[run]`.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Threads at work at once.
    pub jobs: Option<usize>,
    /// Memory that nodes at work may ask for together [B].
    pub memory: Option<u64>,
    /// The longest that one node may take.
    pub timeout: Option<Duration>,
    /// How often to try again what failed for a reason that may pass.
    pub retry: Option<u32>,
    /// Where nodes are computed.
    pub executor: Option<Executor>,
    /// What jobs ask of a cluster.
    pub slurm: Profile,
}

/// Where nodes are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Executor {
    /// On this machine
    Local,
    /// As jobs of the Slurm cluster that this machine belongs to
    Slurm,
}

/// What a step says of how its nodes are run; before what the command line and `[run]` say. It never enters a key.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Care {
    /// The longest that one node may take.
    pub timeout: Option<Duration>,
    /// How often to try again what failed for a reason that may pass.
    pub retry: Option<u32>,
}

/// One `[step.NAME]`.
pub struct Step {
    /// Its name.
    pub name: String,
    /// Where the name is written.
    pub at: At,
    /// Folder that its relative file names start from.
    pub folder: PathBuf,
    /// What it uses.
    pub stage: &'static StageDef,
    /// How its nodes are run.
    pub care: Care,
    /// Its other keys but `use` and the sweep.
    pub params: Table,
    /// Its points; one empty one without a sweep.
    pub points: Vec<Point>,
    /// Where it says `region = "auto"`, if it does.
    pub region: Option<At>,
}

/// Files that include files that include files.
const DEEPEST: usize = 16;

/// Reads a pipeline file, with `--set step.key=value` applied.
///
/// # Errors
/// [`Mistake`] with the file, the line and the text marked.
pub fn read(path: &Path, settings: &[String]) -> Result<Pipeline, Mistake> {
    let mut raw = Raw::default();
    raw.read(path, None, 0)?;
    for setting in settings {
        raw.set(setting)?;
    }
    let mut steps = Vec::new();
    for step in std::mem::take(&mut raw.steps) {
        let step = raw.step(step, &steps)?;
        steps.push(step);
    }
    let unused = raw.materials.iter().filter(|m| m.depth == 0 && !m.is_used.get());
    let remarks = unused.map(|m| format!("{name}: no step uses [material.{}]", m.key.text, name = path.display()));
    let remarks = remarks.collect();
    if steps.is_empty() {
        return Err(Mistake::new(format!("{} has no [step.NAME]: there is nothing to run", path.display())));
    }
    let name = name(path);
    if name.starts_with('.') {
        let title = format!("{} gives the study the name `{name}`, which is no name for a folder", path.display());
        return Err(Mistake::new(title).help("call the file something that doesn't begin with a dot"));
    }
    let (question, settings, tradeoff, choose) = (raw.question, raw.settings, raw.tradeoff, raw.choose);
    let (chosen, regions, files) = (Vec::new(), Vec::new(), raw.files);
    Ok(Pipeline {
        path: path.into(),
        name,
        question,
        steps,
        settings,
        remarks,
        tradeoff,
        choose,
        chosen,
        regions,
        files,
    })
}

/// Name of the study in the file at `path`: the file's stem.
pub fn name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "study".into(), |s| s.to_string_lossy().into_owned())
}

#[derive(Default)]
struct Raw {
    steps: Vec<RawStep>,
    materials: Vec<Material>,
    settings: Settings,
    question: String,
    /// Files that were read to their end: one that several others include counts once.
    read: Vec<PathBuf>,
    files: Vec<(PathBuf, Digest)>,
    tradeoff: Table,
    choose: Table,
}

/// A `[material.NAME]`.
struct Material {
    key: Key,
    table: Value,
    /// 0 in the file that was named, more in those it includes.
    depth: usize,
    is_used: Cell<bool>,
}

struct RawStep {
    key: Key,
    folder: PathBuf,
    table: Table,
}

impl Raw {
    fn read(&mut self, path: &Path, named: Option<&At>, depth: usize) -> Result<(), Mistake> {
        let name = path.display().to_string();
        let text = named_file::read_text(path).map_err(|e| {
            let mistake = Mistake::new(format!("can't read {name}: {e}"));
            named.map_or(Mistake::new(format!("can't read {name}: {e}")), |at| mistake.at(at, "named here"))
        })?;
        if depth == 0 {
            let comment = text.lines().take_while(|l| l.starts_with('#')).map(|l| l.trim_start_matches(['#', ' ']));
            self.question = comment.collect::<Vec<_>>().join("\n");
        }
        self.files.push((path.into(), Digest::of(text.as_bytes())));
        let own = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if self.read.contains(&own) {
            return Ok(());
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let source = Arc::new(Source { name, text });
        for (key, value) in value::parse(&source)?.0 {
            match key.text.as_str() {
                "include" => self.include(&value, &folder, depth)?,
                "step" => {
                    for (key, value) in value.table("[step.NAME]")?.0.iter().cloned() {
                        self.add_step(key, value, &folder)?;
                    }
                }
                "material" => {
                    for (key, value) in value.table("[material.NAME]")?.0.iter().cloned() {
                        self.add_material(key, value, depth)?;
                    }
                }
                "run" => self.run(value.table("[run]")?)?,
                "tradeoff" => self.tradeoff.0.extend(value.table("[tradeoff.NAME]")?.0.iter().cloned()),
                "choose" => self.choose.0.extend(value.table("[choose.NAME]")?.0.iter().cloned()),
                other => {
                    let mistake = Mistake::new(format!("unknown table or key `{other}`")).at(&key.at, "not known here");
                    return Err(mistake.nearest(other, ["step", "include", "material", "run", "tradeoff", "choose"]));
                }
            }
        }
        self.read.push(own);
        Ok(())
    }

    fn include(&mut self, value: &Value, folder: &Path, depth: usize) -> Result<(), Mistake> {
        let Node::List(items) = &value.node else {
            return Err(
                Mistake::new("expected a list of files: include = [\"common.toml\"]").at(&value.at, value.kind())
            );
        };
        if depth == DEEPEST {
            return Err(Mistake::new("files include each other without end").at(&value.at, "here"));
        }
        items.iter().try_for_each(|v| self.read(&folder.join(v.text("a file name")?), Some(&v.at), depth + 1))
    }

    fn add_step(&mut self, key: Key, value: Value, folder: &Path) -> Result<(), Mistake> {
        key.plain("a step")?;
        if self.steps.iter().any(|s| s.key.text == key.text) {
            return Err(Mistake::new(format!("step `{}` is there already", key.text)).at(&key.at, "the second one"));
        }
        let table = value.table("a table: [step.NAME]")?.clone();
        self.steps.push(RawStep { key, folder: folder.into(), table });
        Ok(())
    }

    fn add_material(&mut self, key: Key, value: Value, depth: usize) -> Result<(), Mistake> {
        if self.materials.iter().any(|m| m.key.text == key.text) {
            let title = format!("material `{}` is there already", key.text);
            return Err(Mistake::new(title).at(&key.at, "the second one"));
        }
        value.table("a table: [material.NAME]")?;
        self.materials.push(Material { key, table: value, depth, is_used: Cell::new(false) });
        Ok(())
    }

    fn run(&mut self, table: &Table) -> Result<(), Mistake> {
        for (key, value) in &table.0 {
            match (key.text.as_str(), &value.node) {
                ("jobs", _) => self.settings.jobs = Some(whole("jobs", value, 1..=4096)? as usize),
                ("executor", _) => self.settings.executor = Some(executor(value)?),
                ("slurm", _) => self.settings.slurm.read(value.table("[run.slurm]")?)?,
                ("memory", _) => self.settings.memory = Some(amount(value, "a size: memory = \"8 GB\"", amount::size)?),
                ("timeout", _) => self.settings.timeout = Some(amount(value, TIMEOUT, amount::time)?),
                ("retry", _) => self.settings.retry = Some(whole("retry", value, 0..=100)? as u32),
                (other, _) => {
                    let mistake = Mistake::new(format!("unknown key `{other}` in [run]")).at(&key.at, "not known here");
                    return Err(mistake.nearest(other, ["jobs", "memory", "timeout", "retry", "executor", "slurm"]));
                }
            }
        }
        Ok(())
    }

    /// Applies `--set step.key=value`; the value is TOML, or else taken as text.
    fn set(&mut self, setting: &str) -> Result<(), Mistake> {
        let wrong = |why: String| Mistake::new(format!("--set {setting}: {why}")).help("write --set STEP.KEY=VALUE");
        let (path, text) = setting.split_once('=').ok_or_else(|| wrong("it has no `=`".into()))?;
        let (step, key) = path.trim().split_once('.').ok_or_else(|| wrong("it names no key of a step".into()))?;
        let toml = format!("value = {}", text.trim());
        let source = |text| Arc::new(Source { name: "--set".into(), text });
        let mut table = value::parse(&source(toml))
            .or_else(|_| value::parse(&source(format!("value = {:?}", text.trim()))))
            .map_err(|_| wrong("its value can't be read".into()))?;
        let (_, value) = table.take("value").ok_or_else(|| wrong("it has no value".into()))?;
        let names: Vec<_> = self.steps.iter().map(|s| s.key.text.clone()).collect();
        let Some(raw) = self.steps.iter_mut().find(|s| s.key.text == step) else {
            return Err(wrong(format!("there is no step `{step}`")).nearest(step, names.iter().map(String::as_str)));
        };
        if key.split('.').count() > DEEPEST {
            return Err(wrong("its key has too many parts".into()));
        }
        let key = |text: &str| Key { text: text.into(), at: value.at.clone() };
        for axes in ["sweep", "zip"] {
            // The keys of an axis are literal: `sweep.projectile.diameter` is the key `projectile.diameter` of `sweep`.
            if let Some(inner) = path_below(setting, step, axes)
                && let Some(Value { node: Node::Table(table), .. }) = raw.table.get_mut(axes)
            {
                table.replace(key(inner), value.clone());
                return Ok(());
            }
        }
        if let Some(axes) = swept_in(&raw.table, path_key(setting)) {
            let mistake = wrong(format!("`{}` is set by `{axes}`", path_key(setting)));
            return Err(match axes {
                "points" => mistake.help(format!("set {step}.points=[...] instead")),
                _ => mistake.help(format!("set {step}.{axes}.{}=[...] instead", path_key(setting))),
            });
        }
        raw.table.set(&key(path_key(setting)), value.clone())
    }

    fn step(&self, mut raw: RawStep, above: &[Step]) -> Result<Step, Mistake> {
        let name = raw.key.text;
        let Some((_, stage)) = raw.table.take("use") else {
            let mistake = Mistake::new(format!("step `{name}` doesn't say which stage it uses"));
            return Err(mistake
                .at(&raw.key.at, "add use = \"STAGE\"")
                .help(format!("stages: {}", stage_names().join(", "))));
        };
        let wanted = stage.text("the name of a stage")?;
        let Some(def) = registry::stage(wanted) else {
            let mistake = Mistake::new(format!("unknown stage `{wanted}`")).at(&stage.at, "no such stage");
            return Err(mistake.nearest(wanted, stage_names()));
        };
        let care = Care {
            timeout: raw.table.take("timeout").map(|(_, v)| amount(&v, TIMEOUT, amount::time)).transpose()?,
            retry: raw.table.take("retry").map(|(_, v)| whole("retry", &v, 0..=100)).transpose()?.map(|n| n as u32),
        };
        let region = raw.table.take("region").map(|(_, v)| region(&v)).transpose()?;
        let points_of = |name: &str| above.iter().find(|s| s.name == name).map(|s| &s.points[..]);
        let points = sweep::expand(&mut raw.table, &points_of)?;
        let substitute = |mut v: Value| {
            self.materials(&mut v);
            v
        };
        let params =
            Table(raw.table.0.into_iter().map(|(k, v)| (k.clone(), self.material(&k, substitute(v)))).collect());
        let points = points
            .into_iter()
            .map(|p| p.into_iter().map(|(k, v)| (k.clone(), self.material(&k, substitute(v)))).collect());
        let points = points.collect();
        Ok(Step { name, at: raw.key.at, folder: raw.folder, stage: def, care, params, points, region })
    }

    /// Where a key `material` names a `[material.NAME]`, puts that table in its place.
    fn materials(&self, value: &mut Value) {
        match &mut value.node {
            Node::Table(t) => {
                for (k, v) in &mut t.0 {
                    self.materials(v);
                    *v = self.material(k, v.clone());
                }
            }
            Node::List(items) => items.iter_mut().for_each(|v| self.materials(v)),
            _ => {}
        }
    }

    fn material(&self, key: &Key, value: Value) -> Value {
        let is_material = key.text.rsplit('.').next() == Some("material");
        let named = match &value.node {
            Node::Text(name) if is_material => self.materials.iter().find(|m| m.key.text == *name),
            _ => None,
        };
        let Some(Material { key: name, table, is_used, .. }) = named else { return value };
        is_used.set(true);
        let mut table = table.clone();
        if let Node::Table(t) = &mut table.node
            && t.get("name").is_none()
        {
            let text = Value { node: Node::Text(name.text.clone()), at: name.at.clone() };
            t.0.push((Key { text: "name".into(), at: name.at.clone() }, text));
        }
        table
    }
}

/// A setting of `[run]` that is a text with a unit.
fn amount<T>(value: &Value, expected: &str, read: fn(&str) -> Result<T, String>) -> Result<T, Mistake> {
    let text = value.text(expected)?;
    read(text).map_err(|why| Mistake::new(format!("`{text}`: {why}")).at(&value.at, "here"))
}

const TIMEOUT: &str = "a time: timeout = \"10 min\"";

/// A whole number within its limits.
fn whole(key: &str, value: &Value, range: RangeInclusive<i64>) -> Result<i64, Mistake> {
    match value.node {
        Node::Integer(n) if range.contains(&n) => Ok(n),
        _ => {
            let title = format!("`{key}` is a whole number, {} to {}", range.start(), range.end());
            Err(Mistake::new(title).at(&value.at, "here"))
        }
    }
}

/// `region = "auto"`.
fn region(value: &Value) -> Result<At, Mistake> {
    match value.text("\"auto\"")? {
        "auto" => Ok(value.at.clone()),
        other => {
            let mistake = Mistake::new(format!("unknown region `{other}`")).at(&value.at, "not known here");
            Err(mistake.help("write region = \"auto\", or leave it out for the whole sweep"))
        }
    }
}

fn executor(value: &Value) -> Result<Executor, Mistake> {
    match value.text("\"local\" or \"slurm\"")? {
        "local" => Ok(Executor::Local),
        "slurm" => Ok(Executor::Slurm),
        other => {
            let mistake = Mistake::new(format!("unknown executor `{other}`")).at(&value.at, "not known here");
            Err(mistake.nearest(other, ["local", "slurm"]))
        }
    }
}

/// `KEY` of `STEP.KEY=VALUE`.
fn path_key(setting: &str) -> &str {
    let path = setting.split('=').next().unwrap_or(setting).trim();
    path.split_once('.').map_or("", |(_, key)| key)
}

/// `INNER` of `STEP.AXES.INNER=VALUE`.
fn path_below<'a>(setting: &'a str, step: &str, axes: &str) -> Option<&'a str> {
    setting
        .trim_start()
        .strip_prefix(step)?
        .strip_prefix('.')?
        .strip_prefix(axes)?
        .strip_prefix('.')?
        .split('=')
        .next()
        .map(str::trim)
}

/// Which of `sweep`, `zip` and `points` sets `key`, if one does.
fn swept_in(step: &Table, key: &str) -> Option<&'static str> {
    let has = |v: &Value| matches!(&v.node, Node::Table(t) if t.get(key).is_some());
    ["sweep", "zip", "points"].into_iter().find(|axes| match step.get(axes) {
        Some(Value { node: Node::List(points), .. }) => points.iter().any(has),
        Some(value) => has(value),
        None => false,
    })
}

fn stage_names() -> Vec<&'static str> {
    registry::STAGES.iter().map(|s| s.name).collect()
}
