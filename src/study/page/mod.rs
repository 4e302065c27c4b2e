//! What the HTML page shows of the result documents in a folder.

mod curves;
mod diagnosed;
mod inputs;
mod predicted;
mod shapes;

use std::path::Path;

use serde::de::DeserializeOwned;

use self::curves::{CurveModel, Overlay};
use self::inputs::unchanged;
use crate::identified::{check_identification, result_document};
use crate::{Sources, Study, StudyError, StudyResult};
use file_access::{MOST_DOCUMENT_BYTES, read_file};
use measurement::read_set_from;
use report::digest;
use report::document::IdentificationDocument;
use report::page::Page;

/// Reads the result documents of a folder, and predicts the curves and shapes that the page draws over the
/// measurements, which are read as the sources allow; a set that they name replaces that of the documents.
///
/// # Errors  there is no such folder; it holds no result document, or one that cannot be read.
pub fn page(folder: &Path, sources: &Sources) -> StudyResult<Page> {
    if !folder.is_dir() {
        let fault = if folder.exists() {
            "is not a folder; name a folder that holds result documents"
        } else {
            "there is no such folder"
        };
        return Err(StudyError::input(folder.display(), fault));
    }
    let mut page = Page::default();
    let mut files = Vec::new();
    page.identification = read(folder, "identification.json", &mut files)?;
    page.validation = read(folder, "validation.json", &mut files)?;
    page.prediction = read(folder, "prediction.json", &mut files)?;
    page.comparison = read(folder, "comparison.json", &mut files)?;
    page.peaks = read(folder, "peaks.json", &mut files)?;
    page.diagnosis = read(folder, "diagnosis.json", &mut files)?;
    page.hybrid = read(folder, "hybrid.json", &mut files)?;
    page.bode = read(folder, "bode.json", &mut files)?;
    page.gain = read(folder, "gain.json", &mut files)?;
    page.circle = read(folder, "circle.json", &mut files)?;
    if files.is_empty() {
        let fault = format!(
            "holds no result document; write some into {} first: of identify, validate, predict, compare, peaks, diagnose, hybrid or simulate",
            folder.display()
        );
        return Err(StudyError::input(folder.display(), fault));
    }
    page.files = files;
    let name = folder.canonicalize().ok().and_then(|f| Some(f.file_name()?.to_string_lossy().into_owned()));
    page.title = name.unwrap_or_else(|| folder.display().to_string());
    if let (Some(identified), Some(predicted)) = (&page.identification, &page.prediction) {
        match predicted::measured(identified, predicted, sources) {
            Ok(marks) => page.measured_modes = marks,
            Err(fault) => page
                .notes
                .push(format!("measured natural frequencies are not drawn over the prediction: {fault}")),
        }
    }
    if let Some(identified) = page.identification.take() {
        if let Err(fault) = draw_identified(folder, &identified, sources, &mut page) {
            page.notes.push(format!("FRFs, positions and mode shapes are not drawn: {fault}"));
        }
        page.identification = Some(identified);
    } else if let Some(peaks) = &page.peaks {
        // The nut positions are in the manifest of the set that the peaks come from.
        let manifest = peaks.stamp.inputs.iter().find_map(|i| i.path.strip_suffix("manifest.toml"));
        if let Some(Ok(set)) = manifest.map(|folder| read_set_from(folder, sources.allow_outside)) {
            page.nut_m = set.positions.iter().filter_map(|p| Some((p.name.clone(), p.nut_m?))).collect();
        }
    }
    if let Some(of) = page.diagnosis.take() {
        if let Err(fault) = diagnosed::draw(&of, sources, &mut page) {
            page.notes.push(format!("the diagnosis is not drawn over its FRFs: {fault}"));
        }
        page.diagnosis = Some(of);
    }
    Ok(page)
}

/// Reads a document of the folder; `None` where it does not exist.
fn read<T: DeserializeOwned>(
    folder: &Path,
    name: &str,
    files: &mut Vec<(String, String)>,
) -> StudyResult<Option<T>> {
    let path = folder.join(name);
    let bytes = match read_file(&path, MOST_DOCUMENT_BYTES) {
        Err(fault) if fault.is_missing() => return Ok(None),
        read => read.map_err(|e| StudyError::input(path.display(), e.to_string()))?,
    };
    let document = result_document(&path, &bytes, name.trim_end_matches(".json"))?;
    files.push((name.into(), digest(&bytes)));
    Ok(Some(document))
}

/// Predicts the measurements from the machine and its identified values.
///
/// # Errors  an input has changed since the identification.
fn draw_identified(
    folder: &Path,
    identified: &IdentificationDocument,
    sources: &Sources,
    page: &mut Page,
) -> StudyResult<()> {
    let path = folder.join("identification.json");
    check_identification(&path, identified)?;
    let settings = &identified.settings;
    let study = unchanged(
        Study::of_identification(identified, sources),
        &identified.stamp,
        ("identification", "identify"),
        sources,
    )?;
    page.notes.extend(study.outdated_machine());
    let Study { config, set, .. } = &study;
    let values = study.identified_values(&path, identified)?;
    let rods = study.settings.rods;
    page.title = config.machine.title.clone();
    page.nut_m = set.positions.iter().filter_map(|p| Some((p.name.clone(), p.nut_m?))).collect();
    if study.is_on_motion() {
        return Ok(());
    }
    let (fit, _) = set.split(settings.positions.as_deref(), &settings.hold_out)?;
    let gain = identified.parameters.get("gain").map(|g| g.value);
    let (machine, as_fitted) = study.identified_machine(&path, identified)?;
    let model = CurveModel { machine: config.machine.clone(), values, rods, gain };
    let as_fitted = CurveModel { machine, values: as_fitted, rods, gain };
    page.curves = Overlay { set, fit, models: std::slice::from_ref(&as_fitted) }.curves()?;
    page.shapes = shapes::shapes(set, &model)?;
    Ok(())
}
