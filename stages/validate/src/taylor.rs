//! Stage `validate.taylor`: copper bars on a rigid anvil against final shapes measured.
//!
//! A bar that meets its mirror image at twice the speed meets the plane between them, which nothing crosses: a rigid anvil without
//! friction. So a run of `impact` with the bar as projectile and an equal bar as plate is Taylor's test.
use crate::{Csv, CsvError};
use hvi_impact::result::{Impact, Space};
use hvi_kit::view::{Axis, Cell, Figure, Scalar, Series, Style, Table, View};
use hvi_kit::{Artifact, Ctx, File, Stage, StageError, inputs};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// It has no parameters of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {}

inputs! {
    /// Inputs of the stage.
    pub struct Inputs {
        /// Runs in (r, z) of a bar on an equal bar at twice the speed; each is compared with the shots of its size, speed and temperature.
        runs: Vec<Impact>,
        /// Final shapes: columns `reference`, `T0` [K], `U` [m/s], `L0`, `D0`, `Lf`, `Df`, `Wf` [mm]; the last two may be empty.
        shots: File,
    }
}

/// Lengths of a bar after the test [m].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Final {
    /// Its length.
    pub length: f64,
    /// Diameter of the face that met the anvil.
    pub face: Option<f64>,
    /// Diameter at a fifth of its first length from there.
    pub fifth: Option<f64>,
}

/// A shot and its run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shot {
    /// Who measured it.
    pub reference: String,
    /// Temperature of the bar [K].
    pub temperature: f64,
    /// Speed on the anvil [m/s].
    pub speed: f64,
    /// Length and diameter before [m].
    pub size: [f64; 2],
    /// As measured.
    pub measured: Final,
    /// As computed.
    pub computed: Final,
    /// Cells across the radius.
    pub cells: f64,
    /// Part of the speed that is left in the bar's rear at the end of the run.
    pub unfinished: f64,
}

/// What the stage leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Taylor {
    /// Every shot that has a run, in the order of the file.
    pub shots: Vec<Shot>,
    /// Shots of the file without a run.
    pub left_out: u32,
}

/// The stage.
pub struct TaylorBars;
impl Stage for TaylorBars {
    const NAME: &'static str = "validate.taylor";
    const SUMMARY: &'static str = "bars on a rigid anvil (Taylor's test): computed against measured final shapes";
    type Params = Params;
    type Inputs = Inputs;
    type Output = Taylor;

    fn run(_: &Params, inputs: Inputs, _: &Ctx<'_>) -> Result<Taylor, StageError> {
        let text = inputs.shots.text().map_err(StageError::physics)?;
        let measured = read(text).map_err(StageError::physics)?;
        compare(&measured, &inputs.runs)
    }
}

/// A shot as measured.
struct Measured {
    reference: String,
    temperature: f64,
    speed: f64,
    size: [f64; 2],
    bar: Final,
}

fn read(text: &str) -> Result<Vec<Measured>, CsvError> {
    let csv = Csv::read("shots", text)?;
    let (reference, face, fifth) = (csv.text("reference")?, csv.text("Df")?, csv.text("Wf")?);
    let (temperature, speed) = (csv.numbers("T0")?, csv.numbers("U")?);
    let (before, across, after) = (csv.numbers("L0")?, csv.numbers("D0")?, csv.numbers("Lf")?);
    let width = |text: &str| text.parse::<f64>().ok().map(|x| 1e-3 * x);
    let row = |i: usize| Measured {
        reference: reference[i].into(),
        temperature: temperature[i],
        speed: speed[i],
        size: [1e-3 * before[i], 1e-3 * across[i]],
        bar: Final { length: 1e-3 * after[i], face: width(face[i]), fifth: width(fifth[i]) },
    };
    csv.any((0..after.len()).map(row).collect(), "reference, T0, U, L0, D0, Lf, Df and Wf")
}

/// Sizes and speeds nearer than this are the same.
const SAME: f64 = 2e-3;
/// Temperatures nearer than this are the same [K]: hot bars are run at the mean of their oven's.
const SAME_TEMPERATURE: f64 = 60.0;

