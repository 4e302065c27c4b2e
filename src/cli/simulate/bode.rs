//! `jointid simulate bode`: frequency response from command to position.

use std::fmt::Write;

use rayon::prelude::*;

use super::drive::{describe_pole, find_drive, find_response};
use super::operating::{LoadArguments, find_operating};
use crate::arguments::{OutputArguments, Sources};
use crate::long_work::not_stopped;
use crate::outcome::{CommandResult, Outcome, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::sources::{load_machine, stamp};
use dynamics::motion::{LinearLoops, SimulationSettings, SineResponse, sine_response};
use machine::PointMotion;
use report::loops::{BodeDocument, BodeRow, PoleRow};

/// Arguments of `simulate bode`.
#[derive(Debug, clap::Args)]
pub struct BodeArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Lowest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub from_hz: f64,
    /// Highest frequency (Hz); half the velocity loop's rate by default
    #[arg(long, value_name = "F")]
    pub to_hz: Option<f64>,
    /// Number of frequencies, evenly spaced in their logarithm
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(2..=2000))]
    pub points: u16,
    /// Amplitude of the simulated command (m or rad)
    #[arg(long, value_name = "M", default_value_t = 1e-5)]
    pub amplitude_m: f64,
    /// Point whose travel is the output; by default the reading of the position encoder
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Linearise only, without simulating
    #[arg(long)]
    pub linear: bool,
    /// Simulate without friction and backlash, as in the linearisation
    #[arg(long, conflicts_with = "linear")]
    pub smooth: bool,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    /// Lumps per rod
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub lumps: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &BodeArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let drive = find_drive(&loaded)?;
    let (lowest, highest) = (1e-3, 0.5 / drive.velocity.period_s);
    let to_hz = given.to_hz.unwrap_or(0.99 * highest);
    if !(given.from_hz >= lowest && given.from_hz < to_hz && to_hz <= highest) {
        let fault = format!("write frequencies from {lowest} Hz to {highest} Hz, half the velocity loop's rate");
        return Err(format!("--from-hz {} --to-hz {to_hz}: {fault}", given.from_hz));
    }
    if !(given.amplitude_m > 0.0 && given.amplitude_m.is_finite()) {
        return Err(format!("--amplitude-m {}: write a number above 0", given.amplitude_m));
    }
    let point = given.response.as_deref().map(|name| find_response(machine, name)).transpose()?;
    let operating = find_operating(&loaded, given.nut_m, None, &LoadArguments::default())?;
    let settings = SimulationSettings { operating, lumps: usize::from(given.lumps), ..SimulationSettings::default() };
    let folder = prepare(&given.output)?;
    let values = machine.start();
    let loops = LinearLoops::new(machine, &values, &settings).map_err(to_message)?;
    if let Some(pole) = loops.unstable() {
        return Err(format!("{}: the loops are unstable: {}", loaded.config.path, describe_pole(&pole)));
    }
    let coordinate = match point {
        None => None,
        Some(name) => Some(
            loops.names.iter().position(|n| n == name).ok_or_else(|| format!("--response {name}: has no inertia; name another point"))?,
        ),
    };
    // The rotation of a point is scaled to travel as by the position encoder.
    let rotates = point.and_then(|name| machine.point(name)).is_some_and(|at| machine.points[at].motion == PointMotion::Rotation);
    let travel = if rotates { drive.position.encoder.travel } else { 1.0 };
    let count = usize::from(given.points);
    let even = |i: usize| given.from_hz * (to_hz / given.from_hz).powf(i as f64 / (count - 1) as f64);
    // At multiples of half the position loop's sampling rate a sampled sine vanishes or equals its own image, and has no response. The frequency is
    // moved away by more than the rounding to whole periods in whole samples.
    let half_hz = 0.5 / drive.position.period_s;
    let wanted = |i: usize| {
        let (hz, n) = (even(i), (even(i) / half_hz).round());
        if n >= 1.0 && (hz / half_hz - n).abs() < 0.0055 * n { 0.992 * n * half_hz } else { hz }
    };
    let simulated = if given.smooth { dynamics::motion::smooth(machine) } else { machine.clone() };
    let go_on = not_stopped();
    let progress = WorkProgress::counted(given.output.quiet || given.linear, "bode", count);
    let found: Vec<Result<SineResponse, String>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let frequency_hz = wanted(i);
            let found = match given.linear {
                true => Ok(SineResponse { frequency_hz, ratio: None }),
                false => sine_response(&simulated, &values, &loops, (frequency_hz, given.amplitude_m), point, &settings, &go_on)
                    .map_err(to_message),
            };
            progress.step();
            found
        })
        .collect();
    progress.end();
    let found = found.into_iter().collect::<Result<Vec<_>, String>>()?;
    let rows: Vec<BodeRow> = found
        .iter()
        .map(|f| {
            let linear = loops.response(f.frequency_hz, coordinate) * travel;
            BodeRow {
                frequency_hz: f.frequency_hz,
                magnitude: linear.norm(),
                phase_deg: linear.arg().to_degrees(),
                simulated_magnitude: f.ratio.map(|r| r.norm() * travel),
                simulated_phase_deg: f.ratio.map(|r| r.arg().to_degrees()),
            }
        })
        .collect();
    let complete = given.linear || found.iter().all(|f| f.ratio.is_some());
    let step = drive.position.encoder.step.at(&values, &settings.operating);
    let left_out = machine.joints_ignored_by_frequency_responses().join(", ");
    let warnings: Vec<String> = (!left_out.is_empty())
        .then(|| {
            format!(
                "the linearisation leaves out friction, backlash and lead error of {left_out}: with them the response depends on the amplitude"
            )
        })
        .into_iter()
        .chain((!given.linear && 10.0 * step > given.amplitude_m).then(|| {
            format!(
                "the encoder's step, {step:e}, is not small against the amplitude, {:e}: it affects the simulation; raise --amplitude-m",
                given.amplitude_m
            )
        }))
        .collect();
    warn(&given.output, &warnings);
    let magnitude = |hz: f64| loops.response(hz, coordinate).norm() * travel;
    let bode = document(given, stamp("bode", 0, complete, &loaded, warnings), rows, &loops, magnitude);
    deliver(&given.output, folder.as_ref(), "bode.json", &bode, &text(&bode))?;
    Ok(if complete { Outcome::Done } else { Outcome::Stopped })
}

