//! The page must say what there is, whatever there is, and nothing from outside.
use super::*;
use hvi_kit::view::{Axis, Cell, Figure, Picture, Series, Style, Table};

fn point(label: &str, state: State) -> Point {
    let split = |part: &str| part.split_once('=').map(|(k, v)| (k.to_string(), v.to_string()));
    Point {
        label: label.into(),
        state,
        seconds: 1.5,
        key: "0123abcd".into(),
        params: [("atoms".to_string(), "500".to_string())].into(),
        swept: label.split(", ").filter_map(split).collect(),
        scalars: [Scalar::number("pressure", 32.512345, "GPa")].into(),
        views: vec![],
        unread: Unread::default(),
    }
}

fn step(name: &str, needs: &[&str], points: Vec<Point>) -> Step {
    let needs = needs.iter().map(|n| n.to_string()).collect();
    Step { name: name.into(), stage: "md".into(), summary: "States".into(), needs, sketches: vec![], points }
}

fn study(steps: Vec<Step>) -> Study {
    let (name, question, command) = ("copper".into(), "Why?\n\nBecause.".into(), "hvi-flow run copper.toml".into());
    Study { name, question, steps, seconds: 61.0, command }
}

fn picture(colour: u8) -> View {
    let legend = vec![([1, 2, 255], "liquid & more".into())];
    View::Picture(Picture {
        title: "Film".into(),
        width: 2,
        height: 1,
        rgb: vec![colour; 6],
        legend,
        note: "scale".into(),
    })
}

fn figure() -> View {
    let series = vec![Series::new("MD", Style::Dots, vec![(1.0, 2.0)])];
    let (x, y) = (Axis::linear("V", "cm3/g"), Axis::linear("P", "GPa"));
    View::Figure(Figure { title: "Hugoniot".into(), x, y, series, note: "a note".into() })
}

fn table(rows: usize) -> View {
    let columns = vec![("P".into(), "GPa".into()), ("source".into(), String::new())];
    let rows = (0..rows).map(|k| vec![Cell::Uncertain(k as f64, 0.25), "Marsh".into()]).collect();
    View::Table(Table { title: "Points".into(), columns, rows, note: String::new() })
}

