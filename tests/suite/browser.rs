//! The report in a real browser: every figure draws, nothing is asked of the network, keys work, contrast is enough.
use super::chromium::Chromium;
use super::project::Project;
use hvi_flow::report::{self, Point, State, Step, Study};
use hvi_kit::view::{Axis, Figure, Scalar, Series, Style, View};
use serde_json::json;

const STUDY: &str = r#"
[step.metal]
use = "eos.handbook"
set = "copper-royce"
[step.curves]
use = "eos.curves"
eos = "@metal"
[step.hit]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper" }
plate = { material = "copper", thickness = "0.5 mm", width = "3 mm", eos = "@metal" }
cells = 2
times = ["0.1 us", "0.2 us"]
end = "0.3 us"
sweep = { velocity = ["2 km/s", "3 km/s"] }
[step.film]
use = "radiograph"
run = "@hit[velocity=3 km/s]"
width = 64
sweep = { exposures = [["0.1 us"], ["0.2 us"], ["0.3 us"]] }
[step.other_film]
use = "radiograph"
run = "@hit[velocity=2 km/s]"
width = 64
xray = { energy = "150 keV" }
[step.never]
use = "radiograph"
run = "@hit[velocity=2 km/s]"
exposures = ["7 us"]
"#;

/// Least contrast of any text on the page to what is behind it, with the text: WCAG 2.1, 1.4.3.
const CONTRAST: &str = r#"(() => {
  const rgb = (text) => (text.match(/[\d.]+/g) || []).map(Number);
  const luminance = (c) => {
    const [r, g, b] = c.slice(0, 3).map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (e) => {
    for (; e; e = e.parentElement) {
      const c = rgb(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] === 1) return c;
    }
    return [255, 255, 255];
  };
  let least = [99, ""];
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.getClientRects().length || ["SCRIPT", "STYLE", "TITLE", "OPTION"].includes(e.tagName.toUpperCase())) continue;
    const style = getComputedStyle(e);
    if (style.visibility === "hidden") continue;
    const svg = e instanceof SVGElement;
    const box = svg && e.closest("svg.chain") ? e.parentElement.querySelector(".box") : null;
    const back = box ? rgb(getComputedStyle(box).fill) : behind(svg ? e.closest("svg").parentElement : e);
    const [a, b] = [luminance(rgb(svg ? style.fill : style.color)), luminance(back)].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    if (ratio < least[0]) least = [ratio, e.tagName + ": " + e.textContent.trim().slice(0, 60)];
  }
  return least;
})()"#;

fn page() -> (Project, std::path::PathBuf) {
    let project = Project::new(STUDY);
    let said = project.hvi(&["run", "study.toml", "--keep-going"]);
    assert_eq!(said.code, 1, "the step `never` fails: {}", said.err);
    let page = project.path("out/study/report.html");
    (project, page)
}

#[test]
fn the_report_in_a_browser() {
    let (_project, page) = page();
    let mut browser = Chromium::start();
    browser.screen("light", "screen", [1280, 900]);
    browser.open(&page);
    figures_draw(&mut browser);
    keys_work(&mut browser);
    numbers_say_where_they_come_from(&mut browser);
    pictures_go_by_time(&mut browser);
    for scheme in ["light", "dark"] {
        browser.screen(scheme, "screen", [1280, 900]);
        let least = browser.value(CONTRAST);
        assert!(least[0].as_f64().unwrap() >= 4.5, "{scheme}: {least}");
    }
    browser.screen("light", "screen", [360, 740]);
    let wide = browser.value("document.documentElement.scrollWidth - window.innerWidth");
    assert!(wide.as_f64().unwrap() <= 0.0, "a phone has to scroll sideways by {wide} px");
    browser.screen("dark", "print", [1280, 900]);
    let paper = browser.value("getComputedStyle(document.body).backgroundColor");
    assert_eq!(paper, "rgb(255, 255, 255)", "printed on white");
    let still = browser.value("getComputedStyle(document.querySelector('.plot.alive > svg')).display");
    assert_eq!(still, "block", "the still drawing is printed");
    assert_eq!(browser.faults(), Vec::<String>::new());
}

