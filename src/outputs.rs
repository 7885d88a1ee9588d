//! What a study leaves for people in `out/NAME/`: the report, and every table, figure and picture as a file.
//!
//! Made from the store alone. A manifest keeps the digest of each file: when nothing changed nothing is written, and a
//! file edited by hand is put back. A file whose size, times and inode are those that were noted is not read again,
//! unless it was written so shortly before it was noted that its clock may not have ticked since.
use crate::choose::Choice;
use crate::execute::{Outcome, Report};
use crate::mistake::Mistake;
use crate::pipeline::Pipeline;
use crate::plan::{Plan, PlannedStep};
use crate::region::Region;
use crate::registry::PROGRAM;
use crate::report::{self, Point, Step, Study};
use crate::{extended_xyz, figure, hdf5_table, vtkhdf};
use hvi_kit::view::{Cell, Scalar, Table, View};
use hvi_kit::{Digest, Store, units};
use serde::{Deserialize, Serialize};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};
use std::{fs, io};

mod brief;
mod points;
pub mod sealed;
use brief::Briefs;
use points::Reader;
pub use points::point;

/// A step with more points than this gets one table, no folder a point.
const MOST_FOLDERS: usize = 200;

/// Longer names of points are cut, and told apart by their keys.
const LONGEST_NAME: usize = 100;

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Manifest {
    /// The pipeline whose results these are.
    pipeline: PathBuf,
    /// Digest of everything that is shown.
    study: String,
    /// Each file, by its path in the folder.
    files: BTreeMap<String, Seen>,
    /// When all files were last found to be whole [ns since 1970].
    at: i64,
}

const MANIFEST: &str = ".manifest.json";

/// The report.
const PAGE: &str = "report.html";

/// Beside the manifest, because only comparisons read it: the key of each node that has a result, by its label.
const KEYS: &str = ".keys";

/// Keys of the nodes' results at the last runs that wrote to `folder`, by label.
pub fn last_keys(folder: &Path) -> BTreeMap<String, Digest> {
    let read = fs::read(folder.join(KEYS)).ok();
    let keys: BTreeMap<String, [u8; 32]> = read.and_then(|b| postcard::from_bytes(&b).ok()).unwrap_or_default();
    keys.into_iter().map(|(label, key)| (label, Digest::from_bytes(key))).collect()
}

/// Keeps the keys of a run's results; those of nodes that it did not come to stay.
fn publish_keys(folder: &Path, pipeline: &Pipeline, plan: &Plan, run: &Report) -> io::Result<()> {
    let has_all = plan.steps.len() == pipeline.steps.len() && run.outcomes.iter().all(|o| o.entry().is_some());
    let known = (0..plan.nodes.len()).filter(|&id| run.outcomes[id].entry().is_some());
    let mut keys: Vec<(String, [u8; 32])> =
        known.filter_map(|id| Some((plan.label(id), *run.keys[id]?.bytes()))).collect();
    if !has_all {
        let older = last_keys(folder).into_iter().map(|(label, key)| (label, *key.bytes()));
        let own: HashSet<&str> = keys.iter().map(|(label, _)| label.as_str()).collect();
        let older: Vec<_> = older.filter(|(label, _)| !own.contains(label.as_str())).collect();
        keys.extend(older);
    }
    publish(&folder.join(KEYS), &postcard::to_stdvec(&keys).map_err(io::Error::other)?)
}

/// A file as it was when it was last read or written.
#[derive(Clone, Serialize, Deserialize)]
struct Seen {
    digest: Digest,
    /// Size [B], times of the last change of content and of the file [ns since 1970], inode.
    mark: (u64, i64, i64, u64),
}

/// Changes that follow each other faster may bear the same time [ns].
const TICK: i64 = 1_000_000_000;

fn mark(path: &Path) -> io::Result<(u64, i64, i64, u64)> {
    let meta = fs::metadata(path)?;
    let time = |s: i64, ns: i64| s.wrapping_mul(1_000_000_000).wrapping_add(ns);
    Ok((meta.len(), time(meta.mtime(), meta.mtime_nsec()), time(meta.ctime(), meta.ctime_nsec()), meta.ino()))
}

