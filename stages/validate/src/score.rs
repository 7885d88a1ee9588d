//! What a validation leaves: every experimental point beside what was computed, and the scores.
use hvi_kit::Artifact;
use hvi_kit::view::{Axis, Cell, Figure, Scalar, Series, Style, Table, View};
use serde::{Deserialize, Serialize};

/// An experimental point and the pressures computed at its V/V0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Index into [`Validation::sets`].
    pub set: u32,
    /// V/V0 of the experiment, with its own V0.
    pub ratio: f64,
    /// Measured pressure [Pa].
    pub measured: f64,
    /// Pressure of the equation of state [Pa]; `None` beyond its range.
    pub model: Option<f64>,
    /// Pressure straight from the states [Pa]; `None` where no two states of one phase enclose it.
    pub states: Option<f64>,
}

/// A point of a curve straight from the states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatePoint {
    /// V/V0, V0 being the states' own.
    pub ratio: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Its standard error [Pa].
    pub error: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Solid, or liquid.
    pub solid: bool,
}

/// Deviation of computed from measured pressure at equal V/V0, over one set of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The data.
    pub set: String,
    /// What is judged: the equation of state, or the states.
    pub of: String,
    /// Highest measured pressure counted [Pa].
    pub up_to: f64,
    /// Points counted.
    pub points: u32,
    /// Points in that range of pressure where nothing could be computed.
    pub missed: u32,
    /// Mean, root mean square and largest (with its sign) relative deviation.
    pub mean: f64,
    /// See `mean`.
    pub rms: f64,
    /// See `mean`.
    pub largest: f64,
    /// Measured pressure of the largest [Pa].
    pub largest_at: f64,
}

/// The result of a validation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// The curve: `"Hugoniot"` or `"300 K isotherm"`.
    pub curve: String,
    /// Names of the sets of data.
    pub sets: Vec<String>,
    /// Every point.
    pub points: Vec<Compared>,
    /// The curve straight from the states, volume falling.
    pub states: Vec<StatePoint>,
    /// The equation of state's curve, (V/V0, P [Pa]), volume falling.
    pub line: Vec<(f64, f64)>,
    /// The scores.
    pub scores: Vec<Score>,
    /// V0 of the equation of state, and V0 of the states with its error [m3/kg].
    pub volumes: (f64, f64, f64),
    /// What a reader must know, one sentence each.
    pub notes: Vec<String>,
}

/// Name of the score of all sets together.
pub(crate) const ALL: &str = "all data";
/// Relative deviations count from this measured pressure up [Pa]: below, a percent is less than the error of measurement.
const LEAST: f64 = 5e9;

impl Score {
    /// Scores `points` of set `set` (`None`: all sets) measured up to `up_to` [Pa], by what `computed` picks.
    pub(crate) fn of(
        name: &str,
        of: &str,
        points: &[Compared],
        set: Option<u32>,
        up_to: f64,
        computed: impl Fn(&Compared) -> Option<f64>,
    ) -> Score {
        let mut score = Score {
            set: name.into(),
            of: of.into(),
            up_to,
            points: 0,
            missed: 0,
            mean: 0.0,
            rms: 0.0,
            largest: 0.0,
            largest_at: 0.0,
        };
        let counts = |p: &&Compared| set.is_none_or(|s| s == p.set) && (LEAST..=up_to).contains(&p.measured);
        for p in points.iter().filter(counts) {
            let Some(pressure) = computed(p) else {
                score.missed += 1;
                continue;
            };
            let deviation = pressure / p.measured - 1.0;
            score.points += 1;
            score.mean += deviation;
            score.rms += deviation * deviation;
            if deviation.abs() > score.largest.abs() {
                (score.largest, score.largest_at) = (deviation, p.measured);
            }
        }
        let n = f64::from(score.points.max(1));
        score.mean /= n;
        score.rms = (score.rms / n).sqrt();
        score
    }
}

/// Refuses scores without a single point, which would judge nothing; `up_to` [Pa] is the highest pressure compared.
///
/// # Errors
/// What was expected, where no point of any set lies in any range that is scored.
pub(crate) fn judged(scores: &[Score], up_to: f64) -> Result<(), String> {
    if scores.iter().any(|s| s.points > 0) {
        return Ok(());
    }
    Err(format!(
        "no data points to score: expected pressures from {} to {} GPa at compressions within the model's range",
        LEAST / 1e9,
        up_to / 1e9
    ))
}

impl Validation {
    fn score_table(&self) -> Table {
        let row = |s: &Score| -> Vec<Cell> {
            let numbers = [s.mean * 100.0, s.rms * 100.0, s.largest * 100.0, s.largest_at / 1e9];
            let mut cells: Vec<Cell> =
                vec![s.of.as_str().into(), s.set.as_str().into(), (s.up_to / 1e9).into(), f64::from(s.points).into()];
            cells.push(f64::from(s.missed).into());
            cells.extend(numbers.map(|x| if s.points == 0 { Cell::Empty } else { x.into() }));
            cells
        };
        let columns = [
            ("of", ""),
            ("against", ""),
            ("up to", "GPa"),
            ("points", ""),
            ("not computable", ""),
            ("mean deviation", "%"),
            ("rms deviation", "%"),
            ("largest deviation", "%"),
            ("largest at", "GPa"),
        ];
        Table {
            title: format!("{}: deviation from experiment", self.curve),
            columns: columns.map(|(name, unit)| (name.to_string(), unit.to_string())).into(),
            rows: self.scores.iter().map(row).collect(),
            note: self.notes.join(" "),
        }
    }

