//! Tables as HDF5: one dataset a column, with `units` and `long_name` attributes, as h5py and pandas read them.
use hdf5::types::VarLenUnicode;
use hvi_kit::view::{Cell, Table};
use std::path::Path;

/// Writes `table` to a new file at `path`; the same table gives the same bytes (no time stamps).
///
/// Numbers become f64 with NaN where nothing is known, standard errors a dataset of their own (`NAME_error`), words
/// variable-length UTF-8.
///
/// # Errors
/// Where the file can't be written.
pub fn write(table: &Table, path: &Path) -> hdf5::Result<()> {
    let file = hdf5::FileBuilder::new().with_fcpl(|p| p.obj_track_times(false)).create(path)?;
    let mut keys: Vec<String> = Vec::new();
    for (i, (name, unit)) in table.columns.iter().enumerate() {
        let cells: Vec<&Cell> = table.rows.iter().map(|row| &row[i]).collect();
        let mut key: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        while keys.contains(&key) {
            key.push('_');
        }
        keys.push(key.clone());
        if cells.iter().any(|c| matches!(c, Cell::Text(_))) {
            let words: Result<Vec<VarLenUnicode>, _> = cells.iter().map(|c| word(c).parse()).collect();
            let words = words.map_err(|e| hdf5::Error::from(format!("{name}: {e}")))?;
            let dataset =
                file.new_dataset::<VarLenUnicode>().obj_track_times(false).shape(words.len()).create(key.as_str())?;
            dataset.write_raw(&words)?;
            describe(&dataset, name, unit)?;
            continue;
        }
        numbers(&file, &key, name, unit, &cells.iter().map(|c| number(c).0).collect::<Vec<_>>())?;
        if cells.iter().any(|c| matches!(c, Cell::Uncertain(..))) {
            let errors: Vec<f64> = cells.iter().map(|c| number(c).1).collect();
            numbers(&file, &format!("{key}_error"), &format!("standard error of {name}"), unit, &errors)?;
        }
    }
    file.close()
}

fn numbers(file: &hdf5::File, key: &str, name: &str, unit: &str, values: &[f64]) -> hdf5::Result<()> {
    let dataset = file.new_dataset::<f64>().obj_track_times(false).shape(values.len()).create(key)?;
    dataset.write_raw(values)?;
    describe(&dataset, name, unit)
}

fn describe(dataset: &hdf5::Dataset, name: &str, unit: &str) -> hdf5::Result<()> {
    for (key, text) in [("long_name", name), ("units", if unit.is_empty() { "1" } else { unit })] {
        let text: VarLenUnicode = text.parse().map_err(|e| hdf5::Error::from(format!("{key}: {e}")))?;
        dataset.new_attr::<VarLenUnicode>().create(key)?.write_scalar(&text)?;
    }
    Ok(())
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
        let (a, b) = (folder.path().join("a.h5"), folder.path().join("b.h5"));
        write(&table, &a).unwrap();
        write(&table, &b).unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
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
}
