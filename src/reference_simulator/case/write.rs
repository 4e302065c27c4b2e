//! Files of cases and labels.

use std::fmt::Write as _;
use std::path::Path;

use super::label::Label;
use super::record::{Case, Record, Scatter};
use crate::Result;
use crate::file::{create_folder, quoted, write_text};
use crate::machine::nuisance::Spread;

/// Coherence below which a careful test leaves a line out.
const LEAST_COHERENCE: f64 = 0.8;

/// Writes a case as a measurement set with its machine: `manifest.toml`, `frf/*.csv`, `machine.toml`. The
/// files contain nothing of the label. A follow-up is a case of its own and needs its own call.
pub fn write_case(folder: &Path, case: &Case) -> Result<()> {
    create_folder(folder, "frf")?;
    write_text(&folder.join("machine.toml"), &case.description.to_toml())?;
    write_text(&folder.join("manifest.toml"), &manifest(case))?;
    for record in &case.records {
        write_text(&folder.join(record.file()), &table(case, record))?;
    }
    Ok(())
}

/// Formats labels as one JSON document.
pub fn labels_json(labels: &[Label]) -> serde_json::Result<String> {
    let mut text = serde_json::to_string_pretty(labels)?;
    text.push('\n');
    Ok(text)
}

/// Formats the lines of a record.
fn table(case: &Case, record: &Record) -> String {
    let scatter = match case.scatter {
        Scatter::Coherence => "coherence",
        Scatter::Deviation => "relative_sd",
    };
    let mut text = format!("frequency_hz,real,imag,{scatter}\n");
    for line in &record.lines {
        let _ = match case.scatter {
            Scatter::Coherence => {
                writeln!(
                    text,
                    "{},{:.8e},{:.8e},{:.8}",
                    line.frequency_hz, line.response.re, line.response.im, line.coherence
                )
            }
            Scatter::Deviation if line.coherence < LEAST_COHERENCE => Ok(()),
            Scatter::Deviation => {
                // Both components together: Bendat and Piersol, Random Data, 2010, Eq. 9.73, for the mean of
                // the blows.
                let sd = ((1.0 - line.coherence) / (case.averages as f64 * line.coherence)).sqrt();
                writeln!(
                    text,
                    "{},{:.8e},{:.8e},{sd:.4e}",
                    line.frequency_hz, line.response.re, line.response.im
                )
            }
        };
    }
    text
}

fn manifest(case: &Case) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "title = \"ball-screw feed drive, impact test\"\nquantity = \"{}\"\ngain = 1.0\nexcitation_unit = \"N\"\nresponse = \"table\"\nexcitation = \"table\"",
        case.quantity.name(),
    );
    if case.scatter == Scatter::Coherence {
        let _ = writeln!(out, "averages = {}", case.averages);
    }
    out.push('\n');
    if !case.fit.is_empty() {
        let _ = writeln!(out, "[split]\nfit = [{}]\n", quoted(&case.fit));
    }
    if case.description.states_tolerances {
        let Spread { gain, delay_s, nut_m, .. } = case.description.spread;
        let _ = writeln!(out, "[tolerance]\ngain = {gain}\ndelay_s = {delay_s:e}\nnut_m = {nut_m:e}\n");
    }
    for position in &case.positions {
        let _ = writeln!(out, "[[position]]\nname = \"{}\"\nnut_m = {}\n", position.name, position.nut_m);
    }
    for record in &case.records {
        let _ = writeln!(out, "[[frf]]\nposition = \"{}\"\nfile = \"{}\"", record.position, record.file());
        for (key, point) in [("response", record.channel.response), ("excitation", record.channel.excitation)]
        {
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
