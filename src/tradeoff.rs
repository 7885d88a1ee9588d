//! `[tradeoff.NAME]` of a pipeline: which runs, along which key; joined with what each run cost, which no result may know.
use crate::forecast::Forecast;
use crate::mistake::{At, Mistake};
use crate::pipeline::Pipeline;
use crate::plan::{Node, NodeId, Plan};
use crate::reference::{self, Selection};
use crate::value::{Key, Node as Written, Value};
use hvi_kit::view::View;
use hvi_kit::{Artifact, Store, units};
use hvi_tradeoff::{Check, Measures, Pace, Quantity, Sample, Spread, Unknown};
use std::collections::{BTreeMap, BTreeSet};

/// One `[tradeoff.NAME]`.
pub struct Block {
    /// Its name.
    pub name: String,
    /// What the runs are, in a sentence; may be empty.
    pub about: String,
    /// The runs.
    pub nodes: Vec<NodeId>,
    /// The swept key that is refined.
    pub along: String,
    /// Whether smaller values are finer.
    smaller: bool,
    /// The node whose equation of state a closed form is of.
    eos: Option<NodeId>,
    /// The block whose choices these runs check.
    check: Option<String>,
    /// Whether the runs along the key are as likely as each other, and what counts is how far apart they lie.
    pub spread: bool,
    /// Whether its choices belong on the first screen.
    pub first: bool,
    at: At,
}

/// What came of a block.
pub struct Outcome<'a> {
    /// The block.
    pub block: &'a Block,
    /// Its runs.
    pub samples: Vec<Sample>,
    /// Their quantities.
    pub quantities: Vec<Quantity>,
    /// What became of the choices of another block here, and its name.
    pub checks: Option<(String, Vec<Check>)>,
    /// How far the runs lie apart, where that is what counts.
    pub spreads: Vec<Spread>,
}

impl Outcome<'_> {
    /// Tables and figures.
    pub fn views(&self) -> Vec<View> {
        if self.block.spread {
            let table = hvi_tradeoff::spread_table(&self.block.along, &self.spreads);
            let runs = hvi_tradeoff::spread_runs(&self.block.along, &self.samples);
            let figure = hvi_tradeoff::spread_figure(&self.spreads);
            return vec![View::Table(table), View::Figure(figure), View::Table(runs)];
        }
        let checked = |(made, checks): &(String, Vec<Check>)| hvi_tradeoff::checked(made, &self.block.along, checks);
        let mut views: Vec<View> = self.checks.iter().map(|c| View::Table(checked(c))).collect();
        views.extend(hvi_tradeoff::views(&self.block.along, &self.samples, &self.quantities));
        views
    }
}

const KEYS: [&str; 8] = ["of", "along", "finer", "eos", "check", "spread", "first", "about"];

/// The blocks of `pipeline`, checked against its plan.
///
/// # Errors
/// [`Mistake`] where there are none, a key is unknown, or a run, or the key that is refined, is not there.
pub fn blocks(pipeline: &Pipeline, plan: &Plan) -> Result<Vec<Block>, Mistake> {
    let blocks: Vec<Block> =
        pipeline.tradeoff.0.iter().map(|(key, value)| block(key, value, plan)).collect::<Result<_, _>>()?;
    let names = || blocks.iter().map(|b| b.name.as_str());
    for block in &blocks {
        if let Some(wanted) = block.check.as_ref().filter(|wanted| !names().any(|name| name == *wanted)) {
            let mistake =
                Mistake::new(format!("there is no [tradeoff.{wanted}]")).at(&block.at, "checked by these runs");
            return Err(mistake.nearest(wanted, names()));
        }
    }
    if blocks.is_empty() {
        let title = format!("{} has no [tradeoff.NAME]", pipeline.path.display());
        return Err(Mistake::new(title).help("write [tradeoff.NAME] with of = \"@STEP[*]\" and along = \"KEY\""));
    }
    Ok(blocks)
}

