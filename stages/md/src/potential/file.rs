//! Potentials from files in the formats of DYNAMO and LAMMPS: funcfl, setfl and eam/fs.
//!
//! All are text. Numbers come in free form, as many to a line as the writer likes; what is a line of its own is told below.
//! Functions are on equally spaced knots from 0 on and mean the cubic spline of [`Spline`], cut at the cut-off.
//!
//! - **funcfl** (M. S. Daw and M. I. Baskes): a line of comment; `number mass a structure`; `n_rho d_rho n_r d_r cutoff`; then
//!   n_rho values of F [eV], n_r of the effective charge Z, n_r of f. The pair energy is 27.2 0.529 Z(r)^2/r eV angstrom.
//!   As in LAMMPS the last knot of each function isn't used.
//! - **setfl**: three lines of comment; `n name_1 ... name_n`; `n_rho d_rho n_r d_r cutoff`; for each element
//!   `number mass a structure` and then F and f; then r phi(r) [eV angstrom] of the pairs (1,1), (2,1), (2,2), (3,1), ...
//! - **eam/fs**: setfl with n functions f for each element, one for each element that feels it.
use super::spline::Spline;
use super::{Jet, Structure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Hartree and Bohr radius as DYNAMO and LAMMPS have them [eV angstrom].
const CHARGE_SQUARED: f64 = 27.2 * 0.529;
/// Pairs are never followed nearer than this [angstrom].
const NEAREST: f64 = 1.0;

/// The format of a potential file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub enum Format {
    /// One metal, its pair energy as a charge: LAMMPS' `pair_style eam`.
    #[serde(rename = "funcfl")]
    Funcfl,
    /// One or more metals: LAMMPS' `pair_style eam/alloy`.
    #[serde(rename = "setfl")]
    Setfl,
    /// The same with densities that depend on who feels them: LAMMPS' `pair_style eam/fs`.
    #[serde(rename = "eam/fs")]
    FinnisSinclair,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Format::Funcfl => "funcfl",
            Format::Setfl => "setfl",
            Format::FinnisSinclair => "eam/fs",
        })
    }
}

/// One metal of a potential file.
#[derive(Debug)]
pub struct Tabulated {
    /// Molar mass [g/mol].
    pub molar_mass: f64,
    /// Lattice constant as the file says [angstrom].
    pub lattice_constant: f64,
    /// Its crystal.
    pub structure: Structure,
    /// Distance from which on atoms don't act on each other [angstrom].
    pub cutoff: f64,
    /// Pairs nearer than this are off the table [angstrom].
    pub nearest: f64,
    /// F(rho) [eV].
    pub embedding: Spline,
    /// f(r).
    pub density: Spline,
    /// r phi(r) [eV angstrom].
    pub pair: Spline,
    /// Cubic edge without pressure, once it was asked for.
    pub(super) edge: OnceLock<Option<f64>>,
}

/// What is wrong with a potential file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}: expected {expected}, found {found}")]
pub struct Malformed {
    /// Line, from 1.
    pub line: usize,
    /// What the format has there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

impl Tabulated {
    /// Reads the metal `element` (by name; not needed where the file has but one) from `text`.
    ///
    /// # Errors
    /// [`Malformed`] where the text isn't of this format, or lacks the element.
    pub fn read(text: &str, format: Format, element: Option<&str>) -> Result<Tabulated, Malformed> {
        let mut file = Reader::new(text);
        match format {
            Format::Funcfl => funcfl(&mut file, element),
            Format::Setfl | Format::FinnisSinclair => setfl(&mut file, format, element),
        }
    }

    /// Pair energy phi(r) [eV].
    pub fn pair(&self, r: f64) -> Jet {
        if r >= self.cutoff {
            return Jet::default();
        }
        let z = self.pair.at(r);
        let value = z.value / r;
        Jet { value, slope: (z.slope - value) / r }
    }