fn figures_draw(browser: &mut Chromium) {
    browser.value("document.querySelectorAll('details').forEach((d) => (d.open = true))");
    let count = browser.value("document.querySelectorAll('.plot[data-plot]').length").as_u64().unwrap();
    assert!(count >= 8, "{count} figures");
    for k in 0..count {
        let frame = format!("document.querySelectorAll('.plot[data-plot]')[{k}]");
        browser.value(&format!("{frame}.scrollIntoView()"));
        browser.wait(&format!("{frame}.classList.contains('alive')"));
        let drawn = browser.value(&format!("{frame}.querySelectorAll('.live-plot g path').length"));
        let broken =
            browser.value(&format!("/NaN|Infinity|undefined/.test({frame}.querySelector('.plot-box').innerHTML)"));
        assert!(drawn.as_u64().unwrap() > 0 && broken == false, "figure {k}");
    }
    let images = "[...document.images].every((i) => i.complete && i.naturalWidth > 0)";
    browser.wait(images);
    let sketches = browser.value("document.querySelectorAll('.plot:not([data-plot]) svg circle').length");
    assert!(sketches.as_u64().unwrap() >= 1, "the scene's set-up is drawn");
}

fn keys_work(browser: &mut Chromium) {
    let plot = "document.querySelector('.live-plot')";
    let ticks = format!("[...{plot}.querySelectorAll('text')].map((t) => t.textContent).join(' ')");
    // By Tab from the page's start: links of the chain, buttons, then plots.
    browser.value("document.activeElement.blur(); window.scrollTo(0, 0)");
    let reached = (0..200).any(|_| {
        browser.press("Tab");
        browser.value(&format!("document.activeElement === {plot}")) == true
    });
    assert!(reached, "Tab never reaches a plot");
    let whole = browser.value(&ticks);
    browser.press("+");
    let zoomed = browser.value(&ticks);
    assert_ne!(whole, zoomed, "+ zooms");
    browser.press("ArrowRight");
    assert_ne!(zoomed, browser.value(&ticks), "arrows move");
    browser.press("0");
    assert_eq!(whole, browser.value(&ticks), "0 shows all");
    browser.press("]");
    let tip = browser.value(&format!("{plot}.parentElement.querySelector('.tip-box').textContent"));
    assert!(tip.as_str().unwrap().contains(':'), "a point speaks: {tip}");
    let curves = format!("{plot}.querySelectorAll('g path').length");
    let all = browser.value(&curves).as_u64().unwrap();
    browser.value("document.querySelector('.plot-legend button').focus()");
    browser.press("Enter");
    assert!(browser.value(&curves).as_u64().unwrap() < all, "the legend hides a series");
    browser.value("document.querySelector('.plot-bar button').click()");
    let log = browser.value("document.querySelector('.plot-bar button').getAttribute('aria-pressed')");
    assert_eq!(log, "true", "a logarithmic axis");
}

fn numbers_say_where_they_come_from(browser: &mut Chromium) {
    browser.value("document.querySelector('tr[data-point=\"1\"] td.number:nth-child(3)').click()");
    let said = browser.value("document.querySelector('dialog[open]').textContent");
    let said = said.as_str().unwrap();
    for part in ["hit", "impact", "velocity", "key", "metal"] {
        assert!(said.contains(part), "{part} in {said}");
    }
    browser.press("Escape");
    browser.wait("!document.querySelector('dialog[open]')");
}

fn pictures_go_by_time(browser: &mut Chromium) {
    let shown = "[...document.querySelectorAll('button')].find((b) => b.textContent === 'one by one')\
                 .parentElement.nextElementSibling.querySelectorAll('figure:not([hidden])').length";
    let all = browser.value(shown).as_u64().unwrap();
    browser.value("[...document.querySelectorAll('button')].find((b) => b.textContent === 'one by one').click()");
    let one = browser.value(shown).as_u64().unwrap();
    assert!(one < all && one >= 1, "{one} of {all} pictures");
    assert_eq!(browser.value("document.querySelectorAll('#beside figure').length"), 2, "two steps side by side");
}

