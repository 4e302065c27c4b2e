//! Cycles with different gains of the position loop.

use super::drive::{find_drive, find_response, travel_factor};
use super::operating::{Load, Place, find_operating, require_count};
use super::travel::TravelProfile;
use crate::{Study, StudyError, StudyResult};
use dynamics::motion::{SimulationSettings, gain_study};
use report::loops::{GainStudyDocument, GainStudyRow};

/// What [`gain`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct GainRequest {
    /// Smallest gain of the position loop (1/min).
    pub from_per_min: f64,
    /// Largest gain of the position loop (1/min).
    pub to_per_min: f64,
    /// Number of gains, evenly spaced.
    pub points: usize,
    /// Name of the point whose position is evaluated; the reading of the position encoder where absent.
    pub response: Option<String>,
    /// Travel of the cycle.
    pub travel: TravelProfile,
    /// Place of the nut at the start.
    pub place: Place,
}

impl Default for GainRequest {
    fn default() -> Self {
        GainRequest {
            from_per_min: 500.0,
            to_per_min: 12_000.0,
            points: 24,
            response: None,
            travel: TravelProfile { travel_m: 0.3, velocity_m_s: 0.5, acceleration_m_s2: 5.0, jerk_m_s3: 200.0, rest_s: 0.3 },
            place: Place::MidStroke,
        }
    }
}

/// Computes duration, accuracy, energy and cost of a cycle over the gain of the position loop.
///
/// # Errors  a setting outside its range; the machine has no drive or no such point; a command is beyond the stroke.
pub fn gain(study: &Study, request: &GainRequest) -> StudyResult<GainStudyDocument> {
    let machine = study.machine();
    let drive = find_drive(study)?;
    let (from, to, rest_s) = (request.from_per_min, request.to_per_min, request.travel.rest_s);
    if !(from > 0.0 && from < to && to.is_finite()) {
        let fault = "write two gains above 0, the smaller first";
        return Err(StudyError::setting("from_per_min", format!("{from}, to_per_min {to}"), fault));
    }
    if !(0.2 * rest_s >= 5.0 * drive.position.period_s && rest_s.is_finite()) {
        let least = 25.0 * drive.position.period_s;
        return Err(StudyError::setting("rest_s", rest_s, format!("write {least} s or more, in which the axis comes to rest")));
    }
    let count = require_count("points", request.points, 2)?;
    let point = request.response.as_deref().map(|name| find_response(machine, name)).transpose()?;
    let point = point.map(|at| (at, travel_factor(machine, drive, at)));
    let settings =
        SimulationSettings { operating: find_operating(study, &request.place, &Load::default())?, ..SimulationSettings::default() };
    let course = request.travel.course(drive.position.period_s, false)?;
    let gains: Vec<f64> = (0..count).map(|i| (from + (to - from) * i as f64 / (count - 1) as f64) / 60.0).collect();
    let go_on = || !study.control().stopped();
    let found = gain_study(machine, &machine.start(), &gains, (&course, rest_s), point, &settings, &go_on)?;
    let complete = go_on();
    let unstable: Vec<String> = found.iter().filter(|r| !r.stable).map(|r| format!("{:.0}", 60.0 * r.gain_per_s)).collect();
    let mut warnings = Vec::new();
    if complete && !unstable.is_empty() {
        warnings.push(format!("at {} 1/min the loops are unstable: these gains have no results", unstable.join(", ")));
    }
    let best = found.iter().filter(|r| r.cost.is_some()).min_by(|a, b| a.cost.unwrap_or(0.0).total_cmp(&b.cost.unwrap_or(0.0)));
    if best.is_some_and(|b| b.gain_per_s == gains[0] || b.gain_per_s == gains[count - 1]) {
        warnings.push("the minimum cost lies at an end of the range; widen the range of gains (from_per_min, to_per_min)".into());
    }
    Ok(GainStudyDocument {
        stamp: study.stamp("gain", 0, complete, warnings),
        response: request.response.clone(),
        rows: found
            .iter()
            .map(|r| GainStudyRow {
                gain_per_s: r.gain_per_s,
                gain_per_min: 60.0 * r.gain_per_s,
                time_s: r.time_s,
                static_error: r.static_error,
                energy_j: r.energy_j,
                cost: r.cost,
            })
            .collect(),
        optimum_per_s: best.map(|r| r.gain_per_s),
    })
}
