//! How long a node will take: the cost its stage predicts, scaled by how such predictions did so far.
use super::Outcome;
use crate::plan::Plan;
use hvi_cache::Store;
use std::collections::{BTreeSet, HashMap};

/// Records of a kind that are looked at, the latest ones: each costs two small files to read.
const LOOKED_AT: usize = 16;

/// What is known of the times that stages took.
#[derive(Default)]
pub struct Times {
    /// By stage: predicted core-seconds and those it took.
    known: HashMap<&'static str, Vec<(f64, f64)>>,
}

impl Times {
    /// What hits of this plan took and, for stages without one, the latest results in the store.
    pub fn of(plan: &Plan, outcomes: &[Option<Outcome>], store: &Store) -> Times {
        let (mut times, mut unknown) = (Times::default(), BTreeSet::new());
        for (node, outcome) in plan.nodes.iter().zip(outcomes) {
            match outcome {
                Some(Outcome::Hit(entry)) => times.learn(node.stage.name, node.cost, f64::from(entry.wall_s)),
                Some(_) => {}
                None => drop(unknown.insert((node.stage.output, node.stage.name))),
            }
        }
        unknown.retain(|(_, stage)| !times.known.contains_key(stage));
        for (kind, stage) in unknown {
            for key in store.latest(kind, LOOKED_AT) {
                if let (Some(recipe), Some(record)) = (store.recipe(key), store.lookup(key))
                    && recipe.stage == stage
                {
                    times.learn(stage, record.foretold_s, record.wall_s * record.threads as f64);
                }
            }
        }
        times.known.values_mut().for_each(|all| all.sort_by(|a, b| a.0.total_cmp(&b.0)));
        times
    }

    /// Adds that a node of `stage`, predicted to take `cost` core-seconds, took `seconds` of them.
    fn learn(&mut self, stage: &'static str, cost: f64, seconds: f64) {
        if cost > 0.0 && seconds > 0.0 {
            self.known.entry(stage).or_default().push((cost, seconds));
        }
    }

    /// Core-seconds that a node of `stage` will take, predicted to take `cost`: as far off as the nearest one on record
    /// was; without one the prediction stands.
    pub fn predict(&self, stage: &str, cost: f64) -> f64 {
        let Some(all) = self.known.get(stage) else { return cost };
        let above = all.partition_point(|(known, _)| *known < cost);
        let ratio = |(known, _): &&(f64, f64)| if *known < cost { cost / *known } else { *known / cost };
        let near = &all[above.saturating_sub(1)..(above + 1).min(all.len())];
        let nearest = near.iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        nearest.map_or(cost, |(known, seconds)| cost * seconds / known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_record_scales_the_prediction() {
        let mut times = Times::default();
        for (cost, seconds) in [(100.0, 50.0), (1.0, 2.0)] {
            times.learn("md", cost, seconds);
        }
        times.learn("md", 0.0, 1.0);
        times.known.get_mut("md").unwrap().sort_by(|a, b| a.0.total_cmp(&b.0));
        for (cost, expected) in [(1.0, 2.0), (0.5, 1.0), (9.0, 18.0), (11.0, 5.5), (1000.0, 500.0)] {
            assert_eq!(times.predict("md", cost), expected, "{cost}");
        }
        assert_eq!(times.predict("eos", 3.0), 3.0);
    }
}
