//! `jointid report`: one HTML page of the result documents in a folder.

mod curves;
mod diagnosed;
mod reread_inputs;
mod shapes;

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use self::curves::{CurveModel, Overlay};
use self::reread_inputs::read_inputs_again;
use crate::identified::{check_identification, identified_machine, identified_values};
use crate::motion_records::has_only_motion_records;
use crate::outcome::{CommandResult, Outcome, to_message};
use crate::terminal;
use dynamics::model::RodModel;
use measurement::read_set;
use report::document::IdentificationDocument;
use report::page::{self, Page};
use report::{OutputFolder, digest};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// Folder with result documents, such as identification.json, validation.json, peaks.json or diagnosis.json
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// File of the page; DIR/report.html by default
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Runs the command.
pub fn run(given: &ReportArguments) -> CommandResult {
    let folder = &given.folder;
    if !folder.is_dir() {
        let fault = if folder.exists() { "is not a folder; name a folder that --out has filled" } else { "there is no such folder" };
        return Err(format!("{}: {fault}", folder.display()));
    }
    let mut page = Page::default();
    let mut files = Vec::new();
    page.identification = read(folder, "identification.json", &mut files)?;
    page.validation = read(folder, "validation.json", &mut files)?;
    page.comparison = read(folder, "comparison.json", &mut files)?;
    page.peaks = read(folder, "peaks.json", &mut files)?;
    page.diagnosis = read(folder, "diagnosis.json", &mut files)?;
    page.hybrid = read(folder, "hybrid.json", &mut files)?;
    page.bode = read(folder, "bode.json", &mut files)?;
    page.gain = read(folder, "gain.json", &mut files)?;
    page.circle = read(folder, "circle.json", &mut files)?;
    if files.is_empty() {
        return Err(format!(
            "{}: holds no result document; run identify, validate, compare, peaks, diagnose, hybrid or simulate with --out {0} first",
            folder.display()
        ));
    }
    page.files = files;
    let name = folder.canonicalize().ok().and_then(|f| Some(f.file_name()?.to_string_lossy().into_owned()));
    page.title = name.unwrap_or_else(|| folder.display().to_string());
    if let Some(identified) = page.identification.take() {
        match recompute(folder, &identified, &mut page) {
            Ok(()) => {}
            Err(fault) => page.notes.push(format!("FRFs, positions and mode shapes are not drawn: {fault}")),
        }
        page.identification = Some(identified);
    } else if let Some(peaks) = &page.peaks {
        // The nut positions are in the manifest of the set that the peaks come from.
        let manifest = peaks.stamp.inputs.iter().find_map(|i| i.path.strip_suffix("manifest.toml"));
        if let Some(Ok(set)) = manifest.map(read_set) {
            page.nut_m = set.positions.iter().filter_map(|p| Some((p.name.clone(), p.nut_m?))).collect();
        }
    }
    if let Some(of) = page.diagnosis.take() {
        if let Err(fault) = diagnosed::draw(&of, &mut page) {
            page.notes.push(format!("the diagnosis is not drawn over its FRFs: {fault}"));
        }
        page.diagnosis = Some(of);
    }
    let html = page::html(&page);
    let target = given.out.clone().unwrap_or_else(|| folder.join("report.html"));
    if target.is_dir() {
        return Err(format!("{}: is a folder; name a file with --out", target.display()));
    }
    let parent = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = target.file_name().ok_or_else(|| format!("{}: name a file with --out", target.display()))?;
    let written = OutputFolder::prepare(parent)?.write(&file.to_string_lossy(), html.as_bytes())?;
    if !given.quiet {
        page.notes.iter().for_each(|n| terminal::note(n));
        if html.len() > page::MOST_BYTES {
            terminal::note(&format!("the page has {:.1} MB, more than many mailboxes accept", html.len() as f64 / 1e6));
        }
        eprintln!("written: {} ({:.1} MB)", written.display(), html.len() as f64 / 1e6);
    }
    Ok(Outcome::Done)
}

/// Reads a document of the folder; `None` where it does not exist.
fn read<T: DeserializeOwned>(folder: &Path, name: &str, files: &mut Vec<(String, String)>) -> Result<Option<T>, String> {
    let path = folder.join(name);
    let bytes = match std::fs::read(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        read => read.map_err(|e| format!("{}: {e}", path.display()))?,
    };
    let fault = |text: String| format!("{}: {text}", path.display());
    let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(|e| fault(format!("line {}: is no JSON: {e}", e.line())))?;
    let expected = format!("jointid/{}/1", name.trim_end_matches(".json"));
    match value.get("schema").and_then(serde_json::Value::as_str) {
        Some(schema) if schema == expected => {}
        Some(schema) => return Err(fault(format!("is a {schema}, not a {expected}; make it again with this version"))),
        None => return Err(fault(format!("has no `schema`; a result document has {expected} there"))),
    }
    files.push((name.into(), digest(&bytes)));
    serde_json::from_value(value).map(Some).map_err(|e| fault(format!("is no {expected}: {e}")))
}

/// Predicts the measurements from the configuration and the identified values.
///
/// # Errors  an input has changed since the identification.
fn recompute(folder: &Path, identified: &IdentificationDocument, page: &mut Page) -> Result<(), String> {
    let path = folder.join("identification.json");
    check_identification(&path, identified)?;
    let settings = &identified.settings;
    let loaded = read_inputs_again(&settings.config, &settings.measurements, &identified.stamp, ("identification", "identify"))?;
    let values = identified_values(&path, identified, &loaded.config)?;
    let rods = settings.lumps.map_or(RodModel::Exact, RodModel::Lumped);
    page.title = loaded.config.machine.title.clone();
    page.nut_m = loaded.set.positions.iter().filter_map(|p| Some((p.name.clone(), p.nut_m?))).collect();
    if has_only_motion_records(&loaded.set) {
        return Ok(());
    }
    let set = &loaded.set;
    let (fit, _) = set.split(settings.positions.as_deref(), &settings.hold_out).map_err(to_message)?;
    let gain = identified.parameters.get("gain").map(|g| g.value);
    let (machine, as_fitted) = identified_machine(identified, &loaded, &values)?;
    let model = CurveModel { machine: loaded.config.machine.clone(), values, rods, gain };
    let as_fitted = CurveModel { machine, values: as_fitted, rods, gain };
    page.curves = Overlay { set, fit, models: std::slice::from_ref(&as_fitted) }.curves()?;
    page.shapes = shapes::shapes(set, &model)?;
    Ok(())
}
