//! Figures as SVG (here), drawings too (`figure/drawing.rs`), pictures as PNG and tables as CSV (`figure/files.rs`), figures as PNG
//! (`figure/raster.rs`), numbers and names as text (`figure/words.rs`):
//! what people see of `hvi_kit::view`, the same bytes for the same view.
//!
//! The SVG is written by hand: text stays text, axes take the page's colour (`currentColor`), the background stays clear, so
//! that a figure reads in light and dark pages alike.
mod drawing;
mod files;
mod raster;
mod words;
pub use drawing::drawing;
pub use files::{csv, png};
pub use raster::raster;
pub use words::{escape, number, uncertain, unit};

use hvi_kit::math;
use hvi_kit::view::{Axis, Figure, Series, Style};
use std::fmt::Write;
use words::{order, ten};

/// Colours of the series, each at least 3:1 against white and against near-black, and apart without red-green vision.
const COLOURS: [&str; 8] = ["#2b7bba", "#d55e00", "#008f68", "#b8578f", "#a87b00", "#1a94b8", "#7d828a", "#96603a"];

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 430.0;
/// Plot area: left, top, right, bottom.
const AREA: [f64; 4] = [74.0, 16.0, 704.0, 360.0];
/// Rows of the legend, below the plot.
const LEGEND_ROW: f64 = 20.0;
/// Mean width of a letter.
const LETTER: f64 = 6.6;

/// One axis, laid out.
struct Scale {
    log: bool,
    low: f64,
    high: f64,
    /// Pixels at `low` and `high`.
    at: [f64; 2],
}

impl Scale {
    /// From the finite values (positive ones on a logarithmic axis), with room around them; `zero` keeps 0 in sight.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, zero: bool, at: [f64; 2]) -> Scale {
        let usable = values.filter(|v| v.is_finite() && (!axis.log || *v > 0.0));
        let (mut low, mut high) = usable.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            (low, high) = if axis.log { (1.0, 10.0) } else { (0.0, 1.0) };
        }
        if axis.log {
            let room = math::pow(high / low, 0.04).max(1.1);
            return Scale { log: true, low: (low / room).max(f64::MIN_POSITIVE), high: high * room, at };
        }
        if zero && low > 0.0 && low < 0.5 * high {
            low = 0.0;
        }
        let span = if high > low { high - low } else { high.abs().max(1e-300) };
        let pad = if high > low { 0.04 } else { 0.5 };
        let low = if low == 0.0 && zero { 0.0 } else { low - pad * span };
        Scale { log: false, low, high: high + pad * span, at }
    }

    fn place(&self, v: f64) -> Option<f64> {
        if !v.is_finite() || (self.log && v <= 0.0) {
            return None;
        }
        let share = if self.log {
            math::log(v / self.low) / math::log(self.high / self.low)
        } else {
            (v - self.low) / (self.high - self.low)
        };
        let pixel = self.at[0] + share * (self.at[1] - self.at[0]);
        pixel.is_finite().then_some(pixel)
    }

    /// Values with a label at round places.
    fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        if self.log {
            return self.decades(most);
        }
        let rough = (self.high - self.low) / most as f64;
        let mut step = ten(order(rough));
        step *= [1.0, 2.0, 5.0, 10.0].into_iter().find(|k| k * step >= rough * (1.0 - 1e-9)).unwrap_or(10.0);
        let first = (self.low / step - 1e-9).ceil();
        let count = ((self.high / step + 1e-9).floor() - first).max(0.0) as usize;
        let peak = self.low.abs().max(self.high.abs());
        let places = (-order(step)).max(0) as usize;
        let plain = (1e-4..1e6).contains(&peak);
        let name = |v: f64| if plain { format!("{v:.places$}").replace('-', "−") } else { number(v, 4) };
        (0..=count.min(3 * most))
            .map(|k| (first + k as f64) * step)
            .map(|v| (v, name(if v == 0.0 { 0.0 } else { v })))
            .collect()
    }

    fn decades(&self, most: usize) -> Vec<(f64, String)> {
        let (first, last) = (order(self.low), order(self.high) + 1);
        let decades = (last - first).max(1) as usize;
        let stride = decades.div_ceil(most.max(1)).max(1);
        let mantissas: &[f64] = if self.high / self.low < 300.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let inside = |v: &f64| *v >= self.low * (1.0 - 1e-9) && *v <= self.high * (1.0 + 1e-9);
        let plain = first >= -3 && last <= 5;
        let name = |e: i32, m: f64| if plain { number(m * ten(e), 3) } else { power(m, e) };
        (first..=last)
            .step_by(stride)
            .flat_map(|e| mantissas.iter().map(move |&m| (m * ten(e), m, e)))
            .filter(|(v, _, _)| inside(v))
            .map(|(v, m, e)| (v, name(e, m)))
            .collect()
    }
}

