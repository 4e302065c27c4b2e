//! Machines.

use pyo3::prelude::*;
use study::{MachineConfig, MeasurementSet, machine_from_text, read_machine};

use crate::error::to_exception;
use crate::study::Study;

/// A machine as described: its text (TOML) with a name for messages and documents.
#[pyclass(frozen, module = "jointid._core")]
pub struct Machine(MachineConfig);

#[pymethods]
impl Machine {
    /// Reads the description of a machine from a file; those in `configs` are built in.
    #[staticmethod]
    fn read(path: &str) -> PyResult<Self> {
        read_machine(path).map(Machine).map_err(|e| to_exception(&e))
    }

    /// Makes a machine from the text of its description, under a name for messages and documents.
    #[staticmethod]
    fn from_text(name: &str, text: &str) -> PyResult<Self> {
        machine_from_text(name, text, &[], &[]).map(Machine).map_err(|e| to_exception(&e))
    }

    /// Returns the study of the machine without measurements, for its simulations.
    fn study(&self) -> Study {
        Study(study::Study::new(self.0.clone(), MeasurementSet::none()))
    }

    #[getter]
    fn path(&self) -> &str {
        &self.0.path
    }

    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    #[getter]
    fn title(&self) -> &str {
        &self.0.machine.title
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.clone()
    }

    #[getter]
    fn measurements(&self) -> Option<String> {
        self.0.measurements.as_ref().map(|name| format!("measurements/{name}"))
    }

    #[getter]
    fn points(&self) -> Vec<String> {
        self.0.machine.points.iter().map(|point| point.name.clone()).collect()
    }

    /// Parameters: id, unit, start, lower and upper.
    #[getter]
    fn parameters(&self) -> Vec<(String, String, f64, f64, f64)> {
        self.0
            .machine
            .parameters
            .iter()
            .map(|p| (p.id.clone(), p.unit.clone(), p.start, p.lower, p.upper))
            .collect()
    }
}