fn compare(measured: &[Measured], runs: &[Impact]) -> Result<Taylor, StageError> {
    let bars: Vec<Bar> = runs.iter().map(Bar::of).collect::<Result<_, _>>()?;
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < SAME;
    let mut shots = Vec::new();
    for m in measured {
        let fits = |b: &&Bar| {
            near(b.speed, m.speed)
                && near(b.size[0], m.size[0])
                && near(b.size[1], m.size[1])
                && (b.temperature - m.temperature).abs() < SAME_TEMPERATURE
        };
        let Some(bar) = bars.iter().find(fits) else { continue };
        shots.push(Shot {
            reference: m.reference.clone(),
            temperature: m.temperature,
            speed: m.speed,
            size: m.size,
            measured: m.bar,
            computed: bar.shape,
            cells: bar.cells,
            unfinished: bar.unfinished,
        });
    }
    if shots.is_empty() {
        return Err(StageError::physics(
            "none of the runs is one of the shots: a run has the bar's length and diameter as projectile and as plate, and twice its speed",
        ));
    }
    Ok(Taylor { left_out: (measured.len() - shots.len()) as u32, shots })
}

/// A run read as a bar on an anvil.
struct Bar {
    speed: f64,
    temperature: f64,
    size: [f64; 2],
    shape: Final,
    cells: f64,
    unfinished: f64,
}

impl Bar {
    fn of(run: &Impact) -> Result<Bar, StageError> {
        let refuse = |why: &str| StageError::physics(format!("the run at {} m/s {why}", run.velocity));
        if run.space != Space::Axisymmetric {
            return Err(refuse("is not in (r, z)"));
        }
        let last = run.snapshots.last().ok_or_else(|| refuse("has no snapshot"))?;
        let p = &last.particles;
        let speed = 0.5 * run.velocity;
        let (x, r) = (|i: usize| f64::from(p.position[0][i]), |i: usize| f64::from(p.position[1][i]));
        // Half the initial spacing from a particle's middle to the surface it stands for.
        let skin = 0.25 * run.cell;
        let ends = (0..p.mass.len()).map(x).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        let anvil = 0.5 * (ends.0 + ends.1);
        let width = |at: f64, reach: f64| {
            let near = (0..p.mass.len()).filter(|&i| ((x(i) - anvil).abs() - at).abs() < reach).map(r);
            near.reduce(f64::max).map(|r| 2.0 * (r + skin))
        };
        let length = 0.5 * (ends.1 - ends.0) + skin;
        let rear = |i: &usize| (x(*i) - anvil).abs() > 0.8 * length;
        let rears: Vec<usize> = (0..p.mass.len()).filter(rear).collect();
        let mean = |of: &dyn Fn(usize) -> f64| rears.iter().map(|&i| of(i)).sum::<f64>() / rears.len().max(1) as f64;
        let left = mean(&|i| {
            let inwards = if x(i) < anvil { 1.0 } else { -1.0 };
            inwards * (f64::from(p.velocity[0][i]) - speed)
        });
        Ok(Bar {
            speed,
            // The rear has been heated by elastic waves only.
            temperature: mean(&|i| f64::from(p.temperature[i])),
            size: [run.thickness, run.diameter],
            shape: Final { length, face: width(0.0, run.cell), fifth: width(0.2 * run.thickness, 0.6 * run.cell) },
            cells: 0.5 * run.diameter / run.cell,
            unfinished: left / speed,
        })
    }
}

/// Deviation of computed from measured final length, as a share of the measured.
fn off(s: &Shot) -> f64 {
    s.computed.length / s.measured.length - 1.0
}

