//! A whole universal file in memory.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use crate::companion::{FileHeader, Node, SIZE_FACTOR, SIZE_SLACK, Skipped, TraceLine};
use crate::error::UniversalError;
use crate::reader::{Dataset, UniversalReader};
use crate::record::{RecordHeader, UniversalRecord};
use crate::units::Units;
use crate::warning::{Warning, WarningKind};

/// Number of refused parts at which the reading of a file ends: it is no measured file.
const LEAST_REFUSED_TO_STOP: usize = 1000;

/// Content of a universal file; `F` is [`UniversalRecord`], or [`RecordHeader`] where only headers are read.
#[derive(Debug, Clone, PartialEq)]
pub struct UniversalFile<F = UniversalRecord> {
    /// Datasets 151.
    pub headers: Vec<FileHeader>,
    /// Datasets 164, in file order; each record keeps the one in force.
    pub units: Vec<Units>,
    /// Nodes of datasets 15 and 2411.
    pub nodes: Vec<Node>,
    /// Trace lines of datasets 82.
    pub trace_lines: Vec<TraceLine>,
    /// Datasets 58.
    pub functions: Vec<F>,
    /// Datasets that are not read, in the order of their first occurrence.
    pub skipped: Vec<Skipped>,
    /// Tolerated faults outside records; those of a record are in its header.
    pub warnings: Vec<Warning>,
}

/// Reads a universal file.
///
/// # Errors     the file cannot be read, or the first refused record; [`UniversalReader`] continues after it
pub fn read(input: impl Read + Seek) -> Result<UniversalFile, UniversalError> {
    collect(UniversalReader::new(input)?, UniversalReader::next_dataset, &mut Err)
}

/// Reads the headers of a universal file, without loading its data.
///
/// # Errors     the file cannot be read, or the first refused header
pub fn read_headers(input: impl Read + Seek) -> Result<UniversalFile<RecordHeader>, UniversalError> {
    collect(UniversalReader::new(input)?.accept_missing(), UniversalReader::next_header, &mut Err)
}

/// Reads a universal file with only the functions whose header is `wanted`; the data of the others are
/// skipped without loading.
///
/// # Errors     as [`read`], for the wanted functions
pub fn read_where(
    input: impl Read + Seek,
    wanted: impl Fn(&RecordHeader) -> bool,
) -> Result<UniversalFile, UniversalError> {
    collect(UniversalReader::new(input)?, |reader| next_wanted(reader, &wanted), &mut Err)
}

/// Reads the sound parts of a universal file, with only the functions whose header is `wanted`: a part that
/// is refused is left out and returned as the reason, and missing values (NaN, infinite, asterisks) are NaN.
///
/// # Errors     the file cannot be read, or holds no dataset
pub fn read_sound(
    input: impl Read + Seek,
    wanted: impl Fn(&RecordHeader) -> bool,
) -> Result<(UniversalFile, Vec<UniversalError>), UniversalError> {
    let reader = UniversalReader::new(input)?.accept_missing();
    let mut refused = Vec::new();
    let file =
        collect(reader, |reader| next_wanted(reader, &wanted), &mut |fault| leave_out(fault, &mut refused))?;
    Ok((file, refused))
}

/// Keeps the reason of a part that is left out.
///
/// # Errors     the file itself cannot be read any farther
fn leave_out(fault: UniversalError, refused: &mut Vec<UniversalError>) -> Result<(), UniversalError> {
    if matches!(fault, UniversalError::Io(_)) || refused.len() >= LEAST_REFUSED_TO_STOP {
        return Err(fault);
    }
    refused.push(fault);
    Ok(())
}

/// Returns the next dataset, a record only where its header is `wanted`.
fn next_wanted<R: Read + Seek>(
    reader: &mut UniversalReader<R>,
    wanted: &impl Fn(&RecordHeader) -> bool,
) -> Option<Result<Dataset, UniversalError>> {
    let dataset = reader.next_header()?;
    Some(dataset.and_then(|dataset| match dataset {
        Dataset::Function(header) if wanted(&header) => {
            reader.record(&header).map(|record| Dataset::Function(Box::new(record)))
        }
        Dataset::Function(header) => {
            Ok(Dataset::Skipped(Skipped { number: 58, place: header.place, times: 1 }))
        }
        Dataset::Header(header) => Ok(Dataset::Header(header)),
        Dataset::Units(units) => Ok(Dataset::Units(units)),
        Dataset::Nodes(nodes) => Ok(Dataset::Nodes(nodes)),
        Dataset::TraceLines(lines) => Ok(Dataset::TraceLines(lines)),
        Dataset::Skipped(skipped) => Ok(Dataset::Skipped(skipped)),
    }))
}

/// Collects all datasets that `next` reads; `refused` decides whether a refused part ends the reading.
fn collect<R: Read + Seek, F>(
    mut reader: UniversalReader<R>,
    next: impl Fn(&mut UniversalReader<R>) -> Option<Result<Dataset<F>, UniversalError>>,
    refused: &mut dyn FnMut(UniversalError) -> Result<(), UniversalError>,
) -> Result<UniversalFile<F>, UniversalError> {
    let mut file = UniversalFile {
        headers: Vec::new(),
        units: Vec::new(),
        nodes: Vec::new(),
        trace_lines: Vec::new(),
        functions: Vec::new(),
        skipped: Vec::new(),
        warnings: Vec::new(),
    };
    let mut skipped: BTreeMap<u32, Skipped> = BTreeMap::new();
    let (mut cut, mut is_other_format) = (None, true);
    let mut budget = (SIZE_FACTOR * reader.length()).saturating_add(SIZE_SLACK);
    while let Some(dataset) = next(&mut reader) {
        is_other_format = false;
        let kept = match &dataset {
            Ok(Dataset::Function(_)) => size_of::<F>(),
            Ok(Dataset::Header(_)) => size_of::<FileHeader>(),
            Ok(Dataset::Units(_)) => size_of::<Units>(),
            _ => 0,
        };
        budget = budget.checked_sub(kept as u64).ok_or_else(|| reader.too_many_small())?;
        match dataset {
            Ok(Dataset::Function(function)) => file.functions.push(*function),
            Ok(Dataset::Header(header)) => file.headers.push(header),
            Ok(Dataset::Units(found)) => file.units.push(found),
            Ok(Dataset::Nodes(found)) => file.nodes.extend(found),
            Ok(Dataset::TraceLines(found)) => file.trace_lines.extend(found),
            Ok(Dataset::Skipped(found)) => {
                skipped.entry(found.number).and_modify(|first| first.times += 1).or_insert(found);
            }
            Err(UniversalError::EndsInHeader { place, .. }) if !file.functions.is_empty() => {
                cut = Some(WarningKind::EndsInHeader.at(place))
            }
            Err(fault) => refused(fault)?,
        }
    }
    if is_other_format {
        return Err(reader.nothing_found());
    }
    file.skipped.extend(skipped.into_values());
    file.skipped.sort_by_key(|skipped| skipped.place.byte);
    file.warnings = reader.warnings().into_iter().chain(cut).collect();
    Ok(file)
}
