//! Studies.

use std::path::PathBuf;

use num_complex::Complex64;
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use report::to_json;
use serde::de::DeserializeOwned;
use study::simulation::{
    Load, ModesRequest, MotionRequest, Place, Reference, TravelProfile, displacement_unit, find_operating,
    static_stiffness,
};
use study::{Ablation, DiagnosisRequest, NullCache, PlanRequest, Sources, StudyResult, result_of_text};

use crate::error::{to_exception, word};
use crate::identification::{GivenFrfRequest, Identification, as_array, place, places, reject_duplicates};
use crate::measurement::MeasurementSet;
use crate::settings::GivenSettings;
use crate::work::{Running, compute, run};

/// A machine with its measurements, what is fitted, and how.
#[pyclass(frozen, module = "jointid._core")]
pub struct Study(pub study::Study);

/// Candidates and method of a diagnosis.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenDiagnosis {
    effects: Vec<String>,
    exclude: Vec<String>,
    nulls: Option<usize>,
    cache: Option<PathBuf>,
    ablate: Vec<String>,
}

/// What a plan chooses from.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenPlan {
    data: Option<String>,
    choose: Vec<usize>,
    measured: Vec<String>,
    channels: Vec<String>,
    states: Vec<String>,
    predict_at_m: Vec<f64>,
    diagnosis: Option<String>,
    noise: Option<f64>,
    band_hz: Option<(f64, f64)>,
    lines: Option<usize>,
}

/// Command of a simulated motion: travel, sine, table or record.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenMotion {
    travel: (f64, f64, f64, f64, f64),
    and_back: bool,
    sine: Option<(f64, f64, f64)>,
    table: Option<String>,
    record: Option<String>,
    nut_m: Option<f64>,
    position: Option<String>,
    lumps: Option<usize>,
    step_s: Option<f64>,
}

impl GivenMotion {
    fn request(self) -> MotionRequest {
        let usual = MotionRequest::default();
        let (travel_m, velocity_m_s, acceleration_m_s2, jerk_m_s3, rest_s) = self.travel;
        let travel = TravelProfile { travel_m, velocity_m_s, acceleration_m_s2, jerk_m_s3, rest_s };
        let sine =
            |(amplitude_m, frequency_hz, periods)| Reference::Sine { amplitude_m, frequency_hz, periods };
        let reference = (self.sine.map(sine))
            .or(self.table.map(Reference::Table))
            .or(self.record.map(Reference::Record))
            .unwrap_or(Reference::SCurve { travel, and_back: self.and_back });
        MotionRequest {
            reference,
            place: place(self.nut_m, self.position),
            lumps: self.lumps.unwrap_or(usual.lumps),
            step_s: self.step_s,
        }
    }
}

impl GivenDiagnosis {
    fn request(self) -> PyResult<DiagnosisRequest> {
        let ablated = self.ablate.iter().map(|part| word("ablate", Some(part)));
        let ablated = ablated.collect::<PyResult<Vec<Option<Ablation>>>>()?;
        Ok(DiagnosisRequest {
            nulls: self.nulls.unwrap_or(DiagnosisRequest::default().nulls),
            cache: self.cache.map_or(NullCache::None, NullCache::Folder),
            ablated: ablated.into_iter().flatten().collect(),
            effects: self.effects,
            exclude: self.exclude,
            all_facts: false,
        })
    }
}

impl Study {
    /// Does long work on the study.
    fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        running: &Running,
        work: impl FnOnce(study::Study) -> StudyResult<T> + Send + 'static,
    ) -> PyResult<T> {
        let study = self.0.clone();
        run(py, running, move |control| work(study.with_control(control)))
    }
}

#[pymethods]
impl Study {
    /// Makes a study from a machine's text and a measurement set.
    #[new]
    fn new(
        name: &str,
        text: &str,
        measurements: &MeasurementSet,
        overrides: Vec<String>,
        without: Vec<String>,
    ) -> PyResult<Self> {
        let study = study::Study::described((name, text), (*measurements.set).clone(), &overrides, &without);
        study.map(Study).map_err(|e| to_exception(&e))
    }

    /// Reads machine and measurements as the command does; what is absent is that of the published bench.
    #[staticmethod]
    fn open(
        config: Option<String>,
        measurements: Option<String>,
        overrides: Vec<String>,
        without: Vec<String>,
    ) -> PyResult<Self> {
        let sources = Sources { config, measurements, overrides, without, allow_outside: false };
        study::Study::open(&sources).map(Study).map_err(|e| to_exception(&e))
    }

    /// Returns name, text and title of the machine.
    #[getter]
    fn machine(&self) -> (String, String, String) {
        let (title, path) = self.0.machine_source();
        (path.into(), self.0.machine_description().into(), title.into())
    }

    /// Ids of the machine's parameters, effects taken out.
    #[getter]
    fn parameters(&self) -> Vec<String> {
        self.0.machine().parameters.iter().map(|p| p.id.clone()).collect()
    }

    /// Names of the machine's points.
    #[getter]
    fn points(&self) -> Vec<String> {
        self.0.machine().points.iter().map(|p| p.name.clone()).collect()
    }

    /// Points that move, each with the unit of its displacement: m or rad.
    #[getter]
    fn units(&self) -> Vec<(String, &'static str)> {
        let moving = self.0.machine().points.iter().filter(|point| !point.fixed);
        moving.map(|point| (point.name.clone(), displacement_unit(point))).collect()
    }

