//! Motion of a driven axis along a reference, or along the command of a record.

use std::collections::BTreeMap;

use super::drive::{describe_pole, find_drive};
use super::operating::{Load, Place, find_operating, require_count};
use super::travel::TravelProfile;
use crate::stamp::digest_file;
use crate::{Study, StudyError, StudyResult};
use dynamics::motion::{
    Course, EventKind, LinearLoops, RecordGap, SimulationSettings, Sine, Trace, simulate, simulate_record,
};
use machine::{Machine, Point, PointMotion};
use measurement::{SourceFile, read_reference};
use report::motion::{EnergyBalance, EventRow, Instability, MotionDocument, RecordRow};

/// Command of a simulated motion. For an axis whose encoder reads an angle, rad replaces m.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Travel from rest to rest.
    SCurve {
        /// Travel and its limits.
        travel: TravelProfile,
        /// Whether the axis returns to the start.
        and_back: bool,
    },
    /// A sine whose amplitude rises over the first period.
    Sine {
        /// Amplitude (m).
        amplitude_m: f64,
        /// Frequency (Hz).
        frequency_hz: f64,
        /// Number of periods.
        periods: f64,
    },
    /// Path of a table with the columns `time_s` and `command_m`.
    Table(String),
    /// Name of a record of the measurement set, simulated in closed loop and compared.
    Record(String),
}

/// What [`motion`] simulates.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionRequest {
    /// Command of the axis.
    pub reference: Reference,
    /// Place of the nut at the start.
    pub place: Place,
    /// Number of springs per rod.
    pub lumps: usize,
    /// Longest time step (s), an integer fraction of the innermost loop's period; that period where absent.
    pub step_s: Option<f64>,
}

impl Default for MotionRequest {
    fn default() -> Self {
        let reference = Reference::SCurve { travel: TravelProfile::default(), and_back: false };
        MotionRequest { reference, place: Place::MidStroke, lumps: 4, step_s: None }
    }
}

/// Simulates the motion of the driven axis. A motion that is stopped or diverges gives a document that is not
/// complete.
///
/// # Errors  a setting outside its range; the machine has no drive, the set no such record; a command is
///   beyond the stroke.
pub fn motion(study: &Study, request: &MotionRequest) -> StudyResult<MotionDocument> {
    let machine = study.machine();
    let drive = find_drive(study)?;
    let settings = SimulationSettings {
        operating: find_operating(study, &request.place, &Load::default())?,
        lumps: require_count("lumps", request.lumps, 1)?,
        step_s: request.step_s,
        ..SimulationSettings::default()
    };
    let go_on = || !study.control().stopped();
    let values = machine.start();
    let period_s = drive.position.period_s;
    let along = |word: &str, course: &Course| {
        let trace = simulate(machine, &values, course, &settings, &go_on);
        let trace = trace.map_err(|e| StudyError::setting("reference", word, e.to_string()))?;
        StudyResult::Ok((word.to_string(), trace, None))
    };
    let mut file = None;
    let (word, mut trace, record) = match &request.reference {
        Reference::SCurve { travel, and_back } => along("s-curve", &s_curve(travel, *and_back, period_s)?)?,
        Reference::Sine { amplitude_m, frequency_hz, periods } => {
            let sine =
                Sine { centre: 0.0, amplitude: *amplitude_m, frequency_hz: *frequency_hz, periods: *periods };
            along("sine", &sine.course(period_s)?)?
        }
        Reference::Table(path) => along(path, &table(path, &mut file)?)?,
        Reference::Record(name) => {
            let record = study
                .measurements()
                .motions
                .iter()
                .find(|m| m.name == *name)
                .ok_or_else(|| no_record(study, name))?;
            let (trace, gap) = simulate_record(machine, &values, record, &settings, &go_on)?;
            (format!("record {name}"), trace, gap.map(|gap| record_row(name, &gap)))
        }
    };
    let pole = LinearLoops::new(machine, &values, &settings).ok().and_then(|loops| loops.unstable());
    trace.warnings.extend(pole.map(|pole| {
        format!(
            "the loops, linearised without friction, backlash and limits, are unstable: {}",
            describe_pole(&pole)
        )
    }));
    let mut stamp = study.stamp("motion", 0, trace.complete, trace.warnings.clone());
    stamp.inputs.extend(file.as_ref().map(digest_file));
    let energy = trace.energy;
    Ok(MotionDocument {
        stamp,
        reference: word,
        nut_m: settings.operating.nut_m,
        parameters: machine.parameters.iter().map(|p| (p.id.clone(), p.start)).collect(),
        columns: columns(machine, &trace),
        energy: EnergyBalance {
            supplied_j: energy.supplied_j,
            stored_j: energy.stored_j,
            lost_j: energy.lost_j,
            imbalance: energy.imbalance(),
        },
        events: trace
            .events
            .iter()
            .map(|e| EventRow {
                time_s: e.time_s,
                kind: kind(e.kind).into(),
                joint: e.joint.clone(),
                direction: e.direction,
            })
            .collect(),
        record,
        unstable: trace.unstable.map(|(time_s, error)| Instability { time_s, error }),
    })
}

