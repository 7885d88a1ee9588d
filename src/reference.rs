//! References: `STEP`, `STEP[*]` and `STEP[key=value, ...]`; behind `@` in pipeline files, bare on the command line.
use crate::mistake::Mistake;
use crate::plan::{NodeId, Plan, PlannedStep};
use hvi_kit::units;
use std::collections::{BTreeSet, HashMap};

/// A step and which of its points.
#[derive(Debug, PartialEq)]
pub struct Reference<'a> {
    /// Name of the step.
    pub step: &'a str,
    /// Which points.
    pub selection: Selection<'a>,
}

/// Which points of a step.
#[derive(Debug, PartialEq)]
pub enum Selection<'a> {
    /// `STEP`: the only one, or what the place says.
    None,
    /// `STEP[*]`.
    All,
    /// `STEP[key=value, ...]`: those whose sweep sets all of these.
    Where(Vec<(&'a str, &'a str)>),
}

/// Reads `STEP`, `STEP[*]` or `STEP[key=value, ...]`. Values that hold commas stand in brackets or quotes, as labels show
/// them: `film[exposures=[1 us, 2 us]]`, `hit[name='a, b']`.
///
/// # Errors
/// Why it is no reference.
pub fn parse(text: &str) -> Result<Reference<'_>, &'static str> {
    let Some((step, rest)) = text.split_once('[') else {
        return Ok(Reference { step: text.trim(), selection: Selection::None });
    };
    let inner = rest.trim_end().strip_suffix(']').ok_or("`[` is not closed")?;
    if inner.trim() == "*" {
        return Ok(Reference { step: step.trim(), selection: Selection::All });
    }
    let pairs = split(inner)?.into_iter().map(|pair| {
        let (key, value) = pair.split_once('=').ok_or("a selection is key=value")?;
        Ok((key.trim(), bare(value)))
    });
    let pairs = pairs.collect::<Result<Vec<_>, &'static str>>()?;
    Ok(Reference { step: step.trim(), selection: Selection::Where(pairs) })
}

/// The parts between commas that stand outside brackets and quotes.
fn split(text: &str) -> Result<Vec<&str>, &'static str> {
    let (mut parts, mut from, mut depth, mut quote) = (Vec::new(), 0, 0_usize, None);
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.checked_sub(1).ok_or("a bracket is closed that was not opened")?,
            (None, ',') if depth == 0 => {
                parts.push(&text[from..i]);
                from = i + 1;
            }
            _ => {}
        }
    }
    if quote.is_some() || depth > 0 {
        return Err("a quote or a bracket is not closed");
    }
    parts.push(&text[from..]);
    Ok(parts)
}

/// A value without the quotes around it.
fn bare(value: &str) -> &str {
    let value = value.trim();
    let quoted = |q: char| value.strip_prefix(q)?.strip_suffix(q);
    quoted('"').or_else(|| quoted('\'')).unwrap_or(value)
}

/// The points of swept steps by what they set: made when a step is first selected from, so that a selection costs what it
/// finds, not what there is.
#[derive(Default)]
pub struct Selector {
    /// By index of the step, key and value.
    found: HashMap<usize, HashMap<String, HashMap<Same, Vec<NodeId>>>>,
}

impl Selector {
    /// The points of step `index` of `plan` whose sweep sets all of `pairs`, in its order.
    ///
    /// # Errors
    /// [`Mistake`] where a key isn't swept, or no point fits.
    pub fn select(&mut self, plan: &Plan, index: usize, pairs: &[(&str, &str)]) -> Result<Vec<NodeId>, Mistake> {
        let step = &plan.steps[index];
        let by_key = self.found.entry(index).or_insert_with(|| by_value(plan, step));
        if let Some((key, _)) = pairs.iter().find(|(key, _)| !by_key.contains_key(*key)) {
            let keys: BTreeSet<&str> = by_key.keys().map(String::as_str).collect();
            return Err(Mistake::new(format!("`{}` does not sweep `{key}`", step.name)).nearest(key, keys));
        }
        let fitting = |(key, value): &(&str, &str)| by_key[*key].get(&Same::of(value)).map_or(&[][..], Vec::as_slice);
        let mut lists: Vec<&[NodeId]> = pairs.iter().map(fitting).collect();
        lists.sort_by_key(|list| list.len());
        let (first, rest) = lists.split_first().map_or((&[][..], &[][..]), |(first, rest)| (*first, rest));
        // Each list is in the order of the plan.
        let in_all = |id: &&NodeId| rest.iter().all(|list| list.binary_search(id).is_ok());
        let found: Vec<NodeId> = first.iter().filter(in_all).copied().collect();
        if found.is_empty() {
            let values: Vec<&str> = step.nodes.clone().take(12).map(|id| plan.nodes[id].point.as_str()).collect();
            let mistake = Mistake::new(format!("no point of `{}` fits the selection", step.name));
            return Err(mistake.help(format!("it has: {}", values.join(" | "))));
        }
        Ok(found)
    }
}

