//! Files of cases.

use std::fmt::Write as _;
use std::path::Path;

use super::record::{Case, Record};
use crate::Result;
use crate::file::{write_motions, write_text};
use crate::motion::run::{Log, RECORD_S, Side};

/// Writes a case as a measurement set with its machine: `manifest.toml`, `motion/*.csv`, `machine.toml`. The
/// files contain nothing of the label. A follow-up is a case of its own and needs its own call.
pub fn write_case(folder: &Path, case: &Case) -> Result<()> {
    write_set(folder, case, &case.fit, &case.records)?;
    write_text(&folder.join("machine.toml"), &case.belief.to_toml())
}

/// Writes the held-out records without noise as a set.
pub fn write_quiet(folder: &Path, case: &Case) -> Result<()> {
    write_set(folder, case, &[], &case.quiet)
}

fn write_set(folder: &Path, case: &Case, fit: &[String], records: &[Record]) -> Result<()> {
    let mut head = String::from("title = \"ball-screw axis, motion records\"\n");
    if case.belief.motor_kg.is_some() {
        let response = if case.belief.side == Side::Table { "table" } else { "motor" };
        head += &format!("response = \"{response}\"\nexcitation = \"motor\"\n");
    }
    write_motions(folder, &head, fit, records.iter().map(|record| (record.name.as_str(), rows(&record.log))))
}

fn rows(log: &Log) -> String {
    let mut text = String::from("time_s,command_m,position_m,force_n\n");
    for (k, ((command, position), force)) in
        log.command_m.iter().zip(&log.position_m).zip(&log.force_n).enumerate()
    {
        let _ = writeln!(text, "{:.3},{command:.9e},{position:.9e},{force:.6e}", k as f64 * RECORD_S);
    }
    text
}
