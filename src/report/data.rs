//! Data for the page's script, as JSON that is safe inside an element: points of figures, and where each result comes from.
use super::{State, Step, Study, parts};
use crate::figure;
use hvi_kit::view::{Figure, Series};
use serde_json::{Value, json};

/// Points of one series that the page holds; of longer ones every so many-th, and the last.
const MOST_POINTS: usize = 2000;

/// Text of `value` in which nothing ends a script element or begins a tag.
fn safe(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// A figure's axes and points.
pub fn plot(figure: &Figure) -> String {
    let axis = |a: &hvi_kit::view::Axis| json!({ "label": a.label, "unit": figure::unit(&a.unit), "log": a.log });
    let series = figure::coloured(&figure.series).map(|(s, colour)| self::series(s, colour));
    safe(&json!({
        "title": figure.title,
        "x": axis(&figure.x),
        "y": axis(&figure.y),
        "series": series.collect::<Vec<_>>(),
    }))
}

fn series(s: &Series, colour: &str) -> Value {
    let stride = s.points.len().div_ceil(MOST_POINTS).max(1);
    let kept = |i: &usize| i.is_multiple_of(stride) || *i + 1 == s.points.len();
    let kept: Vec<usize> = (0..s.points.len()).filter(kept).collect();
    let short = |x: f64| x.is_finite().then(|| format!("{x:.6e}").parse::<f64>().unwrap_or(x));
    let points: Vec<_> = kept.iter().map(|&i| [short(s.points[i].0), short(s.points[i].1)]).collect();
    let errors: Vec<_> = kept.iter().filter_map(|&i| s.errors.get(i)).map(|&e| short(e)).collect();
    json!({ "label": s.label, "style": format!("{:?}", s.style), "colour": colour, "points": points, "errors": errors })
}

/// Every step with the points that tables show, and where each comes from.
pub fn study(study: &Study) -> String {
    let steps: Vec<Value> = study.steps.iter().map(step).collect();
    safe(&json!({ "command": study.command, "steps": steps }))
}

fn step(step: &Step) -> Value {
    let point = |p: &super::Point| {
        let swept: Vec<String> = p.swept.iter().map(|(k, v)| format!("{k} = {v}")).collect();
        json!({
            "label": p.label,
            "state": match &p.state {
                State::Hit => "from the store",
                State::Ran => "computed when this page was made",
                State::Failed(_) => "failed",
                State::Skipped(_) | State::Cancelled => "not run",
            },
            "time": if p.seconds > 0.0 { parts::time(p.seconds) } else { String::new() },
            "key": p.key,
            "swept": swept.join("; "),
        })
    };
    json!({
        "name": step.name,
        "stage": step.stage,
        "summary": step.summary,
        "needs": step.needs,
        "params": parts::shared_params(&step.points),
        "points": step.points.iter().take(parts::MOST_ROWS).map(point).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::view::{Axis, Style};

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
        let value = series(&Series::new("", Style::Line, points), "#000");
        let kept = value["points"].as_array().unwrap();
        assert!(kept.len() <= MOST_POINTS + 1);
        assert_eq!((&kept[0][0], &kept[kept.len() - 1][0]), (&json!(0.0), &json!(9999.0)));
    }
}
