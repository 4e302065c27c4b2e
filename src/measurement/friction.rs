//! Friction measured at constant velocities: a table of runs.

use super::motion::EFFORT_COLUMNS;
use super::table::Table;
use super::{MeasurementError, SourceFile};

/// Recorded friction quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionUnit {
    /// Axial force (N).
    Force,
    /// Motor torque (N·m).
    Torque,
}

/// One run at constant velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionRun {
    /// Line of the table, from 1.
    pub line: u64,
    /// Velocity (m/s).
    pub velocity_m_s: f64,
    /// Force (N) or torque (N·m), with the sign of the velocity.
    pub value: f64,
    /// Standard deviation of `value`, where the table gives one.
    pub sd: Option<f64>,
}

/// Friction measurements of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionTable {
    /// Recorded quantity.
    pub unit: FrictionUnit,
    /// Runs, in the order of the table.
    pub runs: Vec<FrictionRun>,
    /// The file.
    pub file: SourceFile,
}

/// Reads a table with the columns `velocity_m_s` and either `force_n` (optionally `force_sd_n`) or
/// `torque_nm` (optionally `torque_sd_nm`).
///
/// # Errors  the file cannot be read, a column is missing, unknown or duplicated, a cell is not a number.
pub fn read_friction(path: &str) -> Result<FrictionTable, MeasurementError> {
    FrictionTable::of(SourceFile::read(path, "")?)
}

impl FrictionTable {
    /// Parses a file that is already read; otherwise as [`read_friction`].
    ///
    /// # Errors  as [`read_friction`].
    pub fn of(file: SourceFile) -> Result<Self, MeasurementError> {
        let path = &file.path;
        let columns = ["force_n", "force_sd_n", "torque_nm", "torque_sd_nm"];
        let table = Table::read(path, file.text()?, &["velocity_m_s"], &columns)?;
        let column = table.one_of(EFFORT_COLUMNS)?;
        let (unit, sd) = if column == EFFORT_COLUMNS[0] {
            (FrictionUnit::Force, "force_sd_n")
        } else {
            (FrictionUnit::Torque, "torque_sd_nm")
        };
        let mut runs = Vec::new();
        for row in table.rows() {
            let row = row?;
            runs.push(FrictionRun {
                line: row.line(),
                velocity_m_s: row.number("velocity_m_s")?,
                value: row.number(column)?,
                sd: row.optional_number(sd)?,
            });
        }
        Ok(FrictionTable { unit, runs, file })
    }
}
