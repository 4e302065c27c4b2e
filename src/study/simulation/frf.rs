//! Frequency response functions of a machine.

use std::collections::BTreeMap;
use std::path::Path;

use super::drive::describe_pole;
use super::operating::{Load, Place, find_operating, load_warnings, require_positive};
use crate::frequency_response::Evaluated;
use crate::identified::check_identification;
use crate::{Study, StudyError, StudyResult};
use dynamics::model::RodModel;
use dynamics::motion::{LinearLoops, MotionError, ServoImpedance, SimulationSettings};
use identification::objective::{COMMAND, Excitation};
use machine::{Chain, Machine, Operating, Parameter};
use measurement::Quantity;
use numeric::unit::omega_rad_s;
use report::document::{FrfsDocument, IdentificationDocument, Input};

/// What [`frf`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct FrfRequest {
    /// Places of the nut. Empty: all positions of the measurement set, or mid-stroke where it has none.
    pub places: Vec<Place>,
    /// Load on the rolling contacts.
    pub load: Load,
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz).
    pub to_hz: f64,
    /// Frequency step (Hz).
    pub step_hz: f64,
    /// Frequencies of the lines (Hz), in place of those from lowest, highest and step.
    pub lines_hz: Option<Vec<f64>>,
    /// Name of the response point; that of the measurement set where absent.
    pub response: Option<String>,
    /// Name of the excitation point, or `command` for the command of the position loop; that of the
    /// measurement set where absent.
    pub excitation: Option<String>,
    /// Whether the loops of the drive are closed and hold the machine.
    pub closed_loop: bool,
    /// Whether the machine has what an identification expects beyond its description: journals, nut lengths,
    /// losses, guide damping and the integral action of a hold, at the medians of their priors. Without it the
    /// machine is exactly as described.
    pub with_tolerances: bool,
    /// Quantity to compute.
    pub quantity: Quantity,
}

impl Default for FrfRequest {
    fn default() -> Self {
        FrfRequest {
            places: Vec::new(),
            load: Load::default(),
            from_hz: 1.0,
            to_hz: 1000.0,
            step_hz: 0.5,
            lines_hz: None,
            response: None,
            excitation: None,
            closed_loop: false,
            with_tolerances: false,
            quantity: Quantity::Receptance,
        }
    }
}

/// Computes frequency response functions at the start values of the parameters, with exact rods.
///
/// # Errors  a setting outside its range; the machine has no such point or does not allow a place; closed
///   loops are unstable or do not exist.
pub fn frf(study: &Study, request: &FrfRequest) -> StudyResult<FrfsDocument> {
    if !request.with_tolerances {
        return computed(study, study.machine(), &study.machine().start(), RodModel::Exact, request);
    }
    // Lengths of journals and nuts are those of an identification from the whole set.
    let mut nuts_m = study.measurements().nuts_m();
    nuts_m.extend(conditions(study, request)?.iter().filter_map(|(_, at)| at.nut_m));
    let machine = study.machine().with_tolerances(&nuts_m).map_err(StudyError::impossible)?;
    let value = |p: &Parameter| if p.is_tolerance() { p.search_start() } else { p.start };
    let values: Vec<f64> = machine.parameters.iter().map(value).collect();
    let document = computed(study, &machine, &values, RodModel::Exact, request)?;
    Ok(FrfsDocument { with_tolerances: true, ..document })
}

/// Computes frequency response functions of a machine as identified, with the rods of the identification.
/// `study` is that of
/// [`Study::open_with_result`]; `result` is the document's file.
///
/// # Errors  as [`frf`]; the document is no identification, or does not belong to the machine.
pub fn identified_frf(
    study: &Study,
    result: &Path,
    (identified, input): (&IdentificationDocument, &Input),
    request: &FrfRequest,
) -> StudyResult<FrfsDocument> {
    check_identification(result, identified)?;
    let (machine, values) = study.identified_machine(result, identified)?;
    let rods = identified.settings.lumps.map_or(RodModel::Exact, RodModel::Lumped);
    let mut document = computed(study, &machine, &values, rods, request)?;
    document.stamp.inputs.push(input.clone());
    Ok(document)
}

fn computed(
    study: &Study,
    machine: &Machine,
    values: &[f64],
    rods: RodModel,
    request: &FrfRequest,
) -> StudyResult<FrfsDocument> {
    let frequency_hz = frequencies_hz(request)?;
    let set = study.measurements();
    // The channel of a set that states none is that of its first FRF.
    let first = set.frfs.first();
    let response = request.response.as_ref().or(set.response.as_ref()).or(first.map(|frf| &frf.response));
    let response = find_point(machine, "response", response)?;
    let excitation =
        request.excitation.as_ref().or(set.excitation.as_ref()).or(first.map(|frf| &frf.excitation));
    let excitation = find_excitation(machine, excitation)?;
    let conditions = conditions(study, request)?;
    let all: Vec<Operating> = conditions.iter().map(|(_, operating)| *operating).collect();
    let closed = request.closed_loop || excitation == Excitation::Command;
    let omegas: Vec<f64> = frequency_hz.iter().copied().map(omega_rad_s).collect();
    let mut positions = BTreeMap::new();
    for (name, operating) in conditions {
        let chain = machine.chain.at(values, &operating);
        if closed {
            check_loops(machine, values, &operating, &omegas)?;
        }
        let receptances =
            Evaluated { machine, values, operating, rods }.response(response, excitation, closed, &omegas)?;
        let recorded = omegas.iter().zip(receptances).map(|(&omega, receptance)| {
            let h =
                receptance * request.quantity.from_receptance(omega) * Chain::log_factor(chain, omega).exp();
            [h.re, h.im]
        });
        positions.insert(name, recorded.collect());
    }
    Ok(FrfsDocument {
        stamp: study.stamp("frf", 0, true, load_warnings(machine, &request.load, &all)),
        quantity: request.quantity.word().into(),
        response: machine.points[response].name.clone(),
        excitation: excitation.name(machine).into(),
        closed_loop: closed,
        with_tolerances: false,
        frequency_hz,
        positions,
    })
}

