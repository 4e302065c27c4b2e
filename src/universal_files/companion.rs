//! Companion datasets of the functions: header, units, nodes and trace lines.

use std::io::{Read, Seek};

use crate::error::UniversalError;
use crate::field::{HeaderLine, parse_integer};
use crate::frame::{is_loose_sentinel, is_sentinel};
use crate::header::header_line;
use crate::number::{Scan, scan};
use crate::place::FilePlace;
use crate::source::ByteSource;
use crate::units::Units;
use crate::warning::{Warning, WarningKind};

/// Largest number of bytes kept in fixed-size items per byte of the file (1); lists may reserve twice as
/// much.
pub(crate) const SIZE_FACTOR: u64 = 2;
/// Number of bytes that may be kept in any case.
pub(crate) const SIZE_SLACK: u64 = 1 << 16;
/// Smallest size of a number and its blank (bytes).
const LEAST_BYTES: u64 = 2;

/// Dataset 151: origin of a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FileHeader {
    /// Line of the dataset number.
    pub place: FilePlace,
    /// Name of the model file.
    pub model_name: String,
    /// Description.
    pub description: String,
    /// Program that created the model.
    pub program: String,
    /// Date and time of creation of the model.
    pub created: String,
    /// Date and time of the last save of the model.
    pub saved: String,
    /// Program that wrote the file.
    pub writer: String,
    /// Date and time of writing of the file.
    pub written: String,
}

/// A node, datasets 15 and 2411.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Node number.
    pub label: i64,
    /// Coordinate system of its position.
    pub definition_system: i64,
    /// Coordinate system of its displacements.
    pub displacement_system: i64,
    /// Position in file units.
    pub position: [f64; 3],
    /// File units of length per metre; `None` without a dataset 164 before the node.
    pub length_factor: Option<f64>,
}

impl Node {
    /// Returns the position in metres, if the file's unit of length is known.
    pub fn position_m(&self) -> Option<[f64; 3]> {
        self.length_factor.map(|factor| self.position.map(|coordinate| coordinate / factor))
    }
}

/// A trace line, dataset 82.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceLine {
    /// Number.
    pub number: i64,
    /// Colour.
    pub color: i64,
    /// Name.
    pub name: String,
    /// Nodes in the order of drawing; 0 lifts the pen.
    pub nodes: Vec<i64>,
}

/// Datasets of one number that are not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skipped {
    /// Dataset number.
    pub number: u32,
    /// Line of the first one.
    pub place: FilePlace,
    /// Number of datasets.
    pub times: u64,
}

/// Reads seven lines of text; missing lines stay empty.
pub(crate) fn read_file_header<R: Read + Seek>(
    source: &mut ByteSource<R>,
    place: FilePlace,
    warnings: &mut Vec<Warning>,
) -> Result<FileHeader, UniversalError> {
    let mut missing = 7;
    let mut next = || match header_line(source, 151, missing, warnings) {
        Ok(line) => {
            missing -= 1;
            Ok(line.text.trim().to_owned())
        }
        Err(UniversalError::ShortHeader { place, dataset, missing }) => {
            let warning = WarningKind::ShortDataset { dataset, missing }.at(place);
            if warnings.last() != Some(&warning) {
                warnings.push(warning);
            }
            Ok(String::new())
        }
        Err(fault) => Err(fault),
    };
    let (model_name, description, program): (_, _, String) = (next()?, next()?, next()?);
    let (created, saved, writer, written) = (next()?, next()?, next()?, next()?);
    Ok(FileHeader { place, model_name, description, program, created, saved, writer, written })
}

/// Reads dataset 164: I10,20A1,I10; 3D25.17; D25.17.
pub(crate) fn read_units<R: Read + Seek>(
    source: &mut ByteSource<R>,
    place: FilePlace,
    warnings: &mut Vec<Warning>,
) -> Result<Units, UniversalError> {
    let mut line = header_line(source, 164, 3, warnings)?;
    let code = line.integer(0, 10, "units code")?;
    let description = line.columns(10, 30).to_owned();
    let temperature_mode = line.integer(30, 40, "temperature mode")?;
    let mut factors = Vec::new();
    for missing in [2, 1] {
        let line = header_line(source, 164, missing, warnings)?;
        numbers(&line, "unit factor", &mut factors)?;
        if factors.len() >= 4 {
            break;
        }
    }
    let &[length_factor, force_factor, temperature_factor, temperature_offset, ..] = factors.as_slice()
    else {
        let found = if factors.is_empty() { "blank" } else { "incomplete" };
        return Err(line.fault("unit factors", found, "write three factors and an offset"));
    };
    for (field, factor) in [("length factor", length_factor), ("force factor", force_factor)] {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(UniversalError::Field {
                place,
                field,
                found: factor.to_string(),
                expected: "write file units per SI unit, above 0",
            });
        }
    }
    let units = Units {
        place,
        code,
        description,
        temperature_mode,
        length_factor,
        force_factor,
        temperature_factor,
        temperature_offset,
    };
    units.check(warnings);
    Ok(units)
}

/// Fields of a node: of its first line, and of the positions in dataset 15 and in dataset 2411.
const NODE_FIELDS: [(usize, usize, &str); 4] = [
    (0, 10, "node label"),
    (10, 20, "definition coordinate system"),
    (20, 30, "displacement coordinate system"),
    (30, 40, "color"),
];
/// See [`NODE_FIELDS`].
const SHORT_POSITION: [(usize, usize, &str); 3] =
    [(40, 53, NODE_COORDINATE), (53, 66, NODE_COORDINATE), (66, 79, NODE_COORDINATE)];