/// Tags that must be closed are closed, in order.
fn assert_nested(html: &str) {
    // The page's own script is no markup.
    let (before, script) = html.split_once("<script>").expect("the page has a script");
    let html = format!("{before}<script>{}", &script[script.find("</script>").expect("it ends")..]);
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html.as_str();
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("every tag ends");
        let tag = &rest[..end];
        let name = tag.trim_start_matches('/').split([' ', '\n']).next().unwrap_or_default();
        let void = ["!doctype", "meta", "img", "br"].contains(&name) || tag.ends_with('/');
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "near {}", &rest[..end.min(80)]);
        } else if !void {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

#[test]
fn a_study_shows_its_numbers_figures_and_pictures() {
    let mut one = point("", State::Ran);
    one.views = vec![table(3), figure(), picture(9), picture(200)];
    let sweep = ["2.5 km/s", "4.2 km/s"].map(|v| point(&format!("velocity={v}"), State::Hit));
    let html = render(&study(vec![step("states", &[], sweep.into()), step("copper", &["states"], vec![one])]));
    // The template engine writes a slash as an entity.
    let slashed = html.replace("&#x2f;", "/");
    for part in [
        "<h1>copper</h1>",
        "Because.",
        "hvi-flow run copper.toml",
        "velocity<small>km/s</small>",
        ">2.5</td>",
        ">32.51</td>",
        "pressure<small>GPa</small>",
        "0.00 ± 0.25",
        "Hugoniot",
        "data:image/png;base64,iVBOR",
        "background:#0102ff",
        "liquid &amp; more",
        "2 from store",
        "href=\"#step-1\"",
        "id=\"step-1\"",
    ] {
        assert!(slashed.contains(part), "{part} is missing in\n{html}");
    }
    assert_nested(&html);
    assert_eq!(html, render(&study_again()), "the same study gives the same page");
}

fn study_again() -> Study {
    let mut one = point("", State::Ran);
    one.views = vec![table(3), figure(), picture(9), picture(200)];
    let sweep = ["2.5 km/s", "4.2 km/s"].map(|v| point(&format!("velocity={v}"), State::Hit));
    study(vec![step("states", &[], sweep.into()), step("copper", &["states"], vec![one])])
}

/// Opens offline: nothing is loaded from anywhere.
#[test]
fn the_page_stands_alone() {
    let html = render(&study_again());
    assert_eq!(html.matches("<script").count(), 3, "a figure's data, the study's, and the page's own script");
    for outside in ["<script src", "<link", "@import", "url(http", "src=\"http", "<iframe", "fetch(", "XMLHttpRequest"]
    {
        assert!(!html.contains(outside), "{outside}");
    }
    let links = html.matches("http").count() - html.matches("http-equiv").count();
    assert_eq!(links, html.matches("http://www.w3.org/2000/svg\"").count(), "names of formats only");
}

#[test]
fn names_are_escaped_everywhere() {
    let evil = "<script>alert('x')</script>\"";
    let mut bad = point(&format!("{evil}={evil}"), State::Failed(evil.into()));
    bad.scalars = [Scalar::text(evil, evil)].into();
    bad.params = [(evil.to_string(), evil.to_string())].into();
    bad.swept = vec![(evil.into(), evil.into())];
    let mut shown = point("", State::Hit);
    shown.key = evil.into();
    shown.scalars = [Scalar::number(evil, 1.0, evil)].into();
    let text = || evil.to_string();
    let rows = vec![vec![Cell::Text(text())]];
    shown.views = vec![
        View::Table(Table { title: text(), columns: vec![(text(), text())], rows, note: text() }),
        View::Figure(Figure {
            title: text(),
            x: Axis::linear(evil, evil),
            y: Axis::linear(evil, evil),
            series: vec![Series::new(evil, Style::Crosses, vec![(1.0, 1.0)])],
            note: text(),
        }),
        View::Picture(Picture {
            title: text(),
            width: 1,
            height: 1,
            rgb: vec![0; 3],
            legend: vec![([0; 3], text())],
            note: text(),
        }),
    ];
    let steps = vec![
        Step { name: text(), stage: text(), summary: text(), needs: vec![], sketches: vec![], points: vec![bad] },
        Step {
            name: "ok".into(),
            stage: text(),
            summary: text(),
            needs: vec![text()],
            sketches: vec![],
            points: vec![shown],
        },
    ];
    let html = render(&Study { name: text(), question: text(), steps, seconds: 1.0, command: text() });
    assert!(!html.contains("<script>alert"), "{html}");
    assert!(html.contains("&lt;script"));
    assert_nested(&html);
}

#[test]
fn any_study_has_a_page() {
    let failed = || State::Failed("step 12, t = 0.4 us: no convergence".into());
    let skipped = || State::Skipped("its input `states` failed".into());
    let cases = [
        study(vec![]),
        study(vec![step("empty", &[], vec![])]),
        study(vec![step("a", &[], vec![point("", failed())]), step("b", &["a"], vec![point("", skipped())])]),
        study(vec![step("a", &[], (0..40).map(|k| point(&format!("v={k} m/s"), State::Cancelled)).collect())]),
    ];
    for case in &cases {
        let html = render(case);
        assert!(html.contains("<h1>copper</h1>") && !html.contains("<pre>"), "{html}");
        assert_nested(&html);
    }
    assert!(render(&cases[0]).contains("This study has no steps"));
    let html = render(&cases[2]);
    assert!(html.contains("role=\"alert\"") && html.matches("step 12, t = 0.4 us: no convergence").count() == 2);
    assert!(html.contains("its input `states` failed"));
    assert!(render(&cases[3]).contains("40 not run"));
}

/// 10,000 points with a picture and a figure each: a page of a few megabytes that says what it leaves out.
#[test]
fn a_great_study_is_cut_to_size() {
    let rows = |k: usize| if k < 30 { 2000 } else { 1 };
    let points = (0..10_000).map(|k| Point {
        views: vec![picture((k % 256) as u8), figure(), table(rows(k))],
        ..point(&format!("velocity={k} m/s"), if k % 1000 == 7 { State::Failed("too fast".into()) } else { State::Ran })
    });
    let html = render(&study(vec![step("runs", &[], points.collect())]));
    assert!(html.len() < 6_000_000, "{} bytes", html.len());
    for part in [
        "9500 more points are left out",
        "9968 of 10000 pictures",
        "the tables and figures of 9976 of 10000 points",
        "1500 more rows are left out",
        "9990 computed, 10 failed",
    ] {
        assert!(html.contains(part), "{part}");
    }
    assert_nested(&html);
}