/// Finds the frequency (Hz) between two at which a magnitude falls below 1/√2, by bisection.
fn crossing_hz(mut low: f64, mut high: f64, magnitude: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if magnitude(middle) >= 0.5_f64.sqrt() { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

fn document(
    given: &BodeArguments,
    stamp: report::document::Stamp,
    rows: Vec<BodeRow>,
    loops: &LinearLoops,
    magnitude: impl Fn(f64) -> f64,
) -> BodeDocument {
    let mut poles = loops.poles();
    poles.retain(|p| p.frequency_hz > 1e-3);
    poles.sort_by(|a, b| a.damping_ratio().total_cmp(&b.damping_ratio()));
    let difference = |of: &dyn Fn(&BodeRow) -> Option<f64>| rows.iter().filter_map(of).reduce(f64::max);
    let last_above = rows.iter().rposition(|r| r.magnitude >= 0.5_f64.sqrt());
    BodeDocument {
        stamp,
        response: given.response.clone(),
        amplitude: (!given.linear).then_some(given.amplitude_m),
        poles: poles
            .iter()
            .map(|p| PoleRow { frequency_hz: p.frequency_hz, damping_ratio: p.damping_ratio(), point: p.point.clone() })
            .collect(),
        bandwidth_hz: last_above.and_then(|at| Some(crossing_hz(rows[at].frequency_hz, rows.get(at + 1)?.frequency_hz, magnitude))),
        largest_difference: difference(&|r| Some((r.simulated_magnitude? / r.magnitude - 1.0).abs())),
        largest_phase_difference_deg: difference(&|r| {
            let off = (r.simulated_phase_deg? - r.phase_deg).rem_euclid(360.0);
            Some(off.min(360.0 - off))
        }),
        rows,
    }
}

fn text(bode: &BodeDocument) -> String {
    let mut text = String::from("frequency_hz,magnitude,phase_deg,simulated_magnitude,simulated_phase_deg\n");
    for r in &bode.rows {
        let cell = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.6}"));
        let _ = writeln!(
            text,
            "{:.4},{:.6e},{:.4},{},{}",
            r.frequency_hz,
            r.magnitude,
            r.phase_deg,
            r.simulated_magnitude.map_or_else(String::new, |x| format!("{x:.6e}")),
            cell(r.simulated_phase_deg)
        );
    }
    let _ = writeln!(text);
    if let Some(hz) = bode.bandwidth_hz {
        let _ = writeln!(text, "bandwidth (−3 dB): {hz:.1} Hz");
    }
    for p in bode.poles.iter().take(6) {
        let _ = writeln!(text, "pole at {:.1} Hz, damping {:.1} %, largest at {}", p.frequency_hz, 100.0 * p.damping_ratio, p.point);
    }
    if let (Some(size), Some(phase)) = (bode.largest_difference, bode.largest_phase_difference_deg) {
        let _ = writeln!(text, "simulation and linearisation differ by at most {:.2e} of the magnitude and {phase:.2e}°", size);
    }
    text
}
