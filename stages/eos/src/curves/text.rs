//! Answers and curves as comma-separated text: what `hvi-flow eos` reads and writes.
use super::trace::Sample;
use crate::{Eos, Phase};
use hvi_kit::units::{self, Dimension};

/// What is wrong with a table of states.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Line, counted from 1.
    pub line: usize,
    /// The text at fault, empty where it is missing.
    pub text: String,
    /// What was expected.
    pub why: String,
}

/// The columns written, SI.
const HEADER: &str = "V [m3/kg],T [K],E [J/kg],P [Pa],phase,liquid_fraction,c [m/s]";

/// Name of a phase in tables.
pub fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Solid => "solid",
        Phase::Melting => "melting",
        Phase::Liquid => "liquid",
        Phase::HotLiquid => "hot-liquid",
        Phase::Vapour => "vapour",
    }
}

/// `samples` as text: a header with units, then a line each; without a sound speed where matter is all but unstable.
pub fn write(samples: &[Sample]) -> String {
    let shocks = samples.iter().any(|s| s.velocities.is_some());
    let mut text = format!("{HEADER}{}\n", if shocks { ",up [m/s],Us [m/s]" } else { "" });
    for s in samples {
        let phase = phase_name(s.phase);
        let sound_speed = s.sound_speed.map_or(String::new(), |c| c.to_string());
        text += &format!(
            "{:e},{},{},{:e},{phase},{},{sound_speed}",
            s.volume, s.temperature, s.energy, s.pressure, s.liquid
        );
        if let Some([up, us]) = s.velocities {
            text += &format!(",{up},{us}");
        }
        text.push('\n');
    }
    text
}

/// Answers of `eos` for the states of `text`: columns `V` and `T`, or `V` and `E`, each SI or in the unit its name carries
/// (`V [cm3/g]`); other columns and `#` lines are passed over.
///
/// # Errors
/// [`Fault`] where a column is missing or twice there, a unit is unknown, or a cell is no number the model can take.
pub fn answer(eos: &Eos, text: &str) -> Result<Vec<Sample>, Fault> {
    // as some spreadsheets begin their files
    let text = text.trim_start_matches('\u{feff}');
    let mut lines =
        text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let Some((line, header)) = lines.next() else {
        return Err(Fault { line: 1, text: String::new(), why: "expected a line of column names: V,T or V,E".into() });
    };
    let volume = column(header, line, "V", Dimension::SpecificVolume)?;
    let temperature = column(header, line, "T", Dimension::Temperature)?;
    let energy = column(header, line, "E", Dimension::SpecificEnergy)?;
    let missing = |why: &str| Fault { line, text: header.into(), why: why.into() };
    let volume = volume.ok_or_else(|| missing("there is no column V"))?;
    let (other, by_temperature) = match (temperature, energy) {
        (Some(t), None) => (t, true),
        (None, Some(e)) => (e, false),
        (None, None) => return Err(missing("there is no column T or E beside V")),
        (Some(_), Some(_)) => return Err(missing("there are both T and E: which one is meant?")),
    };
    let mut all = Vec::new();
    for (line, row) in lines {
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        let expected = header.split(',').count();
        if cells.len() != expected {
            let why = format!("expected {expected} cells, as the header has: there are {}", cells.len());
            return Err(Fault { line, text: row.into(), why });
        }
        let number = |(k, factor): (usize, f64), least: Option<f64>| {
            let text = cells.get(k).copied().unwrap_or_default();
            let value = text.parse::<f64>().ok().filter(|x| x.is_finite() && least.is_none_or(|l| *x > l));
            let why = if least.is_some() { "expected a positive number" } else { "expected a finite number" };
            value.map(|x| x * factor).ok_or_else(|| Fault { line, text: text.into(), why: why.into() })
        };
        let v = number(volume, Some(0.0))?;
        let e = if by_temperature { eos.energy_at(v, number(other, Some(0.0))?) } else { number(other, None)? };
        let sample = eos.sample(v, e);
        if let Some(why) = unanswered(eos, &sample) {
            return Err(Fault { line, text: row.into(), why });
        }
        all.push(sample);
    }
    Ok(all)
}

