//! Times and sizes as people write them on the command line and in `[run]`: `10min`, `30 d`, `8 GB`.
use std::time::Duration;

/// A time: `90s`, `10 min`, `2h`, `30d`, `4w`.
///
/// # Errors
/// What was expected.
pub fn time(text: &str) -> Result<Duration, String> {
    let scales = [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0), ("w", 604_800.0)];
    Duration::try_from_secs_f64(scaled(text, &scales, "10min")?).map_err(|e| e.to_string())
}

/// A number of bytes: `800MB`, `1.5 GB`.
///
/// # Errors
/// What was expected.
pub fn size(text: &str) -> Result<u64, String> {
    let scales = [("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12)];
    Ok(scaled(text, &scales, "8GB")? as u64)
}

fn scaled(text: &str, scales: &[(&str, f64)], example: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len()));
    let scale = scales.iter().find(|(name, _)| *name == unit.trim()).map(|(_, scale)| scale);
    match (number.parse::<f64>(), scale) {
        (Ok(number), Some(scale)) => Ok(number * scale),
        _ => {
            let units: Vec<_> = scales.iter().map(|(name, _)| *name).collect();
            Err(format!("expected a number with one of {}, as in {example}", units.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_scale_and_their_lack_is_told() {
        assert_eq!(time("10min"), Ok(Duration::from_secs(600)));
        assert_eq!(time(" 1.5 h "), Ok(Duration::from_secs(5400)));
        assert_eq!(size("1.5 GB"), Ok(1_500_000_000));
        for wrong in ["10", "min", "10 parsecs", "", "1e3s", "-1s"] {
            assert!(time(wrong).unwrap_err().contains("as in 10min"), "{wrong}");
        }
        assert!(time("99999999999999999999999w").is_err());
    }
}