/// `m` times ten to the power `e`, with raised digits.
fn power(m: f64, e: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    let exponent: String = e.to_string().chars().map(raised).collect();
    if m == 1.0 { format!("10{exponent}") } else { format!("{m}·10{exponent}") }
}

/// A figure as a self-contained SVG element.
///
/// A series without a label is drawn in the colour of the series before it: a curve and its points.
pub fn svg(figure: &Figure) -> String {
    let points = || figure.series.iter().flat_map(|s| s.points.iter());
    let bars = figure.series.iter().flat_map(|s| {
        s.points.iter().zip(&s.errors).filter(|(_, e)| e.is_finite()).flat_map(|(p, e)| [p.1 - e.abs(), p.1 + e.abs()])
    });
    let x = Scale::new(&figure.x, points().map(|p| p.0), false, [AREA[0], AREA[2]]);
    let y = Scale::new(&figure.y, points().map(|p| p.1).chain(bars), true, [AREA[3], AREA[1]]);
    let labelled: Vec<(&Series, &str)> = coloured(&figure.series).filter(|(s, _)| !s.label.is_empty()).collect();
    let height = HEIGHT + LEGEND_ROW * (flow(&labelled).1 - 1) as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" height=\"{height}\" role=\"img\" \
         font-family=\"system-ui, sans-serif\" font-size=\"12.5\" fill=\"none\" stroke-width=\"1\">\n<title>{}</title>\n",
        escape(&figure.title)
    );
    axes(&mut out, figure, &x, &y);
    for (s, colour) in coloured(&figure.series) {
        series(&mut out, s, colour, &x, &y);
    }
    if points().next().is_none() {
        text(&mut out, 0.5 * (AREA[0] + AREA[2]), 0.5 * (AREA[1] + AREA[3]), "middle", "no points");
    }
    legend(&mut out, &labelled);
    out += "</svg>\n";
    out
}

/// The series with their colours: one without a label has that of the series before it.
pub fn coloured(series: &[Series]) -> impl Iterator<Item = (&Series, &'static str)> {
    let mut used = 0usize;
    series.iter().enumerate().map(move |(k, s)| {
        if k == 0 || !s.label.is_empty() {
            used += 1;
        }
        (s, COLOURS[(used - 1) % COLOURS.len()])
    })
}

fn text(out: &mut String, x: f64, y: f64, anchor: &str, what: &str) {
    let what = escape(what);
    let _ =
        writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"currentColor\">{what}</text>");
}

fn axes(out: &mut String, figure: &Figure, x: &Scale, y: &Scale) {
    let [left, top, right, bottom] = AREA;
    let _ = writeln!(out, "<g stroke=\"currentColor\">");
    let (mut grid, mut labels) = (String::new(), String::new());
    for (v, name) in x.ticks(8) {
        let Some(at) = x.place(v) else { continue };
        let _ = write!(grid, "M{at:.1} {top}V{bottom}");
        text(&mut labels, at, bottom + 18.0, "middle", &name);
    }
    for (v, name) in y.ticks(6) {
        let Some(at) = y.place(v) else { continue };
        let _ = write!(grid, "M{left} {at:.1}H{right}");
        text(&mut labels, left - 7.0, at + 4.3, "end", &name);
    }
    let _ = writeln!(out, "<path d=\"{grid}\" stroke-opacity=\"0.13\"/>");
    let _ = writeln!(out, "<path d=\"M{left} {top}V{bottom}H{right}\" stroke-opacity=\"0.6\"/>\n</g>");
    *out += &labels;
    let name = |axis: &Axis| {
        if axis.unit.is_empty() { axis.label.clone() } else { format!("{} [{}]", axis.label, unit(&axis.unit)) }
    };
    text(out, 0.5 * (left + right), bottom + 38.0, "middle", &name(&figure.x));
    let middle = 0.5 * (top + bottom);
    let _ = writeln!(
        out,
        "<text transform=\"translate(15 {middle:.1}) rotate(-90)\" text-anchor=\"middle\" fill=\"currentColor\">{}</text>",
        escape(&name(&figure.y))
    );
}

