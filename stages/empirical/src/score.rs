//! How far a law is from runs, and which runs can check it at all.
use crate::law::Law;
use crate::point::{Point, close};
use serde::{Deserialize, Serialize};

/// How far a law is from runs: raw, a law above 1 counts as wrong where all has melted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Number of runs.
    pub runs: u32,
    /// Root mean square deviation of eta.
    pub rms: f64,
    /// Largest deviation of eta, either way.
    pub worst: f64,
}

impl Score {
    /// Of deviations.
    pub fn of(deviations: impl Iterator<Item = f64>) -> Score {
        let (mut runs, mut squares, mut worst) = (0u32, 0.0, 0f64);
        for d in deviations {
            runs += 1;
            squares += d * d;
            worst = worst.max(d.abs());
        }
        Score { runs, rms: (squares / f64::from(runs.max(1))).sqrt(), worst }
    }
}

/// What a check run can say of the law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// A fitted run at another scale, with as many cells: the scene has no length of its own, so it says nothing new.
    Repeat,
    /// New, within the fitted range of speed and D/t.
    Inside,
    /// New, beyond the fitted range of speed or D/t.
    Outside,
}

impl Standing {
    /// In a word or two.
    pub fn describe(self) -> &'static str {
        match self {
            Standing::Repeat => "repeat",
            Standing::Inside => "new",
            Standing::Outside => "new, outside the range",
        }
    }
}

/// What `check` can say of a law fitted to the used ones of `fitted`.
pub fn standing(check: &Point, fitted: &[Point]) -> Standing {
    let used = || fitted.iter().filter(|p| p.used);
    if used().any(|p| p.is_scaled(check) && close(p.cells, check.cells)) {
        return Standing::Repeat;
    }
    let within = |of: fn(&Point) -> f64| {
        let (low, high) = used().map(of).fold((f64::MAX, 0f64), |(a, b), x| (a.min(x), b.max(x)));
        let x = of(check);
        (x >= low || close(x, low)) && (x <= high || close(x, high))
    };
    if within(Point::ratio) && within(|p| p.velocity) { Standing::Inside } else { Standing::Outside }
}

/// A law against every kind of run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// The runs fitted.
    pub fitted: Score,
    /// All check runs that aren't repeats.
    pub new: Score,
    /// Those of `new` beyond the fitted range of speed or D/t.
    pub outside: Score,
    /// Check runs that are a fitted run at another scale.
    pub repeats: Score,
}

impl Scores {
    /// Of `law` on runs, raw.
    pub fn new(law: &Law, points: &[Point], check: &[Point]) -> Scores {
        let raw = |p: &Point| law.at(p.velocity * 1e-3, p.ratio()) - p.eta;
        let of = |keep: fn(Standing) -> bool| Score::of(check.iter().filter(|&p| keep(standing(p, points))).map(raw));
        Scores {
            fitted: Score::of(points.iter().filter(|p| p.used).map(raw)),
            new: of(|s| s != Standing::Repeat),
            outside: of(|s| s == Standing::Outside),
            repeats: of(|s| s == Standing::Repeat),
        }
    }
}