    /// Density f(r).
    pub fn density(&self, r: f64) -> Jet {
        if r >= self.cutoff { Jet::default() } else { self.density.at(r) }
    }
}

/// The text, line after line.
struct Reader<'a> {
    lines: Vec<&'a str>,
    /// Index of the next line.
    next: usize,
}

/// Numbers on knots.
struct Knots {
    densities: usize,
    density_step: f64,
    distances: usize,
    distance_step: f64,
    cutoff: f64,
}

/// `number mass a structure`.
struct Element {
    molar_mass: f64,
    lattice_constant: f64,
    structure: Structure,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Reader<'a> {
        Reader { lines: text.lines().collect(), next: 0 }
    }

    /// What is wrong with the line read last.
    fn wrong(&self, expected: impl Into<String>, found: &str) -> Malformed {
        let mut short: String = found.chars().take(60).collect();
        if short.len() < found.len() {
            short.push_str("...");
        }
        Malformed { line: self.next, expected: expected.into(), found: format!("`{short}`") }
    }

    fn line(&mut self, expected: &str) -> Result<&'a str, Malformed> {
        let line = self.lines.get(self.next).copied();
        self.next += 1;
        line.ok_or_else(|| Malformed {
            line: self.next,
            expected: expected.into(),
            found: "the end of the file".into(),
        })
    }

    /// `count` finite numbers over as many lines as they fill; the last of these lines holds nothing else.
    fn numbers(&mut self, count: usize, what: &str) -> Result<Vec<f64>, Malformed> {
        let mut all = Vec::with_capacity(count);
        while all.len() < count {
            let line = self.line(&format!("{count} values of {what}, {} of which came", all.len()))?;
            for word in line.split_whitespace() {
                let value = word.parse().ok().filter(|x: &f64| x.is_finite());
                let value = value.ok_or_else(|| self.wrong(format!("value {} of {what}", all.len() + 1), word))?;
                all.push(value);
            }
        }
        match all.len() - count {
            0 => Ok(all),
            more => Err(self
                .wrong(format!("the last of {count} values of {what} at the end of a line"), &format!("{more} more"))),
        }
    }

    fn knots(&mut self) -> Result<Knots, Malformed> {
        let expected = "n_rho d_rho n_r d_r cutoff: two numbers of knots, 5 to 1000000, with their distances, and a length within the table";
        let line = self.line(expected)?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| words.get(k).and_then(|w| w.parse::<f64>().ok()).filter(|x| *x > 0.0 && x.is_finite());
        let count =
            |k: usize| words.get(k).and_then(|w| w.parse::<usize>().ok()).filter(|n| (5..=1_000_000).contains(n));
        let knots = || {
            let (densities, density_step, distances) = (count(0)?, number(1)?, count(2)?);
            Some(Knots { densities, density_step, distances, distance_step: number(3)?, cutoff: number(4)? })
        };
        // some writers put the cut-off one step past the last knot
        let fits = |k: &Knots| k.cutoff <= k.distances as f64 * k.distance_step * (1.0 + 1e-6);
        knots().filter(fits).ok_or_else(|| self.wrong(expected, line))
    }

    fn element(&mut self) -> Result<Element, Malformed> {
        let expected = "an element: its number, mass in g/mol, lattice constant in angstrom and structure";
        let line = self.line(expected)?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| words.get(k).and_then(|w| w.parse::<f64>().ok()).filter(|x| *x >= 0.0 && x.is_finite());
        let element = || {
            let structure = words.get(3).filter(|w| w.starts_with(char::is_alphabetic))?.parse().ok()?;
            Some(Element { molar_mass: number(1).filter(|m| *m > 0.0)?, lattice_constant: number(2)?, structure })
        };
        element().ok_or_else(|| self.wrong(expected, line))
    }
}

