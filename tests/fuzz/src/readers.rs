//! Every reader of the program, given bytes: it reads or refuses them, and what it reads holds together.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};

use jointid::config::read_machine_text;
use jointid::measurement::import::{ImportedFrf, Placement, frf_from_csv, frfs_from_universal, set_files};
use jointid::measurement::universal::{read, read_headers};
use jointid::measurement::{FrictionTable, Quantity, Reference, SourceFile, read_motion, read_set_with};
use jointid::report::page::{self, Page};
use serde_json::from_slice;

/// Reads bytes; panics where the reader does.
pub type Reader = fn(&[u8]);

/// All readers by name.
pub const READERS: [(&str, Reader); 5] =
    [("machine", machine), ("set", set), ("tables", tables), ("universal", universal), ("documents", documents)];

/// A machine's TOML; lines at its end that begin with `--set ` are overrides.
fn machine(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let (text, overrides) = text.split_once("\n--set ").unwrap_or((text, ""));
    let overrides: Vec<String> = overrides.split("\n--set ").filter(|line| !line.is_empty()).map(String::from).collect();
    if let Ok(config) = read_machine_text("machine.toml", text, &overrides, &[]) {
        assert!(!config.machine.points.is_empty());
        assert!(config.machine.parameters.iter().all(|p| p.start.is_finite() && p.lower < p.upper), "{:?}", config.machine.parameters);
    }
}

/// A whole measurement set: files one after another, each but the first, `manifest.toml`, below a line `#### NAME`.
fn set(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let mut parts = text.split("\n#### ");
    let manifest = ("manifest.toml", parts.next().unwrap_or(""));
    let others = parts.filter_map(|part| part.split_once('\n'));
    let files: BTreeMap<&str, &str> = others.chain([manifest]).collect();
    let file = |name: &str| files.get(name).map(|text| text.as_bytes().to_vec()).ok_or_else(|| Error::from(ErrorKind::NotFound));
    if let Ok(set) = read_set_with("set", file) {
        assert!(set.modes.is_some() || !set.frfs.is_empty() || !set.motions.is_empty());
        for line in set.frfs.iter().flat_map(|frf| &frf.lines) {
            assert!(line.frequency_hz > 0.0 && line.value.re.is_finite() && line.value.im.is_finite());
        }
        for frf in &set.frfs {
            assert!(frf.lines.iter().all(|line| frf.component_sd(line).is_none_or(|sd| sd >= 0.0)));
        }
        _ = set.split(None, &[]);
    }
}

/// Tables in CSV: friction runs, commands, time records, FRFs of other programs.
fn tables(bytes: &[u8]) {
    let file = SourceFile { path: "table.csv".into(), bytes: bytes.to_vec() };
    if let Ok(reference) = Reference::of(file.clone()) {
        assert!(reference.step_s > 0.0 && reference.step_s.is_finite(), "{}", reference.step_s);
    }
    _ = FrictionTable::of(file);
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(record) = read_motion("table.csv", "record", text) {
        assert!(record.step_s > 0.0 && record.step_s.is_finite(), "{}", record.step_s);
        assert!(record.time_s.len() == record.load.samples().len());
    }
    for quantity in [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance] {
        if let Ok(frf) = frf_from_csv("table.csv", "table", text, Some(quantity)) {
            made_a_set(vec![frf]);
        }
    }
}

/// A universal file: all of it, its headers, its FRFs.
fn universal(bytes: &[u8]) {
    _ = read_headers(bytes);
    let Ok(file) = read(bytes) else { return };
    for record in &file.functions {
        assert_eq!(record.header.count, record.ordinate.len());
        assert_eq!(record.abscissa.len(), record.ordinate.len());
    }
    if let Ok((frfs, _)) = frfs_from_universal("file.uff", "file", &file, Some(Quantity::Receptance)) {
        made_a_set(frfs);
    }
}

/// What was imported is read again, every line of it.
fn made_a_set(frfs: Vec<ImportedFrf>) {
    if frfs.is_empty() {
        return;
    }
    let counts: Vec<usize> = frfs.iter().map(|f| f.frequency_hz.len()).collect();
    let placed: Vec<_> = frfs.into_iter().map(|f| (f, Placement::default())).collect();
    let files: BTreeMap<String, String> = set_files("imported", &placed, &BTreeMap::new(), Some(2)).into_iter().collect();
    let file = |name: &str| files.get(name).map(|text| text.as_bytes().to_vec()).ok_or_else(|| Error::from(ErrorKind::NotFound));
    match read_set_with("imported", file) {
        Ok(set) => assert!(set.frfs.iter().zip(counts).all(|(f, count)| f.lines.len() + f.rejected == count)),
        // All its lines may be 0, or of low coherence: that is said as it is read.
        Err(fault) => assert!(fault.to_string().contains("no line"), "{fault}"),
    }
}

/// Result documents, seals and labels, and the page drawn of them.
fn documents(bytes: &[u8]) {
    let page = Page {
        identification: from_slice(bytes).ok(),
        validation: from_slice(bytes).ok(),
        comparison: from_slice(bytes).ok(),
        peaks: from_slice(bytes).ok(),
        diagnosis: from_slice(bytes).ok(),
        ..Page::default()
    };
    if page.identification.is_some() || page.comparison.is_some() || page.peaks.is_some() || page.diagnosis.is_some() {
        _ = page::html(&page);
    }
    _ = from_slice::<jointid::withheld::Seal>(bytes);
    _ = from_slice::<jointid::withheld::Run>(bytes);
    _ = from_slice::<Vec<jointid::truth::Label>>(bytes);
}
