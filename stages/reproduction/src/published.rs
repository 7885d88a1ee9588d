//! What was published: one quantity a row of a data file.
use hvi_validate::{Csv, CsvError};

/// How a published quantity is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stated {
    /// A number that is reproduced within this share of it.
    Near(f64, f64),
    /// The quantity lies below.
    Below(f64),
    /// The quantity lies above.
    Above(f64),
    /// No number was published.
    Nothing,
}

/// One published quantity.
#[derive(Clone, Debug)]
pub struct Published {
    /// Where in the paper, e.g. `"Table 1"`.
    pub result: String,
    /// Which quantity: one of [`crate::measured::QUANTITIES`].
    pub id: String,
    /// What it is, for people.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// What is said of it.
    pub stated: Stated,
    /// Where it is said, and how far it can be trusted.
    pub source: String,
}

/// Reads the columns `result`, `id`, `quantity`, `unit`, `relation` (`=`, `<`, `>` or empty), `value`, `within` [%], `source`.
///
/// # Errors
/// [`CsvError`] with the line of what can't be read.
pub fn read(text: &str) -> Result<Vec<Published>, CsvError> {
    let csv = Csv::read("published", text)?;
    let column = |name| csv.text(name);
    let (result, id, quantity) = (column("result")?, column("id")?, column("quantity")?);
    let (unit, relation, source) = (column("unit")?, column("relation")?, column("source")?);
    let (value, within) = (csv.numbers("value")?, csv.numbers("within")?);
    let stated = |i: usize| match relation[i] {
        "=" => Stated::Near(value[i], within[i] / 100.0),
        "<" => Stated::Below(value[i]),
        ">" => Stated::Above(value[i]),
        _ => Stated::Nothing,
    };
    let row = |i: usize| Published {
        result: result[i].into(),
        id: id[i].into(),
        quantity: quantity[i].into(),
        unit: unit[i].into(),
        stated: stated(i),
        source: source[i].into(),
    };
    csv.any((0..id.len()).map(row).collect(), "result, id, quantity, unit, relation, value, within and source")
}