fn series(out: &mut String, s: &Series, colour: &str, x: &Scale, y: &Scale) {
    let placed = |p: &(f64, f64)| Some((x.place(p.0)?, y.place(p.1)?));
    if matches!(s.style, Style::Line | Style::Dashed) {
        let mut path = String::new();
        let mut pen_down = false;
        for p in &s.points {
            // A point that can't be drawn breaks the line.
            let Some((px, py)) = placed(p) else {
                pen_down = false;
                continue;
            };
            path.push(if pen_down { 'L' } else { 'M' });
            tenths(&mut path, px);
            path.push(' ');
            tenths(&mut path, py);
            pen_down = true;
        }
        let _ = writeln!(
            out,
            "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-linejoin=\"round\"{}/>",
            dash(s.style)
        );
    }
    let mut bars = String::new();
    for (p, e) in s.points.iter().zip(&s.errors).filter(|(_, e)| e.is_finite() && **e != 0.0) {
        let ends = [y.place(p.1 - e.abs()).or(y.log.then_some(AREA[3])), y.place(p.1 + e.abs())];
        if let (Some(px), [Some(low), Some(high)]) = (x.place(p.0), ends) {
            let _ = write!(bars, "M{px:.1} {low:.1}V{high:.1}M{:.1} {low:.1}h6M{:.1} {high:.1}h6", px - 3.0, px - 3.0);
        }
    }
    if !bars.is_empty() {
        let _ = writeln!(out, "<path d=\"{bars}\" stroke=\"{colour}\" stroke-width=\"1.2\"/>");
    }
    if !matches!(s.style, Style::Line | Style::Dashed) {
        s.points.iter().filter_map(placed).for_each(|(px, py)| marker(out, s.style, colour, px, py));
    }
}

/// Writes a coordinate with one decimal: a page has many thousands, for which the general way takes three times as long.
fn tenths(out: &mut String, v: f64) {
    let whole = (10.0 * v).round() as i64;
    let (sign, whole) = (if whole < 0 { "-" } else { "" }, whole.unsigned_abs());
    let _ = write!(out, "{sign}{}.{}", whole / 10, whole % 10);
}

fn dash(style: Style) -> &'static str {
    if style == Style::Dashed { " stroke-dasharray=\"6 4\"" } else { "" }
}

fn marker(out: &mut String, style: Style, colour: &str, x: f64, y: f64) {
    let _ = match style {
        Style::Dots => writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.4\" fill=\"{colour}\"/>"),
        Style::Circles => {
            writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.4\" stroke=\"{colour}\" stroke-width=\"1.5\"/>")
        }
        Style::Crosses => writeln!(
            out,
            "<path d=\"M{:.1} {:.1}l7 7m0 -7l-7 7\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
            x - 3.5,
            y - 3.5
        ),
        Style::Triangles => {
            writeln!(out, "<path d=\"M{x:.1} {:.1}l4 7h-8z\" fill=\"{colour}\"/>", y - 4.5)
        }
        Style::Line | Style::Dashed => Ok(()),
    };
}

/// Places of the legend's entries, left to right and row by row as they fit; and the number of rows.
fn flow(entries: &[(&Series, &str)]) -> (Vec<(f64, usize)>, usize) {
    let (mut x, mut row) = (AREA[0], 0);
    let place = |(s, _): &(&Series, &str)| {
        let width = 48.0 + LETTER * shorten(&s.label).chars().count() as f64;
        if x > AREA[0] && x + width > AREA[2] + 16.0 {
            (x, row) = (AREA[0], row + 1);
        }
        let here = (x, row);
        x += width;
        here
    };
    let places: Vec<_> = entries.iter().map(place).collect();
    let rows = places.last().map_or(1, |p| p.1 + 1);
    (places, rows)
}

