//! Tables as HDF5: one dataset a column, with `units` and `long_name` attributes, as h5py and pandas read them.
use crate::hdf5_file::{self, Column, Values};
use hvi_kit::view::{Cell, Table};

/// The bytes of an HDF5 file with `table`; the same table gives the same bytes.
///
/// Numbers become f64 with NaN where nothing is known, standard errors a dataset of their own (`NAME_error`), words
/// variable-length UTF-8.
pub fn encode(table: &Table) -> Vec<u8> {
    let mut columns: Vec<Column> = Vec::new();
    for (i, (name, unit)) in table.columns.iter().enumerate() {
        let cells: Vec<&Cell> = table.rows.iter().map(|row| &row[i]).collect();
        let mut key: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        while columns.iter().any(|c| c.name == key) {
            key.push('_');
        }
        if cells.iter().any(|c| matches!(c, Cell::Text(_))) {
            columns.push(column(key, name, unit, Values::Words(cells.into_iter().map(word).collect())));
            continue;
        }
        let (values, errors): (Vec<f64>, Vec<f64>) = cells.iter().map(|c| number(c)).unzip();
        let uncertain = cells.iter().any(|c| matches!(c, Cell::Uncertain(..)));
        let error_key = format!("{key}_error");
        columns.push(column(key, name, unit, Values::Numbers(values)));
        if uncertain {
            columns.push(column(error_key, &format!("standard error of {name}"), unit, Values::Numbers(errors)));
        }
    }
    hdf5_file::encode(columns)
}

fn column(key: String, name: &str, unit: &str, values: Values) -> Column {
    let unit = if unit.is_empty() { "1" } else { unit };
    Column { name: key, values, attributes: vec![("long_name", name.into()), ("units", unit.into())] }
}

fn number(cell: &Cell) -> (f64, f64) {
    match cell {
        Cell::Number(x) => (*x, f64::NAN),
        Cell::Uncertain(x, e) => (*x, *e),
        Cell::Text(_) | Cell::Empty => (f64::NAN, f64::NAN),
    }
}

fn word(cell: &Cell) -> String {
    match cell {
        Cell::Text(s) => s.clone(),
        Cell::Number(x) | Cell::Uncertain(x, _) => x.to_string(),
        Cell::Empty => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdf5::types::VarLenUnicode;

    #[test]
    fn reads_back_and_repeats() {
        let table = Table {
            title: "states".into(),
            columns: ["pressure", "phase", "a b", "a.b"].map(|n| (n.into(), "GPa".into())).to_vec(),
            rows: vec![
                vec![Cell::Uncertain(1.5, 0.1), "solid".into(), 1.0.into(), 2.0.into()],
                vec![Cell::Empty, "liquid".into(), 3.0.into(), 4.0.into()],
            ],
            note: String::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let a = folder.path().join("a.h5");
        assert_eq!(encode(&table), encode(&table));
        std::fs::write(&a, encode(&table)).unwrap();
        let file = hdf5::File::open(&a).unwrap();
        let pressure = file.dataset("pressure").unwrap();
        let values = pressure.read_raw::<f64>().unwrap();
        assert_eq!(values[0], 1.5);
        assert!(values[1].is_nan());
        assert_eq!(file.dataset("pressure_error").unwrap().read_raw::<f64>().unwrap()[0], 0.1);
        assert_eq!(pressure.attr("units").unwrap().read_scalar::<VarLenUnicode>().unwrap().as_str(), "GPa");
        assert_eq!(file.dataset("a_b_").unwrap().read_raw::<f64>().unwrap(), [2.0, 4.0]);
        assert_eq!(file.dataset("phase").unwrap().read_raw::<VarLenUnicode>().unwrap()[1].as_str(), "liquid");
    }

    /// More words than one heap holds, words of every length near a multiple of eight, none at all, and no rows.
    #[test]
    fn libhdf5_reads_any_words() {
        let words: Vec<String> =
            (0..9000).map(|i| "µ".repeat(i % 19) + &i.to_string()).chain([String::new()]).collect();
        let rows = words.iter().map(|w| vec![Cell::Text(w.clone())]).collect();
        let table =
            |rows| Table { title: "t".into(), columns: vec![("w".into(), "".into())], rows, note: String::new() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("words.h5");
        std::fs::write(&path, encode(&table(rows))).unwrap();
        let file = hdf5::File::open(&path).unwrap();
        let read = file.dataset("w").unwrap().read_raw::<VarLenUnicode>().unwrap();
        assert!(read.iter().zip(&words).all(|(a, b)| a.as_str() == b) && read.len() == words.len());
        let none = folder.path().join("none.h5");
        std::fs::write(&none, encode(&table(vec![]))).unwrap();
        assert_eq!(hdf5::File::open(&none).unwrap().dataset("w").unwrap().size(), 0);
    }
}