fn now() -> i64 {
    let since = std::time::UNIX_EPOCH.elapsed().unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

impl Manifest {
    fn read(folder: &Path) -> Manifest {
        let read = fs::read(folder.join(MANIFEST)).ok();
        let mut found: Manifest = read.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        // Its files may be removed: a name that was edited to lead elsewhere is none of ours.
        let is_inside = |name: &str| Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        found.files.retain(|name, _| is_inside(name));
        found
    }

    fn publish(&self, folder: &Path) -> io::Result<()> {
        publish(&folder.join(MANIFEST), &serde_json::to_vec(self)?)
    }

    /// Whether every file is as it was left; notes those that had to be read for it.
    fn is_whole(&mut self, folder: &Path) -> bool {
        let (settled, at) = (self.at - TICK, now());
        let mut read = false;
        for (name, seen) in &mut self.files {
            let path = folder.join(name);
            let Ok(found) = mark(&path) else { return false };
            if found == seen.mark && found.1.max(found.2) < settled {
                continue;
            }
            if !fs::read(&path).is_ok_and(|bytes| Digest::of(&bytes) == seen.digest) {
                return false;
            }
            (seen.mark, read) = (found, true);
        }
        if read {
            self.at = at;
            // Where it can't be written the files are read again next time.
            let _ = self.publish(folder);
        }
        true
    }
}

/// Checks that `folder` doesn't hold the results of another pipeline of the same name, nor somebody else's report.
///
/// # Errors
/// [`Mistake`] where it does, and that pipeline is still there.
pub fn claim(pipeline: &Pipeline, folder: &Path) -> Result<(), Mistake> {
    let (manifest, page) = (Manifest::read(folder), folder.join(PAGE));
    // One that is known was edited, and is put back.
    if !manifest.files.contains_key(PAGE) && fs::symlink_metadata(&page).is_ok() && !report::is_ours(&page) {
        let title = format!("{} was not made by hvi-flow, and is not overwritten", page.display());
        return Err(Mistake::new(title).help("move it away, or give another folder with --out"));
    }
    let (owner, own) = (manifest.pipeline, full(&pipeline.path));
    if owner.as_os_str().is_empty() || owner == own || !owner.exists() {
        return Ok(());
    }
    let title = format!("{} holds the results of {}", folder.display(), owner.display());
    Err(Mistake::new(title).help("give one of the two another name, or another folder with --out"))
}

/// Where a file lies, links resolved.
pub fn full(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// Path of the report in `folder`.
pub fn page(folder: &Path) -> PathBuf {
    folder.join(PAGE)
}

/// Whether `folder` holds what a run wrote whose [`Written::study`] was this, whole.
pub fn stand(folder: &Path, study: &str) -> bool {
    let mut manifest = Manifest::read(folder);
    manifest.study == study && !manifest.files.is_empty() && manifest.is_whole(folder)
}

/// What was written.
pub struct Written {
    /// Path of the report.
    pub page: PathBuf,
    /// Digest of everything that is shown.
    pub study: String,
    /// Results that the store has but that can't be read, one sentence each.
    pub unreadable: Vec<String>,
}

/// Writes the report and the files of a study to `folder`.
///
/// Files of steps that were not run whole (`--only`, a failure, Ctrl-C) stay as they were.
///
/// # Errors
/// Where a file can't be written.
pub fn write(pipeline: &Pipeline, plan: &Plan, run: &Report, store: &Store, folder: &Path) -> io::Result<Written> {
    let page = page(folder);
    let mut old = Manifest::read(folder);
    let study = digest(pipeline, plan, run);
    if old.study == study && !old.files.is_empty() && old.is_whole(folder) {
        return Ok(Written { page, study, unreadable: Vec::new() });
    }
    let mut writer = Writer { folder, files: BTreeMap::new(), old: std::mem::take(&mut old.files) };
    let mut reader = Reader { plan, run, store, briefs: brief::read(folder), unreadable: Vec::new() };
    let mut steps = Vec::new();
    for step in &plan.steps {
        let points = reader.points(step.nodes.clone());
        writer.step(&step.name, &points)?;
        steps.push(shown(plan, step, points));
    }
    let study_page = Title::of(pipeline).study(plan, run, steps);
    writer.file(PAGE, report::render(&study_page).as_bytes())?;
    for (name, seen) in std::mem::take(&mut writer.old) {
        if let Entry::Vacant(entry) = writer.files.entry(name) {
            if stays(entry.key(), pipeline, plan, run) {
                entry.insert(seen);
            } else {
                let _ = fs::remove_file(folder.join(entry.key()));
            }
        }
    }
    publish_keys(folder, pipeline, plan, run)?;
    // What could not be read is written next time, though the study is the same.
    let Reader { mut briefs, unreadable, .. } = reader;
    let study = if unreadable.is_empty() { study } else { String::new() };
    brief::publish(folder, &mut briefs)?;
    // Not `at: now()`: files that are as old as this are read once more, when clocks have ticked.
    Manifest { pipeline: full(&pipeline.path), study: study.clone(), files: writer.files, at: 0 }.publish(folder)?;
    // The program ends soon: to take a wide sweep's points apart piece by piece would only cost time.
    std::mem::forget((study_page, briefs));
    Ok(Written { page, study, unreadable })
}

/// What a study is called, and what it asks.
pub struct Title {
    /// Name of the pipeline.
    pub name: String,
    /// Its opening comment.
    pub question: String,
    /// The command that makes it.
    pub command: String,
    /// What its `[choose.NAME]` chose.
    pub chosen: Vec<Choice>,
    /// What its `region = "auto"` left out.
    pub regions: Vec<Region>,
}
impl Title {
    /// That of `pipeline`.
    pub fn of(pipeline: &Pipeline) -> Title {
        let command = format!("hvi-flow run {}", pipeline.path.display());
        let (name, question) = (pipeline.name.clone(), pipeline.question.clone());
        Title { name, question, command, chosen: pipeline.chosen.clone(), regions: pipeline.regions.clone() }
    }

    fn study(&self, plan: &Plan, run: &Report, steps: Vec<Step>) -> Study {
        let (name, command, seconds) = (self.name.clone(), self.command.clone(), run.seconds);
        let chosen = self.chosen.iter().map(|choice| choice.compared(plan, run));
        let left_out = self.regions.iter().map(|region| format!("{}.", region.sentence()));
        let question =
            std::iter::once(self.question.clone()).chain(chosen).chain(left_out).collect::<Vec<_>>().join("\n\n");
        Study { name, question, steps, seconds, command }
    }
}

/// The study with what its results show; and those that the store has but that can't be read, one sentence each.
pub fn study(title: &Title, plan: &Plan, run: &Report, store: &Store) -> (Study, Vec<String>) {
    let mut reader = Reader { plan, run, store, briefs: Briefs::new(), unreadable: Vec::new() };
    let steps = plan.steps.iter().map(|step| shown(plan, step, reader.points(step.nodes.clone()))).collect();
    (title.study(plan, run, steps), reader.unreadable)
}

fn shown(plan: &Plan, step: &PlannedStep, points: Vec<Point>) -> Step {
    let (name, stage, summary) = (step.name.clone(), step.stage.name.into(), step.stage.summary.into());
    // A sweep's scenes look alike: the first is drawn.
    let first = step.nodes.clone().next();
    let sketches = first.map_or_else(Vec::new, |id| (step.stage.sketch)(&plan.nodes[id].params));
    Step { name, stage, summary, needs: step.needs.clone(), sketches, points }
}

/// Whether an older file belongs to a step of the pipeline that this run didn't bring to its end.
fn stays(name: &str, pipeline: &Pipeline, plan: &Plan, run: &Report) -> bool {
    let owner = name.split('/').next().unwrap_or(name);
    let owner = owner.strip_suffix(".csv").or(owner.strip_suffix(".h5")).unwrap_or(owner);
    match plan.steps.iter().find(|s| s.name == owner) {
        Some(step) => step.nodes.clone().any(|id| run.outcomes[id].entry().is_none()),
        None => pipeline.steps.iter().any(|s| s.name == owner),
    }
}

/// Writes beside the file, then renames: a reader sees all of it or none.
fn publish(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = beside(path)?;
    fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, path)).inspect_err(|_| drop(fs::remove_file(&beside)))
}

