//! What runs did: one entry a run in the store's `runs/NAME/`, written when a run computed something or came to other keys
//! than the one before. A run that changed nothing pays one look into a folder.
use crate::execute::{Outcome, Report};
use crate::pipeline::Pipeline;
use crate::plan::Plan;
use crate::registry;
use hvi_kit::{Digest, Store};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use std::{fs, io};

/// One run of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The pipeline file.
    pub pipeline: PathBuf,
    /// The command, its words in order.
    pub command: Vec<String>,
    /// Version of the program.
    pub program: String,
    /// Digest of each stage's code, by stage.
    pub code: HashMap<String, Digest>,
    /// When it began, in milliseconds since 1970 (UTC).
    pub began: u64,
    /// Wall time [s].
    pub seconds: f64,
    /// What came of each node, in the order of the plan.
    pub nodes: Vec<Node>,
}

/// What came of one node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Its label: `states[temperature=300 K]`.
    pub label: String,
    /// Its key, where its inputs were known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key: Option<Digest>,
    /// What came of it.
    pub came: Came,
    /// Why it failed or was skipped.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// What came of a node, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Came {
    Hit,
    Ran,
    Failed,
    Skipped,
    Cancelled,
}

impl Came {
    fn of(outcome: &Outcome) -> (Came, &str) {
        match outcome {
            Outcome::Hit(_) => (Came::Hit, ""),
            Outcome::Ran(_) => (Came::Ran, ""),
            Outcome::Failed(why) => (Came::Failed, why),
            Outcome::Skipped(why) => (Came::Skipped, why),
            Outcome::Cancelled => (Came::Cancelled, ""),
        }
    }
}

impl Run {
    /// Number of nodes of which this came.
    pub fn count(&self, came: Came) -> usize {
        self.nodes.iter().filter(|n| n.came == came).count()
    }
}

/// Runs of a study that are kept.
const KEPT: usize = 100;

/// Notes a run, unless it computed nothing and came to the keys of the one before.
///
/// # Errors
/// Where the entry can't be written; the results are in the store all the same.
pub fn append(store: &Store, pipeline: &Pipeline, plan: &Plan, report: &Report) -> io::Result<()> {
    let folder = folder(store, &pipeline.name);
    let earlier = names(&folder);
    let mark = mark(report);
    let all_hits = report.outcomes.iter().all(|o| matches!(o, Outcome::Hit(_)));
    if all_hits && earlier.last().is_some_and(|name| name.ends_with(&mark)) {
        return Ok(());
    }
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_millis() as u64);
    let node = |(id, outcome): (usize, &Outcome)| {
        let (came, why) = Came::of(outcome);
        Node { label: plan.label(id), key: report.keys[id], came, why: why.into() }
    };
    let run = Run {
        pipeline: pipeline.path.canonicalize().unwrap_or_else(|_| pipeline.path.clone()),
        command: std::env::args().collect(),
        program: env!("CARGO_PKG_VERSION").into(),
        code: plan.steps.iter().map(|s| (s.stage.name.to_string(), registry::code(s.stage))).collect(),
        began: now.saturating_sub((report.seconds * 1e3) as u64),
        seconds: report.seconds,
        nodes: report.outcomes.iter().enumerate().map(node).collect(),
    };
    fs::create_dir_all(&folder)?;
    // Later than the last one, also where the clock was set back: the names' order is the runs' order.
    let last = earlier.last().and_then(|name| name.split('-').next()?.parse::<u64>().ok());
    let number = last.map_or(now, |last| now.max(last + 1));
    let beside = folder.join(format!(".{}", std::process::id()));
    let place = folder.join(format!("{number:015}-{mark}"));
    fs::write(&beside, serde_json::to_vec(&run)?).and_then(|()| fs::rename(&beside, place)).inspect_err(|_| {
        let _ = fs::remove_file(&beside);
    })?;
    let surplus = (earlier.len() + 1).saturating_sub(KEPT);
    earlier.iter().take(surplus).for_each(|name| drop(fs::remove_file(folder.join(name))));
    Ok(())
}

