//! Measurement sets from and to files of other programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::{StudyError, StudyResult};
use file_access::{MOST_TABLE_BYTES, read_text};
use measurement::import::{ImportedFrf, Placement, frf_from_csv, frfs_from_universal, is_of_frf, set_files};
use measurement::universal::{
    Abscissa, ByteOrder, Encoding, FileHeader, NodeLocation, RecordAxis, Units, UniversalRecord, UniversalWriter, Warning, data_type,
    read_headers_path, read_path_where,
};
use measurement::{Frf, MeasurementSet, Quantity};

/// What to import, and what the files do not state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportRequest {
    /// Universal files (dataset 58, 58b) or tables (.csv, .tsv).
    pub files: Vec<PathBuf>,
    /// Whether files that end inside their data are accepted.
    pub accept_truncated: bool,
    /// Measured quantity.
    pub quantity: Option<Quantity>,
    /// Position of all records.
    pub position: Option<String>,
    /// Pattern with {} for the position's name, in file names, ID lines or entities.
    pub pattern: Option<String>,
    /// Table that assigns records, with the columns record,position,response,excitation.
    pub map: Option<PathBuf>,
    /// Nut positions (m) by position.
    pub nut_m: BTreeMap<String, f64>,
    /// Response point of all records.
    pub response: Option<String>,
    /// Excitation point of all records.
    pub excitation: Option<String>,
    /// Number of averages of each FRF; required to use a coherence.
    pub averages: Option<u32>,
    /// Title of the set.
    pub title: String,
}

/// An imported measurement set.
#[derive(Debug, Clone)]
pub struct ImportedSet {
    /// What was assumed or left out.
    pub notes: Vec<String>,
    title: String,
    assigned: Vec<(ImportedFrf, Placement)>,
    nut_m: BTreeMap<String, f64>,
    averages: Option<u32>,
}

impl ImportedSet {
    /// Returns the number of FRFs.
    pub fn frfs(&self) -> usize {
        self.assigned.len()
    }

    /// Returns the number of FRFs at a named position.
    pub fn frfs_at_positions(&self) -> usize {
        self.assigned.iter().filter(|(_, placement)| placement.position.is_some()).count()
    }

    /// Returns name and content of every file of the set's folder, `manifest.toml` among them, each generated on demand.
    pub fn files(&self) -> impl Iterator<Item = (String, String)> {
        set_files(&self.title, &self.assigned, &self.nut_m, self.averages)
    }
}

fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|e| ["csv", "tsv"].iter().any(|t| e.eq_ignore_ascii_case(t)))
}

/// Imports files of other programs as a measurement set.
///
/// # Errors  a file cannot be read or holds no FRF; the quantity is unknown; names or positions do not fit the records.
pub fn import(request: &ImportRequest) -> StudyResult<ImportedSet> {
    let (mut frfs, mut notes) = (Vec::new(), Vec::new());
    for path in &request.files {
        let source = path.display().to_string();
        let stem = path.file_stem().map_or_else(|| "frf".into(), |s| s.to_string_lossy().into_owned());
        if is_table(path) {
            let text = read_text(path, MOST_TABLE_BYTES).map_err(|e| unreadable(path, &e.into()))?;
            frfs.push(frf_from_csv(&source, &stem, &text, request.quantity).map_err(StudyError::impossible)?);
        } else {
            let file = read_path_where(path, is_of_frf).map_err(|e| StudyError::input(&source, e.to_string()))?;
            let cut = file.functions.iter().flat_map(|f| &f.header.warnings).find(|w| matches!(w, Warning::Truncated { .. }));
            if let Some(cut) = cut.filter(|_| !request.accept_truncated) {
                return Err(StudyError::input(&source, format!("{cut}, or accept the values that it holds (accept_truncated)")));
            }
            let (found, file_notes) = frfs_from_universal(&source, &stem, file, request.quantity).map_err(StudyError::impossible)?;
            if found.is_empty() {
                return Err(StudyError::input(&source, "holds no FRF (dataset 58, function type 4); list its contents"));
            }
            frfs.extend(found);
            notes.extend(file_notes);
        }
    }
    let assigned = place(frfs, request)?;
    for (frf, _) in &assigned {
        notes.extend(frf.warnings.iter().cloned());
        if frf.coherence.is_some() && request.averages.is_none() {
            notes.push(format!("{}: its coherence is left out, because the number of averages is unknown; state averages", frf.name));
        }
    }
    if let Some(name) = request.nut_m.keys().find(|n| !assigned.iter().any(|(_, p)| p.position.as_ref() == Some(n))) {
        let fault = "no record has a position of that name; use position, pattern or map";
        return Err(StudyError::setting("nut_m", format!("{name}=…"), fault));
    }
    Ok(ImportedSet { notes, title: request.title.clone(), assigned, nut_m: request.nut_m.clone(), averages: request.averages })
}

