//! Impedance of the drive's loops, and gains from an identified spring and damper.

use std::path::Path;

use super::operating::{Load, Place, find_operating};
use crate::identified::read_identification;
use crate::{Study, StudyError, StudyResult};
use dynamics::motion::{ServoImpedance, gains_of};
use machine::PointMotion;
use numeric::unit::omega_rad_s;
use report::loops::{HoldDocument, HoldGains, HoldRow};

/// What [`gains_of_identified`] converts.
#[derive(Debug, Clone, PartialEq)]
pub struct GainsRequest {
    /// Torque per output of the velocity loop (N·m/A or N·m/V).
    pub constant: f64,
    /// Lead of the screw (m per revolution).
    pub lead_m: f64,
    /// Ids of the parameters of stiffness and damping.
    pub ids: Vec<String>,
}

/// Computes stiffness and damping of the drive's loops at the driven point, at each of these frequencies
/// (Hz).
///
/// # Errors  the machine has no drive; a frequency outside the range of the loops.
pub fn hold(study: &Study, at_hz: &[f64]) -> StudyResult<HoldDocument> {
    let machine = study.machine();
    let operating = find_operating(study, &Place::MidStroke, &Load::default())?;
    let hold = ServoImpedance::new(machine, &machine.start(), &operating);
    let hold = hold.map_err(|e| StudyError::input(&study.config.path, e.to_string()))?;
    if let Some(f) = at_hz.iter().find(|f| !(**f > 0.0 && f.is_finite())) {
        return Err(StudyError::setting("at_hz", f, "write frequencies above 0 Hz"));
    }
    let highest_hz = hold.highest_hz();
    if let Some(f) = at_hz.iter().find(|f| **f > highest_hz) {
        let fault = format!(
            "the impedance of the loops is defined up to {highest_hz} Hz, half the slowest sampling rate; write no more"
        );
        return Err(StudyError::setting("at_hz", f, fault));
    }
    let row = |&frequency_hz: &f64| {
        let omega = omega_rad_s(frequency_hz);
        let z = hold.at_driven_point(omega)?;
        Ok(HoldRow { frequency_hz, stiffness: z.re, damping: z.im / omega, phase_deg: z.arg().to_degrees() })
    };
    Ok(HoldDocument {
        stamp: study.stamp("hold", 0, true, Vec::new()),
        point: Some(machine.points[hold.on].name.clone()),
        rows: at_hz.iter().map(row).collect::<StudyResult<Vec<_>>>()?,
        gains: None,
    })
}

/// Returns the units of stiffness and damping at the driven point of a machine.
pub fn impedance_units(study: &Study) -> [&'static str; 2] {
    let machine = study.machine();
    let rotates =
        machine.drive.as_ref().is_some_and(|drive| machine.points[drive.on].motion == PointMotion::Rotation);
    if rotates { ["N·m/rad", "N·m·s/rad"] } else { ["N/m", "N·s/m"] }
}

/// Converts a spring and a damper of an `identification.json` to gains of position and velocity loop.
///
/// # Errors  the file is no identification or lacks a parameter; a value that is not above 0.
pub fn gains_of_identified(
    study: &Study,
    result: &Path,
    request: &GainsRequest,
) -> StudyResult<HoldDocument> {
    let (identified, input) = read_identification(result)?;
    let [k, c] = request.ids.as_slice() else {
        return Err(StudyError::setting(
            "ids",
            request.ids.join(","),
            "write two parameters, of stiffness and damping",
        ));
    };
    let value = |id: &String| {
        identified.parameters.get(id).map(|p| (p.value, p.identifiable)).ok_or_else(|| {
            let known: Vec<&str> = identified.parameters.keys().map(String::as_str).collect();
            StudyError::input(
                result.display(),
                format!("has no parameter «{id}»; it has {}; name others (ids)", known.join(", ")),
            )
        })
    };
    let ((stiffness, identifiable_k), (damping, identifiable_c)) = (value(k)?, value(c)?);
    let fault = "gains need a number above 0";
    for (key, x) in [("constant", request.constant), ("lead_m", request.lead_m)] {
        if !(x > 0.0 && x.is_finite()) {
            return Err(StudyError::setting(key, x, fault));
        }
    }
    for (id, x) in [(k, stiffness), (c, damping)] {
        if !(x > 0.0 && x.is_finite()) {
            return Err(StudyError::impossible(format!("{id} {x}: {fault}")));
        }
    }
    let (position_gain_per_s, velocity_gain) = gains_of(stiffness, damping, request.constant, request.lead_m);
    let mut stamp = study.stamp("hold", 0, true, Vec::new());
    for (id, identifiable) in [(k, identifiable_k), (c, identifiable_c)] {
        if identifiable != Some(true) {
            stamp.warnings.push(format!(
                "{id} is not identifiable from these data: the gains depend on its start value or its range, or on what the model lacks"
            ));
        }
    }
    stamp.inputs.push(input);
    let gains = HoldGains { stiffness, damping, position_gain_per_s, velocity_gain };
    Ok(HoldDocument { stamp, point: None, rows: Vec::new(), gains: Some(gains) })
}
