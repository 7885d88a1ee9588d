//! The chain of a study drawn as boxes and arrows: steps in columns by how far they are from the start.
use crate::figure::escape;
use std::collections::HashMap;
use std::fmt::Write;

/// One step of the chain.
pub struct Node {
    /// Its name.
    pub name: String,
    /// Second line: the stage.
    pub stage: String,
    /// Third line: how many points, how many of them from the store.
    pub counts: String,
    /// CSS class of its state.
    pub class: &'static str,
    /// Names of the steps it takes from; unknown ones are left out.
    pub needs: Vec<String>,
}

const BOX_HEIGHT: f64 = 58.0;
/// Mean widths of a letter of a box's three lines.
const LETTERS: [f64; 3] = [8.5, 7.3, 6.7];
const GAP: [f64; 2] = [44.0, 20.0];

/// A place in a column: a step, or a bend of an arrow that passes the column by.
#[derive(Clone, Copy, PartialEq)]
enum Slot {
    Step(usize),
    Bend,
}

struct Layout {
    /// What stands at each place; its column, and the places that the arrows into it come from.
    slots: Vec<(Slot, usize, Vec<usize>)>,
    /// Places of each column, from the top.
    columns: Vec<Vec<usize>>,
}

/// The chain as an SVG element; empty for no steps.
pub fn svg(nodes: &[Node]) -> String {
    if nodes.is_empty() {
        return String::new();
    }
    let layout = arrange(nodes);
    let lines = nodes.iter().flat_map(|n| [&n.name, &n.stage, &n.counts].into_iter().zip(LETTERS));
    let widest = lines.map(|(text, letter)| text.chars().count() as f64 * letter).fold(0.0, f64::max);
    let wide = (widest + 26.0).clamp(130.0, 230.0).round();
    let tallest = layout.columns.iter().map(|c| height(&layout, c)).fold(0.0, f64::max);
    let width = layout.columns.len() as f64 * (wide + GAP[0]) - GAP[0] + 2.0;
    let mut at = vec![[0.0; 2]; layout.slots.len()];
    for (k, column) in layout.columns.iter().enumerate() {
        let mut y = 1.0 + 0.5 * (tallest - height(&layout, column));
        for &slot in column {
            let tall = slot_height(layout.slots[slot].0);
            at[slot] = [1.0 + k as f64 * (wide + GAP[0]), y + 0.5 * tall];
            y += tall + GAP[1];
        }
    }
    let mut out = format!(
        "<svg class=\"chain\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {h}\" width=\"{width}\" height=\"{h}\" \
         style=\"min-width:{least:.0}px\" role=\"img\" aria-label=\"The chain of steps\">\n<defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" \
         markerWidth=\"7\" markerHeight=\"7\" orient=\"auto\"><path d=\"M0 .8 7 4 0 7.2z\" class=\"tip\"/></marker></defs>\n",
        h = tallest + 2.0,
        least = 0.72 * width,
    );
    for (slot, (what, _, sources)) in layout.slots.iter().enumerate() {
        for &source in sources {
            arrow(&mut out, wide, layout.slots[source].0, at[source], *what, at[slot]);
        }
    }
    for (slot, (what, ..)) in layout.slots.iter().enumerate() {
        if let Slot::Step(k) = *what {
            draw(&mut out, wide, &nodes[k], k, at[slot]);
        }
    }
    out + "</svg>"
}

fn slot_height(slot: Slot) -> f64 {
    if slot == Slot::Bend { 0.0 } else { BOX_HEIGHT }
}

fn height(layout: &Layout, column: &[usize]) -> f64 {
    let boxes: f64 = column.iter().map(|&s| slot_height(layout.slots[s].0)).sum();
    boxes + GAP[1] * column.len().saturating_sub(1) as f64
}

fn arrow(out: &mut String, wide: f64, from: Slot, a: [f64; 2], to: Slot, b: [f64; 2]) {
    // A bend is as wide as a box, so that its arrow passes between the boxes of its column in a straight line.
    let start = a[0] + wide;
    let middle = 0.5 * (start + b[0]);
    let lead =
        if from == Slot::Bend { format!("M{} {:.1}H{start}", a[0], a[1]) } else { format!("M{start} {:.1}", a[1]) };
    let tip = if to == Slot::Bend { "" } else { " marker-end=\"url(#tip)\"" };
    let end = if to == Slot::Bend { b[0] } else { b[0] - 1.0 };
    let _ = writeln!(
        out,
        "<path class=\"arrow\" d=\"{lead}C{middle:.1} {:.1} {middle:.1} {:.1} {end} {:.1}\"{tip}/>",
        a[1], b[1], b[1]
    );
}