fn funcfl(file: &mut Reader, element: Option<&str>) -> Result<Tabulated, Malformed> {
    file.line("a line of comment")?;
    let head = file.element()?;
    if let Some(name) = element {
        return Err(file.wrong(
            format!("no element to be named: funcfl files hold one, without a name (and not `{name}`)"),
            "one",
        ));
    }
    let knots = file.knots()?;
    let mut embedding = file.numbers(knots.densities, "F(rho)")?;
    let charge = file.numbers(knots.distances, "Z(r)")?;
    let mut density = file.numbers(knots.distances, "f(r)")?;
    let mut pair: Vec<f64> = charge.iter().map(|z| CHARGE_SQUARED * z * z).collect();
    // LAMMPS brings funcfl files onto knots of its own, which are these less the last
    for values in [&mut embedding, &mut density, &mut pair] {
        values.pop();
    }
    Ok(tabulated(head, &knots, &embedding, &density, &pair))
}

fn setfl(file: &mut Reader, format: Format, element: Option<&str>) -> Result<Tabulated, Malformed> {
    for _ in 0..3 {
        file.line("three lines of comment")?;
    }
    let names = names(file)?;
    let wanted = match element {
        None if names.len() == 1 => 0,
        None => return Err(file.wrong("`element` to name one of several", &names.join(" "))),
        Some(name) => {
            let found = names.iter().position(|n| *n == name);
            found.ok_or_else(|| file.wrong(format!("the element {name}"), &names.join(" ")))?
        }
    };
    let knots = file.knots()?;
    let mut found = None;
    for (k, name) in names.iter().enumerate() {
        let head = file.element()?;
        let embedding = file.numbers(knots.densities, &format!("F(rho) of {name}"))?;
        let felt_by: Vec<&str> = if format == Format::FinnisSinclair { names.clone() } else { vec![name] };
        let mut own = Vec::new();
        for by in felt_by {
            let density = file.numbers(knots.distances, &format!("f(r) of {name} as felt by {by}"))?;
            if by == *name {
                own = density;
            }
        }
        if k == wanted {
            found = Some((head, embedding, own));
        }
    }
    let mut pair = Vec::new();
    for (a, first) in names.iter().enumerate() {
        for (b, second) in names[..=a].iter().enumerate() {
            let values = file.numbers(knots.distances, &format!("r phi(r) of {first} and {second}"))?;
            if a == wanted && b == wanted {
                pair = values;
            }
        }
    }
    let (head, embedding, density) = found.expect("`wanted` is one of them");
    Ok(tabulated(head, &knots, &embedding, &density, &pair))
}

/// `n name_1 ... name_n`.
fn names<'a>(file: &mut Reader<'a>) -> Result<Vec<&'a str>, Malformed> {
    let expected = "the number of elements and their names";
    let line = file.line(expected)?;
    let mut words = line.split_whitespace();
    let count = words.next().and_then(|w| w.parse::<usize>().ok());
    let names: Vec<&str> = words.collect();
    if count == Some(names.len()) && !names.is_empty() { Ok(names) } else { Err(file.wrong(expected, line)) }
}

fn tabulated(head: Element, knots: &Knots, embedding: &[f64], density: &[f64], pair: &[f64]) -> Tabulated {
    let mut tabulated = Tabulated {
        molar_mass: head.molar_mass,
        lattice_constant: head.lattice_constant,
        structure: head.structure,
        cutoff: knots.cutoff.min((pair.len() - 1) as f64 * knots.distance_step),
        nearest: NEAREST,
        embedding: Spline::new(embedding, knots.density_step),
        density: Spline::new(density, knots.distance_step),
        pair: Spline::new(pair, knots.distance_step),
        edge: OnceLock::new(),
    };
    tabulated.nearest = wall(&tabulated);
    tabulated
}

/// How near a pair may come: as far in as its energy still rises. Many files are filled with anything below that.
fn wall(of: &Tabulated) -> f64 {
    let contact = of.structure.nearest(of.lattice_constant);
    let mut r = 0.8 * contact;
    while r > NEAREST && of.pair(r - of.pair.step).slope < 0.0 {
        r -= of.pair.step;
    }
    r.max(NEAREST)
}
