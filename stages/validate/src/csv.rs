//! Reference data: comma-separated columns under a line of names, after lines `# key: value` of source, units and status.
use hvi_kit::units::{self, Dimension};

/// What is wrong with a data file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}, line {line}: {why}")]
pub struct CsvError {
    /// The port that holds the file.
    pub file: &'static str,
    /// Line, counted from 1.
    pub line: usize,
    /// What was found and what was expected.
    pub why: String,
}

/// A data file: its column names and its rows of text.
#[derive(Clone, Debug)]
pub struct Csv<'a> {
    file: &'static str,
    header: usize,
    /// Line, key and value of what is said of the data above them.
    said: Vec<(usize, &'a str, &'a str)>,
    names: Vec<&'a str>,
    rows: Vec<(usize, Vec<&'a str>)>,
}

impl<'a> Csv<'a> {
    /// Reads `text`, the content of the port `file`.
    ///
    /// # Errors
    /// [`CsvError`] where there is no line of names, or a row has fewer cells than there are names.
    pub fn read(file: &'static str, text: &'a str) -> Result<Csv<'a>, CsvError> {
        let all = || text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let remark = |(i, line): (usize, &'a str)| {
            let (key, value) = line.strip_prefix('#')?.split_once(':')?;
            Some((i, key.trim(), value.trim()))
        };
        let mut lines = all().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let Some((header, names)) = lines.next() else {
            return Err(CsvError { file, line: 1, why: "no line of column names".into() });
        };
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        let mut rows = Vec::new();
        for (line, row) in lines {
            // The last column may hold commas: it is text for people.
            let cells: Vec<&str> = row.splitn(names.len(), ',').map(str::trim).collect();
            if cells.len() < names.len() {
                let why = format!("{} cells, but {} columns: {}", cells.len(), names.len(), names.join(", "));
                return Err(CsvError { file, line, why });
            }
            rows.push((line, cells));
        }
        Ok(Csv { file, header, said: all().filter_map(remark).collect(), names, rows })
    }

    /// What a line `# key: ...` says.
    pub fn said(&self, key: &str) -> Option<&'a str> {
        self.said.iter().find(|s| s.1 == key).map(|s| s.2)
    }

    /// The same as a quantity, in SI.
    ///
    /// # Errors
    /// [`CsvError`] where it is none of `dimension`.
    pub fn quantity(&self, key: &str, dimension: Dimension) -> Result<Option<f64>, CsvError> {
        let Some(&(line, _, text)) = self.said.iter().find(|s| s.1 == key) else { return Ok(None) };
        let wrong = |why| CsvError { file: self.file, line, why: format!("`{key}`: {why}") };
        units::si(text, dimension).map(Some).map_err(wrong)
    }

    fn column(&self, name: &str) -> Result<usize, CsvError> {
        self.names.iter().position(|&n| n == name).ok_or_else(|| CsvError {
            file: self.file,
            line: self.header,
            why: format!("no column `{name}`; there are {}", self.names.join(", ")),
        })
    }

    /// The text of the column `name`, one a row.
    ///
    /// # Errors
    /// [`CsvError`] where there is no such column.
    pub fn text(&self, name: &str) -> Result<Vec<&'a str>, CsvError> {
        let column = self.column(name)?;
        Ok(self.rows.iter().map(|(_, cells)| cells[column]).collect())
    }

    /// The numbers of the column `name`, one a row.
    ///
    /// # Errors
    /// [`CsvError`] where there is no such column, or a cell is no finite number.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, CsvError> {
        let column = self.column(name)?;
        let number = |(line, cells): &(usize, Vec<&str>)| match cells[column].parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(CsvError {
                file: self.file,
                line: *line,
                why: format!("`{}` in column `{name}` is no finite number", cells[column]),
            }),
        };
        self.rows.iter().map(number).collect()
    }

    /// `points`, made from the rows, if there are any; `expected` says what each row should have held.
    ///
    /// # Errors
    /// [`CsvError`] where `points` is empty.
    pub fn any<T>(&self, points: Vec<T>, expected: &str) -> Result<Vec<T>, CsvError> {
        if points.is_empty() {
            let why = format!("no data points below the column names; expected rows with {expected}");
            return Err(CsvError { file: self.file, line: self.header, why });
        }
        Ok(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_by_name() {
        let csv = Csv::read("data", "# source\n\nV, P,note\n1,2.5,a, b\n3,-4e1,\n").unwrap();
        assert_eq!(csv.numbers("P").unwrap(), [2.5, -40.0]);
        assert_eq!(csv.text("note").unwrap(), ["a, b", ""]);
    }

    #[test]
    fn remarks_have_keys() {
        let csv = Csv::read("data", "# source: X, 1970: a book\n# rho0: 8.93 g/cm3\n# T: hot\nV,P\n1,2\n").unwrap();
        assert_eq!((csv.said("source"), csv.said("set")), (Some("X, 1970: a book"), None));
        assert_eq!(csv.quantity("rho0", Dimension::Density).unwrap(), Some(8930.0));
        let wrong = csv.quantity("T", Dimension::Temperature).unwrap_err();
        assert!(wrong.line == 3 && wrong.why.starts_with("`T`: "), "{wrong}");
    }

    #[test]
    fn mistakes_name_their_line() {
        let message = |text: &'static str, column: &str| match Csv::read("marsh", text) {
            Ok(csv) => csv.numbers(column).unwrap_err().to_string(),
            Err(e) => e.to_string(),
        };
        assert_eq!(message("# x\n", "P"), "marsh, line 1: no line of column names");
        assert_eq!(message("# x\nV,P\n1\n", "P"), "marsh, line 3: 1 cells, but 2 columns: V, P");
        assert_eq!(message("V,P\n1,2\n", "T"), "marsh, line 1: no column `T`; there are V, P");
        assert_eq!(message("V,P\n1,2\n3,nan\n", "P"), "marsh, line 3: `nan` in column `P` is no finite number");
    }
}
