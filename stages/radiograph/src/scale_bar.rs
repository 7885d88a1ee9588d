//! A scale bar of round length below a picture.
use hvi_kit::view::Picture;

/// Height of the strip that carries the bar [pixels].
const STRIP: usize = 26;
const INK: [u8; 3] = [60, 60, 60];

/// Rows of 5 bits, the leftmost highest.
const GLYPHS: [(char, [u8; 7]); 13] = [
    ('0', [14, 17, 19, 21, 25, 17, 14]),
    ('1', [4, 12, 4, 4, 4, 4, 14]),
    ('2', [14, 17, 1, 2, 4, 8, 31]),
    ('3', [31, 2, 4, 2, 1, 17, 14]),
    ('4', [2, 6, 10, 18, 31, 2, 2]),
    ('5', [31, 16, 30, 1, 1, 17, 14]),
    ('6', [6, 8, 16, 30, 17, 17, 14]),
    ('7', [31, 1, 2, 4, 8, 8, 8]),
    ('8', [14, 17, 17, 14, 17, 17, 14]),
    ('9', [14, 17, 17, 15, 1, 2, 12]),
    ('.', [0, 0, 0, 0, 0, 12, 12]),
    ('m', [0, 0, 26, 21, 21, 21, 21]),
    ('µ', [0, 0, 17, 17, 19, 29, 16]),
];

/// `picture` with a white strip below it that carries a bar of 1, 2 or 5 times a power of ten, at most a fourth of the width.
pub fn add(mut picture: Picture, pixel: f64) -> Picture {
    let width = picture.width as usize;
    let length = round_below(0.25 * width as f64 * pixel);
    let first = picture.height as usize;
    picture.height += STRIP as u32;
    picture.rgb.resize(3 * width * picture.height as usize, 255);
    let bar = (length / pixel).round() as usize;
    let zoom = if width >= 480 { 2 } else { 1 };
    let left = 8;
    for row in first + 10..first + 14 {
        for column in left..(left + bar).min(width) {
            ink(&mut picture, column, row);
        }
    }
    write(&mut picture, left + bar + 8, first + 12 - 7 * zoom / 2, zoom, &name(length));
    picture
}

/// The largest of 1, 2, 5 times a power of ten that is at most `x > 0`.
fn round_below(x: f64) -> f64 {
    let mut power = 1e-12;
    while power * 10.0 <= x {
        power *= 10.0;
    }
    [5.0, 2.0, 1.0].into_iter().map(|k| k * power).find(|&l| l <= x * (1.0 + 1e-9)).unwrap_or(power)
}

fn name(length: f64) -> String {
    let tidy = |x: f64| (x * 1e3).round() / 1e3;
    if length < 9e-5 { format!("{} µm", tidy(length * 1e6)) } else { format!("{} mm", tidy(length * 1e3)) }
}

fn ink(picture: &mut Picture, column: usize, row: usize) {
    if column < picture.width as usize && row < picture.height as usize {
        let at = 3 * (row * picture.width as usize + column);
        picture.rgb[at..at + 3].copy_from_slice(&INK);
    }
}

fn write(picture: &mut Picture, left: usize, top: usize, zoom: usize, text: &str) {
    for (place, letter) in text.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|g| g.0 == letter) else { continue };
        for (y, bits) in rows.iter().enumerate() {
            for x in (0..5).filter(|x| bits & (16 >> x) != 0) {
                for (dx, dy) in (0..zoom).flat_map(|dx| (0..zoom).map(move |dy| (dx, dy))) {
                    ink(picture, left + (place * 6 + x) * zoom + dx, top + y * zoom + dy);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round() {
        for (x, text) in [(0.0249, "20 mm"), (0.0051, "5 mm"), (0.0012, "1 mm"), (2e-5, "20 µm"), (0.3, "200 mm")] {
            assert_eq!(name(round_below(x)), text);
        }
    }

    /// A bar of 10 mm at 0.1 mm a pixel is 100 pixels of ink in its rows.
    #[test]
    fn the_bar_has_its_length() {
        let blank = Picture {
            title: String::new(),
            width: 500,
            height: 3,
            rgb: vec![0; 4500],
            legend: vec![],
            note: String::new(),
        };
        let picture = add(blank, 1e-4);
        assert_eq!(picture.rgb.len(), 3 * 500 * picture.height as usize);
        let row = &picture.rgb[3 * 500 * (3 + 11)..3 * 500 * (3 + 12)];
        let inked: Vec<usize> = row.chunks(3).enumerate().filter(|(_, c)| *c == INK).map(|(i, _)| i).collect();
        let bar = inked.iter().filter(|&&i| i < 8 + 100 + 8).count();
        assert_eq!((inked[0], bar), (8, 100));
    }
}
