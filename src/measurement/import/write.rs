//! Writes imported FRFs as the files of a measurement set.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::ImportedFrf;

/// Position and points assigned to an imported FRF; `None` where not given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// Position.
    pub position: Option<String>,
    /// Response point of the machine, instead of the name in the file.
    pub response: Option<String>,
    /// Excitation point of the machine, instead of the name in the file.
    pub excitation: Option<String>,
}

/// Quotes text as a TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// Replaces characters that do not belong in a file name by `-`.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}

/// Returns path and content of every file of the set, each generated on demand.
///
/// `nuts_m` holds the nut positions (m) by position name. Coherences are written only together with `averages`.
pub fn set_files(
    title: &str,
    frfs: &[(ImportedFrf, Placement)],
    nuts_m: &BTreeMap<String, f64>,
    averages: Option<u32>,
) -> impl Iterator<Item = (String, String)> {
    let mut manifest = format!("title = {}\ngain = 1.0\nexcitation_unit = \"N\"\n", quoted(title));
    if let Some(averages) = averages {
        let _ = writeln!(manifest, "averages = {averages}");
    }
    let mut positions: Vec<&String> = Vec::new();
    for position in frfs.iter().filter_map(|(_, p)| p.position.as_ref()) {
        if !positions.contains(&position) {
            positions.push(position);
        }
    }
    for name in positions {
        let _ = write!(manifest, "\n[[position]]\nname = {}\n", quoted(name));
        match nuts_m.get(name) {
            Some(nut_m) => {
                let _ = writeln!(manifest, "nut_m = {nut_m:?}");
            }
            None => manifest += "# nut_m = 0.6               # nut position from the left bearing: fill in\n",
        }
    }
    let mut paths = Vec::new();
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    for (frf, placement) in frfs {
        let stem = file_name(&frf.name);
        let count = taken.entry(stem.clone()).or_insert(0);
        *count += 1;
        let path = if *count == 1 { format!("frf/{stem}.csv") } else { format!("frf/{stem}-again-{count}.csv") };
        manifest += "\n[[frf]]\n";
        if let Some(position) = &placement.position {
            let _ = writeln!(manifest, "position = {}", quoted(position));
        }
        let response = placement.response.as_ref().unwrap_or(&frf.response);
        let excitation = placement.excitation.as_ref().unwrap_or(&frf.excitation);
        let _ = writeln!(
            manifest,
            "record = {}\nfile = {}\nresponse = {}\nexcitation = {}\nquantity = \"{}\"",
            quoted(&frf.name),
            quoted(&path),
            quoted(response),
            quoted(excitation),
            frf.quantity.word()
        );
        paths.push(path);
    }
    let tables = paths.into_iter().zip(frfs).map(move |(path, (frf, _))| (path, table(frf, averages.is_some())));
    tables.chain([("manifest.toml".into(), manifest)])
}

/// Formats the table of an FRF.
fn table(frf: &ImportedFrf, averaged: bool) -> String {
    let coherence = frf.coherence.as_ref().filter(|_| averaged);
    let mut text = String::from(if coherence.is_some() { "frequency_hz,real,imag,coherence\n" } else { "frequency_hz,real,imag\n" });
    for (at, (f, h)) in frf.frequency_hz.iter().zip(&frf.values).enumerate() {
        let _ = write!(text, "{f:?},{:e},{:e}", h.re, h.im);
        if let Some(coherence) = coherence {
            let _ = write!(text, ",{}", coherence[at]);
        }
        text.push('\n');
    }
    text
}
