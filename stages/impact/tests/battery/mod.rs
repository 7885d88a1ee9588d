//! The stability battery: hard cases of the method with a known answer, one function a subject, each giving rows of one table.
//!
//! The tests `battery_*.rs` assert the rows; the example `stability` prints all of them as `docs/stability.md`.
#![allow(dead_code, reason = "each test binary uses its part")]
pub mod contact;
pub mod gas;
pub mod grid;
pub mod material;
pub mod shock;
pub mod solid;
pub mod wall;
pub mod yardstick;

/// What a measured figure must be.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// Within a share of the known answer.
    Within {
        /// The answer.
        known: f64,
        /// Largest relative difference.
        share: f64,
    },
    /// No more than this.
    Most(f64),
    /// No less than this.
    Least(f64),
    /// Nothing: the figure is told.
    Reported,
}

/// One figure of one case.
#[derive(Clone, Debug)]
pub struct Row {
    /// The hard case.
    pub case: &'static str,
    /// What is measured, in which scene.
    pub what: String,
    /// The peer's figure, "-" where none is known.
    pub peer: &'static str,
    /// Our figure.
    pub ours: f64,
    /// Its unit.
    pub unit: &'static str,
    /// The bound.
    pub bound: Bound,
    /// A row that misses its bound stays in the table as missed; this is how far it may be off before the test fails: the same
    /// kind of bound, wider.
    pub missed: Option<Bound>,
}

impl Row {
    pub fn new(case: &'static str, what: impl Into<String>, ours: f64, unit: &'static str, bound: Bound) -> Row {
        Row { case, what: what.into(), peer: "-", ours, unit, bound, missed: None }
    }
    /// Within `share` of `known`.
    pub fn within(
        case: &'static str,
        what: impl Into<String>,
        ours: f64,
        unit: &'static str,
        known: f64,
        share: f64,
    ) -> Row {
        Row::new(case, what, ours, unit, Bound::Within { known, share })
    }
    pub fn most(case: &'static str, what: impl Into<String>, ours: f64, unit: &'static str, most: f64) -> Row {
        Row::new(case, what, ours, unit, Bound::Most(most))
    }
    pub fn least(case: &'static str, what: impl Into<String>, ours: f64, unit: &'static str, least: f64) -> Row {
        Row::new(case, what, ours, unit, Bound::Least(least))
    }
    pub fn reported(case: &'static str, what: impl Into<String>, ours: f64, unit: &'static str) -> Row {
        Row::new(case, what, ours, unit, Bound::Reported)
    }
    pub fn peer(self, peer: &'static str) -> Row {
        Row { peer, ..self }
    }
    /// Known to miss its bound.
    pub fn missed(self, worst: Bound) -> Row {
        Row { missed: Some(worst), ..self }
    }

    pub fn met(&self) -> bool {
        holds(self.bound, self.ours)
    }

    /// Why the figure is not as it must be (for a row known as missed: by its wider bound).
    pub fn fault(&self) -> Option<String> {
        let bound = self.missed.unwrap_or(self.bound);
        let text = || format!("{}, {}: {:.6e} {}, allowed {bound:?}", self.case, self.what, self.ours, self.unit);
        (!holds(bound, self.ours)).then(text)
    }
}

fn holds(bound: Bound, x: f64) -> bool {
    match bound {
        Bound::Within { known, share } => (x - known).abs() <= share * known.abs(),
        Bound::Most(most) => x <= most,
        Bound::Least(least) => x >= least,
        Bound::Reported => x.is_finite(),
    }
}

/// Checks every row.
///
/// # Panics
/// Where a figure isn't as it must be; the message has all of them.
pub fn check(rows: &[Row]) {
    for row in rows {
        println!("{} | {} | {:e} {} | {:?}", row.case, row.what, row.ours, row.unit, row.bound);
    }
    let faults: Vec<String> = rows.iter().filter_map(Row::fault).collect();
    assert!(faults.is_empty(), "{} of {} figures are off:\n{}", faults.len(), rows.len(), faults.join("\n"));
}