fn block(key: &Key, value: &Value, plan: &Plan) -> Result<Block, Mistake> {
    key.plain("a block")?;
    let (table, own) = (value.table("[tradeoff.NAME]")?, format!("[tradeoff.{}]", key.text));
    table.only(&KEYS, &own)?;
    let needed = |name: &str| table.needed(name, &own, &key.at);
    let (of, along) = (needed("of")?, needed("along")?);
    let nodes = nodes(plan, of)?;
    if let Some(id) = nodes.iter().find(|id| hvi_tradeoff::names(plan.nodes[**id].stage.output).is_empty()) {
        return Err(unknown(&plan.nodes[*id], &of.at));
    }
    let flag = |name: &str| match table.get(name).map(|v| (v, &v.node)) {
        None => Ok(false),
        Some((_, Written::Bool(flag))) => Ok(*flag),
        Some((v, _)) => Err(Mistake::new(format!("`{name}` is true or false")).at(&v.at, v.kind())),
    };
    let (spread, first) = (flag("spread")?, flag("first")?);
    let text = along.text("a swept key")?;
    let swept = |id: &NodeId| settings(plan, *id, spread).iter().any(|(k, _)| *k == text);
    if !nodes.iter().all(swept) {
        let keys = nodes.iter().flat_map(|id| settings(plan, *id, spread)).map(|(k, _)| k);
        let mistake = Mistake::new(format!("the runs of [tradeoff.{}] do not sweep `{text}`", key.text));
        return Err(mistake.at(&along.at, "not swept").nearest(text, keys));
    }
    let smaller = match table.get("finer").map(|v| (v, v.text("larger or smaller"))) {
        None | Some((_, Ok("larger"))) => false,
        Some((_, Ok("smaller"))) => true,
        Some((_, Err(mistake))) => return Err(mistake),
        Some((v, Ok(_))) => return Err(Mistake::new("`finer` is \"larger\" or \"smaller\"").at(&v.at, "neither")),
    };
    let eos = match table.get("eos") {
        None => None,
        Some(v) => Some(one_eos(plan, v)?),
    };
    let about = table.get("about").map(|v| v.text("a sentence")).transpose()?.unwrap_or_default().into();
    let check = table.get("check").map(|v| v.text("the name of a block")).transpose()?.map(String::from);
    Ok(Block {
        name: key.text.clone(),
        about,
        nodes,
        along: text.into(),
        smaller,
        eos,
        check,
        spread,
        first,
        at: of.at.clone(),
    })
}

/// What the sweep of a run sets; where runs of other runs are what counts (`through`), what theirs sets, once.
fn settings(plan: &Plan, id: NodeId, through: bool) -> Vec<(&str, &str)> {
    let mut all: Vec<(&str, &str)> = Vec::new();
    for (key, value) in &plan.nodes[id].swept {
        let inner = value.strip_prefix('@').filter(|_| through).and_then(|text| reference::parse(text).ok());
        let own = match inner.map(|r| r.selection) {
            Some(Selection::Where(pairs)) => pairs,
            _ => vec![(key.as_str(), value.as_str())],
        };
        own.into_iter().for_each(|pair| {
            if !all.contains(&pair) {
                all.push(pair)
            }
        });
    }
    all
}

/// CPU time [s] of a run and, with `through`, of all it needs.
fn cost(plan: &Plan, forecasts: &[Forecast], id: NodeId, through: bool) -> f64 {
    let (mut open, mut seen, mut sum) = (vec![id], BTreeSet::from([id]), 0.0);
    while let Some(id) = open.pop() {
        let entry = forecasts[id].entry();
        sum += entry.map_or(0.0, |e| f64::from(if e.cpu_s > 0.0 { e.cpu_s } else { e.wall_s }));
        if through {
            open.extend(plan.needs(id).filter(|need| seen.insert(*need)));
        }
    }
    sum
}

/// What is said of runs that have no quantities.
fn unknown(node: &Node, at: &At) -> Mistake {
    let title = format!("no quantities are known of what `{}` makes", node.stage.name);
    Mistake::new(title).at(at, "expected runs of `impact`, `md`, `eos.gray` or `eos.survey`")
}

fn nodes(plan: &Plan, value: &Value) -> Result<Vec<NodeId>, Mistake> {
    reference::nodes(plan, value.text("a reference, as in \"@ball[*]\"")?).map_err(|m| m.at(&value.at, "here"))
}

fn one_eos(plan: &Plan, value: &Value) -> Result<NodeId, Mistake> {
    match nodes(plan, value)?[..] {
        [id] if plan.nodes[id].stage.output == hvi_eos::EosResult::KIND => Ok(id),
        _ => Err(Mistake::new("`eos` is one equation of state").at(&value.at, "this is not")),
    }
}

/// Whether a quantity `wanted`, as QUANTITY or BLOCK.QUANTITY, may come of runs of `blocks`.
///
/// # Errors
/// [`Mistake`] with those that there are, or where no quantities are known of what a block's runs make.
pub fn knows(blocks: &[Block], plan: &Plan, wanted: &str) -> Result<(), Mistake> {
    let mut full = Vec::new();
    for block in blocks {
        let names = block.nodes.iter().flat_map(|id| hvi_tradeoff::names(plan.nodes[*id].stage.output));
        let names: BTreeSet<&str> = names.copied().collect();
        if names.contains(wanted) {
            return Ok(());
        }
        full.extend(names.into_iter().map(|name| format!("{}.{name}", block.name)));
    }
    if full.iter().any(|name| name == wanted) {
        return Ok(());
    }
    let mistake = Mistake::new(format!("there is no quantity `{wanted}`"));
    Err(mistake.nearest(wanted, full.iter().map(String::as_str)))
}