    /// Quantity of the measured FRFs or amplitudes.
    #[getter]
    fn quantity(&self) -> &str {
        self.0.quantity().word()
    }

    #[getter]
    fn measurements(&self) -> MeasurementSet {
        MeasurementSet::of(self.0.measurements().clone())
    }

    fn fit(&self, names: Vec<String>) -> PyResult<Self> {
        self.0.clone().fit(names).map(Study).map_err(|e| to_exception(&e))
    }

    fn hold_out(&self, names: Vec<String>) -> PyResult<Self> {
        self.0.clone().hold_out(names).map(Study).map_err(|e| to_exception(&e))
    }

    fn without(&self, effects: Vec<String>) -> PyResult<Self> {
        self.0.clone().without(effects).map(Study).map_err(|e| to_exception(&e))
    }

    fn with_settings(&self, given: GivenSettings) -> PyResult<Self> {
        Ok(Study(self.0.clone().with_settings(given.settings()?)))
    }

    fn identify(&self, py: Python<'_>, running: Running) -> PyResult<Identification> {
        let document = self.run(py, &running, |study| study.identify())?;
        Ok(Identification { study: self.0.clone(), document })
    }

    fn diagnose(&self, py: Python<'_>, given: GivenDiagnosis, running: Running) -> PyResult<String> {
        let request = given.request()?;
        self.run(py, &running, move |study| Ok(to_json(&study.diagnose_with(&request)?)?))
    }

    fn compare(&self, py: Python<'_>, single: Option<Vec<String>>, running: Running) -> PyResult<String> {
        self.run(py, &running, move |study| Ok(to_json(&study.compare_with(single.as_deref())?)?))
    }

    fn plan(
        &self,
        py: Python<'_>,
        identified: Option<&Identification>,
        given: GivenPlan,
        running: Running,
    ) -> PyResult<String> {
        let usual = PlanRequest::default();
        let request = PlanRequest {
            identified: identified.map(|found| (found.document.clone(), None)),
            data: word("data", given.data.as_deref())?,
            choose: given.choose,
            measured: given.measured,
            channels: given.channels,
            states: given.states,
            predict_at_m: given.predict_at_m,
            diagnosis: given
                .diagnosis
                .map(|text| result("the diagnosis", &text, "diagnosis"))
                .transpose()?
                .map(|document| (document, None)),
            noise: given.noise.unwrap_or(usual.noise),
            band_hz: given.band_hz,
            lines: given.lines.unwrap_or(usual.lines),
        };
        self.run(py, &running, move |study| Ok(to_json(&study.plan_with(&request)?)?))
    }

    /// Returns the description of the machine with the effect that a diagnosis names.
    fn machine_of_diagnosis(&self, diagnosis: &str) -> PyResult<String> {
        let diagnosis = result("the diagnosis", diagnosis, "diagnosis")?;
        self.0.machine_of_diagnosis(&diagnosis).map_err(|e| to_exception(&e))
    }

    /// Computes FRFs at the start values: an array of places by lines.
    fn frf<'py>(
        &self,
        py: Python<'py>,
        given: GivenFrfRequest,
        lines_hz: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let request = given.request(&lines_hz)?;
        reject_duplicates(&request.places)?;
        let document = compute(py, || study::simulation::frf(&self.0, &request))?;
        as_array(py, &request, &document)
    }

    /// Computes undamped modes at the start values, as the text of a document.
    fn modes(
        &self,
        py: Python<'_>,
        nut_m: Option<f64>,
        position: Option<String>,
        max_hz: f64,
    ) -> PyResult<String> {
        let request = ModesRequest { place: place(nut_m, position), max_hz, ..Default::default() };
        compute(py, || Ok(to_json(&study::simulation::modes(&self.0, &request)?)?))
    }

    /// Computes the static stiffness of a point at the start values, at each of the nut positions or of the
    /// named positions; mid-stroke without any.
    fn static_stiffness(
        &self,
        py: Python<'_>,
        point: &str,
        nut_m: Option<Vec<f64>>,
        positions: Option<Vec<String>>,
    ) -> PyResult<Vec<f64>> {
        let at = |place| {
            let operating = find_operating(&self.0, &place, &Load::default())?;
            static_stiffness(self.0.machine(), &operating, point)
        };
        let places = places(nut_m, positions);
        let places = if places.is_empty() { vec![Place::MidStroke] } else { places };
        compute(py, || places.into_iter().map(at).collect())
    }

    /// Simulates the motion of the driven axis at the start values, as the text of a document.
    fn motion(&self, py: Python<'_>, given: GivenMotion, running: Running) -> PyResult<String> {
        let request = given.request();
        self.run(py, &running, move |study| Ok(to_json(&study::simulation::motion(&study, &request)?)?))
    }

    /// Restores an identification of this study from the text of its document.
    fn identification(&self, text: &str) -> PyResult<Identification> {
        Ok(Identification {
            study: self.0.clone(),
            document: result("the identification", text, "identification")?,
        })
    }
}

/// Reads the text of a result as the command reads its file.
fn result<T: DeserializeOwned>(name: &str, text: &str, kind: &str) -> PyResult<T> {
    result_of_text(name, text, kind).map_err(|e| to_exception(&e))
}
