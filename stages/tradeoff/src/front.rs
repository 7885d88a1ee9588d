//! Which settings no other beats in both error and cost, and where on that front to stop.
use hvi_kit::math::log;

/// A setting chosen: its index, and whether it reaches what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chosen {
    /// Index of the point.
    pub index: usize,
    /// Whether it is within what was asked; if not it is the nearest.
    pub reached: bool,
}

/// Errors on scenes that a front is not made of are up to so many times those on it, as choices that were checked on other scenes show:
/// so much less is asked of the front.
pub const MARGIN: f64 = 2.0;

/// Indices of the (cost, error) that no other point beats in one without losing in the other, by rising cost.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut by_cost: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    by_cost.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    by_cost.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    by_cost
}

/// The point of the front beyond which cost grows faster than error falls: the furthest below the line between its ends, both
/// logarithmic and scaled to 1. `None` where the front has fewer than three points.
pub fn knee(points: &[(f64, f64)], front: &[usize]) -> Option<usize> {
    let usable: Vec<usize> = front.iter().copied().filter(|&i| points[i].0 > 0.0 && points[i].1 > 0.0).collect();
    let (first, last) = (*usable.first()?, *usable.last()?);
    let at = |i: usize| {
        let share = |of: fn((f64, f64)) -> f64| {
            (log(of(points[i])) - log(of(points[first]))) / (log(of(points[last])) - log(of(points[first])))
        };
        share(|p| p.1) - share(|p| p.0)
    };
    if usable.len() < 3 {
        return None;
    }
    usable[1..usable.len() - 1].iter().copied().max_by(|&a, &b| at(a).total_cmp(&at(b))).filter(|&i| at(i) > 0.0)
}

/// The cheapest point with an error within `target`, else the one with the least error.
pub fn cheapest(points: &[(f64, f64)], target: f64) -> Option<Chosen> {
    let front = front(points);
    match front.iter().find(|&&i| points[i].1 <= target) {
        Some(&index) => Some(Chosen { index, reached: true }),
        None => front.last().map(|&index| Chosen { index, reached: false }),
    }
}

/// The point with the least error among those within `budget`, else the cheapest.
pub fn most_accurate(points: &[(f64, f64)], budget: f64) -> Option<Chosen> {
    let front = front(points);
    match front.iter().rev().find(|&&i| points[i].0 <= budget) {
        Some(&index) => Some(Chosen { index, reached: true }),
        None => front.first().map(|&index| Chosen { index, reached: false }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [(f64, f64); 6] = [(1.0, 0.1), (2.0, 0.2), (2.0, 0.02), (8.0, 0.015), (20.0, 0.012), (4.0, f64::NAN)];

    #[test]
    fn the_front_its_knee_and_what_to_choose() {
        let found = front(&POINTS);
        assert_eq!(found, [0, 2, 3, 4]);
        assert_eq!(knee(&POINTS, &found), Some(2));
        assert_eq!(knee(&POINTS, &found[..2]), None);
        assert_eq!(cheapest(&POINTS, 0.05), Some(Chosen { index: 2, reached: true }));
        assert_eq!(cheapest(&POINTS, 0.001), Some(Chosen { index: 4, reached: false }));
        assert_eq!(most_accurate(&POINTS, 10.0), Some(Chosen { index: 3, reached: true }));
        assert_eq!(most_accurate(&POINTS, 0.5), Some(Chosen { index: 0, reached: false }));
        assert_eq!(cheapest(&[], 1.0), None);
    }
}