/// Returns the frequencies of the lines (Hz).
fn frequencies_hz(request: &FrfRequest) -> StudyResult<Vec<f64>> {
    if let Some(lines_hz) = &request.lines_hz {
        return match lines_hz.iter().enumerate().find(|(_, hz)| !(**hz > 0.0 && hz.is_finite())) {
            None => Ok(lines_hz.clone()),
            Some((at, hz)) => Err(StudyError::setting(
                "frequency_hz",
                format!("[{at}]"),
                format!("is {hz}; write frequencies above 0 Hz"),
            )),
        };
    }
    let step = require_positive("step_hz", request.step_hz)?;
    let from = require_positive("from_hz", request.from_hz)?;
    if !(request.to_hz >= from && request.to_hz.is_finite()) {
        return Err(StudyError::setting("to_hz", request.to_hz, format!("write a frequency from {from} Hz")));
    }
    let steps = ((request.to_hz - from) / step + 1e-9).floor();
    if !(steps < 1e6) {
        let fault = format!("makes {steps:e} lines, more than a million; choose a larger step");
        return Err(StudyError::setting("step_hz", step, fault));
    }
    Ok((0..steps as usize + 1).map(|i| from + step * i as f64).collect())
}

/// Returns the index of a point, whose name is given or that of the measurement set.
fn find_point(machine: &Machine, key: &str, name: Option<&String>) -> StudyResult<usize> {
    let name = name.ok_or_else(|| StudyError::setting(key, "", "name a point of the machine"))?;
    machine.point(name).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().map(|p| p.name.as_str()).collect();
        StudyError::setting(key, name, format!("no such point; the machine has {}", known.join(", ")))
    })
}

/// Returns the excitation: a point, or the command of the position loop.
fn find_excitation(machine: &Machine, name: Option<&String>) -> StudyResult<Excitation> {
    if name.is_some_and(|name| name == COMMAND) && machine.point(COMMAND).is_none() {
        return match machine.drive {
            Some(_) => Ok(Excitation::Command),
            None => Err(StudyError::setting(
                "excitation",
                COMMAND,
                "the machine has no loops; describe them as [drive], or name a point",
            )),
        };
    }
    find_point(machine, "excitation", name).map(Excitation::Point)
}

/// Returns the operating conditions by name.
fn conditions(study: &Study, request: &FrfRequest) -> StudyResult<Vec<(String, Operating)>> {
    let has_nut = study.machine().stroke_m().is_some();
    let mut places = request.places.clone();
    if places.is_empty() {
        // A machine without a nut is the same at every position.
        places.extend(
            study
                .measurements()
                .positions
                .iter()
                .filter(|_| has_nut)
                .map(|p| Place::Position(p.name.clone())),
        );
    }
    if places.is_empty() {
        places.push(Place::MidStroke);
    }
    let condition = |place: &Place| {
        let name = match place {
            Place::Nut(nut_m) => nut_m.to_string(),
            Place::Position(name) => name.clone(),
            Place::MidStroke => if has_nut { "mid-stroke" } else { "machine" }.into(),
        };
        Ok((name, find_operating(study, place, &request.load)?))
    };
    places.iter().map(condition).collect()
}

/// Checks that the loops of the drive are stable, and defined up to the highest frequency.
fn check_loops(
    machine: &Machine,
    values: &[f64],
    operating: &Operating,
    omega_rad_s: &[f64],
) -> StudyResult<()> {
    let fault = |e: MotionError| StudyError::setting("closed_loop", "", e.to_string());
    let hold = ServoImpedance::new(machine, values, operating).map_err(fault)?;
    let settings = SimulationSettings { operating: *operating, ..SimulationSettings::default() };
    if let Some(pole) = LinearLoops::new(machine, values, &settings).map_err(fault)?.unstable() {
        return Err(StudyError::setting(
            "closed_loop",
            "",
            format!("the loops are unstable: {}", describe_pole(&pole)),
        ));
    }
    let highest_hz = hold.highest_hz();
    if omega_rad_s.iter().any(|omega| *omega > numeric::unit::omega_rad_s(highest_hz)) {
        let fault = format!(
            "closed loops are defined up to {highest_hz} Hz, half the slowest sampling rate; write no more"
        );
        return Err(StudyError::setting("to_hz", "", fault));
    }
    Ok(())
}
