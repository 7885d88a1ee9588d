//! Errors of a set of runs at several settings, quantity by quantity.
use crate::front::{front, knee};
use crate::limit::{How, Limit, Order, limit, order};
use crate::{Measure, Measures};

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Its setting of what is refined, as written.
    pub setting: String,
    /// Its other settings, as written; runs of one group differ in what is refined alone.
    pub group: String,
    /// Size that goes to 0 as the setting is refined; `None` where the setting is no number.
    pub h: Option<f64>,
    /// Its quantities.
    pub measures: Measures,
    /// CPU time [s].
    pub cost: f64,
    /// Core-seconds that its stage predicts.
    pub foretold: f64,
    /// What identifies it.
    pub key: String,
}

/// One quantity over all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Where it leads.
    pub reference: Limit,
    /// What errors are relative to.
    pub scale: f64,
    /// By sample, `None` where a run doesn't have it.
    pub rows: Vec<Option<Row>>,
    /// By group, in order: the observed order.
    pub orders: Vec<(String, Option<Order>)>,
    /// Samples on the front of error against cost, by rising cost.
    pub front: Vec<usize>,
    /// Where on it to stop.
    pub knee: Option<usize>,
}

/// One quantity of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its value.
    pub value: f64,
    /// Its relative error; where the reference is no closed form, with the reference's own uncertainty in quadrature.
    pub error: f64,
    /// The uncertainty of that error: of the reference and of the run itself, relative.
    pub uncertainty: f64,
}

impl Sample {
    /// As much of the key as tells results apart.
    pub(crate) fn short_key(&self) -> &str {
        self.key.get(..12).unwrap_or(&self.key)
    }
}

impl Quantity {
    /// Cost of every sample, and the largest error among it and the finer ones of its group: where errors change sign, a coarse run may
    /// be right by chance. NaN where it doesn't have the quantity.
    pub fn points(&self, samples: &[Sample]) -> Vec<(f64, f64)> {
        let point = |(i, s): (usize, &Sample)| {
            let finer = |k: &usize| samples[*k].group == s.group && samples[*k].h <= s.h && s.h.is_some();
            let errors = (0..samples.len()).filter(finer).filter_map(|k| self.rows[k]).map(|r| r.error);
            (s.cost, self.rows[i].map_or(f64::NAN, |own| errors.fold(own.error, f64::max)))
        };
        samples.iter().enumerate().map(point).collect()
    }
    /// Uncertainty of the reference, relative.
    pub fn blur(&self) -> f64 {
        self.reference.uncertainty / self.scale
    }
}

/// Errors below this are of rounding.
const ROUNDING: f64 = 1e-9;

/// All quantities of `samples` that err by more than rounding, in the order in which they first appear.
pub fn study(samples: &[Sample]) -> Vec<Quantity> {
    let mut names: Vec<&'static str> = Vec::new();
    for m in samples.iter().flat_map(|s| &s.measures.all) {
        if !names.contains(&m.name) {
            names.push(m.name);
        }
    }
    let errs = |q: &Quantity| q.rows.iter().flatten().any(|r| r.error > ROUNDING);
    names.into_iter().filter_map(|name| quantity(samples, name)).filter(errs).collect()
}

fn quantity(samples: &[Sample], name: &'static str) -> Option<Quantity> {
    let of = |s: &Sample| s.measures.all.iter().find(|m| m.name == name).cloned();
    let measured: Vec<Option<Measure>> = samples.iter().map(of).collect();
    let first = measured.iter().flatten().next()?.clone();
    let groups = groups(samples);
    let reference = match first.exact {
        Some(value) => Limit { value, uncertainty: 0.0, how: How::Exact, order: None },
        None => reference(samples, &measured, &groups)?,
    };
    let scale = first.scale.unwrap_or(reference.value.abs().max(first.least));
    let row = |m: &Option<Measure>| {
        m.as_ref().map(|m| {
            let (off, blur) = (m.value - reference.value, reference.uncertainty);
            let error = (off * off + blur * blur).sqrt() / m.scale.unwrap_or(scale);
            Row { value: m.value, error, uncertainty: (blur * blur + m.noise * m.noise).sqrt() / scale }
        })
    };
    let mut rows: Vec<Option<Row>> = measured.iter().map(row).collect();
    if reference.how == How::Last {
        // It agrees with itself: that says nothing.
        rows.iter_mut().rev().find(|r| r.is_some()).map(Option::take);
    }
    let orders = groups.iter().map(|g| {
        let found = match first.exact {
            Some(_) => {
                order(&in_group(samples, g).filter_map(|i| Some((samples[i].h?, rows[i]?.error))).collect::<Vec<_>>())
            }
            None => limit(&levels(samples, &measured, g)).and_then(|l| l.order).or_else(|| {
                // Where the runs do not go one way the order is the errors' against where they lead, the scatter in its uncertainty.
                let off = |(h, value): (f64, f64)| (h, (value - reference.value).abs());
                let levels = levels(samples, &measured, g);
                let (_, coarser) = levels.split_last()?;
                order(&coarser.iter().copied().map(off).collect::<Vec<_>>()).filter(|o| o.uncertainty.is_some())
            }),
        };
        (g.clone(), found)
    });
    let orders = orders.collect();
    let mut quantity =
        Quantity { name, unit: first.unit, reference, scale, rows, orders, front: Vec::new(), knee: None };
    let points = quantity.points(samples);
    quantity.front = front(&points);
    quantity.knee = knee(&points, &quantity.front);
    Some(quantity)
}