fn draw(out: &mut String, wide: f64, node: &Node, k: usize, at: [f64; 2]) {
    let (x, y) = (at[0], at[1] - 0.5 * BOX_HEIGHT);
    let text = |line: f64, class: &str, what: &str, letter: f64| {
        let most = ((wide - 20.0) / letter) as usize;
        let shown: String = if what.chars().count() > most {
            what.chars().take(most - 1).chain(['…']).collect()
        } else {
            what.into()
        };
        format!("<text x=\"{}\" y=\"{}\" class=\"{class}\">{}</text>", x + 14.0, y + line, escape(&shown))
    };
    let _ = writeln!(
        out,
        "<a href=\"#step-{k}\"><title>{} ({})</title><rect class=\"box\" x=\"{x}\" y=\"{y:.1}\" width=\"{}\" height=\"{}\" rx=\"6\"/>\
         <rect class=\"mark {}\" x=\"{x}\" y=\"{y:.1}\" width=\"5\" height=\"{}\" rx=\"2.5\"/>{}{}{}</a>",
        escape(&node.name),
        escape(&node.stage),
        wide,
        BOX_HEIGHT,
        node.class,
        BOX_HEIGHT,
        text(20.0, "name", &node.name, LETTERS[0]),
        text(35.0, "stage", &node.stage, LETTERS[1]),
        text(50.0, "counts", &node.counts, LETTERS[2]),
    );
}

/// Columns by the longest way from a start, with bends where an arrow passes columns; then a few sweeps that order each column by
/// the mean place of what it is joined to (Sugiyama, Tagawa, Toda, IEEE Trans. Syst. Man Cybern. 11, 109 (1981)).
fn arrange(nodes: &[Node]) -> Layout {
    let index: HashMap<&str, usize> = nodes.iter().enumerate().map(|(k, n)| (n.name.as_str(), k)).collect();
    let needs: Vec<Vec<usize>> =
        nodes.iter().map(|n| n.needs.iter().filter_map(|name| index.get(name.as_str()).copied()).collect()).collect();
    let mut depth = vec![0; nodes.len()];
    // As many rounds as there are steps reach every depth; a cycle, which the plan refuses anyway, ends too.
    for _ in 0..nodes.len() {
        let deeper = |k: usize| needs[k].iter().map(|&n| depth[n] + 1).max().unwrap_or(0).min(nodes.len() - 1);
        let next: Vec<usize> = (0..nodes.len()).map(deeper).collect();
        if next == depth {
            break;
        }
        depth = next;
    }
    let mut layout = Layout { slots: Vec::new(), columns: vec![Vec::new(); depth.iter().max().map_or(0, |d| d + 1)] };
    for k in 0..nodes.len() {
        layout.slots.push((Slot::Step(k), depth[k], Vec::new()));
        layout.columns[depth[k]].push(k);
    }
    for (k, sources) in needs.iter().enumerate() {
        for &source in sources {
            let mut from = source;
            for column in depth[source] + 1..depth[k] {
                layout.slots.push((Slot::Bend, column, vec![from]));
                from = layout.slots.len() - 1;
                layout.columns[column].push(from);
            }
            layout.slots[k].2.push(from);
        }
    }
    for sweep in 0..6 {
        order(&mut layout, sweep % 2 == 0);
    }
    layout
}

fn order(layout: &mut Layout, forwards: bool) {
    let mut joined: Vec<Vec<usize>> = vec![Vec::new(); layout.slots.len()];
    for (slot, (_, _, sources)) in layout.slots.iter().enumerate() {
        for &source in sources {
            if forwards { joined[slot].push(source) } else { joined[source].push(slot) }
        }
    }
    let mut place = vec![0.0; layout.slots.len()];
    let count = layout.columns.len();
    let turn = (0..count).map(|k| if forwards { k } else { count - 1 - k });
    for column in turn {
        let slots = &mut layout.columns[column];
        let own: HashMap<usize, f64> = slots.iter().enumerate().map(|(i, &s)| (s, spread(i, slots.len()))).collect();
        let mean = |s: usize| match joined[s].len() {
            0 => own[&s],
            n => joined[s].iter().map(|&j| place[j]).sum::<f64>() / n as f64,
        };
        slots.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
        for (i, &slot) in slots.iter().enumerate() {
            place[slot] = spread(i, slots.len());
        }
    }
}

/// Place `i` of `n` about the middle line, as it is drawn.
fn spread(i: usize, n: usize) -> f64 {
    i as f64 - 0.5 * (n as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, needs: &[&str]) -> Node {
        let needs = needs.iter().map(|n| n.to_string()).collect();
        Node { name: name.into(), stage: "md".into(), counts: String::new(), class: "ran", needs }
    }

    #[test]
    fn every_step_stands_right_of_what_it_needs() {
        let nodes =
            [node("a", &[]), node("b", &["a"]), node("d", &["c", "a"]), node("c", &["b"]), node("e", &["nobody"])];
        let layout = arrange(&nodes);
        assert_eq!(layout.slots[..5].iter().map(|s| s.1).collect::<Vec<_>>(), [0, 1, 3, 2, 0]);
        let bends = layout.slots.iter().filter(|s| s.0 == Slot::Bend).count();
        assert_eq!(bends, 2, "the arrow from a to d passes two columns");
        assert!(layout.columns.iter().flatten().count() == layout.slots.len());
    }

    #[test]
    fn any_chain_is_drawn() {
        assert_eq!(svg(&[]), "");
        let cycle = svg(&[node("a<b", &["c"]), node("c", &["a<b"])]);
        assert!(cycle.contains("a&lt;b") && !cycle.contains("NaN"));
        let many: Vec<Node> = (0..300).map(|k| node(&format!("s{k}"), &[])).collect();
        assert_eq!(svg(&many).matches("class=\"box\"").count(), 300);
    }
}
