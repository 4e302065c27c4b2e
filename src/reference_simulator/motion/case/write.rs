//! Files of cases.

use std::fmt::Write as _;
use std::path::Path;

use super::record::{Case, Record};
use crate::Result;
use crate::file::{create_folder, quoted, write_text};
use crate::motion::run::{RECORD_S, Side};

/// Writes a case as a measurement set with its machine: `manifest.toml`, `motion/*.csv`, `machine.toml`. The files contain nothing of the
/// label. A follow-up is a case of its own and needs its own call.
pub fn write_case(folder: &Path, case: &Case) -> Result<()> {
    create_folder(folder, "motion")?;
    write_text(&folder.join("machine.toml"), &case.belief.to_toml())?;
    write_text(&folder.join("manifest.toml"), &manifest(case, &case.records, &case.fit))?;
    write_records(folder, &case.records)
}

/// Writes the held-out records without noise as a set.
pub fn write_quiet(folder: &Path, case: &Case) -> Result<()> {
    create_folder(folder, "motion")?;
    write_text(&folder.join("manifest.toml"), &manifest(case, &case.quiet, &[]))?;
    write_records(folder, &case.quiet)
}

fn write_records(folder: &Path, records: &[Record]) -> Result<()> {
    for record in records {
        let mut text = String::from("time_s,command_m,position_m,force_n\n");
        let log = &record.log;
        for (k, ((command, position), force)) in log.command_m.iter().zip(&log.position_m).zip(&log.force_n).enumerate() {
            let _ = writeln!(text, "{:.3},{command:.9e},{position:.9e},{force:.6e}", k as f64 * RECORD_S);
        }
        write_text(&folder.join(record.file()), &text)?;
    }
    Ok(())
}

fn manifest(case: &Case, records: &[Record], fit: &[String]) -> String {
    let mut out = String::from("title = \"ball-screw axis, motion records\"\n");
    if case.belief.motor_kg.is_some() {
        let response = if case.belief.side == Side::Table { "table" } else { "motor" };
        let _ = writeln!(out, "response = \"{response}\"\nexcitation = \"motor\"");
    }
    if !fit.is_empty() {
        let _ = writeln!(out, "\n[split]\nfit = [{}]", quoted(fit));
    }
    for record in records {
        let _ = writeln!(out, "\n[[motion]]\nname = \"{}\"\nfile = \"{}\"", record.name, record.file());
    }
    out
}