fn statistics(all: &[f64]) -> [f64; 3] {
    let n = all.len().max(1) as f64;
    let mean = all.iter().sum::<f64>() / n;
    let rms = (all.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
    [mean, rms, all.iter().fold(0.0, |a: f64, d| if d.abs() > a.abs() { *d } else { a })]
}

impl Artifact for Taylor {
    const KIND: &'static str = "taylor/1";

    fn scalars(&self) -> Vec<Scalar> {
        let of =
            |pick: &dyn Fn(&Shot) -> Option<f64>| statistics(&self.shots.iter().filter_map(pick).collect::<Vec<_>>());
        let mut all = vec![Scalar::number("shots", self.shots.len() as f64, "")];
        let [mean, rms, worst] = of(&|s| Some(off(s)));
        all.push(Scalar::number("final length: mean deviation", 100.0 * mean, "%"));
        all.push(Scalar::number("rms", 100.0 * rms, "%"));
        all.push(Scalar::number("largest", 100.0 * worst, "%"));
        let share = |computed: Option<f64>, measured: Option<f64>| Some(computed? / measured? - 1.0);
        let [mean, rms, _] = of(&|s| share(s.computed.face, s.measured.face));
        all.push(Scalar::number("diameter of the face: mean deviation", 100.0 * mean, "%"));
        all.push(Scalar::number("rms of the face", 100.0 * rms, "%"));
        all
    }

    fn views(&self) -> Vec<View> {
        vec![
            View::Figure(self.histogram()),
            View::Figure(self.lengths()),
            View::Table(self.by_reference()),
            View::Table(self.table()),
        ]
    }
}

/// Width of a bin of the histogram.
const BIN: f64 = 0.02;

impl Taylor {
    fn groups(&self) -> [(&'static str, Vec<&Shot>); 2] {
        let (cold, hot) = self.shots.iter().partition(|s| s.temperature < 400.0);
        [("at room temperature", cold), ("at 700 to 1240 K", hot)]
    }

    /// How many shots deviate by how much.
    fn histogram(&self) -> Figure {
        let series = self.groups().into_iter().filter(|g| !g.1.is_empty()).map(|(name, shots)| {
            let bin = |s: &&Shot| (off(s) / BIN).floor() as i64;
            let low = shots.iter().map(bin).min().unwrap_or(0);
            let high = shots.iter().map(bin).max().unwrap_or(0);
            let mut points = vec![(100.0 * BIN * low as f64, 0.0)];
            for k in low..=high {
                let count = shots.iter().filter(|s| bin(s) == k).count() as f64;
                points.extend([k, k + 1].map(|edge| (100.0 * BIN * edge as f64, count)));
            }
            points.push((100.0 * BIN * (high + 1) as f64, 0.0));
            Series::new(&format!("{} shots {name}", shots.len()), Style::Line, points)
        });
        Figure {
            title: "Taylor bars: deviation of the final length".into(),
            x: Axis::linear("computed over measured length, less 1", "%"),
            y: Axis::linear("shots", ""),
            series: series.collect(),
            note: "Bins of 2 %. One set of constants for all coppers and tempers: scatter between laboratories counts too.".into(),
        }
    }

    fn lengths(&self) -> Figure {
        let mut series: Vec<Series> = Vec::new();
        for (k, (name, shots)) in self.groups().into_iter().enumerate() {
            let points = shots.iter().map(|s| (s.measured.length / s.size[0], s.computed.length / s.size[0])).collect();
            series.push(Series::new(name, [Style::Dots, Style::Triangles][k], points));
        }
        series.push(Series::new("equal", Style::Dashed, vec![(0.25, 0.25), (0.9, 0.9)]));
        Figure {
            title: "Taylor bars: final lengths".into(),
            x: Axis::linear("measured Lf/L0", ""),
            y: Axis::linear("computed Lf/L0", ""),
            series,
            note: String::new(),
        }
    }

    fn by_reference(&self) -> Table {
        let mut names: Vec<&str> = Vec::new();
        for s in &self.shots {
            if !names.contains(&s.reference.as_str()) {
                names.push(&s.reference);
            }
        }
        let row = |name: &&str| -> Vec<Cell> {
            let own: Vec<f64> = self.shots.iter().filter(|s| s.reference == *name).map(off).collect();
            let [mean, rms, worst] = statistics(&own);
            vec![
                (*name).into(),
                (own.len() as f64).into(),
                (100.0 * mean).into(),
                (100.0 * rms).into(),
                (100.0 * worst).into(),
            ]
        };
        let columns = [("measured by", ""), ("shots", ""), ("mean", "%"), ("rms", "%"), ("largest", "%")];
        let left = match self.left_out {
            0 => String::new(),
            n => format!("{n} shots of the file have no run."),
        };
        Table {
            title: "Final length: deviation by laboratory".into(),
            columns: columns.map(|(n, u)| (n.to_string(), u.to_string())).to_vec(),
            rows: names.iter().map(row).collect(),
            note: left,
        }
    }

    fn table(&self) -> Table {
        let mm = |x: Option<f64>| x.map_or(Cell::Empty, |x| Cell::Number(1e3 * x));
        let row = |s: &Shot| -> Vec<Cell> {
            vec![
                s.reference.as_str().into(),
                s.temperature.into(),
                s.speed.into(),
                mm(Some(s.size[0])),
                mm(Some(s.size[1])),
                mm(Some(s.measured.length)),
                mm(Some(s.computed.length)),
                (100.0 * off(s)).into(),
                mm(s.measured.face),
                mm(s.computed.face),
                mm(s.measured.fifth),
                mm(s.computed.fifth),
                s.cells.into(),
                s.unfinished.into(),
            ]
        };
        let columns = [
            ("measured by", ""),
            ("T0", "K"),
            ("U", "m/s"),
            ("L0", "mm"),
            ("D0", "mm"),
            ("Lf measured", "mm"),
            ("Lf", "mm"),
            ("off", "%"),
            ("face measured", "mm"),
            ("face", "mm"),
            ("at L0/5 measured", "mm"),
            ("at L0/5", "mm"),
            ("cells a radius", ""),
            ("speed left at the rear", ""),
        ];
        Table {
            title: "Taylor bars".into(),
            columns: columns.map(|(n, u)| (n.to_string(), u.to_string())).to_vec(),
            rows: self.shots.iter().map(row).collect(),
            note: "Speed left: of the bar's rear at the end of the run, over the speed of impact; near 0 the bar has come to rest.".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_impact::result::{Body, Particles, Snapshot};

    /// Two bars of 20 mm that have become 12 mm, with a face of 10 mm, flying on at the anvil's speed.
    fn run(temperature: f32) -> Impact {
        let mut p = Particles::default();
        let h = 0.25e-3;
        for i in -48..48 {
            let x = (f64::from(i) + 0.5) * h;
            let radius = if x.abs() < 2e-3 { 5e-3 } else { 4e-3 };
            for j in 0..(radius / h) as i32 {
                p.position[0].push((x + 30e-3) as f32);
                p.position[1].push(((f64::from(j) + 0.5) * h) as f32);
                p.position[2].push(0.0);
                p.velocity[0].push(200.0);
                p.mass.push(1.0);
                p.temperature.push(temperature);
            }
        }
        let body = |name: &str| Body { name: name.into(), material: "copper".into(), mass: 1.0, density: 8930.0 };
        Impact {
            space: Space::Axisymmetric,
            cell: 2.0 * h,
            cells_through: 40.0,
            velocity: 400.0,
            diameter: 8e-3,
            thickness: 20e-3,
            bodies: vec![body("projectile"), body("plate")],
            snapshots: vec![Snapshot { time: 1e-4, particles: p, melt: vec![] }],
            ledger: vec![],
            angle: 0.0,
            probes: vec![],
            decisions: vec![],
            crossings: vec![],
            leading: [0.0; 3],
            notes: vec![],
        }
    }

    const FILE: &str = "reference,rho0,T0,U,L0,D0,Lf,Lf_over_L0,Xf,Df,Wf\n\
        A,8900,295,200,20,8,12.5,0.6,,10.1,\nB,8900,725,200,20,8,12,0.6,,,\nC,8900,295,150,20,8,14,0.7,,,\n";

    /// Lengths are found to the particles' spacing, .25 mm in 12: 2 %.
    #[test]
    fn a_run_is_found_and_measured() {
        let taylor = compare(&read(FILE).unwrap(), &[run(296.0), run(730.0)]).unwrap();
        assert_eq!((taylor.shots.len(), taylor.left_out), (2, 1));
        let shot = &taylor.shots[0];
        assert!((shot.computed.length - 12e-3).abs() < 0.25e-3, "{shot:?}");
        assert!(
            (shot.computed.face.unwrap() - 10e-3).abs() < 0.25e-3
                && (shot.computed.fifth.unwrap() - 8e-3).abs() < 0.25e-3
        );
        assert!(shot.unfinished.abs() < 1e-6 && (off(shot) + 0.04).abs() < 0.02);
        assert_eq!(Taylor::decode(&taylor.encode()).unwrap(), taylor);
        assert_eq!(taylor.views().len(), 4);
    }

    #[test]
    fn runs_of_other_bars_are_refused() {
        let why = compare(&read(FILE).unwrap(), &[Impact { thickness: 30e-3, ..run(295.0) }]).unwrap_err().to_string();
        assert!(why.contains("none of the runs"), "{why}");
        let plane = Impact { space: Space::Line, ..run(295.0) };
        assert!(compare(&read(FILE).unwrap(), &[plane]).unwrap_err().to_string().contains("(r, z)"));
    }
}
