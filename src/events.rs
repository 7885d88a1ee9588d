//! What happens in a run, as it happens; `console.rs` shows it.
use crate::plan::{NodeId, Plan};
use serde::Serialize;

/// One thing that happened. As JSON: one object a line, tagged by `event`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
pub enum Event {
    /// The result was in the store.
    Hit {
        /// Which node.
        node: NodeId,
    },
    /// The stored result is damaged or gone: it is computed again.
    Damaged {
        /// Which node.
        node: NodeId,
    },
    /// A worker began.
    Started {
        /// Which node.
        node: NodeId,
    },
    /// A worker came further.
    Progress {
        /// Which node.
        node: NodeId,
        /// Share done, 0 to 1.
        share: f64,
        /// What it does now.
        doing: String,
    },
    /// A worker made a result.
    Ran {
        /// Which node.
        node: NodeId,
        /// Wall time [s].
        seconds: f64,
    },
    /// A worker failed.
    Failed {
        /// Which node.
        node: NodeId,
        /// Why.
        why: String,
    },
    /// Not run, because something it needs has no result.
    Skipped {
        /// Which node.
        node: NodeId,
        /// Why.
        why: String,
    },
    /// Stopped by Ctrl-C, or never begun because of it.
    Cancelled {
        /// Which node.
        node: NodeId,
    },
}

impl Event {
    /// The node it happened to.
    pub fn node(&self) -> NodeId {
        match *self {
            Event::Hit { node }
            | Event::Damaged { node }
            | Event::Started { node }
            | Event::Progress { node, .. }
            | Event::Ran { node, .. }
            | Event::Failed { node, .. }
            | Event::Skipped { node, .. }
            | Event::Cancelled { node } => node,
        }
    }
}

/// Whoever listens to a run.
pub trait Listener: Sync {
    /// Something happened; called from the coordinator and from workers.
    fn on(&self, plan: &Plan, event: &Event);
}

impl Listener for () {
    fn on(&self, _: &Plan, _: &Event) {}
}
