//! What a study leaves for people in `out/NAME/`: the report, and every table, figure and picture as a file.
//!
//! Made from the store alone. A manifest keeps the digest of each file: when nothing changed nothing is written, and a
//! file edited by hand is put back.
use crate::execute::{Outcome, Report};
use crate::pipeline::Pipeline;
use crate::plan::{NodeId, Plan};
use crate::registry::PROGRAM;
use crate::report::{self, Point, State, Step, Study};
use crate::{figure, hdf5_table};
use hvi_kit::view::{Cell, Scalar, Table, View};
use hvi_kit::{Digest, Store};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// A step with more points than this gets one table, no folder a point.
const MOST_FOLDERS: usize = 200;

#[derive(Default, PartialEq, Serialize, Deserialize)]
struct Manifest {
    /// Digest of everything that is shown.
    study: String,
    /// Digest of each file, by its path in the folder.
    files: BTreeMap<String, Digest>,
    /// Key of each node that has a result, by its label: what `plan` compares with.
    keys: BTreeMap<String, Digest>,
}

const MANIFEST: &str = ".manifest.json";

/// Keys of the nodes' results at the last run that wrote to `folder`, by label.
pub fn last_keys(folder: &Path) -> BTreeMap<String, Digest> {
    manifest(folder).keys
}

fn manifest(folder: &Path) -> Manifest {
    let read = fs::read(folder.join(MANIFEST)).ok();
    read.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Writes the report and the files of a study to `folder`; returns the path of the report.
///
/// # Errors
/// Where a file can't be written.
pub fn write(pipeline: &Pipeline, plan: &Plan, run: &Report, store: &Store, folder: &Path) -> io::Result<PathBuf> {
    let page = folder.join("report.html");
    let old = manifest(folder);
    let study = digest(plan, run);
    let whole =
        |(name, digest): (&String, &Digest)| fs::read(folder.join(name)).is_ok_and(|b| Digest::of(&b) == *digest);
    if old.study == study && !old.files.is_empty() && old.files.iter().all(whole) {
        return Ok(page);
    }
    let mut writer = Writer { folder, files: BTreeMap::new() };
    let steps = plan.steps.iter().map(|step| {
        let points: Vec<Point> = step.nodes.clone().map(|id| point(plan, run, store, id)).collect();
        writer.step(&step.name, &points)?;
        let (name, stage, summary) = (step.name.clone(), step.stage.name.into(), step.stage.summary.into());
        Ok(Step { name, stage, summary, needs: step.needs.clone(), points })
    });
    let steps = steps.collect::<io::Result<Vec<_>>>()?;
    let study_page = Study {
        name: pipeline.name.clone(),
        question: pipeline.question.clone(),
        steps,
        seconds: run.seconds,
        command: format!("hvi-flow run {}", pipeline.path.display()),
    };
    writer.file("report.html", report::render(&study_page).as_bytes())?;
    let gone = old.files.keys().filter(|name| !writer.files.contains_key(*name));
    gone.for_each(|name| drop(fs::remove_file(folder.join(name))));
    let keys = (0..plan.nodes.len()).filter(|&id| run.outcomes[id].record().is_some());
    let keys = keys.filter_map(|id| Some((plan.label(id), run.keys[id]?))).collect();
    let manifest = Manifest { study, files: writer.files, keys };
    fs::write(folder.join(MANIFEST), serde_json::to_vec(&manifest)?)?;
    Ok(page)
}

/// Digest of what the page shows of the results, but for which of them were hits.
fn digest(plan: &Plan, run: &Report) -> String {
    let mut text = PROGRAM.to_string();
    for (id, outcome) in run.outcomes.iter().enumerate() {
        let what = match outcome {
            Outcome::Hit(r) | Outcome::Ran(r) => r.output.to_string(),
            Outcome::Failed(why) | Outcome::Skipped(why) => why.clone(),
            Outcome::Cancelled => "cancelled".into(),
        };
        text += &format!("\n{} {:?} {what}", plan.label(id), run.keys[id]);
    }
    Digest::of(text.as_bytes()).to_string()
}

fn point(plan: &Plan, run: &Report, store: &Store, id: NodeId) -> Point {
    let node = &plan.nodes[id];
    let (mut scalars, mut views, mut seconds) = (Vec::new(), Vec::new(), 0.0);
    let mut state = match &run.outcomes[id] {
        Outcome::Hit(_) => State::Hit,
        Outcome::Ran(_) => State::Ran,
        Outcome::Failed(why) => State::Failed(why.clone()),
        Outcome::Skipped(why) => State::Skipped(why.clone()),
        Outcome::Cancelled => State::Cancelled,
    };
    if let Some(record) = run.outcomes[id].record() {
        seconds = record.wall_s;
        match (node.stage.show)(record.output, store) {
            Ok(shown) => (scalars, views) = (shown.scalars, shown.views),
            Err(e) => state = State::Failed(e.to_string()),
        }
    }
    let mut params = Vec::new();
    flatten("", &node.params, &mut params);
    let key = run.keys[id].map(|k| k.to_string()).unwrap_or_default();
    Point { label: node.point.clone(), state, seconds, key, params, scalars, views, swept: node.swept.clone() }
}

fn flatten(path: &str, value: &serde_json::Value, all: &mut Vec<(String, String)>) {
    match value {
        serde_json::Value::Object(map) => {
            for (k, v) in map {
                flatten(&if path.is_empty() { k.clone() } else { format!("{path}.{k}") }, v, all);
            }
        }
        serde_json::Value::String(s) => all.push((path.into(), s.clone())),
        serde_json::Value::Null => {}
        other => all.push((path.into(), other.to_string())),
    }
}

struct Writer<'a> {
    folder: &'a Path,
    files: BTreeMap<String, Digest>,
}