/// A name beside `path` that no other process uses, in a folder that is there.
fn beside(path: &Path) -> io::Result<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(folder.join(format!(".{}.{name:.60}", std::process::id())))
}

/// Digest of what the page shows of the results, but for which of them were hits.
fn digest(pipeline: &Pipeline, plan: &Plan, run: &Report) -> String {
    let mut all = Vec::with_capacity(256 * plan.nodes.len());
    let mut add = |part: &[u8]| {
        all.extend_from_slice(&(part.len() as u64).to_le_bytes());
        all.extend_from_slice(part);
    };
    add(PROGRAM.as_bytes());
    add(pipeline.path.as_os_str().as_encoded_bytes());
    add(pipeline.question.as_bytes());
    pipeline.chosen.iter().for_each(|choice| add(choice.sentence().as_bytes()));
    pipeline.regions.iter().for_each(|region| add(region.sentence().as_bytes()));
    pipeline.steps.iter().for_each(|step| add(step.name.as_bytes()));
    for (node, (outcome, key)) in plan.nodes.iter().zip(run.outcomes.iter().zip(&run.keys)) {
        add(plan.steps[node.step].name.as_bytes());
        add(node.point.as_bytes());
        add(key.as_ref().map_or(&[][..], |key| key.bytes()));
        match outcome {
            Outcome::Hit(entry) | Outcome::Ran(entry) => add(entry.output.bytes()),
            Outcome::Failed(why) | Outcome::Skipped(why) => add(why.as_bytes()),
            Outcome::Cancelled => add(b"cancelled"),
        }
    }
    Digest::of(&all).to_string()
}

