//! `[choose.NAME]` of a pipeline: settings taken from a front that `hvi-flow tradeoff` measured, by the error or the time asked for.
//!
//! ```toml
//! [choose.cells]
//! of = ["sweep"]                                # steps that get the front's setting
//! front = "tradeoff.toml"                       # the pipeline that measured it, relative to this file
//! block = "cells"                               # its [tradeoff.NAME]
//! quantity = "hole diameter"
//! accuracy = "5 %"                              # the cheapest setting within it; or budget = "10 min", the most accurate
//! ```
use crate::execute::Report;
use crate::forecast;
use crate::history::Last;
use crate::mistake::{At, Mistake};
use crate::pipeline::{self, Pipeline};
use crate::plan::{self, NodeId, Plan};
use crate::region;
use crate::tradeoff::{self, Outcome};
use crate::value::{Key, Node, Table, Value};
use crate::{amount, console};
use hvi_kit::Store;
use hvi_tradeoff::{MARGIN, Quantity};
use std::path::{Path, PathBuf};

/// Settings that were chosen for some steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The `NAME` of `[choose.NAME]`.
    pub name: String,
    /// The steps.
    pub steps: Vec<String>,
    /// What they get, as `key = value`.
    pub settings: Vec<(String, String)>,
    /// What was asked of which quantity, and by which front.
    pub asked: String,
    /// Relative error to expect.
    pub error: f64,
    /// CPU time to expect of all runs of the steps [s].
    pub foretold: f64,
}

impl Choice {
    /// What was chosen and what to expect of it, in a sentence.
    pub fn sentence(&self) -> String {
        let settings: Vec<String> = self.settings.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        format!(
            "[choose.{}]: {} for {}: {}; expected: an error of {:.2} %, {} of CPU time",
            self.name,
            settings.join(", "),
            self.steps.join(", "),
            self.asked,
            100.0 * self.error,
            console::duration(self.foretold)
        )
    }

    /// CPU time that the results of its steps took [s]; `None` while one is missing.
    pub fn taken(&self, plan: &Plan, report: &Report) -> Option<f64> {
        let nodes = || plan.steps.iter().filter(|s| self.steps.contains(&s.name)).flat_map(|s| s.nodes.clone());
        nodes().map(|id| report.outcomes[id].entry().map(|e| f64::from(e.cpu_s))).sum()
    }

    /// [`Choice::sentence`], and what the runs took in fact.
    pub fn compared(&self, plan: &Plan, report: &Report) -> String {
        match self.taken(plan, report) {
            Some(taken) => format!("{}; taken: {}.", self.sentence(), console::duration(taken)),
            None => format!("{}.", self.sentence()),
        }
    }
}

const KEYS: [&str; 6] = ["of", "front", "block", "quantity", "accuracy", "budget"];

/// What is asked.
enum Goal {
    /// A relative error.
    Accuracy(f64),
    /// CPU time of all runs [s].
    Budget(f64),
}

/// One `[choose.NAME]` as written.
struct Wish<'a> {
    name: &'a str,
    at: &'a At,
    steps: Vec<String>,
    front: PathBuf,
    block: (&'a str, &'a At),
    quantity: (&'a str, &'a At),
    goal: Goal,
    asked: String,
}

/// The pipeline with all its choices made.
///
/// # Errors
/// [`Mistake`] where one is written wrongly, its front was not measured with this store, or no setting of it reaches what is asked.
pub fn settled(pipeline: Pipeline, set: &[String], store: &Store) -> Result<Pipeline, Mistake> {
    let mut set = set.to_vec();
    let mut chosen = Vec::new();
    for (key, value) in &pipeline.choose.0 {
        let wish = wish(&pipeline, key, value)?;
        let choice = choose(&pipeline, &wish, store)?;
        set.extend(settings(&choice));
        chosen.push(choice);
    }
    let mut settled = pipeline::read(&pipeline.path, &set)?;
    settled.remarks.extend(chosen.iter().map(Choice::sentence));
    settled.chosen = chosen;
    Ok(settled)
}

/// The choice as arguments of `--set`.
fn settings(choice: &Choice) -> impl Iterator<Item = String> + '_ {
    choice.steps.iter().flat_map(|step| choice.settings.iter().map(move |(key, value)| format!("{step}.{key}={value}")))
}

