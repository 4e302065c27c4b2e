//! Identifications: FRFs, predictions and validation of an identified machine.

use std::path::Path;

use num_complex::Complex64;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use report::document::{FrfsDocument, IdentificationDocument, Input};
use report::to_json;
use study::simulation::{FrfRequest, Place, identified_frf};
use study::{Drawing, PredictionRequest, ValidationRequest};

use crate::error::{argument, internal, word};
use crate::measurement::MeasurementSet;
use crate::work::{Running, compute, run};

/// Name of an identification in messages.
const NAME: &str = "the identification";

/// An identification, with its study.
#[pyclass(frozen, module = "jointid._core")]
pub struct Identification {
    pub study: study::Study,
    pub document: IdentificationDocument,
}

/// What FRFs are computed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenFrfRequest {
    nut_m: Option<Vec<f64>>,
    positions: Option<Vec<String>>,
    response: Option<String>,
    excitation: Option<String>,
    quantity: Option<String>,
    closed_loop: bool,
}

impl GivenFrfRequest {
    /// Builds the request of the library.
    ///
    /// # Errors  the quantity is unknown.
    pub fn request(self, lines_hz: &PyReadonlyArray1<'_, f64>) -> PyResult<FrfRequest> {
        let usual = FrfRequest::default();
        Ok(FrfRequest {
            places: places(self.nut_m, self.positions),
            lines_hz: Some(lines_hz.as_array().iter().copied().collect()),
            response: self.response,
            excitation: self.excitation,
            closed_loop: self.closed_loop,
            quantity: word("quantity", self.quantity.as_deref())?.unwrap_or(usual.quantity),
            ..usual
        })
    }
}

/// Returns the places of nut positions or of named positions.
pub fn places(nut_m: Option<Vec<f64>>, positions: Option<Vec<String>>) -> Vec<Place> {
    let nuts = nut_m.into_iter().flatten().map(Place::Nut);
    nuts.chain(positions.into_iter().flatten().map(Place::Position)).collect()
}

/// Returns the place of a nut position or of a named position, else mid-stroke.
pub fn place(nut_m: Option<f64>, position: Option<String>) -> Place {
    nut_m.map(Place::Nut).or(position.map(Place::Position)).unwrap_or_default()
}

/// Refuses places that are named twice.
///
/// # Errors  a place is named twice.
pub fn reject_duplicates(places: &[Place]) -> PyResult<()> {
    match places.iter().enumerate().find(|(at, place)| places[..*at].contains(place)) {
        None => Ok(()),
        Some((_, Place::Nut(nut_m))) => {
            Err(argument("nut_m", &format!("{nut_m} is named twice; write each position once")))
        }
        Some((_, Place::Position(name))) => {
            Err(argument("positions", &format!("«{name}» is named twice; write each position once")))
        }
        Some((_, Place::MidStroke)) => Ok(()),
    }
}

/// Converts FRFs to an array of places (in the requested order, else that of the document) by lines.
///
/// # Errors  never: the document has the requested places.
pub fn as_array<'py>(
    py: Python<'py>,
    request: &FrfRequest,
    document: &FrfsDocument,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let named = request.places.iter().filter_map(|place| match place {
        Place::Nut(nut_m) => document.positions.get(&nut_m.to_string()),
        Place::Position(name) => document.positions.get(name),
        Place::MidStroke => None,
    });
    let rows: Vec<&Vec<[f64; 2]>> =
        if request.places.is_empty() { document.positions.values().collect() } else { named.collect() };
    let mut values = Vec::with_capacity(rows.len() * document.frequency_hz.len());
    rows.iter().for_each(|row| values.extend(row.iter().map(|[re, im]| Complex64::new(*re, *im))));
    let flat = PyArray1::from_vec(py, values);
    flat.reshape([rows.len(), document.frequency_hz.len()]).map_err(internal)
}

/// Ids of parameters, values of machines by parameters, and the number of the minimum of each machine.
type Drawn<'py> = (Vec<String>, Bound<'py, PyArray2<f64>>, Vec<usize>);

#[pymethods]
impl Identification {
    /// Returns the document as JSON, as the command prints it.
    fn json(&self) -> PyResult<String> {
        to_json(&self.document).map_err(internal)
    }

    /// Computes FRFs of the identified machine: an array of places by lines.
    fn frf<'py>(
        &self,
        py: Python<'py>,
        given: GivenFrfRequest,
        lines_hz: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let request = given.request(&lines_hz)?;
        reject_duplicates(&request.places)?;
        let input = Input { path: NAME.into(), sha256: String::new() };
        let identified = (&self.document, &input);
        let document = compute(py, || identified_frf(&self.study, Path::new(NAME), identified, &request))?;
        as_array(py, &request, &document)
    }

    /// Predicts natural modes, and FRFs on request, with intervals.
    #[allow(clippy::too_many_arguments)]
    fn predict(
        &self,
        py: Python<'_>,
        nut_m: Option<Vec<f64>>,
        positions: Option<Vec<String>>,
        frf: bool,
        lines_hz: Option<Vec<f64>>,
        band_hz: Option<(f64, f64)>,
        draws: Option<usize>,
        seed: u64,
        running: Running,
    ) -> PyResult<String> {
        let usual = PredictionRequest::default();
        let draws = draws.unwrap_or(usual.draws);
        let request = PredictionRequest {
            places: places(nut_m, positions),
            band_hz,
            frf,
            lines_hz,
            draws,
            seed,
            ..usual
        };
        let (study, document) = (self.study.clone(), self.document.clone());
        run(py, &running, move |control| {
            Ok(to_json(&study.with_control(control).predict_with(&document, &request)?)?)
        })
    }

    /// Draws machines that data and tolerances leave possible: ids of the parameters, an array of the draws by
    /// parameters, and the number of the minimum of each draw.
    fn draws<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        seed: u64,
        lines: bool,
        running: Running,
    ) -> PyResult<Drawn<'py>> {
        let drawing = if lines { Drawing::Lines } else { Drawing::Posterior };
        let (study, document) = (self.study.clone(), self.document.clone());
        let (ids, drawn) = run(py, &running, move |control| {
            study.with_control(control).draw(&document, (count, seed, drawing))
        })?;
        let (minima, rows): (Vec<usize>, Vec<Vec<f64>>) = drawn.into_iter().unzip();
        Ok((ids, PyArray2::from_vec2(py, &rows).map_err(internal)?, minima))
    }

    /// Predicts what was held out, or another set.
    fn validate(
        &self,
        py: Python<'_>,
        positions: Option<Vec<String>>,
        measurements: Option<&MeasurementSet>,
    ) -> PyResult<String> {
        let request = ValidationRequest { positions, file: None };
        let study = match measurements {
            None => self.study.clone(),
            Some(other) => self.study.clone().with_measurements((*other.set).clone()),
        };
        compute(py, || Ok(to_json(&study.validate_with(&self.document, &request)?)?))
    }

    /// Returns the description of the machine as identified.
    fn machine(&self, py: Python<'_>) -> PyResult<String> {
        compute(py, || self.study.machine_of_identification(&self.document, NAME))
    }
}
