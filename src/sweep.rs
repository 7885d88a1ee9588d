//! Sweeps: `sweep` (a product), `zip` (side by side) and `points` (one by one) become a list of points.
use crate::mistake::{At, Mistake};
use crate::reference::{self, Selection};
use crate::value::{Key, Node, Table, Value};
use hvi_kit::units;

/// Keys and values that one point of a sweep sets, in the order written.
pub type Point = Vec<(Key, Value)>;

/// More points than anybody means.
const MOST: usize = 1_000_000;

/// Takes `sweep`, `zip` and `points` out of a step and expands them; no sweep gives one empty point.
///
/// All given together multiply; the first axis written varies slowest. An axis `"@STEP[*]"` or `"@STEP[key=value]"` has a value for
/// each of that step's points that `points_of` knows.
///
/// # Errors
/// [`Mistake`] where an axis is empty, lengths differ, a range can't be read, or there are too many points.
pub fn expand<'a>(step: &mut Table, points_of: &dyn Fn(&str) -> Option<&'a [Point]>) -> Result<Vec<Point>, Mistake> {
    let mut points: Vec<Point> = vec![Vec::new()];
    if let Some((_, value)) = step.take("sweep") {
        for (key, axis) in &value.table("a table: sweep = { key = [values] }")?.0 {
            let axis = axis_points(key, axis, points_of)?;
            points = product(&points, &axis, &key.at)?;
        }
    }
    if let Some((key, value)) = step.take("zip") {
        let mut rows: Vec<Point> = Vec::new();
        for (i, (k, axis)) in value.table("a table: zip = { key = [values], other = [values] }")?.0.iter().enumerate() {
            let axis = axis_points(k, axis, points_of)?;
            if i == 0 {
                rows = axis;
            } else if axis.len() == rows.len() {
                rows.iter_mut().zip(axis).for_each(|(row, more)| row.extend(more));
            } else {
                let title = format!("the lists of `zip` differ in length: {} and {}", rows.len(), axis.len());
                return Err(Mistake::new(title).at(&k.at, format!("{} values", axis.len())));
            }
        }
        points = product(&points, &rows, &key.at)?;
    }
    if let Some((key, value)) = step.take("points") {
        let Node::List(items) = &value.node else {
            return Err(
                Mistake::new("expected a list of tables: points = [{ key = value }]").at(&value.at, value.kind())
            );
        };
        let rows = items.iter().map(|v| Ok(v.table("a table: { key = value }")?.0.clone()));
        let rows = rows.collect::<Result<Vec<Point>, Mistake>>()?;
        points = product(&points, &rows, &key.at)?;
    }
    Ok(points)
}

fn product(points: &[Point], axis: &[Point], at: &At) -> Result<Vec<Point>, Mistake> {
    if axis.is_empty() {
        return Err(Mistake::new("a sweep needs one value or more").at(at, "this has none"));
    }
    let many = points.len().saturating_mul(axis.len());
    if many > MOST {
        let title = format!("the sweep has {many} points or more; {MOST} are allowed");
        return Err(Mistake::new(title).at(at, "with this axis"));
    }
    let set_before = |key: &Key| points.iter().flatten().any(|(k, _)| k.text == key.text);
    if let Some((key, _)) = axis.iter().flatten().find(|(k, _)| set_before(k)) {
        return Err(Mistake::new(format!("`{}` is swept twice", key.text)).at(&key.at, "the second time"));
    }
    let both = |p: &Point, more: &Point| p.iter().chain(more).cloned().collect();
    Ok(points.iter().flat_map(|p| axis.iter().map(move |more| both(p, more))).collect())
}