/// Why `eos` has no answer for the state of `sample`, if it has none.
fn unanswered(eos: &Eos, sample: &Sample) -> Option<String> {
    let numbers = [sample.temperature, sample.energy, sample.pressure, sample.sound_speed.unwrap_or(0.0)];
    if !numbers.iter().all(|x| x.is_finite()) {
        return Some("the model has no finite answer there".into());
    }
    match eos {
        Eos::Table(table) if !table.covers(sample.volume, sample.temperature) => {
            let (v, t) = (sample.volume * 1e3, sample.temperature);
            Some(format!("V {v:.5} cm3/g, T {t:.1} K is outside of the table"))
        }
        _ => None,
    }
}

/// Place of the column `name`, and the size of its unit in SI.
fn column(header: &str, line: usize, name: &str, dimension: Dimension) -> Result<Option<(usize, f64)>, Fault> {
    let mut found = None;
    for (k, cell) in header.split(',').map(str::trim).enumerate() {
        let (own, unit) = cell
            .split_once('[')
            .map_or((cell, None), |(own, unit)| (own.trim(), Some(unit.trim_end_matches(']').trim())));
        if own != name {
            continue;
        }
        let fault = |why: String| Fault { line, text: cell.into(), why };
        if found.is_some() {
            return Err(fault(format!("the column {name} is there twice")));
        }
        let factor = unit.map_or(Ok(1.0), |u| units::si(&format!("1 {u}"), dimension)).map_err(fault)?;
        found = Some((k, factor));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::definition::Definition;
    use crate::handbook::Set;

    #[test]
    fn what_is_written_reads_back() {
        let eos = Definition::of(Set::CopperRoyce).make().unwrap().eos;
        let first = answer(&eos, "# a comment\nT,V [cm3/g],note\n300,0.1118,x\n1000, 0.09 ,y\n").unwrap();
        assert_eq!(first.len(), 2);
        assert!((first[0].temperature - 300.0).abs() < 1e-9 && first[0].pressure.abs() < 1e3);
        let text = write(&first).replace("T [K],", "").replace("300,", "");
        assert!(text.starts_with("V [m3/kg],E [J/kg]"));
        let by_energy = format!("V,E\n{:e},{:e}\n", first[1].volume, first[1].energy);
        assert_eq!(answer(&eos, &by_energy).unwrap()[0], first[1]);
    }

    #[test]
    fn faults_name_line_and_text() {
        let eos = Definition::of(Set::CopperRoyce).make().unwrap().eos;
        let fault = |text: &str| {
            let f = answer(&eos, text).unwrap_err();
            (f.line, f.text, f.why)
        };
        assert_eq!(fault("V,T\n1e-4,300\n1e-4,hot\n").0, 3);
        assert!(fault("V,T\n-1,300\n").2.contains("positive"));
        assert!(fault("V [parsec],T\n").2.contains("unknown unit"));
        assert!(fault("V,T,E\n").2.contains("which one"));
        assert!(fault("V,P\n").2.contains("no column T or E"));
        assert!(fault("V,V,T\n").2.contains("twice"));
        assert_eq!(fault("").0, 1);
        assert!(fault("V,T\n1e-4\n").2.contains("expected 2 cells"));
        assert!(fault("V,T\n1,1,300\n").2.contains("there are 3"));
        assert!(fault("V,E\n1e-4,1e308\n").2.contains("no finite answer"));
        // cold vapour at 1.8 V0 is within its spinodal: it has no sound speed, and the solver's floor is none
        let cold = write(&answer(&eos, "V [cm3/g],T\n0.2,300\n0.1118,300\n").unwrap());
        let rows: Vec<&str> = cold.lines().skip(1).collect();
        assert!(rows[0].ends_with(",vapour,1,") && !rows[1].ends_with(','), "{cold}");
        assert!(answer(&eos, "\u{feff}V,T\n1e-4,300\n").is_ok());
    }
}
