//! Writes imported FRFs as the files of a measurement set.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::folder::Content;
use crate::set::{COMMAND, MANIFEST, read_set_of};
use crate::{MeasurementError, SetWithoutNoise};
use file_access::{MOST_TEXT_BYTES, read_replaced};

use super::ImportedFrf;
use super::imported_table::ImportedTable;
use super::place::direction_name;

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

/// Returns the path of each FRF's table, in their order, none twice.
fn table_paths(frfs: &[(ImportedFrf, Placement)]) -> Vec<String> {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let mut paths = Vec::new();
    for (frf, _) in frfs {
        let stem = file_name(&frf.name);
        let mut path = format!("frf/{stem}.csv");
        let mut count = 1;
        while !taken.insert(path.to_lowercase()) {
            count += 1;
            path = format!("frf/{stem}-again-{count}.csv");
        }
        paths.push(path);
    }
    paths
}

/// Returns the paths of FRF tables in a set's folder that its manifest lists and a set of these FRFs does
/// not: they are left behind where it replaces the other. Only files in `frf/` of the folder itself count.
pub fn left_behind(frfs: &[(ImportedFrf, Placement)], folder: &Path) -> Vec<PathBuf> {
    let manifest = read_replaced(&folder.join(MANIFEST), MOST_TEXT_BYTES)
        .ok()
        .and_then(|text| text.parse::<toml::Table>().ok());
    if !folder.join("frf").symlink_metadata().is_ok_and(|m| m.is_dir()) {
        return Vec::new();
    }
    let entries =
        manifest.as_ref().and_then(|m| m.get("frf")?.as_array()).map(Vec::as_slice).unwrap_or_default();
    let listed = entries.iter().filter_map(|entry| entry.get("file")?.as_str());
    let kept: BTreeSet<String> = table_paths(frfs).into_iter().collect();
    let in_folder = |name: &&str| {
        name.strip_prefix("frf/").is_some_and(|file| !file.contains(['/', '\\']) && file.ends_with(".csv"))
    };
    let left: BTreeSet<&str> = listed.filter(in_folder).filter(|name| !kept.contains(*name)).collect();
    left.into_iter().map(|name| folder.join(name)).collect()
}

/// Returns path and content of every file of the set, the manifest first, each generated on demand.
///
/// `nuts_m` holds the nut positions (m) by position name. Coherences are written only together with
/// `averages`.
pub fn set_files(
    title: &str,
    frfs: &[(ImportedFrf, Placement)],
    nuts_m: &BTreeMap<String, f64>,
    averages: Option<u32>,
) -> impl Iterator<Item = (String, String)> {
    let averaged = averages.is_some();
    let table =
        move |(path, (frf, _)): (_, &(ImportedFrf, _))| (path, ImportedTable { frf, averaged }.text());
    let manifest = manifest(title, frfs, nuts_m, averages);
    std::iter::once((MANIFEST.into(), manifest)).chain(table_paths(frfs).into_iter().zip(frfs).map(table))
}

/// Returns the set that reading these files gives, without writing and parsing the tables. Arguments as of
/// [`set_files`]; `path` names the set.
///
/// # Errors  as those of reading the files.
pub fn set_of(
    path: &str,
    title: &str,
    frfs: Vec<(ImportedFrf, Placement)>,
    nuts_m: &BTreeMap<String, f64>,
    averages: Option<u32>,
) -> Result<SetWithoutNoise, MeasurementError> {
    let manifest = manifest(title, &frfs, nuts_m, averages);
    let paths = table_paths(&frfs).into_iter();
    let table = |(frf, _)| ImportedTable { frf, averaged: averages.is_some() };
    let mut tables: BTreeMap<String, ImportedTable> = paths.zip(frfs.into_iter().map(table)).collect();
    read_set_of(path, |file| match file {
        MANIFEST => Ok(Content::Bytes(manifest.clone().into_bytes())),
        _ => tables
            .remove(file)
            .map(|table| Content::Imported(Box::new(table)))
            .ok_or_else(|| ErrorKind::NotFound.into()),
    })
}

fn manifest(
    title: &str,
    frfs: &[(ImportedFrf, Placement)],
    nuts_m: &BTreeMap<String, f64>,
    averages: Option<u32>,
) -> String {
    let all = |holds: fn(&(ImportedFrf, Placement)) -> bool| !frfs.is_empty() && frfs.iter().all(holds);
    let unit = if all(|(frf, placement)| placement.excitation.as_ref().unwrap_or(&frf.excitation) == COMMAND)
    {
        "m"
    } else if all(|(frf, _)| frf.by_torque) {
        "N*m"
    } else {
        "N"
    };
    let mut manifest = format!("title = {}\ngain = 1.0\nexcitation_unit = \"{unit}\"\n", quoted(title));
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
    for ((frf, placement), path) in frfs.iter().zip(table_paths(frfs)) {
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
        for (key, direction) in [
            ("response_direction", frf.response_direction),
            ("excitation_direction", frf.excitation_direction),
        ] {
            let name = direction_name(direction);
            if !name.is_empty() {
                let _ = writeln!(manifest, "{key} = \"{name}\"");
            }
        }
    }
    manifest
}
