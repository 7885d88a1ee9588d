//! Figures as PNG, for where nothing draws SVG.
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::{Arc, OnceLock};

/// Pixels to a unit of the figure: sharp on paper and on dense screens.
const SCALE: f32 = 2.0;
const FONT: &str = "DejaVu Sans";

/// A figure drawn by [`super::svg`] as a PNG file on white, the same bytes on every machine: the font is in the program.
///
/// Text that is no SVG gives no bytes.
pub fn raster(svg: &str) -> Vec<u8> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.set_sans_serif_family(FONT);
        Arc::new(fonts)
    });
    let options = Options { fontdb: fonts.clone(), font_family: FONT.into(), ..Options::default() };
    let Ok(tree) = Tree::from_str(svg, &options) else { return Vec::new() };
    let [width, height] = [tree.size().width(), tree.size().height()].map(|x| (SCALE * x).ceil() as u32);
    let Some(mut pixels) = Pixmap::new(width, height) else { return Vec::new() };
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of the left half, a word on the right: both are there, the rest is white.
    #[test]
    fn shapes_and_words_are_drawn() {
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"80\" height=\"20\" font-family=\"system-ui, sans-serif\">\
                   <rect width=\"40\" height=\"20\" fill=\"#ff0000\"/><text x=\"42\" y=\"15\" fill=\"currentColor\">word</text></svg>";
        let pixels = Pixmap::decode_png(&raster(svg)).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (160, 40));
        let at = |x: u32, y: u32| pixels.pixel(x, y).map(|p| [p.red(), p.green(), p.blue()]).unwrap();
        assert_eq!((at(10, 10), at(159, 0)), ([255, 0, 0], [255, 255, 255]));
        let dark = (80..160).flat_map(|x| (0..40).map(move |y| (x, y))).filter(|&(x, y)| at(x, y)[0] < 100).count();
        assert!((50..800).contains(&dark), "{dark} dark pixels of the word");
        assert!(raster("no figure").is_empty());
    }
}
