//! What happens in a run, as it happens; `console.rs` shows it.
use crate::plan::{NodeId, Plan};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;

/// One thing that happened to one node.
#[derive(Clone, Debug)]
pub struct Event {
    /// Which node.
    pub node: NodeId,
    /// What.
    pub what: What,
}

/// What happened to a node.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "lowercase")]
pub enum What {
    /// The result was in the store.
    Hit,
    /// The stored result is damaged or gone: it is computed again.
    Damaged,
    /// Another run computes it just now: its result will be used, or its work taken over if it dies.
    Waiting,
    /// A job of a cluster will compute it.
    Queued {
        /// Its name in the cluster's lists.
        job: String,
    },
    /// The cluster does not answer: it is asked again. Said for one of the nodes that wait.
    Delayed {
        /// What it said.
        why: String,
    },
    /// A worker began.
    Started {
        /// Threads it was given.
        threads: usize,
        /// Core-seconds foretold, from what such nodes took before.
        foretold: f64,
    },
    /// It goes on from what an earlier attempt kept.
    Resumed,
    /// A worker came further.
    Progress {
        /// Share done, 0 to 1.
        share: f64,
        /// What it does now.
        doing: String,
    },
    /// A worker made a result.
    Ran {
        /// Wall time [s].
        seconds: f64,
    },
    /// A worker failed in a way that may pass: it will be tried again.
    Retrying {
        /// Why.
        why: String,
        /// Tries that failed.
        failed: u32,
    },
    /// A worker failed.
    Failed {
        /// Why.
        why: String,
    },
    /// Not run: something it needs has no result, or something else failed before it began.
    Skipped {
        /// Why.
        why: String,
    },
    /// Stopped by Ctrl-C, or never begun because of it.
    Cancelled,
}

/// One line of `run --json`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Line<'a> {
    /// Something happened to a node.
    Node(NodeLine<'a>),
    /// The run began or ended.
    Run(RunLine<'a>),
}

/// Something that happened to a node.
#[derive(Serialize, JsonSchema)]
pub struct NodeLine<'a> {
    /// Seconds since the run began.
    pub time: f64,
    /// `STEP`, or `STEP[POINT]` for a point of a sweep.
    pub node: &'a str,
    /// What happened.
    #[serde(flatten)]
    pub what: &'a What,
}

/// The run as a whole: its first line and its last.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "lowercase")]
pub enum RunLine<'a> {
    /// The first line.
    Began {
        /// Name of the study.
        study: &'a str,
        /// Number of nodes.
        nodes: usize,
        /// Threads at work at once.
        jobs: usize,
    },
    /// The last line, once results are written.
    Ended {
        /// Seconds since the run began.
        time: f64,
        /// Nodes whose result was in the store.
        hits: usize,
        /// Nodes that were computed.
        ran: usize,
        /// Nodes that failed.
        failed: usize,
        /// Nodes that were not run because of a failure.
        skipped: usize,
        /// Nodes that were stopped, or not begun because the run was.
        cancelled: usize,
    },
}

/// JSON schema of a line of `run --json`.
pub fn schema() -> Schema {
    SchemaGenerator::default().into_root_schema_for::<Line<'_>>()
}

/// Whoever listens to a run.
pub trait Listener: Sync {
    /// Something happened; called from the coordinator and from workers.
    fn on(&self, plan: &Plan, event: &Event);

    /// Not all is in the store: `seconds` are the core-seconds foretold for each node that isn't settled, 0 for the others.
    fn outlook(&self, _plan: &Plan, _seconds: &[f64]) {}
}

impl Listener for () {
    fn on(&self, _: &Plan, _: &Event) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The schema names every event, and what is written fits it: the tag and the keys of the variant.
    #[test]
    fn lines_fit_the_schema() {
        let schema = serde_json::to_string(&schema()).unwrap();
        let what = What::Progress { share: 0.5, doing: "stepping".into() };
        let line = serde_json::to_value(Line::Node(NodeLine { time: 1.0, node: "a", what: &what })).unwrap();
        let keys: Vec<&String> = line.as_object().unwrap().keys().collect();
        assert_eq!(keys, ["doing", "event", "node", "share", "time"]);
        for event in [
            "began", "hit", "waiting", "queued", "delayed", "started", "resumed", "progress", "ran", "retrying",
            "ended",
        ] {
            assert!(schema.contains(&format!("\"const\":\"{event}\"")), "{event}: {schema}");
        }
    }
}
