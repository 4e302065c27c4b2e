//! Cycles with different gains of the position loop.

use super::gain_study::{GainCycle, gain_study};
use dynamics::motion::SimulationSettings;
use report::loops::{GainStudyDocument, GainStudyRow};
use study::simulation::TravelProfile;
use study::simulation::{Load, Place, find_operating, require_count};
use study::simulation::{find_drive, find_response, travel_factor};
use study::{Study, StudyError, StudyResult};

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
            travel: TravelProfile {
                travel_m: 0.3,
                velocity_m_s: 0.5,
                acceleration_m_s2: 5.0,
                jerk_m_s3: 200.0,
                rest_s: 20.0,
            },
            place: Place::MidStroke,
        }
    }
}

impl GainRequest {
    /// Returns the gains (1/s).
    pub(crate) fn gains_per_s(&self) -> Vec<f64> {
        let (from, to, count) = (self.from_per_min, self.to_per_min, self.points);
        (0..count).map(|i| (from + (to - from) * i as f64 / (count - 1) as f64) / 60.0).collect()
    }
}

/// Computes duration, accuracy, energy and cost of a cycle over the gain of the position loop.
///
/// # Errors  a setting outside its range; the machine has no drive or no such point; a command is beyond the
///   stroke.
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
        return Err(StudyError::setting(
            "rest_s",
            rest_s,
            format!("write {least} s or more, in which the axis comes to rest"),
        ));
    }
    let count = require_count("points", request.points, 2)?;
    let point = request.response.as_deref().map(|name| find_response(machine, name)).transpose()?;
    let point = point.map(|at| (at, travel_factor(machine, drive, at)));
    let settings = SimulationSettings {
        operating: find_operating(study, &request.place, &Load::default())?,
        ..SimulationSettings::default()
    };
    let course = request.travel.course(drive.position.period_s, false)?;
    let gains = request.gains_per_s();
    let go_on = || !study.control().stopped();
    let cycle = GainCycle { course: &course, rest_s, point };
    let found = gain_study(machine, &machine.start(), &gains, &cycle, &settings, &go_on)?;
    let complete = go_on();
    let step = drive.position.encoder.step.at(&machine.start(), &settings.operating);
    let mut warnings = if complete { gain_warnings(&found, rest_s, step) } else { Vec::new() };
    let best = found
        .iter()
        .filter(|r| r.cost.is_some())
        .min_by(|a, b| a.cost.unwrap_or(0.0).total_cmp(&b.cost.unwrap_or(0.0)));
    if best.is_some_and(|b| b.gain_per_s == gains[0] || b.gain_per_s == gains[count - 1]) {
        warnings.push("the minimum cost lies at an end of the range; widen the range of gains (from_per_min, to_per_min)".into());
    }
    Ok(GainStudyDocument {
        stamp: study.stamp("gain", 0, complete, warnings),
        response: request.response.clone(),
        optimum_per_s: best.map(|r| r.gain_per_s),
        rows: found,
    })
}

/// Lists gains as a controller has them.
fn listed<'r>(rows: impl Iterator<Item = &'r GainStudyRow>) -> String {
    rows.map(|r| format!("{:.0}", r.gain_per_min)).collect::<Vec<_>>().join(", ")
}

/// Lists what the figures of a study do not mean: gains without result, and gains that the encoder cannot
/// distinguish from the optimum.
fn gain_warnings(found: &[GainStudyRow], rest_s: f64, step: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    let unstable = listed(found.iter().filter(|r| r.energy_j.is_none()));
    if !unstable.is_empty() {
        warnings.push(format!("at {unstable} 1/min the loops are unstable: these gains have no results"));
    }
    let moving = listed(found.iter().filter(|r| r.energy_j.is_some() && !r.settled));
    if !moving.is_empty() {
        warnings.push(format!(
            "not settled: at {moving} 1/min the axis is not at rest {rest_s} s after the travel, so that these gains have no static error and \
             no cost; lengthen the rest (rest_s)"
        ));
    }
    let cost = |r: &GainStudyRow| r.cost.unwrap_or(f64::INFINITY);
    let (best, worst) = (
        found.iter().filter(|r| r.cost.is_some()).min_by(|a, b| cost(a).total_cmp(&cost(b))),
        found.iter().filter(|r| r.cost.is_some()).filter_map(|r| r.static_error).reduce(f64::max),
    );
    if let (Some(best), Some(worst)) = (best, worst) {
        let alike =
            found.iter().filter(|r| r.gain_per_s != best.gain_per_s && cost(r) <= cost(best) + step / worst);
        let alike = if worst > 0.0 { listed(alike) } else { String::new() };
        if !alike.is_empty() {
            warnings.push(format!(
                "the costs at {alike} 1/min exceed the minimum by less than one step of the encoder in the static error: these gains are as good"
            ));
        }
        warnings
            .push("each term of the cost is relative to its largest value among these gains: the optimum depends on their range".into());
    }
    warnings
}
