//! Positions and points of imported FRFs.

use std::collections::BTreeMap;
use std::path::Path;

use file_access::{MOST_TABLE_BYTES, read_text};

use super::request::ImportRequest;
use crate::{StudyError, StudyResult};
use measurement::import::{ImportedFrf, Placement};

/// Assigns a position and channel to each FRF, as the options state.
pub(super) fn place(
    frfs: Vec<ImportedFrf>,
    request: &ImportRequest,
) -> StudyResult<Vec<(ImportedFrf, Placement)>> {
    let map = request.map.as_deref().map(read_map).transpose()?;
    let mut assigned = Vec::new();
    for mut frf in frfs {
        let mut placement = Placement {
            position: request.position.clone(),
            response: request.response.clone(),
            excitation: request.excitation.clone(),
        };
        if let Some(pattern) = &request.pattern {
            let (before, after) = pattern.split_once("{}").ok_or_else(|| {
                StudyError::setting("pattern", pattern, "write {} in place of the position's name")
            })?;
            let names = std::iter::once(&frf.name).chain(&frf.texts);
            placement.position =
                names.filter_map(|text| matched(text, before, after)).next().or(placement.position);
        }
        if let Some(row) = map.as_ref().and_then(|m| m.get(&frf.name)) {
            placement.position = row.position.clone().or(placement.position);
            placement.response = row.response.clone().or(placement.response);
            placement.excitation = row.excitation.clone().or(placement.excitation);
        }
        apply_signs(&mut frf, &placement);
        assigned.push((frf, placement));
    }
    if let Some(pattern) =
        request.pattern.as_ref().filter(|_| assigned.iter().all(|(_, p)| p.position.is_none()))
    {
        return Err(StudyError::setting(
            "pattern",
            pattern,
            "matches no record; list the contents of the files for their names",
        ));
    }
    if let Some(unknown) =
        map.iter().flat_map(BTreeMap::keys).find(|n| !assigned.iter().any(|(f, _)| f.name == **n))
    {
        let known: Vec<&str> = assigned.iter().map(|(f, _)| f.name.as_str()).collect();
        return Err(StudyError::setting(
            "map",
            "",
            format!("no record is called «{unknown}»; there are {}", known.join(", ")),
        ));
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
    let text = read_text(path, MOST_TABLE_BYTES).map_err(|e| fault(e.to_string()))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| fault(e.to_string()))?.clone();
    if let Some(unknown) =
        header.iter().find(|h| !["record", "position", "response", "excitation"].contains(h))
    {
        let text = format!(
            "{source}, line 1: unknown column «{unknown}»; the columns are record,position,response,excitation"
        );
        return Err(StudyError::Impossible(text));
    }
    let at = |name: &str| header.iter().position(|h| h == name);
    let record = at("record")
        .ok_or_else(|| StudyError::Impossible(format!("{source}, line 1: column «record» is missing")))?;
    let mut map = BTreeMap::new();
    for row in reader.records() {
        let row = row.map_err(|e| fault(e.to_string()))?;
        let cell = |column: Option<usize>| {
            column.and_then(|c| row.get(c)).filter(|c| !c.is_empty()).map(str::to_string)
        };
        let name = cell(Some(record)).ok_or_else(|| fault("a line has no record name; write one".into()))?;
        let placement = Placement {
            position: cell(at("position")),
            response: cell(at("response")),
            excitation: cell(at("excitation")),
        };
        if map.insert(name.clone(), placement).is_some() {
            return Err(fault(format!("record «{name}» is listed twice; keep one line")));
        }
    }
    Ok(map)
}

/// Multiplies the values by the signs of the directions at the points that are named: a point of the machine
/// has one direction, so that a blow along −Z and a sensor along +Z at points of one axis measure −H.
fn apply_signs(frf: &mut ImportedFrf, placement: &Placement) {
    let ends = [
        ("response", placement.response.is_some(), frf.response_direction, frf.response.clone()),
        ("excitation", placement.excitation.is_some(), frf.excitation_direction, frf.excitation.clone()),
    ];
    let negative: Vec<String> = ends
        .iter()
        .filter(|(_, is_named, direction, _)| *is_named && *direction < 0)
        .map(|(end, _, _, place)| format!("{end} {place}"))
        .collect();
    if negative.len() == 1 {
        frf.values.iter_mut().for_each(|value| *value = -*value);
        frf.warnings.push(format!(
            "{}: the values are multiplied by -1, the sign of the direction of the {}",
            frf.name, negative[0]
        ));
    } else if negative.len() == 2 {
        frf.warnings.push(format!(
            "{}: {} have negative directions; their signs cancel",
            frf.name,
            negative.join(" and ")
        ));
    }
    let is_cross = frf.response_direction.abs() != frf.excitation_direction.abs()
        && frf.response_direction != 0
        && frf.excitation_direction != 0;
    if is_cross && placement.response.is_some() && placement.excitation.is_some() {
        frf.warnings.push(format!(
            "{}: response {} and excitation {} have different axes; each named point is assumed to move along the positive axis of its own",
            frf.name, frf.response, frf.excitation
        ));
    }
}
