//! `jointid import` and `jointid export`: measurement sets from and to files of other programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::arguments::QuantityName;
use crate::outcome::{CommandResult, Outcome, print_out, to_message};
use crate::terminal;
use measurement::import::{ImportedFrf, Placement, frf_from_csv, frfs_from_universal, is_of_frf, set_files};
use measurement::universal::{
    Abscissa, ByteOrder, Encoding, FileHeader, NodeLocation, RecordAxis, Units, UniversalRecord, UniversalWriter, Warning, data_type,
    read_headers_path, read_path_where,
};
use measurement::{Frf, Quantity, read_set};
use report::{OutputFolder, wrapped};

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
pub struct ImportArguments {
    /// Universal files (dataset 58, 58b) or tables (.csv, .tsv)
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Folder of the new measurement set
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the contents of the files from their headers, and write nothing
    #[arg(long)]
    pub list: bool,
    /// Accept files that end inside their data
    #[arg(long)]
    pub accept_truncated: bool,
    /// Measured quantity, where the files do not state it
    #[arg(long, value_enum)]
    pub quantity: Option<QuantityName>,
    /// Position of all records
    #[arg(long, value_name = "NAME")]
    pub position: Option<String>,
    /// Pattern with {} for the position's name, in file names, ID lines or entities, e.g. 'pos {}'
    #[arg(long, value_name = "TEXT")]
    pub pattern: Option<String>,
    /// Table that assigns records, with the columns record,position,response,excitation
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Nut positions (m), comma-separated, e.g. l1=0.6,l2=1.3
    #[arg(long, value_name = "NAME=M", value_delimiter = ',')]
    pub nut_m: Vec<String>,
    /// Response point of all records
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Excitation point of all records
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// Number of averages of each FRF; required to use a coherence
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub averages: Option<u32>,
    /// Title of the set
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Print only results and errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct ExportArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// File to write
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Write dataset 58b, binary, instead of text
    #[arg(long)]
    pub binary: bool,
}

fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|e| ["csv", "tsv"].iter().any(|t| e.eq_ignore_ascii_case(t)))
}

/// Imports files of other programs as a measurement set.
pub fn import(given: &ImportArguments) -> CommandResult {
    if given.list {
        return list(given);
    }
    let out = given.out.as_ref().ok_or("import: name the folder of the new set with --out, or list the files with --list")?;
    let quantity = given.quantity.map(QuantityName::quantity);
    let (mut frfs, mut notes) = (Vec::new(), Vec::new());
    for path in &given.files {
        let source = path.display().to_string();
        let stem = path.file_stem().map_or_else(|| "frf".into(), |s| s.to_string_lossy().into_owned());
        if is_table(path) {
            let text = std::fs::read_to_string(path).map_err(|e| unreadable(path, &e))?;
            frfs.push(frf_from_csv(&source, &stem, &text, quantity)?);
        } else {
            let file = read_path_where(path, is_of_frf).map_err(|e| format!("{source}: {e}"))?;
            let cut = file.functions.iter().flat_map(|f| &f.header.warnings).find(|w| matches!(w, Warning::Truncated { .. }));
            if let Some(cut) = cut.filter(|_| !given.accept_truncated) {
                return Err(format!("{source}: {cut}, or accept the values that it holds with --accept-truncated"));
            }
            let (found, file_notes) = frfs_from_universal(&source, &stem, file, quantity)?;
            if found.is_empty() {
                return Err(format!("{source}: holds no FRF (dataset 58, function type 4); list its contents with --list"));
            }
            frfs.extend(found);
            notes.extend(file_notes);
        }
    }
    let nuts_m = nut_positions(&given.nut_m)?;
    let assigned = place(frfs, given)?;
    for (frf, _) in &assigned {
        notes.extend(frf.warnings.iter().cloned());
        if frf.coherence.is_some() && given.averages.is_none() {
            notes.push(format!("{}: its coherence is left out, because the number of averages is unknown; write --averages", frf.name));
        }
    }
    if let Some(name) = nuts_m.keys().find(|n| !assigned.iter().any(|(_, p)| p.position.as_ref() == Some(n))) {
        return Err(format!("--nut-m {name}=…: no record has a position of that name; use --position, --pattern or --map"));
    }
    let title =
        given.title.clone().unwrap_or_else(|| out.file_name().map_or_else(|| "imported".into(), |n| n.to_string_lossy().into_owned()));
    let folder = OutputFolder::claim(out)?;
    if out.join("manifest.toml").exists() {
        return Err(format!("{}: already holds a manifest.toml; name an empty folder with --out", out.display()));
    }
    folder.write_all(set_files(&title, &assigned, &nuts_m, given.averages))?;
    if !given.quiet {
        notes.iter().for_each(|n| terminal::warning(n));
    }
    let with_position = assigned.iter().filter(|(_, p)| p.position.is_some()).count();
    print_out(&format!("{} FRFs imported into {}, {with_position} of them at a position\n", assigned.len(), out.display()))?;
    Ok(Outcome::Done)
}

/// Describes why a file cannot be read.
fn unreadable(path: &Path, error: &std::io::Error) -> String {
    let fault = match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        std::io::ErrorKind::PermissionDenied => "reading it is not permitted".into(),
        std::io::ErrorKind::InvalidData => "is not text in UTF-8".into(),
        _ if path.is_dir() => "is a folder; name a file".into(),
        _ => error.to_string(),
    };
    format!("{}: {fault}", path.display())
}

