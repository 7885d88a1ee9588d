//! What a verdict shows: the table of all results, and how many of them came out.
use crate::verdict::{Found, Reproduced, Row, Verdict};
use hvi_kit::view::{Cell, Scalar, Table, View};

/// How many quantities each column reproduces.
pub fn scalars(verdict: &Verdict) -> Vec<Scalar> {
    let mut all = Vec::new();
    for (k, column) in ["by the paper's choices", "by the best known"].into_iter().enumerate() {
        for kind in [Reproduced::Yes, Reproduced::Nearly, Reproduced::No] {
            let count = verdict.rows.iter().filter(|r| r.verdicts[k] == kind).count();
            all.push(Scalar::number(&format!("{column}: {}", kind.describe()), count as f64, ""));
        }
    }
    all
}

/// The table, with the reasons below it.
pub fn views(verdict: &Verdict) -> Vec<View> {
    let columns =
        ["result", "quantity", "unit", "paper", "paper's choices", "best", "verdict on the choices", "on the best"];
    let table = Table {
        title: "Published and computed".into(),
        columns: columns.map(|c| (c.to_string(), String::new())).to_vec(),
        rows: verdict.rows.iter().map(row).collect(),
        note: "Reproduced: within what the published file allows, or within two standard errors; near: within three times as much. \
               Differs is no failure where the best known is nearer to experiment: the reasons are below."
            .into(),
    };
    let mut reasons: Vec<(Vec<&str>, &str)> = Vec::new();
    for r in verdict.rows.iter().filter(|r| !r.why.is_empty()) {
        match reasons.iter_mut().find(|(_, why)| *why == r.why) {
            Some((quantities, _)) => quantities.push(&r.quantity),
            None => reasons.push((vec![&r.quantity], &r.why)),
        }
    }
    let why = Table {
        title: "What makes the difference".into(),
        columns: ["quantity", "why"].map(|c| (c.to_string(), String::new())).to_vec(),
        rows: reasons.into_iter().map(|(q, why)| vec![q.join("; ").into(), why.into()]).collect(),
        note: String::new(),
    };
    let sources = Table {
        title: "Where it was published".into(),
        columns: ["result", "quantity", "source and status"].map(|c| (c.to_string(), String::new())).to_vec(),
        rows: verdict
            .rows
            .iter()
            .map(|r| vec![r.result.as_str().into(), r.quantity.as_str().into(), r.source.as_str().into()])
            .collect(),
        note: String::new(),
    };
    vec![View::Table(table), View::Table(why), View::Table(sources)]
}

fn row(r: &Row) -> Vec<Cell> {
    let cell = |found: Option<Found>| match found {
        Some(Found { value, error }) if error > 0.0 => Cell::Uncertain(value, error),
        Some(Found { value, .. }) => Cell::Number(value),
        None => Cell::Empty,
    };
    let mut cells: Vec<Cell> = vec![
        r.result.as_str().into(),
        r.quantity.as_str().into(),
        r.unit.as_str().into(),
        r.published.as_str().into(),
        cell(r.paper),
        cell(r.best),
    ];
    cells.extend(r.verdicts.iter().map(|v| Cell::from(v.describe())));
    cells
}