    fn state_table(&self) -> Table {
        let row = |p: &StatePoint| -> Vec<Cell> {
            vec![
                p.ratio.into(),
                Cell::Uncertain(p.pressure / 1e9, p.error / 1e9),
                p.temperature.into(),
                if p.solid { "solid".into() } else { "liquid".into() },
            ]
        };
        Table {
            title: format!("{} straight from the states", self.curve),
            columns: [("V/V0", ""), ("P", "GPa"), ("T", "K"), ("phase", "")].map(|(n, u)| (n.into(), u.into())).into(),
            rows: self.states.iter().map(row).collect(),
            note: format!(
                "V0 of the states {:.5} +- {:.5} cm3/g, of the equation of state {:.5} cm3/g.",
                self.volumes.1 * 1e3,
                self.volumes.2 * 1e3,
                self.volumes.0 * 1e3
            ),
        }
    }

    /// Pressure over V/V0, as in the paper's Figs 5 and 6.
    fn figure(&self) -> Figure {
        let highest = self.line.iter().map(|p| p.1).fold(0.0, f64::max);
        let mut series = self.measured(|p| (p.measured <= highest).then_some((p.ratio, p.measured / 1e9)));
        series.push(Series::new(
            "equation of state",
            Style::Line,
            self.line.iter().map(|p| (p.0, p.1 / 1e9)).collect(),
        ));
        let states: Vec<_> = self.states.iter().map(|p| (p.ratio, p.pressure / 1e9)).collect();
        let errors = self.states.iter().map(|p| p.error / 1e9).collect();
        series.push(Series { errors, ..Series::new("molecular dynamics", Style::Dots, states) });
        Figure {
            title: format!("{}: computed and measured", self.curve),
            x: Axis::linear("V/V0", ""),
            y: Axis::linear("pressure", "GPa"),
            series,
            note: format!("Each with its own V0. {}", self.notes.first().map_or("", String::as_str)),
        }
    }

    /// Relative deviation of the equation of state over pressure, every point.
    fn deviations(&self) -> Figure {
        let highest = self.scores.iter().map(|s| s.up_to).fold(0.0, f64::max);
        let of = |computed: Option<f64>, p: &Compared| {
            let shown = (LEAST..=highest).contains(&p.measured);
            computed.filter(|_| shown).map(|c| (p.measured / 1e9, (c / p.measured - 1.0) * 100.0))
        };
        let mut series = self.measured(|p| of(p.model, p));
        let states = self.points.iter().filter_map(|p| of(p.states, p)).collect();
        series.push(Series::new("molecular dynamics", Style::Dots, states));
        Figure {
            title: format!("{}: pull of each point", self.curve),
            x: Axis::linear("measured pressure", "GPa"),
            y: Axis::linear("computed minus measured", "%"),
            series,
            note: "Open marks: the equation of state, by set of data. Dots: straight from the states.".into(),
        }
    }

    /// One series a set of data.
    fn measured(&self, point: impl Fn(&Compared) -> Option<(f64, f64)>) -> Vec<Series> {
        let styles = [Style::Circles, Style::Triangles, Style::Crosses];
        let of = |(i, name): (usize, &String)| {
            let points = self.points.iter().filter(|p| p.set as usize == i).filter_map(&point).collect();
            Series::new(name, styles[i % styles.len()], points)
        };
        self.sets.iter().enumerate().map(of).collect()
    }
}

impl Artifact for Validation {
    const KIND: &'static str = "validation/2";

    fn scalars(&self) -> Vec<Scalar> {
        let mut scalars = vec![Scalar::text("curve", self.curve.as_str())];
        let scored = || self.scores.iter().filter(|s| s.points > 0);
        let name = |what: &str, s: &Score| format!("{what} of the {} to {:.0} GPa", s.of, s.up_to / 1e9);
        for s in scored().filter(|s| s.set == ALL) {
            scalars.push(Scalar::number(&name("mean deviation", s), s.mean * 100.0, "%"));
            scalars.push(Scalar::number(&name("rms deviation", s), s.rms * 100.0, "%"));
        }
        // Apart, set by set: the largest of all is that of the one experiment furthest off.
        let one = self.sets.len() == 1;
        for s in scored().filter(|s| self.sets.contains(&s.set) || one && s.set == ALL) {
            let set = if one { &self.sets[0] } else { &s.set };
            let what = format!("{}, {set}", name("largest deviation", s));
            scalars.push(Scalar::number(&what, s.largest * 100.0, "%"));
        }
        scalars
    }

    fn views(&self) -> Vec<View> {
        vec![
            View::Table(self.score_table()),
            View::Figure(self.figure()),
            View::Figure(self.deviations()),
            View::Table(self.state_table()),
        ]
    }
}
