//! Frequency response from command to position.

use rayon::prelude::*;

use super::drive::{describe_pole, find_drive, find_response, travel_factor};
use super::operating::{Load, Place, find_operating, require_count};
use crate::{Study, StudyError, StudyResult};
use dynamics::motion::{LinearLoops, SimulationSettings, SineResponse, sine_response, smooth};
use machine::{Drive, Machine};
use numeric::parallel::OrFirstError;
use report::document::Stamp;
use report::loops::{BodeDocument, BodeRow, PoleRow};

/// What [`bode`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct BodeRequest {
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz); 99 % of half the velocity loop's rate where absent.
    pub to_hz: Option<f64>,
    /// Number of frequencies, evenly spaced in their logarithm.
    pub points: usize,
    /// Amplitude of the simulated command (m or rad).
    pub amplitude_m: f64,
    /// Name of the point whose travel is the output; the reading of the position encoder where absent.
    pub response: Option<String>,
    /// Whether to linearise only, without simulating.
    pub linear: bool,
    /// Whether to simulate without friction and backlash, as in the linearisation.
    pub smooth: bool,
    /// Place of the nut.
    pub place: Place,
    /// Number of springs per rod.
    pub lumps: usize,
}

impl BodeRequest {
    /// Checks the settings, and returns the highest frequency (Hz).
    fn checked(&self, drive: &Drive) -> StudyResult<f64> {
        let (lowest, highest) = (1e-3, 0.5 / drive.velocity.period_s);
        let to_hz = self.to_hz.unwrap_or(0.99 * highest);
        if !(self.from_hz >= lowest && self.from_hz < to_hz && to_hz <= highest) {
            let fault =
                format!("write frequencies from {lowest} Hz to {highest} Hz, half the velocity loop's rate");
            return Err(StudyError::setting("from_hz", format!("{}, to_hz {to_hz}", self.from_hz), fault));
        }
        if !(self.amplitude_m > 0.0 && self.amplitude_m.is_finite()) {
            return Err(StudyError::setting("amplitude_m", self.amplitude_m, "write a number above 0"));
        }
        require_count("points", self.points, 2)?;
        require_count("lumps", self.lumps, 1)?;
        Ok(to_hz)
    }

    /// Returns the frequencies to simulate (Hz).
    fn frequencies_hz(&self, to_hz: f64, position_s: f64) -> Vec<f64> {
        let even = |i: usize| self.from_hz * (to_hz / self.from_hz).powf(i as f64 / (self.points - 1) as f64);
        // At multiples of half the position loop's sampling rate a sampled sine vanishes or equals its own
        // image, and has no response. The frequency is moved away by more than the rounding to whole periods
        // in whole samples.
        let half_hz = 0.5 / position_s;
        let moved = |i: usize| {
            let (hz, n) = (even(i), (even(i) / half_hz).round());
            if n >= 1.0 && (hz / half_hz - n).abs() < 0.0055 * n { 0.992 * n * half_hz } else { hz }
        };
        (0..self.points).map(moved).collect()
    }

    /// Lists warnings: what the linearisation leaves out, and an amplitude that is not large against the
    /// encoder's step.
    fn warnings(&self, ignored: &[&str], step: f64) -> Vec<String> {
        let left_out = (!ignored.is_empty()).then(|| {
            format!(
                "the linearisation leaves out friction, backlash and lead error of {}: with them the response depends on the amplitude",
                ignored.join(", ")
            )
        });
        let coarse = (!self.linear && 10.0 * step > self.amplitude_m).then(|| {
            format!(
                "the encoder's step, {step:e}, is not small against the amplitude, {:e}: it affects the simulation; raise the amplitude \
                 (amplitude_m)",
                self.amplitude_m
            )
        });
        left_out.into_iter().chain(coarse).collect()
    }
}

/// Computes the frequency response from command to position: by linearisation, and by simulation of a sine at
/// each frequency.
///
/// # Errors  a setting outside its range; the machine has no drive or no such point; its loops are unstable.
pub fn bode(study: &Study, request: &BodeRequest) -> StudyResult<BodeDocument> {
    let machine = study.machine();
    let drive = find_drive(study)?;
    let to_hz = request.checked(drive)?;
    let point = request.response.as_deref().map(|name| find_response(machine, name)).transpose()?;
    let operating = find_operating(study, &request.place, &Load::default())?;
    let settings = SimulationSettings { operating, lumps: request.lumps, ..SimulationSettings::default() };
    let values = machine.start();
    let loops = LinearLoops::new(machine, &values, &settings)?;
    if let Some(pole) = loops.unstable() {
        return Err(StudyError::input(
            &study.config.path,
            format!("the loops are unstable: {}", describe_pole(&pole)),
        ));
    }
    let name = point.map(|at| machine.points[at].name.as_str());
    let coordinate = name.map(|name| {
        let at = loops.names.iter().position(|n| n == name);
        at.ok_or_else(|| StudyError::setting("response", name, "has no inertia; name another point"))
    });
    let coordinate = coordinate.transpose()?;
    let travel = point.map_or(1.0, |at| travel_factor(machine, drive, at));
    let found = simulated(
        study,
        request,
        &request.frequencies_hz(to_hz, drive.position.period_s),
        (&loops, &settings),
        name,
    )?;
    let complete = request.linear || found.iter().all(|f| f.ratio.is_some());
    let linear = |hz: f64| loops.response(hz, coordinate) * travel;
    let rows = found.iter().map(|f| BodeRow {
        frequency_hz: f.frequency_hz,
        magnitude: linear(f.frequency_hz).norm(),
        phase_deg: linear(f.frequency_hz).arg().to_degrees(),
        simulated_magnitude: f.ratio.map(|r| r.norm() * travel),
        simulated_phase_deg: f.ratio.map(|r| r.arg().to_degrees()),
        stuck_share: f.stuck.map(|(_, share)| share),
    });
    let step = drive.position.encoder.step.at(&values, &settings.operating);
    let mut warnings = request.warnings(&machine.joints_ignored_by_frequency_responses(), step);
    warnings.extend(sticking_warning(request, machine, &found));
    Ok(document(request, study.stamp("bode", 0, complete, warnings), rows.collect(), &loops, |hz| {
        linear(hz).norm()
    }))
}

