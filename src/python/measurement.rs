//! Measurement sets: from folders, file contents, arrays and files of other programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use num_complex::Complex64;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use study::{
    ChannelTolerance, Condition, DriveEffort, FrfArrays, FrfNoise, Gain, ImportRequest, MotionArrays,
    SetArrays, StudyError, export, import, read_set_files, read_set_from,
};

use crate::error::{argument, to_exception, word};

/// A measurement set. The noise that imported FRFs do not state is estimated when the set is first used.
#[pyclass(frozen, module = "jointid._core")]
pub struct MeasurementSet {
    pub set: LazyLock<study::MeasurementSet, Box<dyn FnOnce() -> study::MeasurementSet + Send + Sync>>,
    /// What an import assumed or left out.
    notes: Vec<String>,
}

/// An FRF as arrays.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenFrf<'py> {
    position: Option<String>,
    record: Option<String>,
    response: Option<String>,
    excitation: Option<String>,
    quantity: Option<String>,
    averages: Option<u32>,
    force_n: Option<f64>,
    speed_m_s: Option<f64>,
    acceleration_m_s2: Option<f64>,
    frequency_hz: PyReadonlyArray1<'py, f64>,
    value: PyReadonlyArray1<'py, Complex64>,
    coherence: Option<PyReadonlyArray1<'py, f64>>,
    relative_sd: Option<PyReadonlyArray1<'py, f64>>,
}

/// A motion record as arrays.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenMotion<'py> {
    name: String,
    time_s: PyReadonlyArray1<'py, f64>,
    command_m: PyReadonlyArray1<'py, f64>,
    position_m: PyReadonlyArray1<'py, f64>,
    effort: PyReadonlyArray1<'py, f64>,
    is_torque: bool,
    others: BTreeMap<String, PyReadonlyArray1<'py, f64>>,
}

/// What a set of arrays has in common.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenSet {
    title: String,
    quantity: Option<String>,
    response: Option<String>,
    excitation: Option<String>,
    averages: Option<u32>,
    gain: Option<f64>,
    tolerance: (Option<f64>, Option<f64>, Option<f64>),
    fit: Option<Vec<String>>,
    nut_m: BTreeMap<String, Option<f64>>,
}

/// What to import.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenImport {
    files: Vec<PathBuf>,
    columns: Option<Vec<String>>,
    strict: bool,
    accept_truncated: bool,
    quantity: Option<String>,
    position: Option<String>,
    pattern: Option<String>,
    map: Option<PathBuf>,
    nut_m: BTreeMap<String, f64>,
    response: Option<String>,
    excitation: Option<String>,
    averages: Option<u32>,
    title: String,
}

impl MeasurementSet {
    /// Wraps a set.
    pub fn of(set: study::MeasurementSet) -> Self {
        MeasurementSet { set: LazyLock::new(Box::new(|| set)), notes: Vec::new() }
    }
}

fn copied<T: numpy::Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> Vec<T> {
    array.as_array().iter().copied().collect()
}

impl GivenFrf<'_> {
    fn arrays(&self) -> PyResult<FrfArrays> {
        Ok(FrfArrays {
            position: self.position.clone(),
            record: self.record.clone(),
            quantity: word("quantity", self.quantity.as_deref())?,
            averages: self.averages,
            condition: Condition {
                force_level_n: self.force_n,
                velocity_m_s: self.speed_m_s,
                acceleration_m_s2: self.acceleration_m_s2,
                ..Condition::default()
            },
            response: self.response.clone(),
            excitation: self.excitation.clone(),
            frequency_hz: copied(&self.frequency_hz),
            value: copied(&self.value),
            coherence: self.coherence.as_ref().map(copied),
            relative_sd: self.relative_sd.as_ref().map(copied),
        })
    }
}

impl GivenMotion<'_> {
    fn arrays(&self) -> MotionArrays {
        let effort = copied(&self.effort);
        MotionArrays {
            name: self.name.clone(),
            time_s: copied(&self.time_s),
            command_m: copied(&self.command_m),
            position_m: copied(&self.position_m),
            load: if self.is_torque { DriveEffort::Torque(effort) } else { DriveEffort::Force(effort) },
            others: self.others.iter().map(|(name, array)| (name.clone(), copied(array))).collect(),
        }
    }
}

#[pymethods]
impl MeasurementSet {
    /// Reads a set from its folder; `measurements/tian` is built in.
    #[staticmethod]
    fn read(folder: &str, allow_outside: bool) -> PyResult<Self> {
        let set = read_set_from(folder, allow_outside).map_err(|e| to_exception(&e))?;
        Ok(MeasurementSet::of(set))
    }

    /// Reads a set from the contents of its files by name.
    #[staticmethod]
    fn from_files(path: &str, files: BTreeMap<String, Vec<u8>>) -> PyResult<Self> {
        let set = read_set_files(path, &files).map_err(|e| to_exception(&e))?;
        Ok(MeasurementSet::of(set))
    }

