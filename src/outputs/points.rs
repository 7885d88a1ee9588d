//! Points of a report from the store: no more of what results show is read than the page and the files need.
use super::MOST_FOLDERS;
use super::brief::{Brief, Briefs};
use crate::execute::{Outcome, Report};
use crate::plan::{NodeId, Plan};
use crate::registry;
use crate::report::{self, Point, State, Unread};
use hvi_kit::Store;
use std::sync::Arc;

/// Node `id` with all that its result shows; what can't be read is said in `unreadable`.
pub fn point(plan: &Plan, run: &Report, store: &Store, id: NodeId, unreadable: &mut Vec<String>) -> Point {
    let mut params = Vec::new();
    flatten("", &plan.nodes[id].params, &mut params);
    let mut point = bare_point(plan, run, id, params.into());
    show(&mut point, plan, run, store, id, unreadable);
    point
}

/// Puts in what the result of node `id` shows, if it has one.
fn show(point: &mut Point, plan: &Plan, run: &Report, store: &Store, id: NodeId, unreadable: &mut Vec<String>) {
    if let Some(entry) = run.outcomes[id].entry() {
        match registry::show(plan.nodes[id].stage, entry.output, store) {
            Ok(shown) => (point.scalars, point.views) = (shown.scalars.into(), shown.views),
            Err(e) => {
                unreadable.push(format!("{}: its result can't be read: {e}", plan.label(id)));
                point.state = State::Failed(e);
            }
        }
    }
}

/// Node `id` without what its result shows.
fn bare_point(plan: &Plan, run: &Report, id: NodeId, params: Arc<[(String, String)]>) -> Point {
    let node = &plan.nodes[id];
    let state = match &run.outcomes[id] {
        Outcome::Hit(_) => State::Hit,
        Outcome::Ran(_) => State::Ran,
        Outcome::Failed(why) => State::Failed(why.clone()),
        Outcome::Skipped(why) => State::Skipped(why.clone()),
        Outcome::Cancelled => State::Cancelled,
    };
    Point {
        label: node.point.clone(),
        state,
        seconds: run.outcomes[id].entry().map_or(0.0, |entry| f64::from(entry.wall_s)),
        key: run.keys[id].map(|k| k.to_string()).unwrap_or_default(),
        params,
        swept: node.swept.clone(),
        scalars: Arc::default(),
        views: Vec::new(),
        unread: Unread::default(),
    }
}

/// Reads what results show, no more of them than the report and the files need.
pub struct Reader<'a> {
    pub plan: &'a Plan,
    pub run: &'a Report,
    pub store: &'a Store,
    /// What results showed when they were last read, and what those of this run show.
    pub briefs: Briefs,
    pub unreadable: Vec<String>,
}

impl Reader<'_> {
    /// The points of a step. Of a wide sweep only the first have their tables, figures and pictures: the page shows no
    /// others, and no files are made of them.
    pub fn points(&mut self, nodes: std::ops::Range<NodeId>) -> Vec<Point> {
        let is_wide = nodes.len() > MOST_FOLDERS;
        let params = shared_params(self.plan, nodes.clone());
        let (mut pictures, mut more) = (0, 0);
        let mut points = Vec::with_capacity(nodes.len());
        for id in nodes {
            let output = self.run.outcomes[id].entry().map(|entry| *entry.output.bytes()).filter(|_| is_wide);
            let mut point = bare_point(self.plan, self.run, id, params.clone());
            let is_shown = |brief: &Brief| {
                brief.pictures > 0 && pictures < report::MOST_PICTURES_A_SWEEP
                    || brief.more && more < report::MOST_POINTS_SHOWN
            };
            let brief = output.and_then(|output| self.briefs.get(&output));
            match brief.filter(|brief| !is_shown(brief) || !brief.views.is_empty()) {
                Some(brief) => (point.scalars, point.views) = (brief.scalars.clone(), brief.views.clone()),
                None => {
                    show(&mut point, self.plan, self.run, self.store, id, &mut self.unreadable);
                    if let (Some(output), State::Hit | State::Ran) = (output, &point.state) {
                        self.briefs.insert(output, Brief::of(&point.scalars, &point.views));
                    }
                }
            }
            if let Some(brief) = output.and_then(|output| self.briefs.get_mut(&output)) {
                if !is_shown(brief) {
                    point.unread = Unread { pictures: brief.pictures, more: brief.more };
                    point.views = Vec::new();
                    if !brief.is_used {
                        // What nobody looks at need not be kept.
                        brief.views = Vec::new();
                    }
                }
                brief.is_used = true;
                pictures += brief.pictures;
                more += usize::from(brief.more);
            }
            points.push(point);
        }
        points
    }
}

/// Parameters that all of these nodes have in common.
fn shared_params(plan: &Plan, mut nodes: std::ops::Range<NodeId>) -> Arc<[(String, String)]> {
    let Some(first) = nodes.next() else { return Arc::default() };
    let mut shared = plan.nodes[first].params.clone();
    nodes.for_each(|id| retain(&mut shared, &plan.nodes[id].params));
    let mut params = Vec::new();
    flatten("", &shared, &mut params);
    params.into()
}

/// Takes out of `shared` what isn't the same in `other`.
fn retain(shared: &mut serde_json::Value, other: &serde_json::Value) {
    match (shared, other) {
        (serde_json::Value::Object(shared), serde_json::Value::Object(other)) => shared.retain(|key, value| {
            other.get(key).is_some_and(|other| {
                retain(value, other);
                value.is_object() || value == other
            })
        }),
        (shared, other) if shared != other => *shared = serde_json::Value::Null,
        _ => {}
    }
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