/// Describes why a file cannot be read.
fn unreadable(path: &Path, error: &std::io::Error) -> StudyError {
    let fault = match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        std::io::ErrorKind::PermissionDenied => "reading it is not permitted".into(),
        std::io::ErrorKind::InvalidData => "is not text in UTF-8".into(),
        _ if path.is_dir() => "is a folder; name a file".into(),
        _ => error.to_string(),
    };
    StudyError::input(path.display(), fault)
}

/// Contents of a file, from its headers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileContents {
    /// Text, one record per line.
    pub text: String,
    /// Warnings about the file.
    pub warnings: Vec<String>,
}

/// Lists the records of files from their headers.
///
/// # Errors  a file cannot be read.
pub fn list_contents(files: &[PathBuf]) -> StudyResult<Vec<FileContents>> {
    let mut all = Vec::new();
    for path in files {
        let mut text = String::new();
        let source = path.display();
        if is_table(path) {
            text += &format!("{source}: a table\n");
            all.push(FileContents { text, warnings: Vec::new() });
            continue;
        }
        let file = read_headers_path(path).map_err(|e| StudyError::input(&source, e.to_string()))?;
        text += &format!("{source}: {} functions, {} nodes, {} unit sets\n", file.functions.len(), file.nodes.len(), file.units.len());
        for (at, h) in file.functions.iter().enumerate() {
            let place = |l: &NodeLocation| format!("{}:{}", l.node, l.direction);
            text += &format!(
                "  {:>3}  type {}  {} values  {} / {}  {}\n",
                at + 1,
                h.function_type,
                h.count,
                place(&h.response),
                place(&h.reference),
                h.id_lines[0].trim()
            );
        }
        for skipped in &file.skipped {
            text += &format!("  dataset {} is not read ({} ×)\n", skipped.number, skipped.times);
        }
        let warnings = file.warnings.iter().chain(file.functions.iter().flat_map(|f| &f.warnings));
        all.push(FileContents { text, warnings: warnings.map(ToString::to_string).collect() });
    }
    Ok(all)
}

/// Assigns a position and channel to each FRF, as the options state.
fn place(frfs: Vec<ImportedFrf>, request: &ImportRequest) -> StudyResult<Vec<(ImportedFrf, Placement)>> {
    let map = request.map.as_deref().map(read_map).transpose()?;
    let mut assigned = Vec::new();
    for frf in frfs {
        let mut placement =
            Placement { position: request.position.clone(), response: request.response.clone(), excitation: request.excitation.clone() };
        if let Some(pattern) = &request.pattern {
            let (before, after) = pattern
                .split_once("{}")
                .ok_or_else(|| StudyError::setting("pattern", pattern, "write {} in place of the position's name"))?;
            let names = std::iter::once(&frf.name).chain(&frf.texts);
            placement.position = names.filter_map(|text| matched(text, before, after)).next().or(placement.position);
        }
        if let Some(row) = map.as_ref().and_then(|m| m.get(&frf.name)) {
            placement.position = row.position.clone().or(placement.position);
            placement.response = row.response.clone().or(placement.response);
            placement.excitation = row.excitation.clone().or(placement.excitation);
        }
        assigned.push((frf, placement));
    }
    if let Some(pattern) = request.pattern.as_ref().filter(|_| assigned.iter().all(|(_, p)| p.position.is_none())) {
        return Err(StudyError::setting("pattern", pattern, "matches no record; list the contents of the files for their names"));
    }
    if let Some(unknown) = map.iter().flat_map(BTreeMap::keys).find(|n| !assigned.iter().any(|(f, _)| f.name == **n)) {
        let known: Vec<&str> = assigned.iter().map(|(f, _)| f.name.as_str()).collect();
        return Err(StudyError::setting("map", "", format!("no record is called «{unknown}»; there are {}", known.join(", "))));
    }
    Ok(assigned)
}

/// Returns the text between `before` and `after`; up to white space where `after` is empty.
fn matched(text: &str, before: &str, after: &str) -> Option<String> {
    let start = text.find(before)? + before.len();
    let rest = &text[start..];
    let word = if after.is_empty() { rest.split_whitespace().next()? } else { &rest[..rest.find(after)?] };
    (!word.is_empty()).then(|| word.to_string())
}