impl Writer<'_> {
    fn file(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::write(&path, bytes)?;
        self.files.insert(name.into(), Digest::of(bytes));
        Ok(())
    }

    fn hdf5(&mut self, name: &str, table: &Table) -> io::Result<()> {
        let path = self.folder.join(name);
        hdf5_table::write(table, &path).map_err(|e| io::Error::other(format!("{}: {e}", path.display())))?;
        self.files.insert(name.into(), Digest::of(&fs::read(path)?));
        Ok(())
    }

    fn step(&mut self, step: &str, points: &[Point]) -> io::Result<()> {
        if let Some(table) = compare(step, points) {
            self.file(&format!("{step}.csv"), figure::csv(&table).as_bytes())?;
            self.hdf5(&format!("{step}.h5"), &table)?;
        }
        if points.len() > MOST_FOLDERS {
            return Ok(());
        }
        for point in points {
            let place =
                if point.label.is_empty() { step.to_string() } else { format!("{step}/{}", slug(&point.label)) };
            for view in &point.views {
                match view {
                    View::Table(t) => {
                        self.file(&format!("{place}/{}.csv", slug(&t.title)), figure::csv(t).as_bytes())?
                    }
                    View::Figure(f) => {
                        self.file(&format!("{place}/{}.svg", slug(&f.title)), figure::svg(f).as_bytes())?
                    }
                    View::Picture(p) => self.file(&format!("{place}/{}.png", slug(&p.title)), &figure::png(p))?,
                }
            }
        }
        Ok(())
    }
}

/// A row a point: what the sweep sets, and the scalars of the results.
fn compare(step: &str, points: &[Point]) -> Option<Table> {
    let keys: Vec<&String> = points.first()?.swept.iter().map(|(k, _)| k).collect();
    let named = points.iter().find(|p| !p.scalars.is_empty())?;
    let mut columns: Vec<(String, String)> = keys.iter().map(|k| (k.to_string(), String::new())).collect();
    columns.extend(named.scalars.iter().map(|s| (s.name.clone(), s.unit.clone())));
    let row = |p: &Point| {
        let swept = keys
            .iter()
            .map(|k| p.swept.iter().find(|(name, _)| name == *k).map_or(Cell::Empty, |(_, v)| v.clone().into()));
        let value =
            |s: &Scalar| p.scalars.iter().find(|own| own.name == s.name).map_or(Cell::Empty, |own| own.value.clone());
        swept.chain(named.scalars.iter().map(value)).collect()
    };
    Some(Table { title: step.into(), columns, rows: points.iter().map(row).collect(), note: String::new() })
}

/// A file name that any system takes: letters, digits, `.`, `-` and `_`.
fn slug(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '=' | '_') { c } else { '-' };
    let slug: String = text.replace('µ', "u").chars().map(plain).collect();
    let parts: Vec<&str> = slug.split('-').filter(|p| !p.is_empty()).collect();
    let joined = parts.join("-");
    let trimmed = joined.trim_start_matches('.');
    if trimmed.is_empty() { "result".into() } else { trimmed.chars().take(120).collect() }
}
