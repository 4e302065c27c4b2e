//! CSV tables with named columns; every fault names its line.

use std::collections::HashMap;

use file_access::{is_physical, shortened};

use super::MeasurementError;

/// Largest number of characters of a cell that a message quotes.
const QUOTED: usize = 40;

/// A table with a header line. Its lines are parsed one at a time, so that a long table costs no memory
/// beyond its text.
pub(super) struct Table<'p> {
    path: &'p str,
    text: &'p str,
    columns: HashMap<String, usize>,
    width: usize,
}

/// One line of a table.
pub(super) struct Row<'t> {
    table: &'t Table<'t>,
    line: u64,
    record: csv::StringRecord,
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes())
}

fn no_csv_line(path: &str, error: &csv::Error) -> MeasurementError {
    let line = error.position().map_or(1, csv::Position::line);
    MeasurementError::line(path, line, format!("is not a CSV line: {error}"))
}

impl<'p> Table<'p> {
    /// Reads text with the `required` and any of the `optional` columns; others are refused.
    pub(super) fn read(
        path: &'p str,
        text: &'p str,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, MeasurementError> {
        Self::read_with(path, text, required, optional, false)
    }

    /// Reads as [`Table::read`], but keeps unknown columns.
    pub(super) fn read_open(
        path: &'p str,
        text: &'p str,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, MeasurementError> {
        Self::read_with(path, text, required, optional, true)
    }

    fn read_with(
        path: &'p str,
        text: &'p str,
        required: &[&str],
        optional: &[&str],
        open: bool,
    ) -> Result<Self, MeasurementError> {
        let known = || required.iter().chain(optional).copied().collect::<Vec<_>>().join(",");
        if text.trim().is_empty() {
            return Err(MeasurementError::file(
                path,
                format!("is empty; write the header {} and at least one line", known()),
            ));
        }
        let mut lines = reader(text);
        let header = lines.headers().map_err(|e| no_csv_line(path, &e))?.clone();
        // A file that is no such table, named by mistake or on purpose, is not quoted.
        let is_known = |cell: &str| {
            let name = cell.trim_start_matches('\u{feff}').trim();
            required.contains(&name) || optional.contains(&name)
        };
        if !header.iter().flat_map(|cell| cell.split([';', '\t'])).any(is_known) {
            return Err(MeasurementError::line(
                path,
                1,
                format!("is not the header of a table; the columns are {}", known()),
            ));
        }
        if let Some(separator) = header
            .get(0)
            .filter(|_| header.len() == 1)
            .and_then(|only| only.chars().find(|c| [';', '\t'].contains(c)))
        {
            let what = if separator == ';' { "semicolons" } else { "tabs" };
            let fault = format!(
                "its columns are separated by {what}; separate them by commas, and write points for decimal commas"
            );
            return Err(MeasurementError::line(path, 1, fault));
        }
        let mut columns = HashMap::new();
        for (at, name) in header.iter().enumerate() {
            let name = name.trim_start_matches('\u{feff}');
            if !open && !required.contains(&name) && !optional.contains(&name) {
                return Err(MeasurementError::line(
                    path,
                    1,
                    format!("unknown column «{}»; the columns are {}", shortened(name, QUOTED), known()),
                ));
            }
            if columns.insert(name.to_string(), at).is_some() {
                return Err(MeasurementError::line(
                    path,
                    1,
                    format!("column «{}» appears twice; keep one", shortened(name, QUOTED)),
                ));
            }
        }
        if let Some(missing) = required.iter().find(|n| !columns.contains_key(**n)) {
            return Err(MeasurementError::line(
                path,
                1,
                format!("column «{missing}» is missing; the header is {}", known()),
            ));
        }
        if lines.records().next().is_none() {
            return Err(MeasurementError::file(path, "holds a header and no line; write at least one"));
        }
        Ok(Table { path, text, columns, width: header.len() })
    }

    /// Returns the lines, each parsed on demand.
    pub(super) fn rows(&self) -> impl Iterator<Item = Result<Row<'_>, MeasurementError>> {
        reader(self.text).into_records().map(|record| {
            let record = record.map_err(|e| no_csv_line(self.path, &e))?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != self.width {
                let hint = if record.len() > self.width { " (decimal commas? write points)" } else { "" };
                let fault = format!("has {} cells where the header has {}{hint}", record.len(), self.width);
                return Err(MeasurementError::line(self.path, line, fault));
            }
            Ok(Row { table: self, line, record })
        })
    }

    /// Returns the names of all columns, in the order of the header.
    pub(super) fn columns(&self) -> Vec<&str> {
        let mut names: Vec<(&str, usize)> =
            self.columns.iter().map(|(name, at)| (name.as_str(), *at)).collect();
        names.sort_by_key(|(_, at)| *at);
        names.into_iter().map(|(name, _)| name).collect()
    }

    /// Returns the one of two columns that the table has.
    pub(super) fn one_of(&self, [a, b]: [&'static str; 2]) -> Result<&'static str, MeasurementError> {
        match (self.has(a), self.has(b)) {
            (true, false) => Ok(a),
            (false, true) => Ok(b),
            (true, true) => {
                Err(MeasurementError::line(self.path, 1, format!("has both {a} and {b}; keep one of them")))
            }
            (false, false) => Err(MeasurementError::line(
                self.path,
                1,
                format!("has neither {a} nor {b}; write one of them"),
            )),
        }
    }

    pub(super) fn has(&self, column: &str) -> bool {
        self.columns.contains_key(column)
    }
}

impl Row<'_> {
    /// Returns its line number, from 1.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// Creates a fault at this line.
    pub(super) fn fault(&self, fault: String) -> MeasurementError {
        MeasurementError::line(self.table.path, self.line, fault)
    }

    /// Returns a cell that must not be empty.
    pub(super) fn text(&self, column: &str) -> Result<&str, MeasurementError> {
        let cell = self.table.columns.get(column).and_then(|at| self.record.get(*at)).unwrap_or("");
        if cell.is_empty() { Err(self.fault(format!("{column} is empty; write a value"))) } else { Ok(cell) }
    }

    /// Returns a cell as a finite number.
    pub(super) fn number(&self, column: &str) -> Result<f64, MeasurementError> {
        let cell = self.text(column)?;
        match cell.parse::<f64>() {
            Ok(x) if is_physical(x) || x.abs() < 1.0 => Ok(x),
            Ok(x) if x.is_finite() => {
                Err(self.fault(format!("{column} is {x:e}; no quantity in SI units is that large")))
            }
            _ => {
                let cell = shortened(cell, QUOTED);
                let hint = if cell.contains(',') { ", with a decimal point" } else { "" };
                Err(self
                    .fault(format!("{column} is «{cell}»; write a finite number such as 12.5 or 1e-6{hint}")))
            }
        }
    }

    /// Returns a cell as a finite number; `None` where the cell is empty or the column is missing.
    pub(super) fn optional_number(&self, column: &str) -> Result<Option<f64>, MeasurementError> {
        let cell = self.table.columns.get(column).and_then(|at| self.record.get(*at)).unwrap_or("");
        if cell.is_empty() { Ok(None) } else { self.number(column).map(Some) }
    }
}
