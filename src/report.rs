//! The report: one self-contained HTML page of a study, from plain data.
//!
//! `report.html` is the page's template, `report/page.js` its script, `report/live.js` that of a page that renews itself,
//! `report/data.rs` the data for it, `report/chain.rs` draws the chain, `report/parts.rs` turns results into rows, drawings and
//! pictures, `report/markdown.rs` into Markdown. Every name is escaped, by the template or where cells and
//! drawings are made, which go in as they are.
mod chain;
mod data;
mod markdown;
mod parts;
pub use markdown::markdown;

use hvi_kit::view::{Scalar, View};
use parts::{Block, Budget, Grid};
pub use parts::{MOST_PICTURES_A_SWEEP, MOST_POINTS_SHOWN};
use serde::Serialize;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// A study and what came of it.
pub struct Study {
    /// Name of the pipeline.
    pub name: String,
    /// What it asks: the pipeline's opening comment; empty lines part paragraphs.
    pub question: String,
    /// Its steps, in order.
    pub steps: Vec<Step>,
    /// Time the run took [s].
    pub seconds: f64,
    /// The command that makes it.
    pub command: String,
}

/// One step of a pipeline.
pub struct Step {
    /// Its name.
    pub name: String,
    /// Name of its stage.
    pub stage: String,
    /// What the stage makes, in one line.
    pub summary: String,
    /// Names of the steps it takes from.
    pub needs: Vec<String>,
    /// What its parameters alone show: the scene before anything is computed; of a sweep, its first point's.
    pub sketches: Vec<View>,
    /// Its points; one, with an empty label, where nothing is swept.
    pub points: Vec<Point>,
}

/// One computation.
pub struct Point {
    /// `"velocity=2.5 km/s, ..."`, empty for a step without a sweep.
    pub label: String,
    /// What came of it.
    pub state: State,
    /// Time the computation took, also where its result was in the store [s].
    pub seconds: f64,
    /// Key of the result.
    pub key: String,
    /// Parameters, canonical: all, or, of points of a sweep, those that they have in common.
    pub params: Arc<[(String, String)]>,
    /// Swept keys and their values as written.
    pub swept: Vec<(String, String)>,
    /// The numbers that sum it up.
    pub scalars: Arc<[Scalar]>,
    /// Its tables, figures and pictures.
    pub views: Vec<View>,
    /// What it has beside `views`.
    pub unread: Unread,
}

/// Views that a result has, but that were not read: a page shows the first ones of a sweep only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unread {
    /// Number of pictures.
    pub pictures: usize,
    /// Whether there is anything else.
    pub more: bool,
}

/// What came of a computation.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// The result was in the store.
    Hit,
    /// It was computed.
    Ran,
    /// It failed, and why.
    Failed(String),
    /// It was not tried, and why.
    Skipped(String),
    /// The run was stopped before it.
    Cancelled,
}

/// Rows of one kind of trouble that are shown in full.
const MOST_TROUBLES: usize = 30;

#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    question: Vec<&'a str>,
    command: &'a str,
    totals: Vec<(String, &'static str, &'static str)>,
    chain: String,
    failures: Vec<Trouble>,
    failures_left_out: usize,
    steps: Vec<Section<'a>>,
    /// What the script knows of the study, as JSON.
    study: String,
    script: &'static str,
    live: &'static str,
}

#[derive(Serialize)]
struct Trouble {
    step: String,
    anchor: usize,
    label: String,
    why: String,
}

#[derive(Serialize)]
struct Section<'a> {
    name: &'a str,
    stage: &'a str,
    summary: &'a str,
    class: &'static str,
    counts: String,
    time: String,
    /// Parameters of the only point, or those that all points share.
    params: Vec<(String, String)>,
    key: &'a str,
    scalars: Option<Grid>,
    sweep: Option<Grid>,
    troubles: Vec<Trouble>,
    troubles_left_out: usize,
    blocks: Vec<Block>,
    left_out: String,
}

/// What each page says of itself near its beginning, in `report.html`.
const MARK: &str = r#"<meta name="generator" content="hvi-flow">"#;

/// Whether the file at `path` is such a page.
pub fn is_ours(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(1024).read_to_end(&mut head));
    read.is_ok() && String::from_utf8_lossy(&head).contains(MARK)
}

/// The page.
pub fn render(study: &Study) -> String {
    page(study, "")
}

/// The page while the study runs: it asks beside itself how far that is, and renews itself.
pub fn render_live(study: &Study) -> String {
    page(study, include_str!("report/live.js"))
}

fn page(study: &Study, live: &'static str) -> String {
    let mut budget = Budget::default();
    let failures =
        || study.steps.iter().enumerate().flat_map(|(k, s)| s.points.iter().filter_map(move |p| failure(k, s, p)));
    let page = Page {
        name: &study.name,
        question: study.question.split("\n\n").map(str::trim).filter(|p| !p.is_empty()).collect(),
        command: &study.command,
        totals: totals(study),
        chain: chain::svg(&study.steps.iter().map(node).collect::<Vec<_>>()),
        failures: failures().take(MOST_TROUBLES).collect(),
        failures_left_out: failures().count().saturating_sub(MOST_TROUBLES),
        steps: study.steps.iter().enumerate().map(|(k, s)| section(k, s, &mut budget)).collect(),
        study: data::study(study),
        script: include_str!("report/page.js"),
        live,
    };
    // The template is part of the program and tested; were it wrong, the reader still learns of it.
    fill(&page).unwrap_or_else(|e| format!("<!doctype html><pre>{}</pre>\n", crate::figure::escape(&format!("{e:#}"))))
}

