//! One step's results as Markdown, for a document that is kept beside the code.
use super::{Step, Study, parts};
use crate::figure::{number, uncertain, unit};
use hvi_kit::view::{Cell, Table, View};
use std::fmt::Write;

/// Heading, question, and every table of `step`; figures and pictures are named only.
pub fn markdown(study: &Study, step: &Step) -> String {
    let mut out = format!("# {}\n\n", plain(&title(&study.name, &step.name)));
    for paragraph in study.question.split("\n\n").map(str::trim).filter(|p| !p.is_empty()) {
        let _ = writeln!(out, "{}\n", plain(paragraph));
    }
    let work: f64 = study.steps.iter().flat_map(|s| &s.points).map(|p| p.seconds).sum();
    let _ = writeln!(
        out,
        "Made by `{}` and `hvi-flow report --markdown {}`; {} results, {} of computing, all told.\n",
        study.command,
        step.name,
        study.steps.iter().map(|s| s.points.len()).sum::<usize>(),
        parts::time(work)
    );
    for point in &step.points {
        if !point.label.is_empty() {
            let _ = writeln!(out, "## {}\n", plain(&point.label));
        }
        let scalars: Vec<String> =
            point.scalars.iter().map(|s| format!("{}: {} {}", s.name, cell(&s.value), unit(&s.unit))).collect();
        if !scalars.is_empty() {
            let _ = writeln!(out, "{}.\n", plain(&scalars.join("; ").replace(" ;", ";")));
        }
        for view in &point.views {
            match view {
                View::Table(t) => table(&mut out, t),
                View::Figure(f) => _ = writeln!(out, "Figure in the report: {}.\n", plain(&f.title)),
                View::Picture(p) => _ = writeln!(out, "Picture in the report: {}.\n", plain(&p.title)),
                View::Drawing(d) => _ = writeln!(out, "Drawing in the report: {}.\n", plain(&d.title)),
                View::Trajectory(t) => _ = writeln!(out, "Trajectory beside the report: {}.\n", plain(&t.title)),
                View::Text(t) => _ = writeln!(out, "File beside the report: {}.\n", plain(&t.title)),
                View::Cloud(c) => _ = writeln!(out, "Particles beside the report: {}.\n", plain(&c.title)),
            }
        }
    }
    out.trim_end().to_string() + "\n"
}

fn title(study: &str, step: &str) -> String {
    let mut letters = step.chars();
    let step = letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect());
    format!("{step} of {study}")
}

fn table(out: &mut String, t: &Table) {
    let head = |(name, symbol): &(String, String)| match symbol.as_str() {
        "" => plain(name),
        symbol => format!("{} [{}]", plain(name), plain(&unit(symbol))),
    };
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let _ = writeln!(out, "## {}\n", plain(&t.title));
    *out += &row(t.columns.iter().map(head).collect());
    *out += &row(vec!["---".into(); t.columns.len()]);
    for cells in &t.rows {
        let symbol = |k: usize, text: &str| t.columns.get(k).is_some_and(|c| c.0 == "unit").then(|| unit(text));
        let text = |(k, c): (usize, &Cell)| match c {
            Cell::Text(text) => plain(&symbol(k, text).unwrap_or_else(|| text.clone())),
            c => cell(c),
        };
        *out += &row(cells.iter().enumerate().map(text).collect());
    }
    out.push('\n');
    if !t.note.is_empty() {
        let _ = writeln!(out, "{}\n", plain(&t.note));
    }
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Number(x) => number(*x, 4),
        Cell::Uncertain(x, e) => uncertain(*x, *e),
        Cell::Text(t) => plain(t),
        Cell::Empty => String::new(),
    }
}

/// One line without what Markdown would read as its own.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\r' => out.push(' '),
            '|' | '<' | '*' | '_' | '`' | '[' | ']' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_survive_their_own_marks() {
        let mut out = String::new();
        let columns = vec![("what".into(), String::new()), ("unit".into(), String::new()), ("P".into(), "GPa".into())];
        let rows = vec![vec!["a|b <c>\nd".into(), "cm3/g".into(), Cell::Uncertain(1.25, 0.1)]];
        table(&mut out, &Table { title: "T_1".into(), columns, rows, note: "n".into() });
        assert_eq!(
            out,
            "## T\\_1\n\n| what | unit | P [GPa] |\n| --- | --- | --- |\n| a\\|b \\<c> d | cm³/g | 1.25 ± 0.10 |\n\nn\n\n"
        );
    }
}
