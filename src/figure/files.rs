//! Pictures as PNG, tables as CSV.
use hvi_kit::view::{Cell, Picture, Table};

/// A picture as a PNG file: grey or palette where the colours allow, else red, green, blue.
///
/// A picture whose pixels don't fit its size gives no bytes.
pub fn png(picture: &Picture) -> Vec<u8> {
    let pixels = picture.width as usize * picture.height as usize;
    if pixels == 0 || picture.rgb.len() != 3 * pixels {
        return Vec::new();
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_depth(png::BitDepth::Eight);
    let colours = picture.rgb.as_chunks::<3>().0;
    let data = if colours.iter().all(|c| c[0] == c[1] && c[1] == c[2]) {
        encoder.set_color(png::ColorType::Grayscale);
        colours.iter().map(|c| c[0]).collect()
    } else if let Some((palette, indices)) = palette(colours) {
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette);
        indices
    } else {
        encoder.set_color(png::ColorType::Rgb);
        picture.rgb.clone()
    };
    let written = encoder.write_header().and_then(|mut w| w.write_image_data(&data));
    written.map_or_else(|_| Vec::new(), |()| bytes)
}

/// The colours in order of their first appearance, and each pixel's place among them; `None` beyond 256.
fn palette(colours: &[[u8; 3]]) -> Option<(Vec<u8>, Vec<u8>)> {
    let mut seen = std::collections::HashMap::new();
    let mut palette = Vec::new();
    let mut indices = Vec::with_capacity(colours.len());
    for colour in colours {
        let next = seen.len();
        let index = *seen.entry(*colour).or_insert(next);
        if index == next && palette.len() == 3 * next {
            palette.extend(colour);
        }
        indices.push(u8::try_from(index).ok()?);
    }
    Some((palette, indices))
}

/// A table as CSV (RFC 4180): the header names units, numbers have all their digits, an uncertain column gets a second one with
/// its standard errors.
pub fn csv(table: &Table) -> String {
    let in_column = |k: usize| table.rows.iter().any(|row| matches!(row.get(k), Some(Cell::Uncertain(..))));
    let uncertain: Vec<bool> = (0..table.columns.len()).map(in_column).collect();
    let mut header = Vec::new();
    for (k, (name, unit)) in table.columns.iter().enumerate() {
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        header.push(field(&format!("{name}{unit}")));
        if uncertain[k] {
            header.push(field(&format!("{name} standard error{unit}")));
        }
    }
    let mut out = header.join(",") + "\r\n";
    for row in &table.rows {
        let mut fields = Vec::new();
        for (k, cell) in row.iter().enumerate().take(table.columns.len()) {
            let (value, error) = match cell {
                Cell::Number(x) => (format!("{x:?}"), String::new()),
                Cell::Uncertain(x, e) => (format!("{x:?}"), format!("{e:?}")),
                Cell::Text(t) => (field(t), String::new()),
                Cell::Empty => (String::new(), String::new()),
            };
            fields.push(value);
            if uncertain[k] {
                fields.push(error);
            }
        }
        out += &(fields.join(",") + "\r\n");
    }
    out
}

fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_survive_the_file() {
        let rgb = |f: fn(u32) -> [u8; 3]| (0..600 * 4).flat_map(f).collect::<Vec<u8>>();
        let kinds: [(Vec<u8>, png::ColorType); 3] = [
            (rgb(|k| [(k % 251) as u8; 3]), png::ColorType::Grayscale),
            (rgb(|k| if k % 3 == 0 { [255, 0, 0] } else { [0, 0, 9] }), png::ColorType::Indexed),
            (rgb(|k| [(k % 256) as u8, (k / 256) as u8, 7]), png::ColorType::Rgb),
        ];
        for (rgb, kind) in kinds {
            let picture =
                Picture { title: String::new(), width: 600, height: 4, rgb, legend: vec![], note: String::new() };
            let file = png(&picture);
            assert_eq!(file, png(&picture), "the same bytes");
            let mut decoder = png::Decoder::new(std::io::Cursor::new(&file));
            assert_eq!(decoder.read_header_info().unwrap().color_type, kind);
            decoder.set_transformations(png::Transformations::EXPAND);
            let mut reader = decoder.read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let expected: Vec<u8> = if kind == png::ColorType::Grayscale {
                picture.rgb.iter().copied().step_by(3).collect()
            } else {
                picture.rgb
            };
            assert_eq!(pixels, expected);
        }
    }

    #[test]
    fn tables_keep_units_digits_and_commas() {
        let table = Table {
            title: "t".into(),
            columns: vec![("P".into(), "GPa".into()), ("what, who".into(), String::new())],
            rows: vec![vec![Cell::Uncertain(0.1 + 0.2, 1e-3), "a \"b\"".into()], vec![Cell::Number(1.0), Cell::Empty]],
            note: String::new(),
        };
        let expected =
            "P [GPa],P standard error [GPa],\"what, who\"\r\n0.30000000000000004,0.001,\"a \"\"b\"\"\"\r\n1.0,,\r\n";
        assert_eq!(csv(&table), expected);
    }
}