struct Writer<'a> {
    folder: &'a Path,
    files: BTreeMap<String, Seen>,
    /// Files as they were left by an earlier run: those that come out the same are not written again.
    old: BTreeMap<String, Seen>,
}

impl Writer<'_> {
    fn file(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.folder.join(name);
        self.stay_inside(&path)?;
        let digest = Digest::of(bytes);
        let is_same = |seen: &Seen| seen.digest == digest && fs::read(&path).is_ok_and(|found| found == bytes);
        if !self.old.get(name).is_some_and(is_same) {
            publish(&path, bytes)?;
        }
        self.files.insert(name.into(), Seen { digest, mark: mark(&path)? });
        Ok(())
    }

    /// Refuses a folder that a link leads out of the output folder.
    fn stay_inside(&self, path: &Path) -> io::Result<()> {
        let parent = path.parent().unwrap_or(self.folder);
        fs::create_dir_all(parent)?;
        if parent.canonicalize()?.starts_with(self.folder.canonicalize()?) {
            return Ok(());
        }
        Err(io::Error::other(format!("{} leads out of {}: remove that link", parent.display(), self.folder.display())))
    }

    fn step(&mut self, step: &str, points: &[Point]) -> io::Result<Exported> {
        let mut exported = Exported { shared: Vec::new(), of_points: vec![Vec::new(); points.len()] };
        if let Some(table) = compare(step, points) {
            exported.shared = vec![format!("{step}.csv"), format!("{step}.h5")];
            self.file(&exported.shared[0], figure::csv(&table).as_bytes())?;
            self.file(&exported.shared[1], &hdf5_table::encode(&table))?;
        }
        if points.len() > MOST_FOLDERS {
            return Ok(exported);
        }
        let mut taken: BTreeSet<String> = BTreeSet::new();
        for (point, names) in points.iter().zip(&mut exported.of_points) {
            let mut place = step.to_string();
            if !point.label.is_empty() {
                let mut name = slug(&point.label);
                if name.len() > LONGEST_NAME || taken.contains(&name) {
                    let digits = point.key.get(..8).unwrap_or("no-key");
                    name = format!("{}-{digits}", name.chars().take(LONGEST_NAME).collect::<String>());
                }
                place = format!("{step}/{name}");
                taken.insert(name);
            }
            for view in &point.views {
                let (title, extension, bytes) = match view {
                    View::Table(t) => (&t.title, "csv", figure::csv(t).into_bytes()),
                    View::Figure(f) => (&f.title, "svg", figure::svg(f).into_bytes()),
                    View::Picture(p) => (&p.title, "png", figure::png(p)),
                    View::Drawing(d) => (&d.title, "svg", figure::drawing(d).into_bytes()),
                    View::Trajectory(t) => (&t.title, "xyz", extended_xyz::encode(t).into_bytes()),
                    View::Cloud(c) => (&c.title, "vtkhdf", vtkhdf::encode(c)),
                    View::Text(t) => (&t.title, t.extension.as_str(), t.text.clone().into_bytes()),
                };
                let mut name = format!("{place}/{}.{extension}", slug(title));
                let mut copy = 2;
                while self.files.contains_key(&name) {
                    name = format!("{place}/{}-{copy}.{extension}", slug(title));
                    copy += 1;
                }
                self.file(&name, &bytes)?;
                names.push(name);
            }
        }
        Ok(exported)
    }
}

