//! What an uncertain input does: runs that are as likely as each other, and how far apart their answers lie.
use crate::{Measure, Sample, median};
use hvi_kit::view::{Axis, Cell, Figure, Series, Style, Table};

/// One quantity over the runs of one group.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// What the group's runs have in common.
    pub group: String,
    /// The quantity and its unit.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Runs.
    pub runs: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// CPU time of one run and of all it needs, the median [s].
    pub cost: f64,
}

/// Spreads of every quantity, group by group, of groups of two runs or more.
pub fn spreads(samples: &[Sample]) -> Vec<Spread> {
    let mut names: Vec<(&'static str, &'static str)> = Vec::new();
    let mut groups: Vec<&str> = Vec::new();
    for s in samples {
        if !groups.contains(&s.group.as_str()) {
            groups.push(&s.group);
        }
        for m in s.measures.all.iter().filter(|m| m.exact.is_none()) {
            if !names.contains(&(m.name, m.unit)) {
                names.push((m.name, m.unit));
            }
        }
    }
    let each = names.iter().flat_map(|&name| groups.iter().map(move |&group| (name, group)));
    each.filter_map(|((name, unit), group)| spread(samples, name, unit, group)).collect()
}

fn spread(samples: &[Sample], name: &'static str, unit: &'static str, group: &str) -> Option<Spread> {
    let of = |s: &Sample| s.measures.all.iter().find(|m| m.name == name).map(|m| m.value);
    let here: Vec<&Sample> = samples.iter().filter(|s| s.group == group).collect();
    let values: Vec<f64> = here.iter().filter_map(|s| of(s)).collect();
    let runs = values.len();
    if runs < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / runs as f64;
    let squares = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    let cost = median(here.iter().map(|s| s.cost).collect());
    let deviation = (squares / (runs - 1) as f64).sqrt();
    Some(Spread { group: group.into(), name, unit, runs, mean, deviation, cost })
}

/// The spreads as a table.
pub fn spread_table(along: &str, all: &[Spread]) -> Table {
    let row = |s: &Spread| -> Vec<Cell> {
        vec![
            s.name.into(),
            s.unit.into(),
            s.group.as_str().into(),
            (s.runs as f64).into(),
            Cell::Uncertain(s.mean, s.deviation),
            (100.0 * s.deviation / s.mean.abs()).into(),
            s.cost.into(),
        ]
    };
    let columns = [
        ("quantity", ""),
        ("unit", ""),
        ("by", ""),
        ("runs", ""),
        ("mean and standard deviation", ""),
        ("deviation", "%"),
        ("CPU time, all it needs", "s"),
    ];
    Table {
        title: "Spread".into(),
        columns: columns.map(|(name, unit)| (name.to_string(), unit.to_string())).into(),
        rows: all.iter().map(row).collect(),
        note: format!(
            "Runs that differ in `{along}` are as likely as each other: their standard deviation is what the uncertainty that they are drawn \
             from does to the answer. The time is that of one run with everything before it, from the records."
        ),
    }
}

/// Every run: its quantities, and the key of its recipe.
pub fn spread_runs(along: &str, samples: &[Sample]) -> Table {
    let measured: Vec<&Measure> = samples.iter().take(1).flat_map(|s| &s.measures.all).collect();
    let mut columns: Vec<(String, String)> = vec![(along.into(), String::new()), ("by".into(), String::new())];
    columns.push(("CPU time, all it needs".into(), "s".into()));
    columns.extend(measured.iter().map(|m| (m.name.to_string(), m.unit.to_string())));
    columns.push(("recipe".into(), String::new()));
    let row = |s: &Sample| -> Vec<Cell> {
        let value = |name: &str| s.measures.all.iter().find(|m| m.name == name).map_or(Cell::Empty, |m| m.value.into());
        let mut cells: Vec<Cell> = vec![s.setting.as_str().into(), s.group.as_str().into(), s.cost.into()];
        cells.extend(measured.iter().map(|m| value(m.name)));
        cells.push(s.short_key().into());
        cells
    };
    let note = "The recipe's key names the result in the store.".into();
    Table { title: "Runs".into(), columns, rows: samples.iter().map(row).collect(), note }
}

/// Relative deviation against the time it took, a curve a quantity.
pub fn spread_figure(all: &[Spread]) -> Figure {
    let mut series: Vec<Series> = Vec::new();
    for s in all {
        let point = (s.cost, 100.0 * s.deviation / s.mean.abs());
        match series.iter_mut().find(|other| other.label == s.name) {
            Some(own) => own.points.push(point),
            None => series.push(Series::new(s.name, Style::Circles, vec![point])),
        }
    }
    series.iter_mut().for_each(|s| s.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let log = |label: &str, unit: &str| Axis { label: label.into(), unit: unit.into(), log: true };
    Figure {
        title: "Spread against time".into(),
        x: log("CPU time of one run and all it needs", "s"),
        y: log("standard deviation", "%"),
        series,
        note: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Measure, Measures};

    /// Three runs at 1, 2 and 3 and two at 4 and 4: mean, deviation and the median cost of each group.
    #[test]
    fn mean_and_deviation_by_group() {
        let run = |group: &str, value: f64, cost: f64| Sample {
            setting: String::new(),
            group: group.into(),
            h: None,
            measures: Measures { all: vec![Measure::free("eta", "", value)], work: 1.0, unit: "steps" },
            cost,
            foretold: 1.0,
            key: String::new(),
        };
        let samples =
            [run("a", 1.0, 5.0), run("a", 2.0, 9.0), run("b", 4.0, 1.0), run("a", 3.0, 7.0), run("b", 4.0, 1.0)];
        let all = spreads(&samples);
        assert_eq!(all.len(), 2);
        assert_eq!((all[0].runs, all[0].mean, all[0].deviation, all[0].cost), (3, 2.0, 1.0, 7.0));
        assert_eq!((all[1].runs, all[1].mean, all[1].deviation), (2, 4.0, 0.0));
        assert!(spreads(&samples[..1]).is_empty());
    }
}
