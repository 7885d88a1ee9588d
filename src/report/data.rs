//! Data for the page's script, as JSON that is safe inside an element: points of figures, and where each result comes from.
use super::{Point, State, Step, Study, parts};
use crate::figure;
use hvi_kit::view::{Axis, Figure, Series, Style};
use serde::{Serialize, Serializer};

/// Points of one series that the page holds; of longer ones every so many-th, and the last.
const MOST_POINTS: usize = 2000;

/// Text of `value` in which nothing ends a script element or begins a tag.
fn safe(value: &impl Serialize) -> String {
    let text = serde_json::to_string(value).expect("plain data has a text");
    if !text.contains(['<', '>', '&']) {
        return text;
    }
    text.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// A number as a script needs it: seven digits, nothing where there is no number.
#[derive(Clone, Copy)]
struct Short(f64);
impl Serialize for Short {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let single = self.0 as f32;
        match self.0 {
            x if !x.is_finite() => serializer.serialize_none(),
            x if single.is_normal() || x == 0.0 => serializer.serialize_f32(single),
            x => serializer.serialize_f64(x),
        }
    }
}

#[derive(Serialize)]
struct Plot<'a> {
    title: &'a str,
    x: PlotAxis<'a>,
    y: PlotAxis<'a>,
    series: Vec<PlotSeries<'a>>,
}

#[derive(Serialize)]
struct PlotAxis<'a> {
    label: &'a str,
    unit: String,
    log: bool,
}

#[derive(Serialize)]
struct PlotSeries<'a> {
    label: &'a str,
    style: Style,
    colour: &'a str,
    points: Vec<[Short; 2]>,
    errors: Vec<Short>,
}

/// A figure's axes and points.
pub fn plot(figure: &Figure) -> String {
    fn axis(a: &Axis) -> PlotAxis<'_> {
        PlotAxis { label: &a.label, unit: figure::unit(&a.unit), log: a.log }
    }
    let series = figure::coloured(&figure.series).map(|(s, colour)| self::series(s, colour)).collect();
    safe(&Plot { title: &figure.title, x: axis(&figure.x), y: axis(&figure.y), series })
}

fn series<'a>(s: &'a Series, colour: &'a str) -> PlotSeries<'a> {
    let stride = s.points.len().div_ceil(MOST_POINTS).max(1);
    let kept = |i: &usize| i.is_multiple_of(stride) || *i + 1 == s.points.len();
    let kept = || (0..s.points.len()).filter(kept);
    PlotSeries {
        label: &s.label,
        style: s.style,
        colour,
        points: kept().map(|i| [Short(s.points[i].0), Short(s.points[i].1)]).collect(),
        errors: kept().filter_map(|i| s.errors.get(i)).map(|&e| Short(e)).collect(),
    }
}

#[derive(Serialize)]
struct Origins<'a> {
    command: &'a str,
    steps: Vec<OriginStep<'a>>,
}

#[derive(Serialize)]
struct OriginStep<'a> {
    name: &'a str,
    stage: &'a str,
    summary: &'a str,
    needs: &'a [String],
    params: Vec<(String, String)>,
    points: Vec<Origin<'a>>,
}

#[derive(Serialize)]
struct Origin<'a> {
    label: &'a str,
    state: &'a str,
    time: String,
    key: &'a str,
    swept: String,
}

/// Every step with the points that tables show, and where each comes from.
pub fn study(study: &Study) -> String {
    safe(&Origins { command: &study.command, steps: study.steps.iter().map(step).collect() })
}

fn step(step: &Step) -> OriginStep<'_> {
    OriginStep {
        name: &step.name,
        stage: &step.stage,
        summary: &step.summary,
        needs: &step.needs,
        params: parts::shared_params(&step.points),
        points: step.points.iter().take(parts::MOST_ROWS).map(origin).collect(),
    }
}

fn origin(p: &Point) -> Origin<'_> {
    let mut swept = String::new();
    for (k, v) in &p.swept {
        let between = if swept.is_empty() { "" } else { "; " };
        [between, k, " = ", v].iter().for_each(|part| swept.push_str(part));
    }
    Origin {
        label: &p.label,
        state: match &p.state {
            State::Hit => "from the store",
            State::Ran => "computed when this page was made",
            State::Failed(_) => "failed",
            State::Skipped(_) | State::Cancelled => "not run",
        },
        time: if p.seconds > 0.0 { parts::time(p.seconds) } else { String::new() },
        key: &p.key,
        swept,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// What a name holds can neither end the element that the data stands in, nor open another; and it reads back.
    #[test]
    fn data_stays_data() {
        let evil = "</script><script>alert(1)</script><!--";
        let points = vec![(1.0, f64::NAN), (2.0, 0.1 + 0.2)];
        let figure = Figure {
            title: evil.into(),
            x: Axis::linear(evil, ""),
            y: Axis::linear("P", "cm3/g"),
            series: vec![Series::new(evil, Style::Dots, points)],
            note: String::new(),
        };
        let text = plot(&figure);
        assert!(!text.contains(['<', '>', '&']));
        let back: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["title"], evil);
        assert_eq!(back["y"]["unit"], "cm³/g");
        assert_eq!(back["series"][0]["points"], json!([[1.0, null], [2.0, 0.3]]));
    }

    #[test]
    fn long_series_are_thinned_with_their_ends() {
        let points: Vec<(f64, f64)> = (0..10_000).map(|k| (f64::from(k), 1.0)).collect();
        let value = serde_json::to_value(series(&Series::new("", Style::Line, points), "#000")).unwrap();
        let kept = value["points"].as_array().unwrap();
        assert!(kept.len() <= MOST_POINTS + 1);
        assert_eq!((&kept[0][0], &kept[kept.len() - 1][0]), (&json!(0.0), &json!(9999.0)));
    }
}
