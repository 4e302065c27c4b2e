//! Imported FRFs as the files of a measurement set.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::ImportedFrf;

/// Where an imported FRF belongs, as far as it was said.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// Position.
    pub position: Option<String>,
    /// Point of the machine that responds, instead of the file's name for it.
    pub response: Option<String>,
    /// Point of the machine that is excited.
    pub excitation: Option<String>,
}

/// Text as a TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// A name that can be a file's.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}

/// Path and content of every file of the set, each made when it is asked for. `nuts_m` are nut positions by position name; `averages` goes
/// with coherence.
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

/// The lines of an FRF.
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