/// Share of the evaluated time from which on the axis sticks: all of it, within a sample.
const STUCK: f64 = 0.999;

/// Says at which frequencies the axis sticks, and in which joint.
fn sticking_warning(request: &BodeRequest, machine: &Machine, found: &[SineResponse]) -> Option<String> {
    let stuck = || {
        found
            .iter()
            .filter_map(|f| Some((f.frequency_hz, f.stuck?)))
            .filter(|(_, (_, share))| *share >= STUCK)
    };
    let (first, last) = (stuck().next()?, stuck().next_back()?);
    Some(format!(
        "the axis sticks at an amplitude of {:e} at {} of {} frequencies from {:.4} to {:.4} Hz: the friction of «{}» does not slide, and the \
         simulated response is that of the held machine; raise the amplitude (amplitude_m)",
        request.amplitude_m,
        stuck().count(),
        found.len(),
        first.0,
        last.0,
        machine.joints[first.1.0].name
    ))
}

/// Simulates a sine at each frequency; without simulation, returns the frequencies alone.
fn simulated(
    study: &Study,
    request: &BodeRequest,
    frequencies_hz: &[f64],
    (loops, settings): (&LinearLoops, &SimulationSettings),
    point: Option<&str>,
) -> StudyResult<Vec<SineResponse>> {
    if request.linear {
        return Ok(frequencies_hz
            .iter()
            .map(|&frequency_hz| SineResponse { frequency_hz, ratio: None, stuck: None })
            .collect());
    }
    let machine = if request.smooth { smooth(study.machine()) } else { study.machine().clone() };
    let values = machine.start();
    let go_on = || !study.control().stopped();
    let step = study.control().steps("bode", frequencies_hz.len());
    let found = frequencies_hz.par_iter().map(|hz| {
        let found =
            sine_response(&machine, &values, loops, (*hz, request.amplitude_m), point, settings, &go_on);
        step();
        Ok(found?)
    });
    found.or_first_error()
}

/// Builds the document with bandwidth, poles, and differences between simulation and linearisation.
fn document(
    request: &BodeRequest,
    stamp: Stamp,
    rows: Vec<BodeRow>,
    loops: &LinearLoops,
    magnitude: impl Fn(f64) -> f64,
) -> BodeDocument {
    let mut poles = loops.poles();
    poles.retain(|p| p.frequency_hz > 1e-3);
    poles.sort_by(|a, b| a.damping_ratio().total_cmp(&b.damping_ratio()));
    let moving = |row: &&BodeRow| row.stuck_share.is_none_or(|share| share < STUCK);
    let difference =
        |of: &dyn Fn(&BodeRow) -> Option<f64>| rows.iter().filter(moving).filter_map(of).reduce(f64::max);
    let last_above = rows.iter().rposition(|r| r.magnitude >= 0.5_f64.sqrt());
    BodeDocument {
        stamp,
        response: request.response.clone(),
        amplitude: (!request.linear).then_some(request.amplitude_m),
        poles: poles
            .iter()
            .map(|p| PoleRow {
                frequency_hz: p.frequency_hz,
                damping_ratio: p.damping_ratio(),
                point: p.point.clone(),
            })
            .collect(),
        bandwidth_hz: last_above.and_then(|at| {
            Some(crossing_hz(rows[at].frequency_hz, rows.get(at + 1)?.frequency_hz, magnitude))
        }),
        largest_difference: difference(&|r| Some((r.simulated_magnitude? / r.magnitude - 1.0).abs())),
        largest_phase_difference_deg: difference(&|r| {
            let off = (r.simulated_phase_deg? - r.phase_deg).rem_euclid(360.0);
            Some(off.min(360.0 - off))
        }),
        rows,
    }
}

/// Finds the frequency (Hz) between two at which a magnitude falls below 1/√2, by bisection.
fn crossing_hz(mut low: f64, mut high: f64, magnitude: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if magnitude(middle) >= 0.5_f64.sqrt() { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