/// Lists the records of the files from their headers, one per line.
fn list(given: &ImportArguments) -> CommandResult {
    let mut text = String::new();
    for path in &given.files {
        let source = path.display();
        if is_table(path) {
            text += &format!("{source}: a table\n");
            continue;
        }
        let file = read_headers_path(path).map_err(|e| format!("{source}: {e}"))?;
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
        warnings.for_each(|w| text += &wrapped(&format!("  warning: {w}")));
    }
    print_out(&text)?;
    Ok(Outcome::Done)
}

fn nut_positions(given: &[String]) -> Result<BTreeMap<String, f64>, String> {
    given
        .iter()
        .map(|text| {
            let (name, number) = text.split_once('=').ok_or_else(|| format!("--nut-m {text}: write NAME=M, as in l1=0.6"))?;
            let nut_m = number.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            Ok((name.trim().to_string(), nut_m.ok_or_else(|| format!("--nut-m {text}: «{number}» is no distance in m"))?))
        })
        .collect()
}

/// Assigns a position and channel to each FRF, as the options state.
fn place(frfs: Vec<ImportedFrf>, given: &ImportArguments) -> Result<Vec<(ImportedFrf, Placement)>, String> {
    let map = given.map.as_deref().map(read_map).transpose()?;
    let mut assigned = Vec::new();
    for frf in frfs {
        let mut placement =
            Placement { position: given.position.clone(), response: given.response.clone(), excitation: given.excitation.clone() };
        if let Some(pattern) = &given.pattern {
            let (before, after) =
                pattern.split_once("{}").ok_or_else(|| format!("--pattern {pattern}: write {{}} in place of the position's name"))?;
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
    if let Some(pattern) = given.pattern.as_ref().filter(|_| assigned.iter().all(|(_, p)| p.position.is_none())) {
        return Err(format!("--pattern {pattern}: matches no record; list their names with --list"));
    }
    if let Some(unknown) = map.iter().flat_map(BTreeMap::keys).find(|n| !assigned.iter().any(|(f, _)| f.name == **n)) {
        let known: Vec<&str> = assigned.iter().map(|(f, _)| f.name.as_str()).collect();
        return Err(format!("--map: no record is called «{unknown}»; there are {}", known.join(", ")));
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
fn read_map(path: &Path) -> Result<BTreeMap<String, Placement>, String> {
    let source = path.display();
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(|e| format!("{source}: {e}"))?;
    let header = reader.headers().map_err(|e| format!("{source}: {e}"))?.clone();
    if let Some(unknown) = header.iter().find(|h| !["record", "position", "response", "excitation"].contains(h)) {
        return Err(format!("{source}, line 1: unknown column «{unknown}»; the columns are record,position,response,excitation"));
    }
    let at = |name: &str| header.iter().position(|h| h == name);
    let record = at("record").ok_or_else(|| format!("{source}, line 1: column «record» is missing"))?;
    let mut map = BTreeMap::new();
    for row in reader.records() {
        let row = row.map_err(|e| format!("{source}: {e}"))?;
        let cell = |column: Option<usize>| column.and_then(|c| row.get(c)).filter(|c| !c.is_empty()).map(str::to_string);
        let name = cell(Some(record)).ok_or_else(|| format!("{source}: a line has no record name; write one"))?;
        let placement = Placement { position: cell(at("position")), response: cell(at("response")), excitation: cell(at("excitation")) };
        if map.insert(name.clone(), placement).is_some() {
            return Err(format!("{source}: record «{name}» is listed twice; keep one line"));
        }
    }
    Ok(map)
}

/// Writes the FRFs of a set as a universal file.
pub fn export(given: &ExportArguments) -> CommandResult {
    let set = read_set(&given.measurements).map_err(to_message)?;
    if set.frfs.is_empty() {
        return Err(format!("{}: the set has no FRF to export", set.path));
    }
    let folder = match given.out.parent().filter(|p| !p.as_os_str().is_empty()) {
        Some(parent) => parent.to_path_buf(),
        None => PathBuf::from("."),
    };
    let name = given.out.file_name().and_then(|n| n.to_str()).ok_or_else(|| format!("--out {}: name a file", given.out.display()))?;
    let mut points: Vec<String> = Vec::new();
    let mut node = |name: &str| match points.iter().position(|p| p == name) {
        Some(at) => at as i64 + 1,
        None => {
            points.push(name.to_string());
            points.len() as i64
        }
    };
    let mut writer = UniversalWriter::new(Vec::new());
    let fault = |e: measurement::universal::WriteError| format!("{}: {e}", given.out.display());
    writer.header(&FileHeader { model_name: set.title.clone(), ..FileHeader::default() }).map_err(fault)?;
    writer.units(&Units::si()).map_err(fault)?;
    let encoding = if given.binary { Encoding::Binary(ByteOrder::Little) } else { Encoding::Ascii };
    for frf in &set.frfs {
        let position = frf.position.map(|p| set.positions[p].name.clone());
        let (response, excitation) = (node(&frf.response), node(&frf.excitation));
        writer.record(&record(frf, position.as_deref(), response, excitation), encoding).map_err(fault)?;
    }
    let bytes = writer.finish().map_err(fault)?;
    OutputFolder::prepare(&folder)?.write(name, &bytes)?;
    if set.frfs.iter().any(|f| f.lines.iter().any(|l| l.noise.is_some())) {
        terminal::warning(
            "coherence and relative_sd have no field in a universal FRF record and are not written; keep the measurement set, too",
        );
    }
    print_out(&format!("{} FRFs written to {}\n", set.frfs.len(), given.out.display()))?;
    Ok(Outcome::Done)
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
