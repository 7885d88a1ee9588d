//! Whether settings chosen on one front hold elsewhere: errors and times of the same settings on runs the front is not made of.
use crate::limit::How;
use crate::{MARGIN, Quantity, Sample, cheapest};

/// Errors that settings are chosen for.
const TARGETS: [f64; 3] = [0.05, 0.02, 0.01];

/// One choice and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The quantity.
    pub quantity: &'static str,
    /// The error asked for.
    pub target: f64,
    /// The setting chosen.
    pub setting: String,
    /// The error it has here, relative.
    pub error: f64,
    /// The uncertainty of that error.
    pub uncertainty: f64,
    /// CPU time predicted before the run, from that of the front's run and the stage's own prediction of both [s].
    pub predicted: f64,
    /// CPU time it took [s].
    pub taken: f64,
}

impl Check {
    /// Whether the error is within the target.
    pub fn holds(&self) -> bool {
        self.error <= self.target
    }
    /// By which factor the time was mistaken, 1 or more.
    pub fn factor(&self) -> f64 {
        (self.taken / self.predicted).max(self.predicted / self.taken)
    }
}

/// Every choice that the front of `made` offers with a margin of [`MARGIN`], and that was run `here` too. Quantities known in closed form are left out.
pub fn check(made: (&[Sample], &[Quantity]), here: (&[Sample], &[Quantity])) -> Vec<Check> {
    let mut all = Vec::new();
    for q in made.1.iter().filter(|q| q.reference.how != How::Exact) {
        let points = q.points(made.0);
        let Some(own) = here.1.iter().find(|own| own.name == q.name) else { continue };
        for target in TARGETS {
            let Some(chosen) = cheapest(&points, target / MARGIN).filter(|c| c.reached).map(|c| &made.0[c.index])
            else {
                continue;
            };
            let same = |s: &Sample| s.setting == chosen.setting && s.group == chosen.group;
            let Some(i) = here.0.iter().position(same) else { continue };
            // The run that all others here are held against can't be held against itself.
            let finer = |s: &Sample| s.group == here.0[i].group && s.h < here.0[i].h && s.h.is_some();
            if own.reference.how == How::Finest && !here.0.iter().any(finer) {
                continue;
            }
            let (sample, Some(row)) = (&here.0[i], own.rows[i]) else { continue };
            all.push(Check {
                quantity: q.name,
                target,
                setting: sample.setting.clone(),
                error: row.error,
                uncertainty: row.uncertainty,
                predicted: chosen.cost * sample.foretold / chosen.foretold,
                taken: sample.cost,
            });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Measure, Measures, study};

    /// Errors are three times as large on the second set: more than the margin, so that a choice that just holds on the first does not
    /// hold there.
    #[test]
    fn a_choice_is_held_against_other_runs() {
        let run = |cells: f64, share: f64| Sample {
            setting: format!("{cells}"),
            group: String::new(),
            h: Some(1.0 / cells),
            measures: Measures { all: vec![Measure::free("eta", "", 1.0 + share / cells)], work: 1.0, unit: "steps" },
            cost: cells,
            foretold: 2.0 * cells,
            key: String::new(),
        };
        let of = |share: f64| [4.0, 8.0, 16.0, 32.0, 64.0].map(|n| run(n, share));
        let (made, here) = (of(0.3), of(0.9));
        let (all, own) = (study(&made), study(&here));
        let checks = check((&made, &all), (&here, &own));
        let found: Vec<(f64, &str, bool)> = checks.iter().map(|c| (c.target, c.setting.as_str(), c.holds())).collect();
        // Half the target: 0.3 over the cells, and 1.25 times that of 64 beside it in quadrature, as the limit is known no better:
        // 0.0197 at 16, 0.0111 at 32, 0.0075 at 64. The last target is not reached.
        assert_eq!(found, [(0.05, "16", false), (0.02, "64", false)]);
        assert!(checks.iter().all(|c| c.factor() == 1.0));
        let own = check((&made, &all), (&made, &all));
        assert!(own.iter().all(Check::holds));
    }
}
