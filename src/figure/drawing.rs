//! Drawings to scale as SVG: bodies, lengths, velocities.
use super::{COLOURS, LETTER, escape};
use hvi_kit::math;
use hvi_kit::view::{Drawing, Shape};
use std::fmt::Write;

/// Greatest width and height of the drawing proper [px].
const AREA: [f64; 2] = [560.0, 380.0];
/// Room around it for words.
const MARGIN: f64 = 54.0;
const ROW: f64 = 20.0;

/// From the drawing's unit to pixels.
struct Frame {
    scale: f64,
    left: f64,
    top: f64,
}

impl Frame {
    fn place(&self, p: [f64; 2]) -> [f64; 2] {
        [MARGIN + (p[0] - self.left) * self.scale, MARGIN + (self.top - p[1]) * self.scale]
    }
}

/// A drawing as a self-contained SVG element; text and axes take the page's colour.
pub fn drawing(d: &Drawing) -> String {
    let ends: Vec<[f64; 2]> = d.shapes.iter().flat_map(ends).filter(|p| p[0].is_finite() && p[1].is_finite()).collect();
    let bound = |k: usize| ends.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[k]), b.max(p[k])));
    let ((left, right), (bottom, top)) = if ends.is_empty() { ((0.0, 1.0), (0.0, 1.0)) } else { (bound(0), bound(1)) };
    let span = [(right - left).max(1e-300), (top - bottom).max(1e-300)];
    let scale = (AREA[0] / span[0]).min(AREA[1] / span[1]);
    let frame = Frame { scale, left, top };
    let words = d.bodies.iter().map(|b| b.chars().count()).max().unwrap_or(0) as f64 * LETTER + 40.0;
    let width = (span[0] * scale + 2.0 * MARGIN).max(words + 20.0).round();
    let height = (span[1] * scale + 2.0 * MARGIN + ROW * d.bodies.len() as f64).round();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\" \
         font-family=\"system-ui, sans-serif\" font-size=\"12.5\" fill=\"none\">\n<title>{}</title>\n",
        escape(&d.title)
    );
    d.shapes.iter().for_each(|s| shape(&mut out, &frame, s));
    for (k, name) in d.bodies.iter().enumerate() {
        let y = height - ROW * (d.bodies.len() - k) as f64 + 6.0;
        let colour = colour(k);
        let _ = writeln!(
            out,
            "<rect x=\"10\" y=\"{:.1}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"30\" y=\"{y:.1}\" \
             fill=\"currentColor\">{}</text>",
            y - 10.5,
            escape(name)
        );
    }
    out + "</svg>\n"
}

fn colour(body: usize) -> &'static str {
    COLOURS[body % COLOURS.len()]
}

fn ends(shape: &Shape) -> Vec<[f64; 2]> {
    match shape {
        Shape::Outline { corners, .. } => corners.clone(),
        Shape::Disc { centre: [x, y], radius: r, .. } => vec![[x - r, y - r], [x + r, y + r]],
        Shape::Arrow { from, to, .. } | Shape::Length { from, to, .. } | Shape::Axis { from, to } => vec![*from, *to],
    }
}

fn shape(out: &mut String, frame: &Frame, shape: &Shape) {
    let all = ends(shape).into_iter().map(|p| frame.place(p)).collect::<Vec<_>>();
    if all.iter().flatten().any(|x| !x.is_finite()) || all.is_empty() {
        return;
    }
    let (a, b) = (all[0], all[all.len() - 1]);
    let _ = match shape {
        Shape::Outline { body, .. } => {
            let points: Vec<String> = all.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
            // The thin stroke of its own colour closes the seams between rows.
            writeln!(
                out,
                "<polygon points=\"{}\" fill=\"{c}\" stroke=\"{c}\" stroke-width=\"0.6\"/>",
                points.join(" "),
                c = colour(*body)
            )
        }
        Shape::Disc { body, .. } => writeln!(
            out,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"{}\"/>",
            0.5 * (a[0] + b[0]),
            0.5 * (a[1] + b[1]),
            0.5 * (b[0] - a[0]),
            colour(*body)
        ),
        Shape::Axis { .. } => writeln!(
            out,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"currentColor\" stroke-opacity=\"0.6\" stroke-dasharray=\"9 4 2 4\"/>",
            a[0], a[1], b[0], b[1]
        ),
        Shape::Length { text, .. } => {
            ticked(out, a, b);
            // Beside an upright length, below a level one.
            let upright = (a[1] - b[1]).abs() > (a[0] - b[0]).abs();
            let at = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            if upright {
                // Off its middle, where an axis may run.
                words(out, [at[0] - 8.0, 0.75 * a[1].min(b[1]) + 0.25 * a[1].max(b[1]) + 4.0], "end", text)
            } else {
                words(out, [at[0], at[1] + 18.0], "middle", text)
            }
        }
        Shape::Arrow { text, .. } => {
            head(out, a, b);
            words(out, [0.5 * (a[0] + b[0]), a[1].min(b[1]) - 9.0], "middle", text)
        }
    };
}