fn legend(out: &mut String, entries: &[(&Series, &str)]) {
    for ((s, colour), (x, row)) in entries.iter().zip(flow(entries).0) {
        let y = HEIGHT - 6.0 + LEGEND_ROW * row as f64;
        let middle = y - 4.0;
        match s.style {
            Style::Line | Style::Dashed => {
                let dash = dash(s.style);
                let _ = writeln!(
                    out,
                    "<path d=\"M{x:.1} {middle:.1}h22\" stroke=\"{colour}\" stroke-width=\"1.8\"{dash}/>"
                );
            }
            style => marker(out, style, colour, x + 11.0, middle),
        }
        text(out, x + 28.0, y, "start", &shorten(&s.label));
    }
}

/// At most as many characters as fit into one row of the legend.
fn shorten(text: &str) -> String {
    const MOST: usize = 84;
    if text.chars().count() <= MOST { text.into() } else { text.chars().take(MOST - 1).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(log: bool, points: Vec<(f64, f64)>) -> Figure {
        let axis = |label: &str, unit: &str| Axis { label: label.into(), unit: unit.into(), log };
        let errors = vec![0.5; points.len()];
        let dots = Series { errors, ..Series::new("measured <here>", Style::Dots, points.clone()) };
        let line = Series::new("", Style::Line, points);
        Figure {
            title: "P & V".into(),
            x: axis("V", "cm3/g"),
            y: axis("P", "GPa"),
            series: vec![dots, line],
            note: String::new(),
        }
    }

    /// Contrast of WCAG 2.1: graphics need 3:1, here against white and against the page's dark background.
    #[test]
    fn colours_stand_out_on_light_and_dark() {
        let luminance = |hex: &str| {
            let part = |k: usize| f64::from(u8::from_str_radix(&hex[k..k + 2], 16).unwrap()) / 255.0;
            let linear = |c: f64| if c <= 0.04045 { c / 12.92 } else { math::pow((c + 0.055) / 1.055, 2.4) };
            0.2126 * linear(part(1)) + 0.7152 * linear(part(3)) + 0.0722 * linear(part(5))
        };
        for colour in COLOURS {
            let l = luminance(colour);
            assert!(1.05 / (l + 0.05) >= 3.0, "{colour} on white");
            assert!((l + 0.05) / (luminance("#15181c") + 0.05) >= 3.0, "{colour} on dark");
        }
    }

    #[test]
    fn text_is_text_and_escaped() {
        let svg = svg(&figure(false, vec![(1.0, 2.0), (3.0, 5.0)]));
        for part in [
            ">V [cm³/g]</text>",
            ">P [GPa]</text>",
            "measured &lt;here&gt;",
            "<title>P &amp; V</title>",
            "currentColor",
        ] {
            assert!(svg.contains(part), "{part} in {svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 3, "two points and one in the legend");
        assert_eq!(svg.matches(COLOURS[0]).count(), 5, "points, bars, curve and legend share a colour");
    }

    #[test]
    fn nothing_that_cannot_be_drawn_is_drawn() {
        for log in [false, true] {
            for points in [
                vec![],
                vec![(f64::NAN, 1.0)],
                vec![(0.0, -1.0), (2.0, f64::INFINITY)],
                vec![(1e-300, 1e300)],
                vec![(5.0, 5.0)],
            ] {
                let svg = svg(&figure(log, points.clone()));
                assert!(
                    svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"),
                    "{log} {points:?}: {svg}"
                );
            }
        }
    }

    #[test]
    fn ticks_are_round() {
        let names = |log: bool, low: f64, high: f64| {
            let scale = Scale { log, low, high, at: [0.0, 1.0] };
            scale.ticks(6).into_iter().map(|t| t.1).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(names(false, -0.04, 1.04), "0.0 0.2 0.4 0.6 0.8 1.0");
        assert_eq!(names(false, -11.0, 52.0), "0 20 40");
        assert_eq!(names(true, 0.5, 20.0), "0.5 1 2 5 10 20");
        assert_eq!(names(true, 1e-9, 1.1e3), "10⁻⁹ 10⁻⁶ 10⁻³ 10⁰ 10³");
    }
}