fn fill(page: &Page<'_>) -> Result<String, minijinja::Error> {
    let mut engine = minijinja::Environment::new();
    engine.set_syntax(minijinja::syntax::SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    engine.add_template("report.html", include_str!("report.html"))?;
    engine.get_template("report.html")?.render(minijinja::value::Serde(page))
}

type Kind = fn(&State) -> bool;

fn count(points: &[Point], state: Kind) -> usize {
    points.iter().filter(|p| state(&p.state)).count()
}

fn is_failed(s: &State) -> bool {
    matches!(s, State::Failed(_))
}

fn is_missing(s: &State) -> bool {
    matches!(s, State::Skipped(_) | State::Cancelled)
}

/// Words, numbers and classes of the page's head.
fn totals(study: &Study) -> Vec<(String, &'static str, &'static str)> {
    let sum = |state: Kind| study.steps.iter().map(|s| count(&s.points, state)).sum::<usize>();
    let mut all = vec![
        (study.steps.len().to_string(), if study.steps.len() == 1 { "step" } else { "steps" }, ""),
        (sum(|_| true).to_string(), if sum(|_| true) == 1 { "node" } else { "nodes" }, ""),
        (sum(|s| *s == State::Hit).to_string(), "from the store", "hit"),
        (sum(|s| *s == State::Ran).to_string(), "computed", "ran"),
    ];
    for (n, word, class) in [(sum(is_failed), "failed", "failed"), (sum(is_missing), "not run", "missing")] {
        if n > 0 {
            all.push((n.to_string(), word, class));
        }
    }
    all.push((parts::time(study.seconds), "that run", ""));
    let work: f64 = study.steps.iter().flat_map(|s| &s.points).map(|p| p.seconds).sum();
    all.push((parts::time(work), "computing, all told", ""));
    all
}

/// CSS class of a step: the worst that came of its points.
fn class(step: &Step) -> &'static str {
    let points = &step.points;
    if count(points, is_failed) > 0 {
        "failed"
    } else if points.is_empty() || count(points, is_missing) > 0 {
        "missing"
    } else if count(points, |s| *s == State::Ran) > 0 {
        "ran"
    } else {
        "hit"
    }
}

/// In words: how many points, and what came of them.
fn counts(step: &Step) -> String {
    let n = step.points.len();
    let kinds: [(Kind, &str); 4] = [
        (|s| *s == State::Hit, "from store"),
        (|s| *s == State::Ran, "computed"),
        (is_failed, "failed"),
        (is_missing, "not run"),
    ];
    let kinds = kinds.map(|(state, word)| (count(&step.points, state), word));
    if let Some((_, word)) = kinds.iter().find(|(k, _)| *k == n && n > 0) {
        return if n == 1 { word.to_string() } else { format!("{n} {word}") };
    }
    let some: Vec<String> = kinds.iter().filter(|(k, _)| *k > 0).map(|(k, word)| format!("{k} {word}")).collect();
    if some.is_empty() { "no points".into() } else { some.join(", ") }
}

fn node(step: &Step) -> chain::Node {
    let seconds: f64 = step.points.iter().map(|p| p.seconds).sum();
    let time = if seconds > 0.0 { format!(" · {}", parts::time(seconds)) } else { String::new() };
    chain::Node {
        name: step.name.clone(),
        stage: step.stage.clone(),
        counts: counts(step) + &time,
        class: class(step),
        needs: step.needs.clone(),
    }
}

fn failure(anchor: usize, step: &Step, point: &Point) -> Option<Trouble> {
    let State::Failed(why) = &point.state else { return None };
    Some(Trouble { step: step.name.clone(), anchor, label: point.label.clone(), why: why.clone() })
}

/// Failures, then what was skipped, each reason once.
fn troubles(anchor: usize, step: &Step) -> Vec<Trouble> {
    let mut all: Vec<Trouble> = step.points.iter().filter_map(|p| failure(anchor, step, p)).collect();
    let mut reasons: Vec<(String, usize)> = Vec::new();
    for point in &step.points {
        let why = match &point.state {
            State::Skipped(why) => why.clone(),
            State::Cancelled => "the run was stopped before it".into(),
            _ => continue,
        };
        match reasons.iter_mut().find(|r| r.0 == why) {
            Some(reason) => reason.1 += 1,
            None => reasons.push((why, 1)),
        }
    }
    let name = |n: usize| if step.points.len() == 1 { String::new() } else { format!("{n} not run") };
    all.extend(reasons.into_iter().map(|(why, n)| Trouble { step: step.name.clone(), anchor, label: name(n), why }));
    all
}

fn section<'a>(anchor: usize, step: &'a Step, budget: &mut Budget) -> Section<'a> {
    let single = match step.points.as_slice() {
        [only] if only.label.is_empty() => Some(only),
        _ => None,
    };
    let seconds: f64 = step.points.iter().map(|p| p.seconds).sum();
    let mut troubles = troubles(anchor, step);
    let troubles_left_out = troubles.len().saturating_sub(MOST_TROUBLES);
    troubles.truncate(MOST_TROUBLES);
    let (shown, left_out) = match single {
        Some(point) => (parts::blocks(&point.views, budget), String::new()),
        None => parts::sweep_blocks(&step.points, budget),
    };
    let blocks = parts::blocks(&step.sketches, budget).into_iter().chain(shown).collect();
    Section {
        name: &step.name,
        stage: &step.stage,
        summary: &step.summary,
        class: class(step),
        counts: counts(step),
        time: if seconds > 0.0 { parts::time(seconds) } else { String::new() },
        params: parts::shared_params(&step.points),
        key: single.map_or("", |p| p.key.as_str()),
        scalars: single.and_then(parts::scalars),
        sweep: if single.is_none() { parts::sweep(&step.points) } else { None },
        troubles,
        troubles_left_out,
        blocks,
        left_out,
    }
}

#[cfg(test)]
mod tests;
