//! Every reader of the program as a function of bytes: it reads or refuses them, and a result that it reads
//! is consistent.

use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind};

use config::{ConfigError, MachineConfig, read_machine_text};
use lab::withheld::{Run, Seal};
use measurement::import::{
    ImportedFrf, Placement, TableRequest, decoded, described, described_table, frfs_from_table,
    frfs_from_universal, set_files,
};
use measurement::{
    FrictionTable, MeasurementError, MeasurementSet, Quantity, Reference, SourceFile, read_motion,
    read_set_with,
};
use reference_simulator::Label;
use report::page::{Page, html};
use serde_json::{Value, from_slice};
use universal_files::{read, read_headers, read_sound};

/// Reads bytes; panics where the reader panics or its result is inconsistent.
pub type Reader = fn(&[u8]);

/// All readers by name.
pub const READERS: [(&str, Reader); 6] = [
    ("machine", machine),
    ("set", set),
    ("tables", tables),
    ("universal", universal),
    ("documents", documents),
    ("page", page),
];

/// Returns the file of a table.
fn table_file(bytes: &[u8]) -> SourceFile {
    let content = bytes.to_vec();
    SourceFile::new("table.csv".into(), move || content)
}

/// Whether a reader accepts bytes.
pub type Accepts = fn(&[u8]) -> bool;

/// Acceptance by reader name, for the readers that can refuse.
pub const ACCEPTANCE: [(&str, Accepts); 5] = [
    ("machine", |bytes| machine_of(bytes).is_some_and(|read| read.is_ok())),
    ("set", |bytes| set_of(bytes).is_ok()),
    ("tables", |bytes| {
        let file = table_file(bytes);
        let text = std::str::from_utf8(bytes).unwrap_or("");
        let frf = [Quantity::Receptance, Quantity::Accelerance]
            .iter()
            .any(|q| frfs_from_table("table.csv", "table", text, &of_quantity(*q)).is_ok());
        frf || Reference::of(file.clone()).is_ok() || FrictionTable::of(file).is_ok()
    }),
    ("universal", |bytes| read(Cursor::new(bytes)).is_ok() && read_headers(Cursor::new(bytes)).is_ok()),
    ("documents", |bytes| document_of(bytes).is_some()),
];

/// Reads a machine's TOML; lines at its end that begin with `--set ` are overrides.
fn machine_of(bytes: &[u8]) -> Option<Result<MachineConfig, ConfigError>> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (text, overrides) = text.split_once("\n--set ").unwrap_or((text, ""));
    let overrides: Vec<String> =
        overrides.split("\n--set ").filter(|line| !line.is_empty()).map(String::from).collect();
    Some(read_machine_text("machine.toml", text, &overrides, &[]))
}

fn machine(bytes: &[u8]) {
    if let Some(Ok(config)) = machine_of(bytes) {
        assert!(!config.machine.points.is_empty());
        assert!(
            config.machine.parameters.iter().all(|p| p.start.is_finite() && p.lower < p.upper),
            "{:?}",
            config.machine.parameters
        );
    }
}

/// Reads a whole measurement set: the files follow one another, each below a line `#### NAME`, except the
/// first, `manifest.toml`.
fn set_of(bytes: &[u8]) -> Result<MeasurementSet, MeasurementError> {
    let text = String::from_utf8_lossy(bytes);
    let mut parts = text.split("\n#### ");
    let manifest = ("manifest.toml", parts.next().unwrap_or(""));
    let others = parts.filter_map(|part| part.split_once('\n'));
    let files: BTreeMap<&str, &str> = others.chain([manifest]).collect();
    let file = |name: &str| {
        files.get(name).map(|text| text.as_bytes().to_vec()).ok_or_else(|| Error::from(ErrorKind::NotFound))
    };
    read_set_with("set", file)
}