/// Reads a table with the columns record,position[,response][,excitation], by record.
fn read_map(path: &Path) -> StudyResult<BTreeMap<String, Placement>> {
    let source = path.display();
    let fault = |text: String| StudyError::input(&source, text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(|e| fault(e.to_string()))?;
    let header = reader.headers().map_err(|e| fault(e.to_string()))?.clone();
    if let Some(unknown) = header.iter().find(|h| !["record", "position", "response", "excitation"].contains(h)) {
        let text = format!("{source}, line 1: unknown column «{unknown}»; the columns are record,position,response,excitation");
        return Err(StudyError::Impossible(text));
    }
    let at = |name: &str| header.iter().position(|h| h == name);
    let record = at("record").ok_or_else(|| StudyError::Impossible(format!("{source}, line 1: column «record» is missing")))?;
    let mut map = BTreeMap::new();
    for row in reader.records() {
        let row = row.map_err(|e| fault(e.to_string()))?;
        let cell = |column: Option<usize>| column.and_then(|c| row.get(c)).filter(|c| !c.is_empty()).map(str::to_string);
        let name = cell(Some(record)).ok_or_else(|| fault("a line has no record name; write one".into()))?;
        let placement = Placement { position: cell(at("position")), response: cell(at("response")), excitation: cell(at("excitation")) };
        if map.insert(name.clone(), placement).is_some() {
            return Err(fault(format!("record «{name}» is listed twice; keep one line")));
        }
    }
    Ok(map)
}

/// A measurement set as a universal file.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportedSet {
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Number of FRFs.
    pub frfs: usize,
    /// What the file cannot hold.
    pub notes: Vec<String>,
}

/// Formats the FRFs of a set as a universal file, in dataset 58b (binary) or 58 (text).
///
/// # Errors  the set holds no FRF, or one that a universal file cannot hold.
pub fn export(set: &MeasurementSet, binary: bool) -> StudyResult<ExportedSet> {
    if set.frfs.is_empty() {
        return Err(StudyError::input(&set.path, "the set has no FRF to export"));
    }
    let mut points: Vec<String> = Vec::new();
    let mut node = |name: &str| match points.iter().position(|p| p == name) {
        Some(at) => at as i64 + 1,
        None => {
            points.push(name.to_string());
            points.len() as i64
        }
    };
    let mut writer = UniversalWriter::new(Vec::new());
    let fault = |e: measurement::universal::WriteError| StudyError::input(&set.path, e.to_string());
    writer.header(&FileHeader { model_name: set.title.clone(), ..FileHeader::default() }).map_err(fault)?;
    writer.units(&Units::si()).map_err(fault)?;
    let encoding = if binary { Encoding::Binary(ByteOrder::Little) } else { Encoding::Ascii };
    for frf in &set.frfs {
        let position = frf.position.map(|p| set.positions[p].name.clone());
        let (response, excitation) = (node(&frf.response), node(&frf.excitation));
        writer.record(&record(frf, position.as_deref(), response, excitation), encoding).map_err(fault)?;
    }
    let bytes = writer.finish().map_err(fault)?;
    let has_noise = set.frfs.iter().any(|f| f.lines.iter().any(|l| l.noise.is_some()));
    let left_out = "coherence and relative_sd have no field in a universal FRF record and are not written; keep the measurement set, too";
    Ok(ExportedSet { bytes, frfs: set.frfs.len(), notes: has_noise.then(|| left_out.to_string()).into_iter().collect() })
}

fn record(frf: &Frf, position: Option<&str>, response: i64, excitation: i64) -> UniversalRecord {
    let (code, label, unit) = match frf.quantity {
        Quantity::Receptance => (data_type::DISPLACEMENT, "Displacement", "m"),
        Quantity::Mobility => (data_type::VELOCITY, "Velocity", "m/s"),
        Quantity::Accelerance => (data_type::ACCELERATION, "Acceleration", "m/s^2"),
    };
    let location = |name: &str, node: i64| NodeLocation { entity: name.chars().take(10).collect(), node, direction: 1 };
    let frequency = Abscissa::Uneven(frf.lines.iter().map(|l| l.frequency_hz).collect());
    let values = frf.lines.iter().map(|l| l.value).collect();
    let numerator = RecordAxis::new(code, label, unit);
    let mut record = UniversalRecord::frequency_response(
        location(&frf.response, response),
        location(&frf.excitation, excitation),
        numerator,
        frequency,
        values,
    );
    record.header.id_lines[0] = format!("{} / {}", frf.response, frf.excitation);
    if let Some(position) = position {
        record.header.id_lines[3] = format!("position {position}");
    }
    record
}
