//! Cases and labels as files.

use std::fmt::Write as _;
use std::path::Path;

use super::label::Label;
use super::record::Case;
use crate::TruthError;
use crate::file::{made_folder, put, quoted};
use crate::machine::nuisance::Spread;

/// Writes a case as a measurement set with its machine: `manifest.toml`, `frf/*.csv`, `machine.toml`. Nothing of the label is in it;
/// a follow-up is a case of its own, written by a call of its own.
pub fn write_case(folder: &Path, case: &Case) -> Result<(), TruthError> {
    made_folder(folder, "frf")?;
    put(&folder.join("machine.toml"), &case.description.to_toml())?;
    put(&folder.join("manifest.toml"), &manifest(case))?;
    for record in &case.records {
        let mut text = String::from("frequency_hz,real,imag,coherence\n");
        for line in &record.lines {
            let _ = writeln!(text, "{},{:.8e},{:.8e},{:.8}", line.frequency_hz, line.response.re, line.response.im, line.coherence);
        }
        put(&folder.join(record.file()), &text)?;
    }
    Ok(())
}

/// Labels as one document.
pub fn labels_json(labels: &[Label]) -> Result<String, serde_json::Error> {
    let mut text = serde_json::to_string_pretty(labels)?;
    text.push('\n');
    Ok(text)
}

fn manifest(case: &Case) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "title = \"ball-screw feed drive, impact test\"\nquantity = \"{}\"\ngain = 1.0\nexcitation_unit = \"N\"\nresponse = \"table\"\nexcitation = \"table\"\naverages = {}\n\n[split]\nfit = [{}]\n",
        case.quantity.name(),
        case.averages,
        quoted(&case.fit)
    );
    let Spread { gain, delay_s, nut_m, .. } = case.description.spread;
    let _ = writeln!(out, "[tolerance]\ngain = {gain}\ndelay_s = {delay_s:e}\nnut_m = {nut_m:e}\n");
    for position in &case.positions {
        let _ = writeln!(out, "[[position]]\nname = \"{}\"\nnut_m = {}\n", position.name, position.nut_m);
    }
    for record in &case.records {
        let _ = writeln!(out, "[[frf]]\nposition = \"{}\"\nfile = \"{}\"", record.position, record.file());
        for (key, point) in [("response", record.channel.response), ("excitation", record.channel.excitation)] {
            if point.name() != "table" {
                let _ = writeln!(out, "{key} = \"{}\"", point.name());
            }
        }
        if let Some(name) = &record.name {
            let _ = writeln!(out, "record = \"{}-{name}\"", record.position);
        }
        if let Some(force_n) = record.force_n {
            let _ = writeln!(out, "force_n = {force_n}");
        }
        out.push('\n');
    }
    out
}
