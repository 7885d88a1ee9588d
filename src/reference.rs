//! References: `STEP`, `STEP[*]` and `STEP[key=value, ...]`; behind `@` in pipeline files, bare on the command line.
use crate::mistake::Mistake;
use crate::plan::{NodeId, Plan, PlannedStep};
use hvi_kit::units;
use std::collections::BTreeSet;

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

/// The points of `step` whose sweep sets all of `pairs`, in its order.
///
/// # Errors
/// [`Mistake`] where a key isn't swept, or no point fits.
pub fn select(plan: &Plan, step: &PlannedStep, pairs: &[(&str, &str)]) -> Result<Vec<NodeId>, Mistake> {
    let swept = |id: NodeId| &plan.nodes[id].swept;
    let is_swept = |key: &str| step.nodes.clone().any(|id| swept(id).iter().any(|(k, _)| k == key));
    if let Some((key, _)) = pairs.iter().find(|(key, _)| !is_swept(key)) {
        let keys: BTreeSet<&str> = step.nodes.clone().flat_map(swept).map(|(k, _)| k.as_str()).collect();
        return Err(Mistake::new(format!("`{}` does not sweep `{key}`", step.name)).nearest(key, keys));
    }
    let fits =
        |id: &NodeId| pairs.iter().all(|(key, value)| swept(*id).iter().any(|(k, v)| k == key && same(v, value)));
    let found: Vec<NodeId> = step.nodes.clone().filter(fits).collect();
    if found.is_empty() {
        let values: Vec<&str> = step.nodes.clone().take(12).map(|id| plan.nodes[id].point.as_str()).collect();
        let mistake = Mistake::new(format!("no point of `{}` fits the selection", step.name));
        return Err(mistake.help(format!("it has: {}", values.join(" | "))));
    }
    Ok(found)
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
    let Some(step) = plan.steps.iter().find(|s| s.name == reference.step) else {
        let names = plan.steps.iter().map(|s| s.name.as_str());
        return Err(Mistake::new(format!("there is no step `{}`", reference.step)).nearest(reference.step, names));
    };
    match reference.selection {
        Selection::None | Selection::All => Ok(step.nodes.clone().collect()),
        Selection::Where(pairs) => select(plan, step, &pairs),
    }
}

/// Whether two values as written are the same: as text, as quantities, or as lists of such.
fn same(a: &str, b: &str) -> bool {
    let quantity = |text: &str| {
        let (number, unit) = units::split(text)?;
        match units::dimension(unit) {
            Some(d) => units::si(text, d).ok(),
            None if unit.is_empty() => number.parse().ok(),
            None => None,
        }
    };
    if let (Some(a), Some(b)) = (items(a), items(b)) {
        return a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same(bare(a), bare(b)));
    }
    a == b || matches!((quantity(a), quantity(b)), (Some(x), Some(y)) if x == y)
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
        assert!(!same("2.5 mm", "2.5 m") && !same("[1 us]", "[1 us, 2 us]") && !same("a", "b"));
    }
}