fn groups(samples: &[Sample]) -> Vec<String> {
    let mut groups: Vec<String> = Vec::new();
    for s in samples {
        if !groups.contains(&s.group) {
            groups.push(s.group.clone());
        }
    }
    groups
}

fn in_group<'a>(samples: &'a [Sample], group: &'a str) -> impl Iterator<Item = usize> + 'a {
    (0..samples.len()).filter(move |&i| samples[i].group == group)
}

/// (h, value) of a group's runs, coarse to fine; empty where its settings are no numbers.
fn levels(samples: &[Sample], measured: &[Option<Measure>], group: &str) -> Vec<(f64, f64)> {
    let level = |i: usize| Some((samples[i].h?, measured[i].as_ref()?.value));
    let mut levels: Vec<(f64, f64)> = in_group(samples, group).filter_map(level).collect();
    levels.sort_by(|a, b| b.0.total_cmp(&a.0));
    levels
}

/// The limit of the group with the finest run; where settings are no numbers, the last run as written. Noise of the finest run,
/// where it has some, is part of the uncertainty.
fn reference(samples: &[Sample], measured: &[Option<Measure>], groups: &[String]) -> Option<Limit> {
    let finest = |g: &&String| levels(samples, measured, g).last().map_or(f64::INFINITY, |l| l.0);
    let group = groups.iter().min_by(|a, b| finest(a).total_cmp(&finest(b)))?;
    let found = limit(&levels(samples, measured, group));
    let own = in_group(samples, group).filter(|&i| measured[i].is_some());
    let order = |a: &usize, b: &usize| {
        samples[*a].h.unwrap_or(f64::INFINITY).total_cmp(&samples[*b].h.unwrap_or(f64::INFINITY))
    };
    let noise = own.min_by(order).and_then(|i| Some(measured[i].as_ref()?.noise)).unwrap_or(0.0);
    let last = || {
        let value = measured.iter().flatten().next_back()?.value;
        Some(Limit { value, uncertainty: 0.0, how: How::Last, order: None })
    };
    let found = found.or_else(last)?;
    // Averages scatter about their limit: there is no order to extrapolate by.
    Some(if noise > 0.0 {
        let finest = levels(samples, measured, group).last()?.1;
        Limit { value: finest, uncertainty: noise, how: How::Finest, order: None }
    } else {
        found
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measure;

    fn run(cells: f64, group: &str, value: f64) -> Sample {
        let all = vec![Measure::free("eta", "", value), Measure::deviation("drift", 1e-3 / cells)];
        Sample {
            setting: format!("{cells}"),
            group: group.into(),
            h: Some(1.0 / cells),
            measures: Measures { all, work: cells, unit: "steps" },
            cost: cells * cells,
            foretold: cells * cells,
            key: String::new(),
        }
    }

    /// Two methods, first and second order, towards the same 0.5: the reference is that of the one with the finest run.
    #[test]
    fn errors_orders_and_front() {
        let mut samples: Vec<Sample> = [4.0, 8.0, 16.0, 32.0].map(|n| run(n, "first", 0.5 + 0.4 / n)).into();
        samples.extend([4.0, 8.0, 16.0].map(|n| run(n, "second", 0.5 + 0.8 / n / n)));
        let all = study(&samples);
        assert_eq!(all.iter().map(|q| q.name).collect::<Vec<_>>(), ["eta", "drift"]);
        let eta = &all[0];
        assert!((eta.reference.value - 0.5).abs() < 1e-3, "{:?}", eta.reference);
        assert_eq!(eta.reference.how, How::Extrapolated);
        let order = |k: usize| eta.orders[k].1.unwrap().value;
        assert!((order(0) - 1.0).abs() < 0.03 && (order(1) - 2.0).abs() < 0.05, "{:?}", eta.orders);
        assert_eq!(eta.front, [4, 5, 6], "the second method beats the first everywhere");
        let drift = &all[1];
        assert_eq!((drift.reference.how, drift.scale), (How::Exact, 1.0));
        assert!((drift.orders[0].1.unwrap().value - 1.0).abs() < 1e-9);
        assert!(eta.rows.iter().flatten().all(|r| r.uncertainty >= 0.0));
    }

    #[test]
    fn averages_are_not_extrapolated() {
        let noisy = |t: f64, value: f64| {
            let m = Measure { noise: 0.1 / t.sqrt(), ..Measure::free("pressure", "GPa", value) };
            let measures = Measures { all: vec![m], work: t, unit: "steps" };
            Sample { h: Some(1.0 / t), measures, ..run(t, "", 0.0) }
        };
        let all = study(&[noisy(1.0, 10.2), noisy(4.0, 10.1), noisy(16.0, 10.05)]);
        assert_eq!(
            (all[0].reference.how, all[0].reference.value, all[0].reference.uncertainty),
            (How::Finest, 10.05, 0.025)
        );
    }
}