fn wish<'a>(pipeline: &Pipeline, key: &'a Key, value: &'a Value) -> Result<Wish<'a>, Mistake> {
    let (table, own) = (value.table("[choose.NAME]")?, format!("[choose.{}]", key.text));
    table.only(&KEYS, &own)?;
    let needed = |name: &str| table.needed(name, &own, &key.at);
    let text = |name: &str| Ok::<_, Mistake>((needed(name)?.text("a name")?, &needed(name)?.at));
    let (block, quantity, front) = (text("block")?, text("quantity")?, text("front")?);
    let (goal, words) = goal(key, table)?;
    let beside = pipeline.path.parent().unwrap_or(Path::new("")).join(front.0);
    Ok(Wish {
        name: &key.text,
        at: front.1,
        steps: steps(pipeline, needed("of")?)?,
        asked: format!("{words} of {} by [tradeoff.{}] of {}", quantity.0, block.0, front.0),
        front: beside,
        block,
        quantity,
        goal,
    })
}

fn goal(key: &Key, table: &Table) -> Result<(Goal, String), Mistake> {
    match (table.get("accuracy"), table.get("budget")) {
        (Some(v), None) => {
            let text = v.text("a share: accuracy = \"2 %\"")?;
            let share = percent(text).ok_or_else(|| {
                Mistake::new(format!("`{text}` is no share above 0 and below 100 %")).at(&v.at, "as in \"2 %\"")
            })?;
            Ok((Goal::Accuracy(share), format!("accuracy {text}")))
        }
        (None, Some(v)) => {
            let text = v.text("a time: budget = \"10 min\"")?;
            let time = amount::time(text).map_err(|why| Mistake::new(format!("`{text}`: {why}")).at(&v.at, "here"))?;
            Ok((Goal::Budget(time.as_secs_f64()), format!("budget {text}")))
        }
        _ => {
            let title = format!("[choose.{}] needs either `accuracy` or `budget`", key.text);
            Err(Mistake::new(title).at(&key.at, "here").help("accuracy = \"2 %\", or budget = \"10 min\""))
        }
    }
}

/// `2 %` as 0.02.
pub fn percent(text: &str) -> Option<f64> {
    let number = text.trim().strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok());
    number.filter(|n| *n > 0.0 && *n < 100.0).map(|n| n / 100.0)
}

fn steps(pipeline: &Pipeline, value: &Value) -> Result<Vec<String>, Mistake> {
    let Node::List(items) = &value.node else {
        return Err(Mistake::new("expected a list of steps: of = [\"sweep\"]").at(&value.at, value.kind()));
    };
    let name = |v: &Value| {
        let text = v.text("the name of a step")?;
        let names = || pipeline.steps.iter().map(|s| s.name.as_str());
        if names().any(|name| name == text) {
            return Ok(text.to_string());
        }
        Err(Mistake::new(format!("there is no step `{text}`")).at(&v.at, "here").nearest(text, names()))
    };
    match items.is_empty() {
        true => Err(Mistake::new("no step gets the setting: of = [\"sweep\"]").at(&value.at, "names none")),
        false => items.iter().map(name).collect(),
    }
}

