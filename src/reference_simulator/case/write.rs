//! Files of cases and labels.

use std::fmt::Write as _;
use std::path::Path;

use super::label::Label;
use super::record::Case;
use crate::SimulatorError;
use crate::file::{create_folder, quoted, write_text};
use crate::machine::nuisance::Spread;

/// Writes a case as a measurement set with its machine: `manifest.toml`, `frf/*.csv`, `machine.toml`. The files contain nothing of the
/// label. A follow-up is a case of its own and needs its own call.
pub fn write_case(folder: &Path, case: &Case) -> Result<(), SimulatorError> {
    create_folder(folder, "frf")?;
    write_text(&folder.join("machine.toml"), &case.description.to_toml())?;
    write_text(&folder.join("manifest.toml"), &manifest(case))?;
    for record in &case.records {
        let mut text = String::from("frequency_hz,real,imag,coherence\n");
        for line in &record.lines {
            let _ = writeln!(text, "{},{:.8e},{:.8e},{:.8}", line.frequency_hz, line.response.re, line.response.im, line.coherence);
        }
        write_text(&folder.join(record.file()), &text)?;
    }
    Ok(())
}

/// Formats labels as one JSON document.
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
