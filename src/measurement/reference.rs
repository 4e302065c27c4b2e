//! A commanded motion from a table.

use super::motion::step;
use super::table::Table;
use super::{MeasurementError, SourceFile};

/// A command, sampled evenly.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Time between samples (s).
    pub step_s: f64,
    /// Command (m).
    pub command_m: Vec<f64>,
    /// What its column `pulse_v` adds to the drive's input (V); empty without that column.
    pub added_v: Vec<f64>,
    /// The file.
    pub file: SourceFile,
}

/// Reads a table with the columns `time_s` and `command_m`, such as a time record; of others only `pulse_v` counts.
///
/// # Errors  the file cannot be read; a column is missing, a cell is no number; time stamps repeat, run backward, are uneven or leave a gap.
pub fn read_reference(path: &str) -> Result<Reference, MeasurementError> {
    Reference::of(SourceFile::read(path, "write s-curve, sine or the name of a .csv file")?)
}

impl Reference {
    /// As [`read_reference`], of a file that was read.
    ///
    /// # Errors  as [`read_reference`].
    pub fn of(file: SourceFile) -> Result<Self, MeasurementError> {
        let table = Table::read_open(&file.path, file.text()?, &["time_s", "command_m"], &["pulse_v"])?;
        let (mut lines, mut time_s, mut command_m, mut added_v) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for row in table.rows() {
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