/// Files of a step's results, by their paths in the folder.
pub struct Exported {
    /// Tables over all points.
    pub shared: Vec<String>,
    /// Tables, figures and pictures of each point; none where there are too many points for a folder each.
    pub of_points: Vec<Vec<String>>,
}

/// Writes the tables, figures and pictures of a step's points to `folder`.
///
/// # Errors
/// Where a file can't be written.
pub fn export(folder: &Path, step: &str, points: &[Point]) -> io::Result<Exported> {
    Writer { folder, files: BTreeMap::new(), old: BTreeMap::new() }.step(step, points)
}

/// A row a point: what the sweep sets, and the scalars of the results, but for those that only repeat it; nothing where no
/// point has a result.
pub fn compare(step: &str, points: &[Point]) -> Option<Table> {
    let mut keys: Vec<&String> = Vec::new();
    for (key, _) in points.iter().flat_map(|p| &p.swept) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let named = points.iter().find(|p| !p.scalars.is_empty())?;
    let swept: Vec<(String, Vec<Cell>)> = keys.iter().map(|key| swept_column(key, points)).collect();
    let mut columns: Vec<(String, String)> =
        keys.iter().zip(&swept).map(|(k, (unit, _))| (k.to_string(), unit.clone())).collect();
    let value = |p: &Point, s: &Scalar| {
        p.scalars.iter().find(|own| own.name == s.name).map_or(Cell::Empty, |own| own.value.clone())
    };
    // A result may say again what the sweep set.
    let is_repeated = |s: &&Scalar| {
        let same = |cells: &[Cell]| points.iter().zip(cells).all(|(p, cell)| value(p, s) == *cell);
        keys.iter().zip(&swept).any(|(key, (unit, cells))| **key == s.name && *unit == s.unit && same(cells))
    };
    let scalars: Vec<&Scalar> = named.scalars.iter().filter(|s| !is_repeated(s)).collect();
    columns.extend(scalars.iter().map(|s| (s.name.clone(), s.unit.clone())));
    let row = |(i, p): (usize, &Point)| {
        swept.iter().map(|(_, cells)| cells[i].clone()).chain(scalars.iter().map(|s| value(p, s))).collect()
    };
    Some(Table { title: step.into(), columns, rows: points.iter().enumerate().map(row).collect(), note: String::new() })
}

/// Unit and values of a swept key: numbers where all points give a number in the same unit, else the words.
fn swept_column(key: &str, points: &[Point]) -> (String, Vec<Cell>) {
    let text = |p: &Point| p.swept.iter().find(|(name, _)| name == key).map(|(_, v)| v.clone());
    let texts: Vec<Option<String>> = points.iter().map(text).collect();
    let parts: Option<Vec<(f64, &str)>> = texts
        .iter()
        .map(|t| t.as_deref().and_then(units::split).and_then(|(number, unit)| Some((number.parse().ok()?, unit))))
        .collect();
    match parts {
        Some(parts) if parts.iter().all(|(_, unit)| *unit == parts[0].1) => {
            (parts[0].1.to_string(), parts.iter().map(|(x, _)| Cell::Number(*x)).collect())
        }
        _ => (String::new(), texts.into_iter().map(|t| t.map_or(Cell::Empty, Cell::Text)).collect()),
    }
}

/// A file name that any system takes: letters, digits, `.`, `=`, `-` and `_`; brackets go, the rest becomes `-`.
fn slug(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '=' | '_') { c } else { '-' };
    let named: String = text.replace('µ', "u").replace(['[', ']', '{', '}'], "").chars().map(plain).collect();
    let parts: Vec<&str> = named.split('-').filter(|p| !p.is_empty()).collect();
    let joined = parts.join("-");
    let joined = joined.trim_start_matches('.');
    if joined.is_empty() { "result".into() } else { joined.into() }
}
