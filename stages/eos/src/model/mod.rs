//! One file a model.
pub mod gray;
pub mod ideal_gas;
pub mod mie_gruneisen;
mod monotone;
pub mod sesame;
pub mod stiffened_gas;
pub(crate) mod table;
pub mod tabulated;
pub mod tillotson;

/// The smaller of `volume` and the smallest volume from 0.9 `reference` on at which `pressure` vanishes.
///
/// Marches to the first negative pressure in steps of a twentieth of the reference volume (of its own volume in thin matter),
/// then closes in.
pub(crate) fn relax(reference: f64, volume: f64, pressure: impl Fn(f64) -> f64) -> f64 {
    let at = |u: f64| pressure(u * reference);
    let end = volume / reference;
    let (mut low, mut known) = (0.9, None);
    while low < end {
        let high = (low * 1.05f64).max(low + 0.05).min(end);
        let below = at(high);
        if below < 0.0 {
            let above = known.unwrap_or_else(|| at(low));
            return close_in([low, above], [high, below], at) * reference;
        }
        (low, known) = (high, Some(below));
    }
    volume
}

/// Width of a bracket in which a root is found.
const CLOSE: f64 = 1e-12;
/// Evaluations after which a bracket must have halved, or is halved.
const PATIENCE: u32 = 3;

/// Root of `f` between `low`, where it is positive, and `high`, where it is negative, each a place with its value: the false position,
/// with the value at an end that stays halved (the Illinois rule; M. Dowell and P. Jarratt, BIT 11, 168 (1971)), and plain halving where
/// that is slow. The place of `low` if it is not positive there.
fn close_in(mut low: [f64; 2], mut high: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    if !(low[1] > 0.0) {
        return low[0];
    }
    let (mut goal, mut spent, mut side) = (0.5 * (high[0] - low[0]), 0, 0.0);
    while high[0] - low[0] > CLOSE {
        let width = high[0] - low[0];
        if width <= goal {
            (goal, spent) = (0.5 * width, 0);
        }
        // Not so near to an end that the bracket would stay as it is.
        let guess = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1]);
        let guess = guess.max(low[0] + 0.4 * CLOSE).min(high[0] - 0.4 * CLOSE);
        let next = if spent < PATIENCE { guess } else { 0.5 * (low[0] + high[0]) };
        spent += 1;
        let value = f(next);
        if value > 0.0 {
            high[1] *= if side > 0.0 { 0.5 } else { 1.0 };
            (low, side) = ([next, value], 1.0);
        } else {
            low[1] *= if side < 0.0 { 0.5 } else { 1.0 };
            (high, side) = ([next, value], -1.0);
        }
    }
    0.5 * (low[0] + high[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth, steep, kinked and jumping: to 1e-11, the first two in no more than 15 evaluations, where halving takes 39; the others in
    /// no more than four times that.
    #[test]
    fn roots_are_found() {
        type Function = fn(f64) -> f64;
        let functions: [(Function, f64, u32); 4] = [
            (|x| 2.0 - x * x, 2f64.sqrt(), 15),
            (|x| 1.0 / (x * x * x * x) - 0.3, 1.0 / 0.3f64.sqrt().sqrt(), 15),
            (|x| if x < 1.2 { 1e-3 * (1.2 - x) } else { 50.0 * (1.2 - x) }, 1.2, 156),
            (|x| if x < 1.37 { 1.0 } else { -2.0 }, 1.37, 156),
        ];
        for (k, (f, root, most)) in functions.into_iter().enumerate() {
            let calls = std::cell::Cell::new(0);
            let counted = |x: f64| {
                calls.set(calls.get() + 1);
                f(x)
            };
            let found = close_in([1.0, f(1.0)], [1.5, f(1.5)], counted);
            assert!((found - root).abs() < 1e-11, "{k}: {found}, expected {root}");
            assert!(calls.get() <= most, "{k}: {} evaluations", calls.get());
        }
        assert_eq!(close_in([1.0, -1.0], [2.0, -2.0], |x| -x), 1.0);
        assert!((relax(2.0, 2.6, |v| 2.5 - v) - 2.5).abs() < 1e-11);
        assert_eq!(relax(2.0, 2.4, |v| 2.5 - v), 2.4);
    }
}