/// 10,000 points with figures: the page opens, draws what is near, and says the rest.
#[test]
fn a_great_study_opens() {
    let figure = || {
        let points = (0..500).map(|k| (f64::from(k), f64::from(k * k))).collect();
        let (x, y) = (Axis::linear("V", "cm3/g"), Axis::linear("P", "GPa"));
        let series = vec![Series::new("MD", Style::Line, points)];
        View::Figure(Figure { title: "Hugoniot".into(), x, y, series, note: String::new() })
    };
    let point = |k: usize| Point {
        label: format!("velocity={k} m/s"),
        state: if k % 100 == 7 { State::Failed("too fast".into()) } else { State::Ran },
        seconds: 0.5,
        key: format!("{k:064x}"),
        params: vec![("atoms".to_string(), "500".to_string())].into(),
        swept: vec![("velocity".into(), format!("{k} m/s"))],
        scalars: [Scalar::number("pressure", k as f64, "GPa")].into(),
        views: vec![figure()],
        unread: report::Unread::default(),
    };
    let step = |name: &str, points: Vec<Point>| Step {
        name: name.into(),
        stage: "md".into(),
        summary: "states".into(),
        needs: vec![],
        sketches: vec![],
        points,
    };
    let steps = vec![step("runs", (0..10_000).map(point).collect()), step("nothing", vec![])];
    let study = Study {
        name: "great".into(),
        question: String::new(),
        steps,
        seconds: 1.0,
        command: "hvi-flow run great.toml".into(),
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    std::fs::write(&file, report::render(&study)).unwrap();
    let mut browser = Chromium::start();
    browser.open(&file);
    let text = browser.value("document.body.innerText");
    assert!(text.as_str().unwrap().contains("9500 more points are left out"));
    let first = "document.querySelector('details[data-point]')";
    browser.value(&format!("{first}.open = true; {first}.scrollIntoView()"));
    browser.wait("document.querySelector('.plot.alive') !== null");
    assert_eq!(browser.faults(), Vec::<String>::new());
    let params = json!({ "expression": "document.querySelectorAll('*').length", "returnByValue": true });
    let nodes = browser.call("Runtime.evaluate", params)["result"]["value"].as_u64().unwrap();
    assert!(nodes < 60_000, "{nodes} elements");
}

/// Behind its secret the page renews itself while the study runs; nothing else is answered.
#[test]
fn a_study_is_watched() {
    use std::io::{BufRead, BufReader, Read, Write};
    let project = Project::new(super::project::SLOW);
    let mut browser = Chromium::start();
    let mut command = project.command(&["run", "study.toml", "--watch"]);
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("http://") {
        line.clear();
        assert!(said.read_line(&mut line).unwrap() > 0, "no address was said");
    }
    let url = line[line.find("http://").unwrap()..].trim().to_string();
    let (host, path) = url.strip_prefix("http://").unwrap().split_once('/').unwrap();
    assert!(host.starts_with("127.0.0.1:"), "{url}");
    let ask = |path: &str, named: &str| {
        let mut stream = std::net::TcpStream::connect(host).unwrap();
        write!(stream, "GET /{path} HTTP/1.1\r\nHost: {named}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    assert!(ask(path, host).contains("<h1>study</h1>"));
    let state = ask(&format!("{path}state"), host);
    assert!(state.contains("\"of\":1"), "{state}");
    let other = path.replace(['0', '1', '2', '3'], "9");
    for refused in [ask("", host), ask(&other, host), ask(path, "example.org"), ask(&format!("{path}other"), host)] {
        assert!(refused.starts_with("HTTP/1.1 404"), "{refused}");
    }
    browser.call("Page.navigate", json!({ "url": url }));
    browser.wait("document.querySelector('.live-bar') !== null && /done|at work|over/.test(document.querySelector('.live-bar').textContent)");
    let mut rest = String::new();
    said.read_to_string(&mut rest).unwrap();
    assert!(child.wait().unwrap().success(), "{rest}");
}
