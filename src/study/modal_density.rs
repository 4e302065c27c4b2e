//! Bounds the number of modes that a computation has to find: numbers in wrong units make them countless.

use std::sync::Arc;

use crate::{Study, StudyError, StudyResult};
use dynamics::model::{RodModel, Structure};
use identification::IdentificationSettings;
use machine::{Machine, Operating, Parameter, Prior};
use measurement::MeasurementSet;
use numeric::unit::omega_rad_s;

/// Largest number of modes in the measured band. A screw of 60 m has some 150 below 2 kHz.
const MOST_TO_FIT: usize = 300;
/// Largest number of modes to list.
const MOST_TO_LIST: usize = 50_000;
/// Highest frequency (Hz) at which rods are computed.
const HIGHEST_HZ: f64 = 1e7;

impl Study {
    /// Checks the settings, and builds those of an identification on responses.
    ///
    /// # Errors  a number outside its range; a frozen parameter is unknown or has a prior; the machine has too
    ///   many modes in the measured band.
    pub fn identification_settings(&self) -> StudyResult<IdentificationSettings> {
        self.check_frozen()?;
        let is_known = |p: &&Parameter| matches!(p.prior, Some(Prior::Catalogue(..)));
        let mut known = self.machine().parameters.iter().filter(is_known);
        if let Some(Parameter { id, .. }) = known.find(|p| self.settings.freeze.contains(&p.id)) {
            let fault = format!(
                "keeps its start value, so parameter.{id}.prior has no effect; remove one of the two"
            );
            return Err(StudyError::setting("freeze", id, fault));
        }
        let made = self.settings.identification(&self.set)?;
        self.check_measured_band()?;
        Ok(made)
    }

    /// Checks that the machine has a bounded number of modes in the measured band.
    ///
    /// # Errors  it has too many.
    pub(crate) fn check_measured_band(&self) -> StudyResult<()> {
        let highest_hz = highest_hz(&self.set).min(self.settings.band_hz.map_or(f64::INFINITY, |(_, to)| to));
        let operating = Operating::at(self.machine().stroke_m().map(|s| 0.5 * s));
        check(self.machine(), self.settings.rods, &operating, highest_hz, MOST_TO_FIT)
    }
}

/// Returns the measured natural frequencies of a set (Hz).
pub(crate) fn mode_frequencies_hz(set: &MeasurementSet) -> Vec<f64> {
    set.modes
        .iter()
        .flat_map(|table| table.positions.iter().flatten())
        .filter_map(|mode| mode.frequency_hz)
        .collect()
}

/// Returns the highest measured frequency of a set (Hz): of modes and lines; 0 without any.
pub(crate) fn highest_hz(set: &MeasurementSet) -> f64 {
    let lines = set.frfs.iter().filter_map(|frf| Some(frf.lines.last()?.frequency_hz));
    mode_frequencies_hz(set).into_iter().chain(lines).fold(0.0, f64::max)
}

/// Checks that the modes of a machine below a frequency can be listed.
///
/// # Errors  they are too many.
pub(crate) fn check_listed(
    machine: &Machine,
    rods: RodModel,
    operating: &Operating,
    max_hz: f64,
) -> StudyResult<()> {
    if max_hz > HIGHEST_HZ {
        return Err(StudyError::setting(
            "max_hz",
            format!("{max_hz:e}"),
            format!("write at most {HIGHEST_HZ:e} Hz"),
        ));
    }
    check(machine, rods, operating, max_hz, MOST_TO_LIST)
}

fn check(
    machine: &Machine,
    rods: RodModel,
    operating: &Operating,
    max_hz: f64,
    most: usize,
) -> StudyResult<()> {
    let Some(first) = machine.points.iter().position(|point| !point.fixed).filter(|_| max_hz > 0.0) else {
        return Ok(());
    };
    let Ok(structure) = Structure::new(machine, first, first, rods).map(Arc::new) else { return Ok(()) };
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), operating);
    match model.modes_below(omega_rad_s(max_hz.min(HIGHEST_HZ)), &mut structure.workspace()) {
        count if count > most => Err(StudyError::impossible(format!(
            "the machine has {count} natural frequencies below {max_hz} Hz, more than {most}; check length, moduli and density of its shafts, or \
             lower the highest frequency"
        ))),
        _ => Ok(()),
    }
}