fn choose(pipeline: &Pipeline, wish: &Wish<'_>, store: &Store) -> Result<Choice, Mistake> {
    let front = region::settled(pipeline::read(&wish.front, &[])?)?;
    let plan = plan::plan(&front, &[])?;
    let blocks = tradeoff::blocks(&front, &plan)?;
    let Some(block) = blocks.iter().find(|b| b.name == wish.block.0) else {
        let mistake = Mistake::new(format!("{} has no [tradeoff.{}]", wish.front.display(), wish.block.0));
        return Err(mistake.at(wish.block.1, "here").nearest(wish.block.0, blocks.iter().map(|b| b.name.as_str())));
    };
    let forecasts = forecast::forecast(&plan, store, &Last::of(store, &front.name));
    let missing = block.nodes.iter().filter(|&&id| forecasts[id].entry().is_none()).count();
    if missing > 0 {
        let title = format!(
            "the front of [choose.{}] isn't measured: {missing} of its {} runs are missing",
            wish.name,
            block.nodes.len()
        );
        let help = format!("hvi-flow tradeoff {}", wish.front.display());
        return Err(Mistake::new(title).at(wish.at, "its results are not in the store").help(help));
    }
    let names_results = |id: &NodeId| plan.nodes[*id].swept.iter().find(|(_, value)| value.starts_with('@'));
    if let Some((swept, value)) = block.nodes.iter().find_map(names_results) {
        let title = format!("the settings of [tradeoff.{}] name results of {}", block.name, wish.front.display());
        let mistake = Mistake::new(title).at(wish.block.1, "no setting of it can be taken over");
        return Err(mistake.help(format!("one of them is {swept} = {value}")));
    }
    let outcome = tradeoff::outcome(block, &plan, &forecasts, store)?;
    let Some(quantity) = outcome.quantities.iter().find(|q| q.name == wish.quantity.0) else {
        let mistake = Mistake::new(format!("[tradeoff.{}] has no quantity `{}`", block.name, wish.quantity.0));
        return Err(mistake
            .at(wish.quantity.1, "here")
            .nearest(wish.quantity.0, outcome.quantities.iter().map(|q| q.name)));
    };
    best(candidates(pipeline, wish, &plan, &outcome, quantity)?, wish)
}

/// What each run of the front would mean for the steps.
fn candidates(
    pipeline: &Pipeline,
    wish: &Wish<'_>,
    front: &Plan,
    outcome: &Outcome<'_>,
    quantity: &Quantity,
) -> Result<Vec<Choice>, Mistake> {
    let runs = outcome.block.nodes.iter().zip(&outcome.samples).zip(quantity.points(&outcome.samples));
    let known = runs.filter(|(_, (cost, error))| cost.is_finite() && error.is_finite());
    let candidate = |((&id, sample), (cost, error)): ((&usize, &hvi_tradeoff::Sample), (f64, f64))| {
        let mut choice = Choice {
            name: wish.name.into(),
            steps: wish.steps.clone(),
            settings: front.nodes[id].swept.clone(),
            asked: wish.asked.clone(),
            error: MARGIN * error,
            foretold: 0.0,
        };
        let set: Vec<String> = settings(&choice).collect();
        let planned = |set: &[String]| plan::plan(&region::settled(pipeline::read(&pipeline.path, set)?)?, &wish.steps);
        let plan = planned(&set).map_err(|why| {
            let title = format!("the front's setting {} fits none of {}", set.join(", "), wish.steps.join(", "));
            Mistake::new(title).at(wish.block.1, "of this front").help(why.to_string())
        })?;
        let own = plan.steps.iter().filter(|s| wish.steps.contains(&s.name)).flat_map(|s| s.nodes.clone());
        // As far off as the front's run was that has the same setting.
        choice.foretold = own.map(|id| plan.nodes[id].cost * cost / sample.foretold).sum();
        Ok(choice)
    };
    let (mut fitting, mut refused) = (Vec::new(), None);
    for found in known.map(candidate) {
        match found {
            Ok(choice) => fitting.push(choice),
            Err(mistake) => refused = Some(mistake),
        }
    }
    match (fitting.is_empty(), refused) {
        (true, Some(mistake)) => Err(mistake),
        _ => Ok(fitting),
    }
}

fn best(all: Vec<Choice>, wish: &Wish<'_>) -> Result<Choice, Mistake> {
    let least = |of: fn(&Choice) -> f64, within: &dyn Fn(&&Choice) -> bool| {
        all.iter().filter(within).min_by(|a, b| of(a).total_cmp(&of(b)))
    };
    let (found, nearest) = match wish.goal {
        Goal::Accuracy(share) => (least(|c| c.foretold, &|c| c.error <= share), least(|c| c.error, &|_| true)),
        Goal::Budget(time) => (least(|c| c.error, &|c| c.foretold <= time), least(|c| c.foretold, &|_| true)),
    };
    if let Some(found) = found {
        return Ok(found.clone());
    }
    let mistake = Mistake::new(format!("no setting reaches {}", wish.asked)).at(wish.quantity.1, "asked of this");
    Err(match nearest {
        Some(nearest) => mistake.help(format!("the nearest is {}", nearest.sentence())),
        None => mistake.help("no run of the front has an error of it that is known"),
    })
}