fn axis_points<'a>(
    key: &Key,
    axis: &Value,
    points_of: &dyn Fn(&str) -> Option<&'a [Point]>,
) -> Result<Vec<Point>, Mistake> {
    let values = match &axis.node {
        Node::List(items) => items.clone(),
        Node::Text(text) if text.starts_with('@') => each(&text[1..], axis, points_of)?,
        Node::Text(text) => range(text, &axis.at)?,
        _ => {
            let title =
                format!("expected a list of values for `{}`, or a range such as \"1 km/s .. 8 km/s in 8\"", key.text);
            return Err(Mistake::new(title).at(&axis.at, format!("this is {}", axis.kind())));
        }
    };
    Ok(values.into_iter().map(|v| vec![(key.clone(), v)]).collect())
}

/// `STEP[*]` or `STEP[key=value, ...]`: a reference to each of those points.
fn each<'a>(text: &str, axis: &Value, points_of: &dyn Fn(&str) -> Option<&'a [Point]>) -> Result<Vec<Value>, Mistake> {
    let wrong = |why: String| Mistake::new(why).at(&axis.at, "here");
    let wanted = reference::parse(text).map_err(|why| wrong(format!("`@{text}`: {why}")))?;
    let Some(points) = points_of(wanted.step) else {
        return Err(wrong(format!("there is no step `{}` above this one, whose points could be swept", wanted.step)));
    };
    let pairs = match wanted.selection {
        Selection::Where(pairs) => pairs,
        Selection::All | Selection::None => Vec::new(),
    };
    let has =
        |p: &Point, key: &str, value: &str| p.iter().any(|(k, v)| k.text == key && reference::same(&v.label(), value));
    let fits = |p: &&Point| pairs.iter().all(|(key, value)| has(p, key, value));
    let value = |p: &Point| Value { node: Node::Text(format!("@{}[{}]", wanted.step, label(p))), at: axis.at.clone() };
    let values: Vec<Value> = points.iter().filter(fits).map(value).collect();
    match points.iter().find(|p| p.is_empty()) {
        Some(_) => Err(wrong(format!("`{}` sweeps nothing: write [\"@{}\"]", wanted.step, wanted.step))),
        None if values.is_empty() => Err(wrong(format!("no point of `{}` fits the selection", wanted.step))),
        None => Ok(values),
    }
}

/// `"1 km/s .. 8 km/s in 8"`: evenly spaced values, both ends included, in the unit they are written in.
fn range(text: &str, at: &At) -> Result<Vec<Value>, Mistake> {
    let wrong = |why: &str| {
        let title = format!("`{text}` is no range: {why}");
        Mistake::new(title).at(at, "expected \"FIRST .. LAST in COUNT\", or a list")
    };
    let (first, rest) = text.split_once("..").ok_or_else(|| wrong("it has no `..`"))?;
    let (last, count) = rest.rsplit_once(" in ").ok_or_else(|| wrong("it has no ` in COUNT`"))?;
    let count: usize = count.trim().parse().map_err(|_| wrong("COUNT must be a whole number"))?;
    let (a, unit) = units::split(first).ok_or_else(|| wrong("FIRST must be a number, with its unit if it has one"))?;
    let (b, other) = units::split(last).ok_or_else(|| wrong("LAST must be a number, with its unit if it has one"))?;
    if unit != other {
        return Err(wrong("both ends must be in the same unit"));
    }
    if !(2..=MOST).contains(&count) {
        return Err(wrong(&format!("COUNT must be 2 to {MOST}")));
    }
    let whole = a.parse::<i64>().is_ok() && b.parse::<i64>().is_ok();
    let (a, b): (f64, f64) = (a.parse().map_err(|_| wrong("FIRST"))?, b.parse().map_err(|_| wrong("LAST"))?);
    let value = |i: usize| {
        let x = a + (b - a) * i as f64 / (count - 1) as f64;
        // 12 digits: a step that is round for people stays round, whatever the rounding of the line above.
        let x: f64 = format!("{x:.11e}").parse().expect("a printed number reads back");
        let node = match unit {
            "" if whole && x.fract() == 0.0 => Node::Integer(x as i64),
            "" => Node::Float(x),
            unit => Node::Text(format!("{x} {unit}")),
        };
        Value { node, at: at.clone() }
    };
    Ok((0..count).map(value).collect())
}

