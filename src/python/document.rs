//! Work that needs no study: peaks, friction, the library of effects, the command.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use report::{EARLIER, Existing, OutputFolder, to_json};
use study::{FrictionRequest, PeaksRequest, Sources};

use crate::error::{to_exception, unwritten, word};
use crate::measurement::MeasurementSet;
use crate::work::{Running, compute, run};

fn peaks_request(band_hz: Option<(f64, f64)>, local: bool, max_order: Option<usize>) -> PeaksRequest {
    let usual = PeaksRequest::default();
    PeaksRequest { band_hz, local, max_order: max_order.unwrap_or(usual.max_order) }
}

/// Extracts peaks from the FRFs of a set: the document, and the modes as a table.
#[pyfunction]
pub fn peaks(
    py: Python<'_>,
    measurements: &MeasurementSet,
    band_hz: Option<(f64, f64)>,
    local: bool,
    max_order: Option<usize>,
    running: Running,
) -> PyResult<(String, String)> {
    let (set, request) = ((*measurements.set).clone(), peaks_request(band_hz, local, max_order));
    run(py, &running, move |control| {
        let found = study::peaks(&set, &request, &control)?;
        Ok((to_json(&found.document)?, found.modes_csv))
    })
}

/// Computes the stabilisation diagram of an FRF: order, natural frequency (Hz), damping ratio, stable.
#[pyfunction]
pub fn stabilisation(
    py: Python<'_>,
    measurements: &MeasurementSet,
    frf: usize,
    max_order: Option<usize>,
) -> PyResult<Vec<(usize, f64, f64, bool)>> {
    let request = peaks_request(None, false, max_order);
    let found = compute(py, || study::stabilisation(&measurements.set, frf, &request))?;
    Ok(found
        .into_iter()
        .map(|pole| (pole.order, pole.frequency_hz, pole.damping_ratio, pole.stable))
        .collect())
}

/// Makes the HTML page of the result documents in a folder, with notes on what it does not draw. A named
/// measurement set takes the place of that of the documents.
#[pyfunction]
pub fn page(
    py: Python<'_>,
    folder: PathBuf,
    measurements: Option<String>,
) -> PyResult<(String, Vec<String>)> {
    let sources = Sources { measurements, ..Sources::default() };
    let page = compute(py, || study::page(&folder, &sources))?;
    Ok((report::page::html(&page), page.notes))
}

/// Fits a Stribeck curve to a table of friction.
#[pyfunction]
pub fn friction(
    py: Python<'_>,
    path: String,
    lead_m: Option<f64>,
    efficiency: f64,
    noise: Option<String>,
) -> PyResult<String> {
    let noise = word("noise", noise.as_deref())?;
    let request = FrictionRequest { path, lead_m, efficiency, noise };
    compute(py, || Ok(to_json(&study::friction(&request)?)?))
}

/// Lists the library of effects.
#[pyfunction]
pub fn effects(config: Option<&str>, id: Option<&str>) -> PyResult<String> {
    let listed = study::effects(config, id).and_then(|document| Ok(to_json(&document)?));
    listed.map_err(|e| to_exception(&e))
}

/// Writes files into a folder, all or none. Existing ones are replaced where this program wrote the first, or
/// on request.
#[pyfunction]
#[pyo3(signature = (folder, files, new, replace=false))]
pub fn write_files(
    py: Python<'_>,
    folder: PathBuf,
    files: Vec<(String, Vec<u8>)>,
    new: bool,
    replace: bool,
) -> PyResult<()> {
    let existing = match (new, replace) {
        (true, _) => Existing::Kept("name a new folder"),
        (_, true) => Existing::Replaced,
        _ => EARLIER,
    };
    let write = || OutputFolder::prepare(&folder)?.write_all(files, existing);
    py.detach(write).map_err(|error| unwritten(&folder, if new { "folder" } else { "path" }, &error))
}

/// Runs the command with these arguments, the name of the program first. Returns its exit code.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::run_with(arguments))
}
