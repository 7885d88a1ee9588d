//! Parts of the report: tables as rows of text, figures as drawings, pictures as embedded files.
use super::{Point, State, data};
use crate::figure::{self, escape, number, uncertain, unit};
use hvi_kit::units;
use hvi_kit::view::{Cell, Picture, Scalar, Table, View};
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// Rows of one table that the page holds; the files beside it hold all.
pub const MOST_ROWS: usize = 500;
/// Tables longer than this scroll in a box, those longer than the next are folded as well.
const LONG_TABLE: usize = 20;
const GREAT_TABLE: usize = 48;
/// Pictures in the whole page.
const MOST_PICTURES: usize = 96;
/// Pictures of one sweep.
pub const MOST_PICTURES_A_SWEEP: usize = 32;
/// Points of a sweep whose tables and figures are in the page.
pub const MOST_POINTS_SHOWN: usize = 24;

/// How many pictures still go into the page.
pub struct Budget {
    pictures: usize,
}
impl Default for Budget {
    fn default() -> Self {
        Budget { pictures: MOST_PICTURES }
    }
}
impl Budget {
    fn take(&mut self) -> bool {
        let left = self.pictures > 0;
        self.pictures = self.pictures.saturating_sub(1);
        left
    }
}

/// A table as text.
#[derive(Serialize)]
pub struct Grid {
    title: String,
    head: Vec<Head>,
    /// In the page, each row as its escaped cells.
    #[serde(serialize_with = "as_cells")]
    rows: Vec<Vec<Text>>,
    left_out: usize,
    tall: bool,
    folded: bool,
    total: usize,
    note: String,
}

#[derive(Serialize)]
struct Head {
    name: String,
    unit: String,
    number: bool,
}

struct Text {
    text: String,
    number: bool,
    class: &'static str,
    /// With all digits, where the text has fewer.
    full: String,
}

/// Rows as HTML: a page has thousands of cells, for which a template takes ten times as long.
fn as_cells<S: Serializer>(rows: &[Vec<Text>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(rows.iter().map(|row| {
        let mut html = String::with_capacity(32 * row.len());
        row.iter().for_each(|cell| cell.write(&mut html));
        html
    }))
}

impl Text {
    fn write(&self, html: &mut String) {
        html.push_str("<td");
        let class = [if self.number { "number" } else { "" }, self.class];
        let class: Vec<&str> = class.into_iter().filter(|c| !c.is_empty()).collect();
        for (name, value) in [("class", class.join(" ")), ("data-full", escape(&self.full))] {
            if !value.is_empty() {
                [" ", name, "=\"", &value, "\""].iter().for_each(|part| html.push_str(part));
            }
        }
        html.push('>');
        html.push_str(&escape(&self.text));
        html.push_str("</td>");
    }
    fn word(text: impl Into<String>, class: &'static str) -> Text {
        Text { text: text.into(), number: false, class, full: String::new() }
    }
    fn number(text: String, full: String) -> Text {
        let full = if full == text { String::new() } else { full };
        Text { text, number: true, class: "", full }
    }
    fn of(cell: &Cell) -> Text {
        match cell {
            Cell::Number(x) => Text::number(number(*x, 4), format!("{x}")),
            Cell::Uncertain(x, e) => Text::number(uncertain(*x, *e), format!("{x} ± {e}")),
            Cell::Text(t) => Text::word(t.clone(), ""),
            Cell::Empty => Text::word("", ""),
        }
    }
}

/// One thing after another in a step's section.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Block {
    /// A table.
    Table {
        /// It.
        grid: Grid,
    },
    /// A figure.
    Figure {
        /// Heading.
        title: String,
        /// The drawing, made here: safe.
        svg: String,
        /// Its points for the script, or nothing for a drawing that only is looked at.
        data: String,
        /// What to make of it.
        note: String,
    },
    /// Pictures side by side.
    Pictures {
        /// They.
        pictures: Vec<Image>,
    },
    /// What one point of a sweep shows, folded.
    Point {
        /// Which point, counted from 0.
        index: usize,
        /// Its name.
        label: String,
        /// What it shows.
        blocks: Vec<Block>,
    },
}

/// One picture.
#[derive(Serialize)]
pub struct Image {
    /// Pictures of one group follow each other in time.
    group: String,
    label: String,
    title: String,
    data: String,
    width: u32,
    height: u32,
    legend: Vec<(String, String)>,
    note: String,
}

