//! Measurement sets from files of other programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::place::place;
use super::request::ImportRequest;
use super::source::{is_table, read_universal, table_text};
use crate::{StudyError, StudyResult};
use measurement::SetWithoutNoise;
use measurement::import::{
    ImportedFrf, Placement, TableRequest, frfs_from_table, frfs_from_universal, is_of_frf, left_behind,
    set_files, set_of,
};
use universal_files::function_type::FREQUENCY_RESPONSE;
use universal_files::{UniversalRecord, WarningKind, read_sound, read_where};

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

    /// Returns the paths of FRF tables in a set's folder that its manifest lists and this set does not: they
    /// are left behind where it replaces the other. Only files in `frf/` of the folder itself count.
    pub fn left_behind(&self, folder: &Path) -> Vec<PathBuf> {
        left_behind(&self.assigned, folder)
    }

    /// Returns name and content of every file of the set's folder, `manifest.toml` among them, each generated
    /// on demand.
    pub fn files(&self) -> impl Iterator<Item = (String, String)> {
        set_files(&self.title, &self.assigned, &self.nut_m, self.averages)
    }

    /// Returns the set, as reading its files gives it, and what was assumed or left out. `path` names the set
    /// in messages and documents.
    ///
    /// # Errors  a line is not usable.
    pub fn into_set(self, path: &str) -> StudyResult<(SetWithoutNoise, Vec<String>)> {
        Ok((set_of(path, &self.title, self.assigned, &self.nut_m, self.averages)?, self.notes))
    }
}

/// Imports files of other programs as a measurement set.
///
/// # Errors  a file cannot be read or holds no FRF; the quantity is unknown; names or positions do not fit
///   the records.
pub fn import(request: &ImportRequest) -> StudyResult<ImportedSet> {
    let (mut frfs, mut notes) = (Vec::new(), Vec::new());
    for path in &request.files {
        let source = path.display().to_string();
        let stem = path.file_stem().map_or_else(|| "frf".into(), |s| s.to_string_lossy().into_owned());
        if is_table(path) {
            let of_table = TableRequest {
                quantity: request.quantity,
                columns: request.columns.clone(),
                strict: request.strict,
            };
            frfs.extend(
                frfs_from_table(&source, &stem, &table_text(path)?, &of_table)
                    .map_err(StudyError::impossible)?,
            );
        } else {
            let (found, of_file) = universal(path, &source, &stem, request)?;
            frfs.extend(found);
            notes.extend(of_file);
        }
    }
    let assigned = place(frfs, request)?;
    for (frf, _) in &assigned {
        notes.extend(frf.warnings.iter().cloned());
        if frf.coherence.is_some() && request.averages.is_none() {
            notes.push(format!(
                "{}: its coherence is left out, because the number of averages is unknown; state averages",
                frf.name
            ));
        }
    }
    if let Some(name) =
        request.nut_m.keys().find(|n| !assigned.iter().any(|(_, p)| p.position.as_ref() == Some(n)))
    {
        let mut known: Vec<&str> = assigned.iter().filter_map(|(_, p)| p.position.as_deref()).collect();
        known.dedup();
        let fault = match known[..] {
            [] => "no record has a position; use position, pattern or map, and list the contents of the files for their names".into(),
            _ => format!("no record has a position of that name; there are {}", known.join(", ")),
        };
        return Err(StudyError::setting("nut_m", format!("{name}=…"), fault));
    }
    if assigned.iter().any(|(frf, _)| frf.by_torque) && assigned.iter().any(|(frf, _)| !frf.by_torque) {
        let of = |wanted: bool| {
            assigned.iter().find(|(frf, _)| frf.by_torque == wanted).map_or("", |(frf, _)| frf.name.as_str())
        };
        let fault = format!(
            "{} is excited by a torque, {} by a force; a set has one unit of excitation: import them apart",
            of(true),
            of(false)
        );
        return Err(StudyError::Impossible(fault));
    }
    Ok(ImportedSet {
        notes,
        title: request.title.clone(),
        assigned,
        nut_m: request.nut_m.clone(),
        averages: request.averages,
    })
}

/// Reads the FRFs of a universal file, with notes on what is left out.
fn universal(
    path: &Path,
    source: &str,
    stem: &str,
    request: &ImportRequest,
) -> StudyResult<(Vec<ImportedFrf>, Vec<String>)> {
    let (mut file, refused) = read_universal(path, |input| match request.strict {
        true => Ok((read_where(input, is_of_frf)?, Vec::new())),
        false => read_sound(input, is_of_frf),
    })?;
    let mut notes: Vec<String> =
        refused.iter().map(|fault| format!("{source}: {fault}; this part is left out")).collect();
    let cut = |f: &UniversalRecord| {
        f.header.warnings.iter().any(|w| matches!(w.kind, WarningKind::Truncated { .. }))
    };
    if !request.accept_truncated
        && let Some(record) = file.functions.iter().find(|f| cut(f))
    {
        let truncated =
            record.header.warnings.iter().find(|w| matches!(w.kind, WarningKind::Truncated { .. }));
        let text = truncated.map_or_else(String::new, ToString::to_string);
        let remedy = "accept the values that it holds (accept_truncated)";
        if request.strict
            || file.functions.iter().all(|f| cut(f) || f.header.function_type != FREQUENCY_RESPONSE)
        {
            return Err(StudyError::input(source, format!("{text}, or {remedy}")));
        }
        notes.push(format!("{source}: {text}; this record is left out; get the whole file, or {remedy}"));
        file.functions.retain(|f| !cut(f));
    }
    let (found, of_file) = frfs_from_universal(source, stem, file, request.quantity, request.strict)
        .map_err(StudyError::impossible)?;
    if found.is_empty() {
        // The first refused part may have been the FRF.
        let fault = refused.first().map_or_else(
            || "holds no FRF (dataset 58, function type 4); list its contents".to_string(),
            |first| format!("holds no FRF that can be read: {first}"),
        );
        return Err(StudyError::input(source, fault));
    }
    notes.extend(of_file);
    Ok((found, notes))
}