/// Measures the runs of `block`, all of which have results.
///
/// # Errors
/// [`Mistake`] where no quantities are known of such results, or one can't be read.
pub fn outcome<'a>(
    block: &'a Block,
    plan: &Plan,
    forecasts: &[Forecast],
    store: &Store,
) -> Result<Outcome<'a>, Mistake> {
    let unreadable = |e: hvi_kit::LoadError| Mistake::new(format!("[tradeoff.{}]: {e}", block.name));
    let eos = match block.eos.and_then(|id| forecasts[id].entry()) {
        Some(entry) => Some(hvi_kit::load::<hvi_eos::EosResult>(store, entry.output).map_err(unreadable)?.eos),
        None => None,
    };
    let coupled = coupled(block, plan);
    let mut samples = Vec::new();
    for &id in &block.nodes {
        let (node, Some(entry)) = (&plan.nodes[id], forecasts[id].entry()) else { continue };
        let kind = node.stage.output;
        let measures: Measures =
            hvi_tradeoff::of_kind(kind, entry.output, store, eos.as_ref()).map_err(|e| match e {
                Unknown::Load(e) => unreadable(e),
                Unknown::Kind => unknown(node, &block.at),
            })?;
        let swept = settings(plan, id, block.spread);
        let of = |wanted: bool| swept.iter().filter(move |(k, _)| (*k == block.along) == wanted);
        let setting = of(true).map(|(_, v)| v.to_string()).next().unwrap_or_default();
        let group = of(false)
            .filter(|(k, _)| !coupled.contains(k))
            .map(|(k, v)| format!("{k}={v}"))
            .collect::<Vec<_>>()
            .join(", ");
        let number = si(&setting).filter(|x| *x > 0.0);
        let h = number.map(|x| if block.smaller { x } else { 1.0 / x });
        let cost = cost(plan, forecasts, id, block.spread);
        let key = forecasts[id].key.map(|k| k.to_string()).unwrap_or_default();
        samples.push(Sample { setting, group, h, measures, cost, foretold: node.cost, key });
    }
    let (quantities, spreads) = match block.spread {
        true => (Vec::new(), hvi_tradeoff::spreads(&samples)),
        false => (hvi_tradeoff::study(&samples), Vec::new()),
    };
    Ok(Outcome { block, samples, quantities, checks: None, spreads })
}

/// A setting as a number, in SI where it has a unit: a sweep may mix `500 fs` and `1 ps`.
fn si(setting: &str) -> Option<f64> {
    let (number, unit) = units::split(setting)?;
    match units::dimension(unit) {
        Some(dimension) => units::si(setting, dimension).ok(),
        None => number.parse().ok(),
    }
}

/// Swept keys that go with the one that is refined: each of its values with one of theirs and the other way round.
fn coupled<'a>(block: &Block, plan: &'a Plan) -> Vec<&'a str> {
    let value = |id: &NodeId, key: &str| {
        plan.nodes[*id].swept.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str()).unwrap_or_default()
    };
    let go_together = |key: &str| {
        let (mut there, mut back) = (BTreeMap::new(), BTreeMap::new());
        let pairs = || block.nodes.iter().map(|id| (value(id, &block.along), value(id, key)));
        pairs().all(|(a, b)| *there.entry(a).or_insert(b) == b && *back.entry(b).or_insert(a) == a)
    };
    let keys: BTreeSet<&str> = plan.nodes[block.nodes[0]].swept.iter().map(|(k, _)| k.as_str()).collect();
    keys.into_iter().filter(|key| *key != block.along && go_together(key)).collect()
}

/// Holds the choices of blocks against the runs of those that check them.
pub fn check(outcomes: &mut [Outcome<'_>]) {
    for k in 0..outcomes.len() {
        let Some(wanted) = outcomes[k].block.check.clone() else { continue };
        if let Some(made) = outcomes.iter().find(|o| o.block.name == wanted) {
            let here = &outcomes[k];
            let checks = hvi_tradeoff::check((&made.samples, &made.quantities), (&here.samples, &here.quantities));
            outcomes[k].checks = Some((wanted, checks));
        }
    }
}

/// By stage, how its predicted core-seconds compare with those that the plan's results took.
pub fn paces(plan: &Plan, forecasts: &[Forecast]) -> Vec<(&'static str, Pace)> {
    let mut runs: BTreeMap<&'static str, Vec<(f64, f64)>> = BTreeMap::new();
    for (node, forecast) in plan.nodes.iter().zip(forecasts) {
        if let Some(entry) = forecast.entry() {
            runs.entry(node.stage.name).or_default().push((node.cost, f64::from(entry.cpu_s)));
        }
    }
    runs.into_iter().filter_map(|(stage, runs)| Some((stage, hvi_tradeoff::pace(&runs)?))).collect()
}