/// A length of time for people.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s.is_nan() || s <= 0.0 => "0 s".into(),
        s if s < 0.0005 => "< 1 ms".into(),
        s if s < 0.9995 => format!("{:.0} ms", s * 1e3),
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 119.5 => format!("{s:.0} s"),
        s if s < 597.0 => format!("{:.1} min", s / 60.0),
        s if s < 7170.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn grid(title: &str, head: Vec<(String, String)>, mut rows: Vec<Vec<Text>>, note: &str) -> Grid {
    let total = rows.len();
    rows.truncate(MOST_ROWS);
    let numeric = |k: usize| rows.iter().any(|r| r.get(k).is_some_and(|t| t.number));
    let head = head
        .into_iter()
        .enumerate()
        .map(|(k, (name, unit))| Head { name, unit: figure::unit(&unit), number: numeric(k) })
        .collect();
    Grid {
        title: title.into(),
        head,
        left_out: total - rows.len(),
        rows,
        tall: total > LONG_TABLE,
        folded: total > GREAT_TABLE,
        total,
        note: note.into(),
    }
}

fn table(t: &Table) -> Grid {
    // Rows beyond those shown needn't be made into text.
    let cell = |(k, cell): (usize, &Cell)| match cell {
        Cell::Text(symbol) if t.columns.get(k).is_some_and(|c| c.0 == "unit") => Text::word(unit(symbol), "unit"),
        cell => Text::of(cell),
    };
    let shown = t.rows.iter().take(MOST_ROWS).map(|row| row.iter().enumerate().map(cell).collect()).collect();
    let mut grid = grid(&t.title, t.columns.clone(), shown, &t.note);
    (grid.total, grid.left_out) = (t.rows.len(), t.rows.len().saturating_sub(MOST_ROWS));
    (grid.tall, grid.folded) = (t.rows.len() > LONG_TABLE, t.rows.len() > GREAT_TABLE);
    grid
}

/// The numbers of a step without a sweep.
pub fn scalars(point: &Point) -> Option<Grid> {
    // Words stand in the numbers' column, so they are set like them.
    let value = |s: &Scalar| Text { number: true, ..Text::of(&s.value) };
    let row = |s: &Scalar| vec![Text::word(s.name.clone(), ""), value(s), Text::word(unit(&s.unit), "unit")];
    let head = ["quantity", "value", "unit"].map(|h| (h.to_string(), String::new())).to_vec();
    (!point.scalars.is_empty()).then(|| grid("", head, point.scalars.iter().map(row).collect(), ""))
}

/// A row a point: what the sweep sets, what came of it, the numbers.
pub fn sweep(points: &[Point]) -> Option<Grid> {
    let first = points.first()?;
    let mut keys: Vec<(String, String)> =
        first.swept.iter().map(|(k, _)| (k.clone(), common_unit(points, k))).collect();
    let by_label = keys.is_empty();
    if by_label {
        keys.push(("point".into(), String::new()));
    }
    let mut scalars: Vec<&Scalar> = Vec::new();
    for scalar in points.iter().flat_map(|p| &p.scalars[..]) {
        if !scalars.iter().any(|s| s.name == scalar.name) {
            scalars.push(scalar);
        }
    }
    let sound = points.iter().all(|p| matches!(p.state, State::Hit | State::Ran));
    let row = |p: &Point| {
        let mut row: Vec<Text> = if by_label {
            vec![Text::word(p.label.clone(), "")]
        } else {
            keys.iter().map(|(key, unit)| value(p, key, unit)).collect()
        };
        if !sound {
            row.push(state(&p.state));
        }
        let own = |s: &&Scalar| {
            p.scalars.iter().find(|own| own.name == s.name).map_or(Text::word("", ""), |own| Text::of(&own.value))
        };
        row.extend(scalars.iter().map(own));
        let took = if p.seconds > 0.0 { time(p.seconds) } else { String::new() };
        row.push(Text { class: "quiet", ..Text::number(took, String::new()) });
        row
    };
    let rows: Vec<_> = points.iter().take(MOST_ROWS).map(row).collect();
    let mut head = keys.clone();
    if !sound {
        head.push((String::new(), String::new()));
    }
    head.extend(scalars.iter().map(|s| (s.name.clone(), s.unit.clone())));
    head.push(("time".into(), String::new()));
    let mut grid = grid("", head, rows, "");
    (grid.total, grid.left_out) = (points.len(), points.len().saturating_sub(MOST_ROWS));
    (grid.tall, grid.folded) = (points.len() > LONG_TABLE, points.len() > GREAT_TABLE);
    Some(grid)
}

fn state(state: &State) -> Text {
    match state {
        State::Hit => Text::word("from store", "hit"),
        State::Ran => Text::word("computed", "ran"),
        State::Failed(_) => Text::word("failed", "failed"),
        State::Skipped(_) | State::Cancelled => Text::word("not run", "missing"),
    }
}

/// The unit that all values of a swept key are written in, or nothing.
fn common_unit(points: &[Point], key: &str) -> String {
    let mut found: Option<&str> = None;
    for (_, value) in points.iter().flat_map(|p| &p.swept).filter(|(k, _)| k == key) {
        match (units::split(value), found) {
            (Some((_, unit)), None) => found = Some(unit),
            (Some((_, unit)), Some(known)) if unit == known => {}
            _ => return String::new(),
        }
    }
    found.unwrap_or_default().into()
}