fn set(bytes: &[u8]) {
    if let Ok(set) = set_of(bytes) {
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

/// Reads a CSV table, classified by its columns: friction runs, commands and time records, FRFs of other
/// programs.
fn tables(bytes: &[u8]) {
    let file = table_file(bytes);
    // A table to import may be in any encoding.
    let imported = decoded(bytes.to_vec());
    if imported
        .lines()
        .next()
        .is_none_or(|first| !first.contains("time_s") && !first.contains("velocity_m_s"))
    {
        _ = described_table("table.csv", &imported, &TableRequest::default());
        let quantity = if imported.contains("s^2") { Quantity::Accelerance } else { Quantity::Receptance };
        for strict in [false, true] {
            if let Ok(frfs) = frfs_from_table(
                "table.csv",
                "table",
                &imported,
                &TableRequest { strict, ..of_quantity(quantity) },
            ) {
                check_written_set(frfs);
            }
        }
    }
    let Ok(text) = file.text() else { return };
    if text.contains("velocity_m_s") {
        _ = FrictionTable::of(file);
    } else if text.contains("time_s") {
        if let Ok(record) = read_motion("table.csv", "record", text) {
            assert!(record.step_s > 0.0 && record.step_s.is_finite(), "{}", record.step_s);
            assert!(record.time_s.len() == record.load.samples().len());
        }
        if let Ok(reference) = Reference::of(file) {
            assert!(reference.step_s > 0.0 && reference.step_s.is_finite(), "{}", reference.step_s);
        }
    }
}

fn of_quantity(quantity: Quantity) -> TableRequest {
    TableRequest { quantity: Some(quantity), ..TableRequest::default() }
}

/// Reads a universal file: the whole file, its headers, its FRFs.
fn universal(bytes: &[u8]) {
    if let Ok(file) = read_headers(Cursor::new(bytes)) {
        file.functions.iter().for_each(|header| _ = described(header));
    }
    if let Ok((file, _)) = read_sound(Cursor::new(bytes), |_| true)
        && let Ok((frfs, _)) =
            frfs_from_universal("file.uff", "file", file, Some(Quantity::Receptance), false)
    {
        check_written_set(frfs);
    }
    let Ok(file) = read(Cursor::new(bytes)) else { return };
    for record in &file.functions {
        assert_eq!(record.header.count, record.ordinate.len());
        assert_eq!(record.abscissa.len(), record.ordinate.len());
    }
    if let Ok((frfs, _)) = frfs_from_universal("file.uff", "file", file, Some(Quantity::Receptance), true) {
        check_written_set(frfs);
    }
}

/// Checks that imported FRFs, written as a set, can be read again without losing a line.
fn check_written_set(frfs: Vec<ImportedFrf>) {
    if frfs.is_empty() {
        return;
    }
    // Lines without coherence are left out where the coherence is written.
    let written = |f: &ImportedFrf| {
        f.coherence.as_ref().map(|c| c.iter().filter(|c| c.is_finite()).count()).filter(|count| *count > 0)
    };
    let counts: Vec<usize> = frfs.iter().map(|f| written(f).unwrap_or(f.frequency_hz.len())).collect();
    let placed: Vec<_> = frfs.into_iter().map(|f| (f, Placement::default())).collect();
    let files: BTreeMap<String, String> = set_files("imported", &placed, &BTreeMap::new(), Some(2)).collect();
    let file = |name: &str| {
        files.get(name).map(|text| text.as_bytes().to_vec()).ok_or_else(|| Error::from(ErrorKind::NotFound))
    };
    match read_set_with("imported", file) {
        Ok(set) => {
            assert!(set.frfs.iter().zip(counts).all(|(f, count)| f.lines.len() + f.rejected.len() == count))
        }
        // All its lines may be 0 or of low coherence; the reader then reports it.
        Err(fault) => assert!(fault.to_string().contains("no line"), "{fault}"),
    }
}

/// Reads a result document by its schema, or a seal, run or label file of the blind check.
fn documents(bytes: &[u8]) {
    _ = document_of(bytes);
}

fn document_of(bytes: &[u8]) -> Option<Page> {
    let mut page = Page::default();
    let schema =
        from_slice::<Value>(bytes).ok()?.get("schema").and_then(Value::as_str).unwrap_or("").to_string();
    match schema.as_str() {
        "jointid/identification/1" => page.identification = Some(from_slice(bytes).ok()?),
        "jointid/validation/1" => page.validation = Some(from_slice(bytes).ok()?),
        "jointid/comparison/1" => page.comparison = Some(from_slice(bytes).ok()?),
        "jointid/peaks/1" => page.peaks = Some(from_slice(bytes).ok()?),
        "jointid/diagnosis/1" => page.diagnosis = Some(from_slice(bytes).ok()?),
        "jointid/withheld-seal/1" => _ = from_slice::<Seal>(bytes).ok()?,
        "" => _ = from_slice::<Vec<Label>>(bytes).ok()?,
        _ => _ = from_slice::<Run>(bytes).ok()?,
    }
    Some(page)
}

/// Renders the page of a result document.
fn page(bytes: &[u8]) {
    if let Some(page) = document_of(bytes) {
        _ = html(&page);
    }
}