/// `velocity=2.5 km/s, diameter=1.6 mm`; empty for the only point of a step without a sweep. A text that a selection would
/// read otherwise stands in quotes.
pub fn label(point: &Point) -> String {
    let value = |v: &Value| match &v.node {
        Node::Text(text) if text.contains([',', '[', ']', '{', '}', '"']) && !text.contains('\'') => {
            format!("'{text}'")
        }
        _ => v.label(),
    };
    point.iter().map(|(k, v)| format!("{}={}", k.text, value(v))).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mistake::Source;
    use std::sync::Arc;

    fn labels(text: &str) -> Result<Vec<String>, String> {
        let source = Arc::new(Source { name: "test".into(), text: text.into() });
        let at = || At { source: source.clone(), span: 0..0 };
        let mut table = crate::value::parse(&source).map_err(|m| m.to_string())?;
        let point = |a: i64, b: &str| {
            let pair = |k: &str, node| (Key { text: k.into(), at: at() }, Value { node, at: at() });
            vec![pair("a", Node::Integer(a)), pair("b", Node::Text(b.into()))]
        };
        let above = [point(1, "1 km/s"), point(1, "2 km/s"), point(2, "1 km/s")];
        let points_of = |name: &str| (name == "above").then_some(&above[..]);
        Ok(expand(&mut table, &points_of).map_err(|m| m.to_string())?.iter().map(label).collect())
    }

    #[test]
    fn products_zips_and_points_multiply() {
        let all = labels("sweep = { a = [1, 2], \"b.c\" = \"1 km/s .. 2 km/s in 3\" }").unwrap();
        assert_eq!(all[..4], ["a=1, b.c=1 km/s", "a=1, b.c=1.5 km/s", "a=1, b.c=2 km/s", "a=2, b.c=1 km/s"]);
        assert_eq!(labels("zip = { a = [1, 2], b = [3, 4] }").unwrap(), ["a=1, b=3", "a=2, b=4"]);
        assert_eq!(labels("points = [{ a = 1 }, { b = 2 }]").unwrap(), ["a=1", "b=2"]);
        assert_eq!(labels("a = 1").unwrap(), [""]);
    }

    #[test]
    fn ranges_keep_round_numbers_round() {
        let all = labels("sweep = { r = \"1.06 .. 0.64 in 15\" }").unwrap();
        assert_eq!(all[1], "r=1.03");
        assert_eq!(all[14], "r=0.64");
        assert_eq!(labels("sweep = { n = \"2 .. 4 in 3\" }").unwrap(), ["n=2", "n=3", "n=4"]);
    }

    #[test]
    fn the_points_of_a_step_make_an_axis() {
        let all = labels("sweep = { eos = \"@above[*]\" }").unwrap();
        assert_eq!(all.len(), 3);
        assert_eq!(all[1], "eos='@above[a=1, b=2 km/s]'");
        assert_eq!(labels("sweep = { eos = \"@above[b=1000 m/s]\" }").unwrap().len(), 2);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, part) in [
            ("sweep = { a = \"@below[*]\" }", "no step `below` above"),
            ("sweep = { a = \"@above[a=7]\" }", "no point of `above` fits"),
            ("sweep = { a = \"1 km/s .. 8 m/s in 8\" }", "same unit"),
            ("sweep = { a = \"1 .. 8\" }", "in COUNT"),
            ("sweep = { a = [] }", "one value or more"),
            ("sweep = { a = 3 }", "expected a list"),
            ("zip = { a = [1], b = [1, 2] }", "differ in length"),
            ("sweep = { a = [1] }\npoints = [{ b = 1 }, { a = 2 }]", "`a` is swept twice"),
            ("sweep = { a = \"1 .. 8 in 1000\", b = \"1 .. 8 in 1000000\" }", "1000000000 points"),
        ] {
            assert!(labels(text).unwrap_err().contains(part), "{text}");
        }
    }
}