/// Whether the last run of a study on record bears this [`mark`].
pub fn ended_with(store: &Store, study: &str, mark: &str) -> bool {
    names(&folder(store, study)).last().is_some_and(|name| name.ends_with(mark))
}

/// What tells two runs apart: the keys they came to, and which nodes have results.
pub fn mark(report: &Report) -> String {
    let mut bytes = Vec::with_capacity(33 * report.keys.len());
    for (key, outcome) in report.keys.iter().zip(&report.outcomes) {
        bytes.extend(key.map_or([0; 32], |k| *k.bytes()));
        bytes.push(u8::from(matches!(outcome, Outcome::Hit(_) | Outcome::Ran(_))));
    }
    Digest::of(&bytes).short()
}

fn folder(store: &Store, study: &str) -> PathBuf {
    store.folder().join("runs").join(study)
}

/// Names of the entries, oldest first.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.'));
    names.sort_unstable();
    names
}

/// The runs of a study, newest first; an entry that can't be read is passed over.
pub fn runs(store: &Store, study: &str) -> impl Iterator<Item = Run> + use<> {
    let folder = folder(store, study);
    let names = names(&folder);
    names.into_iter().rev().filter_map(move |name| serde_json::from_slice(&fs::read(folder.join(name)).ok()?).ok())
}

/// Names of the studies that have run on this store.
pub fn studies(store: &Store) -> Vec<String> {
    names(&store.folder().join("runs"))
}

/// Which key each node had when it last had one, and what the others had then.
pub struct Last {
    runs: Vec<HashMap<String, Digest>>,
}

/// Runs that [`Last`] looks back over: a node that has had no key for so long is as good as new.
const BACK: usize = 20;

impl Last {
    /// Reads the history of a study.
    pub fn of(store: &Store, study: &str) -> Last {
        let keys = |run: Run| run.nodes.into_iter().filter_map(|n| Some((n.label, n.key?))).collect();
        Last { runs: runs(store, study).take(BACK).map(keys).collect() }
    }

    /// The key that `label` had last.
    pub fn key(&self, label: &str) -> Option<Digest> {
        self.runs.iter().find_map(|run| run.get(label)).copied()
    }

    /// The key that `other` had in the run in which `label` last had one.
    pub fn key_beside(&self, label: &str, other: &str) -> Option<Digest> {
        self.runs.iter().find(|run| run.contains_key(label))?.get(other).copied()
    }
}

/// `2026-11-22T04:13:52Z` of `milliseconds` since 1970: ISO 8601.
pub fn iso(milliseconds: u64) -> String {
    time(milliseconds).replacen(' ', "T", 1).replace(" UTC", "Z")
}

/// `2026-11-22 04:13:52 UTC` of `milliseconds` since 1970.
pub fn time(milliseconds: u64) -> String {
    let seconds = milliseconds / 1000;
    let (days, of_day) = (seconds / 86_400, seconds % 86_400);
    let (mut year, mut day) = (1970, days);
    let is_leap = |y: u64| (y.is_multiple_of(4) && !y.is_multiple_of(100)) || y.is_multiple_of(400);
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while day >= lengths[month] {
        day -= lengths[month];
        month += 1;
    }
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year}-{:02}-{:02} {hour:02}:{minute:02}:{second:02} UTC", month + 1, day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `date -u -d @N` prints them: a leap day, the last second of a year, one not of a leap century.
    #[test]
    fn times_are_those_of_the_calendar() {
        assert_eq!(time(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(time(951_782_400_000), "2000-02-29 00:00:00 UTC");
        assert_eq!(time(1_735_689_599_999), "2024-12-31 23:59:59 UTC");
        assert_eq!(iso(951_782_400_000), "2000-02-29T00:00:00Z");
        assert_eq!(time(4_107_542_400_000), "2100-03-01 00:00:00 UTC");
    }
}