fn words(out: &mut String, at: [f64; 2], anchor: &str, text: &str) -> std::fmt::Result {
    writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" fill=\"currentColor\">{}</text>",
        at[0],
        at[1],
        escape(text)
    )
}

/// A line with a stroke across either end.
fn ticked(out: &mut String, a: [f64; 2], b: [f64; 2]) {
    let along = unit(a, b);
    let tick = |p: [f64; 2]| {
        format!(
            "M{:.1} {:.1}L{:.1} {:.1}",
            p[0] - 4.0 * along[1],
            p[1] + 4.0 * along[0],
            p[0] + 4.0 * along[1],
            p[1] - 4.0 * along[0]
        )
    };
    let _ = writeln!(
        out,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}{}{}\" stroke=\"currentColor\" stroke-width=\"1.1\"/>",
        a[0],
        a[1],
        b[0],
        b[1],
        tick(a),
        tick(b)
    );
}

fn head(out: &mut String, a: [f64; 2], b: [f64; 2]) {
    let along = unit(a, b);
    let back = [b[0] - 9.0 * along[0], b[1] - 9.0 * along[1]];
    let side = |s: f64| format!("{:.1},{:.1}", back[0] - s * along[1], back[1] + s * along[0]);
    let _ = writeln!(
        out,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"currentColor\" stroke-width=\"1.8\"/><polygon points=\"{:.1},{:.1} {} {}\" \
         fill=\"currentColor\"/>",
        a[0],
        a[1],
        back[0],
        back[1],
        b[0],
        b[1],
        side(4.5),
        side(-4.5)
    );
}

fn unit(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let d = [b[0] - a[0], b[1] - a[1]];
    let long = math::sqrt(d[0] * d[0] + d[1] * d[1]).max(1e-9);
    [d[0] / long, d[1] / long]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_drawn_to_scale_and_escaped() {
        let shapes = vec![
            Shape::Outline { corners: vec![[0.0, -20.0], [2.0, -20.0], [2.0, 20.0], [0.0, 20.0]], body: 1 },
            Shape::Disc { centre: [-5.0, 0.0], radius: 5.0, body: 0 },
            Shape::Length { from: [-11.0, -5.0], to: [-11.0, 5.0], text: "10 mm".into() },
            Shape::Arrow { from: [-20.0, 0.0], to: [-12.0, 0.0], text: "5 km/s <here>".into() },
            Shape::Axis { from: [-20.0, 0.0], to: [4.0, 0.0] },
        ];
        let svg = drawing(&Drawing {
            title: "Set-up".into(),
            bodies: vec!["a & b".into(), "plate".into()],
            shapes,
            note: String::new(),
        });
        // 40 mm over 380 px is what fits: the disc's radius is 5 mm of it.
        assert!(svg.contains("r=\"47.5\""), "{svg}");
        assert!(svg.contains("&lt;here&gt;") && svg.contains("a &amp; b") && !svg.contains("NaN"));
    }

    #[test]
    fn what_has_no_size_is_drawn_too() {
        let empty = Drawing { title: String::new(), bodies: vec![], shapes: vec![], note: String::new() };
        let dot =
            Drawing { shapes: vec![Shape::Disc { centre: [1.0, f64::NAN], radius: 0.0, body: 0 }], ..empty.clone() };
        for d in [empty, dot] {
            let svg = drawing(&d);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