    /// Makes a set from arrays.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        given: GivenSet,
        frfs: Vec<GivenFrf<'_>>,
        motions: Vec<GivenMotion<'_>>,
    ) -> PyResult<Self> {
        let usual = ChannelTolerance::default();
        let (gain_sd, delay_s, nut_m) = given.tolerance;
        let arrays = SetArrays {
            title: given.title,
            quantity: word("quantity", given.quantity.as_deref())?,
            response: given.response,
            excitation: given.excitation,
            averages: given.averages,
            gain: given.gain.map_or(Gain::Unknown, Gain::Known),
            tolerance: ChannelTolerance {
                gain: gain_sd.unwrap_or(usual.gain),
                delay_s: delay_s.unwrap_or(usual.delay_s),
                nut_m: nut_m.unwrap_or(usual.nut_m),
            },
            split: given.fit,
            nut_m: given.nut_m,
            frfs: frfs.iter().map(GivenFrf::arrays).collect::<PyResult<_>>()?,
            motions: motions.iter().map(GivenMotion::arrays).collect(),
        };
        let made = py.detach(|| study::MeasurementSet::from_arrays(&arrays));
        made.map(MeasurementSet::of).map_err(|e| to_exception(&StudyError::from(e)))
    }

    /// Imports files of other programs.
    #[staticmethod]
    fn import_files(py: Python<'_>, given: GivenImport) -> PyResult<Self> {
        let request = ImportRequest {
            files: given.files,
            columns: given.columns,
            strict: given.strict,
            accept_truncated: given.accept_truncated,
            quantity: word("quantity", given.quantity.as_deref())?,
            position: given.position,
            pattern: given.pattern,
            map: given.map,
            nut_m: given.nut_m,
            response: given.response,
            excitation: given.excitation,
            averages: given.averages,
            title: given.title,
        };
        let read = py.detach(|| {
            let path = request.files.first().map_or("the import".into(), |path| path.display().to_string());
            import(&request)?.into_set(&path)
        });
        let (set, notes) = read.map_err(|e: StudyError| to_exception(&e))?;
        Ok(MeasurementSet { set: LazyLock::new(Box::new(|| set.with_noise())), notes })
    }

    /// Returns the FRFs of the set as a universal file, with notes on what it cannot hold.
    fn universal<'py>(&self, py: Python<'py>, binary: bool) -> PyResult<(Bound<'py, PyBytes>, Vec<String>)> {
        let exported = export(&self.set, binary).map_err(|e| to_exception(&e))?;
        Ok((PyBytes::new(py, &exported.bytes), exported.notes))
    }

    /// Returns the contents of the files by name.
    fn files<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyBytes>)> {
        let folder = Path::new(&self.set.path);
        let name = |path: &str| {
            Path::new(path)
                .strip_prefix(folder)
                .map_or_else(|_| path.to_string(), |name| name.display().to_string())
        };
        self.set.files.iter().map(|file| (name(&file.path), PyBytes::new(py, file.bytes()))).collect()
    }

    #[getter]
    fn path(&self) -> &str {
        &self.set.path
    }

    #[getter]
    fn title(&self) -> &str {
        &self.set.title
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        [&self.set.warnings[..], &self.notes].concat()
    }

    /// Positions in order, each with its nut position (m).
    #[getter]
    fn positions(&self) -> Vec<(String, Option<f64>)> {
        self.set.positions.iter().map(|p| (p.name.clone(), p.nut_m)).collect()
    }

    /// Names of the motion records.
    #[getter]
    fn motions(&self) -> Vec<String> {
        self.set.motions.iter().map(|record| record.name.clone()).collect()
    }

    /// Number of FRFs.
    #[getter]
    fn frfs(&self) -> usize {
        self.set.frfs.len()
    }

    /// Observed modes: position, order, natural frequency (Hz) and amplitude.
    #[getter]
    fn modes(&self) -> Vec<(String, u32, Option<f64>, Option<f64>)> {
        let Some(table) = &self.set.modes else { return Vec::new() };
        let named = self.set.positions.iter().zip(&table.positions);
        named
            .flat_map(|(p, modes)| {
                modes.iter().map(|m| (p.name.clone(), m.order, m.frequency_hz, m.amplitude))
            })
            .collect()
    }

    /// Returns an FRF by its index, with its accepted lines as arrays.
    fn frf<'py>(&self, py: Python<'py>, at: usize) -> PyResult<Bound<'py, PyDict>> {
        let frf = self
            .set
            .frfs
            .get(at)
            .ok_or_else(|| argument("frf", &format!("is {at}; the set has {}", self.set.frfs.len())))?;
        let found = PyDict::new(py);
        found.set_item("position", frf.position.map(|p| self.set.positions[p].name.as_str()))?;
        found.set_item("record", &frf.record)?;
        found.set_item("response", &frf.response)?;
        found.set_item("excitation", &frf.excitation)?;
        found.set_item("quantity", frf.quantity.word())?;
        found.set_item("averages", frf.averages)?;
        found.set_item(
            "frequency_hz",
            PyArray1::from_iter(py, frf.lines.iter().map(|line| line.frequency_hz)),
        )?;
        found.set_item("value", PyArray1::from_iter(py, frf.lines.iter().map(|line| line.value)))?;
        let noise = |pick: fn(FrfNoise) -> Option<f64>| -> Option<Vec<f64>> {
            frf.lines.iter().map(|line| line.noise.and_then(pick)).collect()
        };
        let coherence = noise(|n| if let FrfNoise::Coherence(gamma2) = n { Some(gamma2) } else { None });
        let relative_sd = noise(|n| if let FrfNoise::RelativeSd(sd) = n { Some(sd) } else { None });
        found.set_item("coherence", coherence.map(|array| PyArray1::from_vec(py, array)))?;
        found.set_item("relative_sd", relative_sd.map(|array| PyArray1::from_vec(py, array)))?;
        Ok(found)
    }
}