fn by_value(plan: &Plan, step: &PlannedStep) -> HashMap<String, HashMap<Same, Vec<NodeId>>> {
    let mut by_key: HashMap<String, HashMap<Same, Vec<NodeId>>> = HashMap::new();
    for id in step.nodes.clone() {
        for (key, value) in &plan.nodes[id].swept {
            let by_value = match by_key.get_mut(key) {
                Some(found) => found,
                None => by_key.entry(key.clone()).or_default(),
            };
            by_value.entry(Same::of(value)).or_default().push(id);
        }
    }
    by_key
}

/// The nodes that a reference on the command line names.
///
/// # Errors
/// [`Mistake`] where it is no reference, or names nothing.
pub fn nodes(plan: &Plan, text: &str) -> Result<Vec<NodeId>, Mistake> {
    let wrong = |why| {
        let mistake = Mistake::new(format!("`{text}` names no result: {why}"));
        mistake.help("write STEP, or STEP[key=value, ...] in quotes")
    };
    let reference = parse(text.strip_prefix('@').unwrap_or(text)).map_err(wrong)?;
    let Some(index) = plan.steps.iter().position(|s| s.name == reference.step) else {
        let names = plan.steps.iter().map(|s| s.name.as_str());
        return Err(Mistake::new(format!("there is no step `{}`", reference.step)).nearest(reference.step, names));
    };
    match reference.selection {
        Selection::None | Selection::All => Ok(plan.steps[index].nodes.clone().collect()),
        Selection::Where(pairs) => Selector::default().select(plan, index, &pairs),
    }
}

/// Whether two values as written are the same: `2.5 mm` and `0.0025 m` are.
pub fn same(a: &str, b: &str) -> bool {
    Same::of(a) == Same::of(b)
}

/// What values that are the same as written have in common: the text, the quantity, or the items of a list.
#[derive(PartialEq, Eq, Hash)]
enum Same {
    Text(String),
    /// Its SI unit, if it has one, and the bits of its value.
    Quantity(Option<&'static str>, u64),
    List(Vec<Same>),
}

impl Same {
    fn of(text: &str) -> Same {
        if let Some(items) = items(text) {
            return Same::List(items.into_iter().map(|item| Same::of(bare(item))).collect());
        }
        let quantity = || {
            let (number, unit) = units::split(text)?;
            let dimension = units::dimension(unit);
            let value: f64 = match dimension {
                Some(d) => units::si(text, d).ok()?,
                None if unit.is_empty() => number.parse().ok()?,
                None => return None,
            };
            // 0 and -0 are the same.
            Some(Same::Quantity(dimension.map(units::Dimension::si), (value + 0.0).to_bits()))
        };
        quantity().unwrap_or_else(|| Same::Text(text.into()))
    }
}

/// The items of `[a, b]`.
fn items(text: &str) -> Option<Vec<&str>> {
    split(text.trim().strip_prefix('[')?.strip_suffix(']')?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(text: &str) -> Vec<(&str, &str)> {
        match parse(text).unwrap().selection {
            Selection::Where(pairs) => pairs,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn selections_are_read() {
        assert_eq!(parse(" copper ").unwrap(), Reference { step: "copper", selection: Selection::None });
        assert_eq!(parse("runs[*]").unwrap().selection, Selection::All);
        assert_eq!(pairs("runs[a=1, b.c=2 mm]"), [("a", "1"), ("b.c", "2 mm")]);
    }

    #[test]
    fn values_may_hold_commas_in_brackets_or_quotes() {
        assert_eq!(pairs("film[t=[1 us, 2 us], w=3]"), [("t", "[1 us, 2 us]"), ("w", "3")]);
        assert_eq!(pairs("x[name='a, b]', n=\"c=d\"]"), [("name", "a, b]"), ("n", "c=d")]);
        assert_eq!(pairs("x[m={a=1, b=2}]"), [("m", "{a=1, b=2}")]);
    }

    #[test]
    fn what_is_not_closed_is_said() {
        for text in ["x[a=1", "x[a=[1]", "x[a='1]", "x[a=1]]", "x[a]", "x[]"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn values_are_the_same_in_any_unit() {
        assert!(same("2.5 mm", "0.0025 m") && same("[1 us, 2 us]", "[1000 ns,2 us]") && same("1", "1.0"));
        assert!(same("0", "-0.0") && same("copper", "copper") && same("['a', b]", "[a,b]"));
        assert!(!same("2.5 mm", "2.5 m") && !same("[1 us]", "[1 us, 2 us]") && !same("a", "b"));
        assert!(!same("1 m", "1 s") && !same("1 m", "1"));
    }
}
