//! Tables like SESAME's 301: pressure and energy on a grid of density and temperature, read and written as text.
//!
//! Text: `#` lines for people; then numbers parted by white space, as a 301 table orders its words: the number of densities NR
//! and of temperatures NT; NR densities [g/cm3]; NT temperatures [K]; NR x NT pressures [GPa], density running fastest; as
//! many energies [MJ/kg]. Layout: S. P. Lyon and J. D. Johnson, LA-UR-92-3407 (1992).
use super::tabulated::{Isochore, Node, Parameters};
use crate::Eos;
use hvi_kit::math::bisect;

/// What is wrong with a table's text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("SESAME table, {0}")]
pub struct SesameError(pub String);

/// Most numbers of one axis that are read.
const LONGEST: usize = 100_000;

/// The table in `text`, phases not told apart; its V0 is where the isotherm of `reference_temperature` [K] crosses zero pressure, the
/// densest such place.
///
/// Rows of zero density are left out. Energies are counted from the reference state, whatever the file counts them from.
///
/// # Errors
/// [`SesameError`] with the line where a word is no finite number, or counts that don't fit, or where no isotherm crosses zero pressure.
pub fn read(text: &str, reference_temperature: f64) -> Result<Parameters, SesameError> {
    let mut words = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim_start().starts_with('#')) {
        for word in line.split_whitespace() {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            words.push(number.ok_or_else(|| SesameError(format!("line {}: `{word}` is no finite number", i + 1)))?);
        }
    }
    let count = |k: usize| words.get(k).copied().filter(|x| x.fract() == 0.0 && (2.0..=LONGEST as f64).contains(x));
    let (Some(nr), Some(nt)) = (count(0), count(1)) else {
        return Err(SesameError("begins with the numbers of densities and temperatures, whole and 2 or more".into()));
    };
    let (nr, nt) = (nr as usize, nt as usize);
    let needed = 2 + nr + nt + 2 * nr * nt;
    if words.len() != needed {
        let why = format!("{nr} densities and {nt} temperatures make {needed} numbers, but there are {}", words.len());
        return Err(SesameError(why));
    }
    let (densities, temperatures) = (&words[2..2 + nr], &words[2 + nr..2 + nr + nt]);
    let (pressures, energies) = words[2 + nr + nt..needed].split_at(nr * nt);
    let node = |i: usize, j: usize| Node {
        temperature: temperatures[j],
        pressure: pressures[j * nr + i] * 1e9,
        energy: energies[j * nr + i] * 1e6,
        errors: [0.0; 2],
    };
    let isochore = |i: usize| Isochore { volume: 1e-3 / densities[i], nodes: (0..nt).map(|j| node(i, j)).collect() };
    let solid: Vec<Isochore> = (0..nr).rev().filter(|&i| densities[i] > 0.0).map(isochore).collect();
    let reference_volume = free_volume(&solid, reference_temperature).ok_or_else(|| {
        SesameError(format!("no pressure vanishes along {reference_temperature} K: it has no reference state"))
    })?;
    let mut parameters = Parameters { reference_volume, reference_temperature, solid, liquid: Vec::new() };
    if let Ok(table) = super::tabulated::Tabulated::new(parameters.clone()) {
        let zero = Eos::Table(table).energy_at(reference_volume, reference_temperature);
        parameters.solid.iter_mut().flat_map(|i| &mut i.nodes).for_each(|n| n.energy -= zero);
    }
    Ok(parameters)
}

/// The smallest volume [m3/kg] at which the isotherm crosses zero pressure: linear between the grid's points first, then on the
/// table's own interpolation.
fn free_volume(solid: &[Isochore], t: f64) -> Option<f64> {
    let pressure = |i: &Isochore| {
        let k = i.nodes.partition_point(|n| n.temperature <= t).clamp(1, i.nodes.len() - 1);
        let (a, b) = (&i.nodes[k - 1], &i.nodes[k]);
        a.pressure + (t - a.temperature) / (b.temperature - a.temperature) * (b.pressure - a.pressure)
    };
    let pair = solid.windows(2).find(|w| pressure(&w[0]) > 0.0 && pressure(&w[1]) <= 0.0)?;
    let (p, q) = (pressure(&pair[0]), pressure(&pair[1]));
    let guess = pair[0].volume + p / (p - q) * (pair[1].volume - pair[0].volume);
    let parameters =
        Parameters { reference_volume: guess, reference_temperature: t, solid: solid.to_vec(), liquid: Vec::new() };
    let Ok(table) = super::tabulated::Tabulated::new(parameters) else { return Some(guess) };
    let eos = Eos::Table(table);
    Some(bisect(pair[0].volume, pair[1].volume, 1e-15 * guess, |v| eos.pressure_at(v, t)).unwrap_or(guess))
}

/// `eos` on the grid of `densities` [kg/m3] and `temperatures` [K], both rising; numbers that read back to the same bits.
pub fn write(eos: &Eos, source: &str, densities: &[f64], temperatures: &[f64]) -> String {
    let (mut pressures, mut energies) = (Vec::new(), Vec::new());
    for &t in temperatures {
        for &density in densities {
            let energy = eos.energy_at(1.0 / density, t);
            pressures.push(eos.point(1.0 / density, energy).pressure * 1e-9);
            energies.push(energy * 1e-6);
        }
    }
    let mut text = format!(
        "# {}: {source}\n# NR NT; densities g/cm3; temperatures K; pressures GPa, density fastest; energies MJ/kg\n",
        eos.name()
    );
    text += &format!("{} {}\n", densities.len(), temperatures.len());
    let densities: Vec<f64> = densities.iter().map(|d| d * 1e-3).collect();
    for block in [&densities[..], temperatures, &pressures, &energies] {
        for five in block.chunks(5) {
            let line: Vec<String> = five.iter().map(|x| format!("{x:24.16e}")).collect();
            text += &line.join("");
            text.push('\n');
        }
    }
    text
}