fn no_record(study: &Study, name: &str) -> StudyError {
    let set = study.measurements();
    let known: Vec<&str> = set.motions.iter().map(|m| m.name.as_str()).collect();
    let known = match known.is_empty() {
        true => "it has none; name the folder of a set with records (measurements)".to_string(),
        false => format!("it has {}", known.join(", ")),
    };
    StudyError::setting("record", name, format!("{} has no such record; {known}", set.path))
}

fn record_row(name: &str, gap: &RecordGap) -> RecordRow {
    RecordRow { name: name.into(), force_gap: gap.force, tracking_gap: gap.tracking }
}

fn s_curve(travel: &TravelProfile, and_back: bool, period_s: f64) -> StudyResult<Course> {
    if !(travel.rest_s >= 0.0 && travel.rest_s.is_finite()) {
        return Err(StudyError::setting("rest_s", travel.rest_s, "write 0 or a time in s"));
    }
    travel.course(period_s, and_back)
}

/// Reads a reference from a table, and keeps the file.
fn table(path: &str, file: &mut Option<SourceFile>) -> StudyResult<Course> {
    let read = read_reference(path)?;
    *file = Some(read.file);
    Ok(Course { added: read.added_v, ..Course::new(read.step_s, read.command_m) })
}

/// Returns the unit of the encoder's reading, `m` or `rad`, and the column of force or torque.
fn units(machine: &Machine) -> (&'static str, &'static str) {
    let Some(drive) = &machine.drive else { return ("m", "force_n") };
    let angle = drive.position.encoder.reads_angle(machine);
    let rotates = machine.points[drive.on].motion == PointMotion::Rotation;
    (if angle { "rad" } else { "m" }, if rotates { "torque_nm" } else { "force_n" })
}

/// Returns the unit of the displacement of a point, `m` or `rad`.
pub fn displacement_unit(point: &Point) -> &'static str {
    match point.motion {
        PointMotion::Translation => "m",
        PointMotion::Rotation => "rad",
    }
}

fn point_column(machine: &Machine, name: &str) -> String {
    let unit = machine.point(name).map_or("m", |p| displacement_unit(&machine.points[p]));
    format!("{name}_{unit}")
}

/// Returns the signals of a simulation by name.
fn columns(machine: &Machine, trace: &Trace) -> BTreeMap<String, Vec<f64>> {
    let (unit, load) = units(machine);
    let fixed = [
        "time_s".into(),
        format!("command_{unit}"),
        format!("position_{unit}"),
        load.into(),
        format!("velocity_{unit}_s"),
    ];
    let names = fixed.into_iter().chain(trace.points.iter().map(|name| point_column(machine, name)));
    let column = |at: usize| {
        let signal = trace.samples.iter().map(|s| match at {
            0 => s.time_s,
            1 => s.command,
            2 => s.position,
            3 => s.force,
            4 => s.velocity,
            point => s.points[point - 5],
        });
        signal.collect()
    };
    names.enumerate().map(|(at, name)| (name, column(at))).collect()
}

fn kind(kind: EventKind) -> &'static str {
    match kind {
        EventKind::Sticks => "sticks",
        EventKind::Slides => "slides",
        EventKind::Reverses => "reverses",
        EventKind::Closes => "closes",
        EventKind::Opens => "opens",
    }
}
