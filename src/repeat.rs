//! A study computed again for its times: the CPU times on record become medians, and every result must have the same bits again.
use crate::execute::{self, Options, Outcome};
use crate::plan::Plan;
use hvi_kit::Store;

/// Computes `plan`, all of whose results `store` has, `more` times, each in an empty store that is removed afterwards, and puts the
/// median of all CPU times on record. False where it was stopped: then nothing is changed.
///
/// # Errors
/// In words: a store that can't be written, a result that failed, or came out with other bits than at first.
pub fn medians(plan: &Plan, store: &Store, options: &Options<'_>, more: usize) -> Result<bool, String> {
    let first = execute::execute(plan, store, options).map_err(|e| e.to_string())?;
    let mut times: Vec<Vec<f64>> = Vec::with_capacity(plan.nodes.len());
    for (id, outcome) in first.outcomes.iter().enumerate() {
        let entry = outcome.entry().ok_or_else(|| format!("{}: has no result", plan.label(id)))?;
        times.push(vec![f64::from(entry.cpu_s)]);
    }
    for _ in 0..more {
        let folder = tempfile::tempdir().map_err(|e| format!("{}: {e}", std::env::temp_dir().display()))?;
        let other = Store::open(folder.path().join("store")).map_err(|e| e.to_string())?;
        let again = execute::execute(plan, &other, options).map_err(|e| e.to_string())?;
        for (id, (now, then)) in again.outcomes.iter().zip(&first.outcomes).enumerate() {
            match (now, now.entry().zip(then.entry())) {
                (_, Some((now, then))) if now.output == then.output => times[id].push(f64::from(now.cpu_s)),
                (_, Some(_)) => return Err(format!("{}: came out with other bits than at first", plan.label(id))),
                (Outcome::Failed(why), None) => return Err(format!("{}: {why}", plan.label(id))),
                (_, None) => return Ok(false),
            }
        }
    }
    for (key, times) in first.keys.iter().zip(times) {
        // Times without a record, in a store that is only read, stay as they are.
        if let Some((recipe, mut record)) = key.and_then(|key| Some((store.recipe(key)?, store.lookup(key)?))) {
            record.cpu_s = hvi_tradeoff::median(times);
            store.record(&recipe, &record).map_err(|e| e.to_string())?;
        }
    }
    Ok(true)
}
