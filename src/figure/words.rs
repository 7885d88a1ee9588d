//! Text for people: escaped, and numbers with sensible digits.

/// `text` for HTML, SVG and attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c if c.is_control() && c != '\n' => {}
            c => out.push(c),
        }
    }
    out
}

/// A number with `figures` significant digits and no trailing zeros, e.g. `0.0123`, `4230`, `1.2e-9`; whole numbers, which are
/// counts, with all of theirs.
pub fn number(x: f64, figures: usize) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !x.is_finite() {
        return if x.is_nan() {
            "not a number".into()
        } else if x > 0.0 {
            "∞".into()
        } else {
            "−∞".into()
        };
    }
    if x.fract() == 0.0 && x.abs() < 1e7 {
        return format!("{x}").replace('-', "−");
    }
    let scientific = format!("{x:.*e}", figures.max(1) - 1);
    let mantissa = scientific.split('e').next().unwrap_or_default();
    let exponent = order(scientific.parse().unwrap_or(x));
    let trim = |text: &str| {
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text.into() }
    };
    let text = if (-4..7).contains(&exponent) {
        let places = (figures as i32 - 1 - exponent).max(0) as usize;
        trim(&format!("{:.places$}", scientific.parse::<f64>().unwrap_or(x)))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    };
    text.replace('-', "−")
}

/// Power of ten of the first digit: the whole part of the decimal logarithm, exact.
pub fn order(x: f64) -> i32 {
    format!("{x:e}").split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0)
}

/// Ten to the power `exponent`.
pub fn ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::INFINITY)
}

/// A number and its standard error, both to the error's second digit: `0.0123 ± 0.0011`.
pub fn uncertain(x: f64, error: f64) -> String {
    let plain = |v: f64| v == 0.0 || (1e-6..1e7).contains(&v.abs());
    if !(error > 0.0 && plain(x) && plain(error)) {
        return format!("{} ± {}", number(x, 4), number(error, 2));
    }
    let places = 1 - order(error);
    let unit = ten(-places.min(0));
    let places = places.max(0) as usize;
    let show =
        |v: f64| format!("{:.places$}", if unit > 1.0 { (v / unit).round() * unit } else { v }).replace('-', "−");
    format!("{} ± {}", show(x), show(error))
}

/// A unit as people write it: `kg/m3` -> `kg/m³`, `us` -> `µs`.
pub fn unit(symbol: &str) -> String {
    let mut out = String::new();
    let mut last = ' ';
    for c in symbol.chars() {
        let raised = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
        match c.to_digit(10) {
            Some(d) if last.is_alphabetic() => out.push(raised[d as usize]),
            _ => out.push(c),
        }
        last = c;
    }
    let micro = |part: &str| if matches!(part, "us" | "um") { part.replace('u', "µ") } else { part.to_string() };
    out.split('/').map(micro).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_set_as_people_write_them() {
        for (symbol, text) in
            [("kg/m3", "kg/m³"), ("s2/km2", "s²/km²"), ("1/us", "1/µs"), ("um", "µm"), ("GPa", "GPa"), ("", "")]
        {
            assert_eq!(unit(symbol), text);
        }
    }

    #[test]
    fn numbers_have_sensible_digits() {
        let cases = [
            (0.0123456, "0.01235"),
            (4230.0, "4230"),
            (1.25e-9, "1.25e−9"),
            (-0.5, "−0.5"),
            (123456.7, "123500"),
            (9_999_900.5, "1e7"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x, 4), text);
        }
        assert_eq!(uncertain(0.012345, 0.0011), "0.0123 ± 0.0011");
        assert_eq!(number(114_328.0, 4), "114328");
        assert_eq!(uncertain(-0.004, 0.0025), "−0.0040 ± 0.0025");
        assert_eq!(uncertain(1326.4, 12.0), "1326 ± 12");
        assert_eq!(uncertain(86_412.0, 1234.0), "86400 ± 1200");
        assert_eq!(uncertain(-250.0, 0.0), "−250 ± 0");
    }
}