/// See [`NODE_FIELDS`].
const LONG_POSITION: [(usize, usize, &str); 3] =
    [(0, 25, NODE_COORDINATE), (25, 50, NODE_COORDINATE), (50, 75, NODE_COORDINATE)];
const NODE_COORDINATE: &str = "node coordinate";

/// Reads dataset 15 (4I10,3E13.5 per line) or 2411 (4I10 and a line of 3D25.16). Stops before the closing
/// sentinel. Where missing values are accepted, a node with a field of asterisks is left out.
pub(crate) fn read_nodes<R: Read + Seek>(
    source: &mut ByteSource<R>,
    dataset: u32,
    (length_factor, accepts_missing): (Option<f64>, bool),
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Node>, UniversalError> {
    let begin = source.position();
    let mut nodes = Vec::new();
    while !at_sentinel(source)? {
        let mut line = header_line(source, dataset, 1, warnings)?;
        if line.text.is_empty() {
            continue;
        }
        let mut overflown = line
            .overflown(&NODE_FIELDS)
            .or_else(|| line.overflown(&SHORT_POSITION).filter(|_| dataset == 15));
        let second = if dataset == 15 { None } else { Some(header_line(source, dataset, 1, warnings)?) };
        overflown = overflown.or_else(|| second.as_ref()?.overflown(&LONG_POSITION));
        if let Some(field) = overflown.filter(|_| accepts_missing) {
            warnings.push(WarningKind::Overflown { field, taken: "the node is left out" }.at(line.place));
            continue;
        }
        let label = line.integer(0, 10, "node label")?;
        let definition_system = line.integer(10, 20, "definition coordinate system")?;
        let displacement_system = line.integer(20, 30, "displacement coordinate system")?;
        line.integer(30, 40, "color")?;
        let mut coordinates = Vec::with_capacity(3);
        match second {
            None => line.text = line.text.chars().skip(40).collect(),
            Some(second) => line = second,
        }
        numbers(&line, "node coordinate", &mut coordinates)?;
        let &[x, y, z] = coordinates.as_slice() else {
            return Err(line.fault("node coordinates", line.text.trim(), "write three numbers"));
        };
        check_size::<Node>(nodes.len(), begin, source.place(), "nodes")?;
        nodes.push(Node {
            label,
            definition_system,
            displacement_system,
            position: [x, y, z],
            length_factor,
        });
    }
    nodes.shrink_to_fit();
    Ok(nodes)
}

/// Reads dataset 82: 3I10; 80A1; 8I10 until all nodes are read. Stops before the closing sentinel.
pub(crate) fn read_trace_lines<R: Read + Seek>(
    source: &mut ByteSource<R>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<TraceLine>, UniversalError> {
    let begin = source.position();
    let mut traces = Vec::new();
    while !at_sentinel(source)? {
        let mut line = header_line(source, 82, 3, warnings)?;
        if line.text.is_empty() {
            continue;
        }
        let number = line.integer(0, 10, "trace line number")?;
        let count = line.integer(10, 20, "number of trace line nodes")?;
        let color = line.integer(20, 30, "color")?;
        let count = usize::try_from(count).map_err(|_| {
            line.fault("number of trace line nodes", &count.to_string(), "write how many node numbers follow")
        })?;
        let name = header_line(source, 82, 2, warnings)?.text.trim().to_owned();
        check_size::<TraceLine>(traces.len(), begin, source.place(), "trace lines")?;
        let mut nodes = Vec::new();
        nodes.reserve_exact(
            count.min(usize::try_from(source.remaining() / LEAST_BYTES).unwrap_or(usize::MAX)),
        );
        while nodes.len() < count {
            let line = header_line(source, 82, 1, warnings)?;
            let left = count - nodes.len();
            for word in line.text.split_whitespace().take(left) {
                let node = parse_integer(word).ok_or_else(|| {
                    line.fault("trace line node", word, "write a node number, or 0 to lift the pen")
                })?;
                nodes.push(node);
            }
        }
        nodes.shrink_to_fit();
        traces.push(TraceLine { number, color, name, nodes });
    }
    Ok(traces)
}

/// Refuses more items than the bytes read can represent, so that memory stays proportional to the file size.
fn check_size<T>(
    items: usize,
    begin: u64,
    place: FilePlace,
    what: &'static str,
) -> Result<(), UniversalError> {
    let kept = (items * size_of::<T>()) as u64;
    if kept > SIZE_FACTOR * (place.byte - begin) + SIZE_SLACK {
        return Err(UniversalError::TooManySmall { place, what });
    }
    Ok(())
}

/// Whether a sentinel or the end of the file follows here; does not move.
fn at_sentinel<R: Read + Seek>(source: &mut ByteSource<R>) -> Result<bool, UniversalError> {
    let window = source.peek(128)?;
    let line = window.split(|&byte| byte == b'\n').next().unwrap_or_default();
    Ok(window.is_empty() || is_sentinel(line) || is_loose_sentinel(line))
}

/// Reads all numbers of a line.
fn numbers(line: &HeaderLine, field: &'static str, numbers: &mut Vec<f64>) -> Result<(), UniversalError> {
    let text = line.text.as_bytes();
    let mut offset = 0;
    loop {
        match scan(text, offset) {
            Scan::End => return Ok(()),
            Scan::Number { value, end, .. } if value.is_finite() => {
                numbers.push(value);
                offset = end;
            }
            Scan::Number { .. } | Scan::Bad { .. } => {
                return Err(line.fault(field, line.text.trim(), "write finite numbers"));
            }
        }
    }
}
