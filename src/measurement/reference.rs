//! Commanded motion read from a table.

use super::motion::step;
use super::table::Table;
use super::{MeasurementError, SourceFile};

/// A commanded motion with a constant sampling step.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Time between samples (s).
    pub step_s: f64,
    /// Command (m).
    pub command_m: Vec<f64>,
    /// Voltage added to the drive's input (V), column `pulse_v`; empty without that column.
    pub added_v: Vec<f64>,
    /// The file.
    pub file: SourceFile,
}

/// Reads a table with the columns `time_s` and `command_m`, such as a time record; of the other columns only
/// `pulse_v` is used.
///
/// # Errors  the file cannot be read; a column is missing, a cell is not a number; time stamps repeat,
///   decrease, are uneven or skip samples.
pub fn read_reference(path: &str) -> Result<Reference, MeasurementError> {
    Reference::of(SourceFile::read(path, "write s-curve, sine or the name of a .csv file")?)
}

impl Reference {
    /// Parses a file that is already read; otherwise as [`read_reference`].
    ///
    /// # Errors  as [`read_reference`].
    pub fn of(file: SourceFile) -> Result<Self, MeasurementError> {
        let table = Table::read_open(&file.path, file.text()?, &["time_s", "command_m"], &["pulse_v"])?;
        let (mut lines, mut time_s, mut command_m, mut added_v) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for row in table.rows() {
            let row = row?;
            lines.push(row.line());
            time_s.push(row.number("time_s")?);
            command_m.push(row.number("command_m")?);
            if table.has("pulse_v") {
                added_v.push(row.number("pulse_v")?);
            }
        }
        Ok(Reference { step_s: step(&file.path, &time_s, &lines)?, command_m, added_v, file })
    }
}