fn value(point: &Point, key: &str, unit: &str) -> Text {
    let Some((_, value)) = point.swept.iter().find(|(k, _)| k == key) else { return Text::word("", "") };
    match units::split(value).filter(|(_, own)| *own == unit) {
        Some((digits, _)) => Text::number(digits.replace('-', "−"), String::new()),
        None => Text::word(value.clone(), ""),
    }
}

/// Parameters that have the same value at every point.
pub fn shared_params(points: &[Point]) -> Vec<(String, String)> {
    let Some((first, rest)) = points.split_first() else { return Vec::new() };
    let others = || rest.iter().filter(|p| !Arc::ptr_eq(&p.params, &first.params));
    let everywhere =
        |(key, value): &&(String, String)| others().all(|p| p.params.iter().any(|(k, v)| k == key && v == value));
    first.params.iter().filter(everywhere).cloned().collect()
}

/// What a result shows, in its order; pictures that follow each other stand side by side.
pub fn blocks(views: &[View], budget: &mut Budget) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for view in views {
        match view {
            View::Table(t) => blocks.push(Block::Table { grid: table(t) }),
            View::Figure(f) => {
                let (title, note) = (f.title.clone(), f.note.clone());
                blocks.push(Block::Figure { title, svg: figure::svg(f), data: data::plot(f), note })
            }
            View::Drawing(d) => {
                let (title, note) = (d.title.clone(), d.note.clone());
                blocks.push(Block::Figure { title, svg: figure::drawing(d), data: String::new(), note })
            }
            View::Picture(p) => {
                if budget.take() {
                    push_picture(&mut blocks, image(p, ""));
                }
            }
            // Files for other programs.
            View::Trajectory(_) | View::Cloud(_) | View::Text(_) => {}
        }
    }
    blocks
}

fn push_picture(blocks: &mut Vec<Block>, image: Image) {
    match blocks.last_mut() {
        Some(Block::Pictures { pictures }) => pictures.push(image),
        _ => blocks.push(Block::Pictures { pictures: vec![image] }),
    }
}

/// A sweep's pictures as a gallery, its tables and figures folded by point; and what was left out, in words.
pub fn sweep_blocks(points: &[Point], budget: &mut Budget) -> (Vec<Block>, String) {
    let pictures = || {
        points.iter().flat_map(|p| {
            p.views.iter().filter_map(move |v| if let View::Picture(x) = v { Some((p, x)) } else { None })
        })
    };
    let mut blocks = Vec::new();
    let mut shown = 0;
    for (point, picture) in pictures().take(MOST_PICTURES_A_SWEEP) {
        if budget.take() {
            push_picture(&mut blocks, image(picture, &point.label));
            shown += 1;
        }
    }
    let other = |p: &&Point| p.views.iter().any(|v| !matches!(v, View::Picture(_)));
    for (index, point) in points.iter().enumerate().filter(|(_, p)| other(p)).take(MOST_POINTS_SHOWN) {
        let views: Vec<View> = point.views.iter().filter(|v| !matches!(v, View::Picture(_))).cloned().collect();
        blocks.push(Block::Point { index, label: point.label.clone(), blocks: self::blocks(&views, budget) });
    }
    let mut left = Vec::new();
    let all_pictures = pictures().count() + points.iter().map(|p| p.unread.pictures).sum::<usize>();
    let all_points = points.iter().filter(|p| other(p) || p.unread.more).count();
    if all_pictures > shown {
        left.push(format!("{} of {all_pictures} pictures", all_pictures - shown));
    }
    if all_points > MOST_POINTS_SHOWN {
        left.push(format!("the tables and figures of {} of {all_points} points", all_points - MOST_POINTS_SHOWN));
    }
    (blocks, left.join(" and "))
}

fn image(p: &Picture, label: &str) -> Image {
    let colour = |c: &[u8; 3]| format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
    Image {
        group: p
            .title
            .split([',', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9'])
            .next()
            .unwrap_or_default()
            .trim()
            .into(),
        label: label.into(),
        title: p.title.clone(),
        data: base64(&figure::png(p)),
        width: p.width,
        height: p.height,
        legend: p.legend.iter().map(|(c, text)| (colour(c), text.clone())).collect(),
        note: p.note.clone(),
    }
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let at = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for k in 0..4 {
            let digit = char::from(DIGITS[(word >> (18 - 6 * k) & 63) as usize]);
            out.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648, section 10.
    #[test]
    fn base64_of_the_standard() {
        for (text, expected) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }

    #[test]
    fn times_are_for_people() {
        let cases = [
            (0.0, "0 s"),
            (1e-5, "< 1 ms"),
            (0.0123, "12 ms"),
            (4.26, "4.3 s"),
            (71.0, "71 s"),
            (212.0, "3.5 min"),
            (600.0, "10 min"),
            (9000.0, "2.5 h"),
        ];
        for (seconds, text) in cases {
            assert_eq!(time(seconds), text);
        }
        assert_eq!(time(f64::NAN), "0 s");
    }
}
