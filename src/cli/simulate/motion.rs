//! `jointid simulate motion`: a driven axis on a reference, or on the command of a record.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::drive::{describe_pole, find_drive};
use super::operating::{LoadArguments, find_operating};
use crate::arguments::{OutputArguments, Sources};
use crate::long_work::not_stopped;
use crate::outcome::{CommandResult, Outcome, prepare, print_out, to_message, warn, write_announced};
use crate::sources::{Loaded, digest_file, load_machine, stamp};
use dynamics::motion::{Course, EventKind, LinearLoops, RecordGap, SCurve, SimulationSettings, Sine, Trace, simulate, simulate_record};
use machine::{Machine, PointMotion};
use measurement::{SourceFile, read_reference};
use report::motion::{EnergyBalance, EventRow, Instability, MotionDocument, RecordRow};
use report::to_json;

/// Arguments of `simulate motion`.
#[derive(Debug, clap::Args)]
pub struct MotionArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Reference of the axis: s-curve, sine, or a table with the columns time_s and command_m
    #[arg(long, value_name = "s-curve|sine|FILE", required_unless_present = "record", conflicts_with = "record")]
    pub reference: Option<String>,
    /// Record of the measurement set to simulate in closed loop and to compare
    #[arg(long, value_name = "NAME")]
    pub record: Option<String>,
    /// S-curve: travel (m)
    #[arg(long, value_name = "M", default_value_t = 0.1, allow_negative_numbers = true)]
    pub travel_m: f64,
    /// S-curve: largest velocity (m/s)
    #[arg(long, value_name = "V", default_value_t = 0.2)]
    pub velocity_m_s: f64,
    /// S-curve: largest acceleration (m/s²)
    #[arg(long, value_name = "A", default_value_t = 2.0)]
    pub acceleration_m_s2: f64,
    /// S-curve: largest jerk (m/s³)
    #[arg(long, value_name = "J", default_value_t = 50.0)]
    pub jerk_m_s3: f64,
    /// S-curve: rest before and after (s)
    #[arg(long, value_name = "S", default_value_t = 0.2)]
    pub rest_s: f64,
    /// S-curve: return to the start
    #[arg(long)]
    pub and_back: bool,
    /// Sine: amplitude (m)
    #[arg(long, value_name = "M", default_value_t = 0.01)]
    pub amplitude_m: f64,
    /// Sine: frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub frequency_hz: f64,
    /// Sine: number of periods
    #[arg(long, value_name = "N", default_value_t = 3.0)]
    pub periods: f64,
    /// Nut position at the start, from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    /// Lumps per rod
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub lumps: u16,
    /// Longest time step (s), an integer fraction of the innermost loop's period
    #[arg(long, value_name = "S")]
    pub step_s: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &MotionArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let drive = find_drive(&loaded)?;
    let settings = SimulationSettings {
        operating: find_operating(&loaded, given.nut_m, None, &LoadArguments::default())?,
        lumps: usize::from(given.lumps),
        step_s: given.step_s,
        ..SimulationSettings::default()
    };
    let folder = prepare(&given.output)?;
    let go_on = not_stopped();
    let values = machine.start();
    let mut file = None;
    let (word, trace, gap) = match &given.record {
        Some(name) => {
            let record = loaded.set.motions.iter().find(|m| m.name == *name).ok_or_else(|| no_record(&loaded, name))?;
            let (trace, gap) = simulate_record(machine, &values, record, &settings, &go_on).map_err(to_message)?;
            (format!("record {name}"), trace, gap)
        }
        None => {
            let word = given.reference.clone().unwrap_or_default();
            let course = course(given, &word, drive.position.period_s, &mut file)?;
            let trace = simulate(machine, &values, &course, &settings, &go_on).map_err(|e| format!("--reference {word}: {e}"))?;
            (word, trace, None)
        }
    };
    let mut trace = trace;
    let pole = LinearLoops::new(machine, &values, &settings).ok().and_then(|loops| loops.unstable());
    trace.warnings.extend(
        pole.map(|pole| format!("the loops, linearised without friction, backlash and limits, are unstable: {}", describe_pole(&pole))),
    );
    warn(&given.output, &trace.warnings);
    let document = document(given, &loaded, &word, &settings, &trace, gap, file.as_ref());
    let csv = table(&document, machine);
    let json = to_json(&document)?;
    if let Some(folder) = &folder {
        write_announced(&given.output, folder, &[("motion.json", &json), ("motion.csv", &csv)])?;
    }
    print_out(if given.output.json { &json } else { &csv })?;
    if !given.output.json && !given.output.quiet {
        eprint!("{}", summary(&document));
    }
    Ok(if trace.complete { Outcome::Done } else { Outcome::Stopped })
}

fn no_record(loaded: &Loaded, name: &str) -> String {
    let known: Vec<&str> = loaded.set.motions.iter().map(|m| m.name.as_str()).collect();
    let known =
        if known.is_empty() { "it has none; name a set with --measurements".to_string() } else { format!("it has {}", known.join(", ")) };
    format!("--record {name}: {} has no such record; {known}", loaded.set.path)
}

/// Builds the requested reference.
fn course(given: &MotionArguments, word: &str, period_s: f64, file: &mut Option<SourceFile>) -> Result<Course, String> {
    match word {
        "s-curve" => {
            if !(given.rest_s >= 0.0 && given.rest_s.is_finite()) {
                return Err(format!("--rest-s {}: write 0 or a time in s", given.rest_s));
            }
            let curve = SCurve {
                from: 0.0,
                to: given.travel_m,
                velocity: given.velocity_m_s,
                acceleration: given.acceleration_m_s2,
                jerk: given.jerk_m_s3,
            };
            curve.course(period_s, given.rest_s, given.and_back).map_err(to_message)
        }
        "sine" => {
            let sine = Sine { centre: 0.0, amplitude: given.amplitude_m, frequency_hz: given.frequency_hz, periods: given.periods };
            sine.course(period_s).map_err(to_message)
        }
        path => {
            let read = read_reference(path).map_err(|e| format!("--reference {e}"))?;
            *file = Some(read.file);
            Ok(Course { added: read.added_v, ..Course::new(read.step_s, read.command_m) })
        }
    }
}

/// Returns the unit of the encoder's reading, `m` or `rad`, and the column of force or torque.
fn units(machine: &Machine) -> (&'static str, &'static str) {
    let Some(drive) = &machine.drive else { return ("m", "force_n") };
    let encoder = &drive.position.encoder;
    let angle = machine.points[encoder.at].motion == PointMotion::Rotation && encoder.travel == 1.0;
    let rotates = machine.points[drive.on].motion == PointMotion::Rotation;
    (if angle { "rad" } else { "m" }, if rotates { "torque_nm" } else { "force_n" })
}

/// Returns the names of the columns, in the order of the table and of a sample.
fn order(machine: &Machine, points: impl Iterator<Item = String>) -> Vec<String> {
    let (unit, load) = units(machine);
    let fixed = ["time_s".into(), format!("command_{unit}"), format!("position_{unit}"), load.into(), format!("velocity_{unit}_s")];
    fixed.into_iter().chain(points).collect()
}

fn point_column(machine: &Machine, name: &str) -> String {
    let rotates = machine.point(name).is_some_and(|p| machine.points[p].motion == PointMotion::Rotation);
    format!("{name}_{}", if rotates { "rad" } else { "m" })
}

fn document(
    given: &MotionArguments,
    loaded: &Loaded,
    word: &str,
    settings: &SimulationSettings,
    trace: &Trace,
    gap: Option<RecordGap>,
    file: Option<&SourceFile>,
) -> MotionDocument {
    let machine = &loaded.config.machine;
    let points: Vec<String> = trace.points.iter().map(|name| point_column(machine, name)).collect();
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (at, name) in order(machine, points.into_iter()).into_iter().enumerate() {
        let column = trace.samples.iter().map(|s| match at {
            0 => s.time_s,
            1 => s.command,
            2 => s.position,
            3 => s.force,
            4 => s.velocity,
            point => s.points[point - 5],
        });
        columns.insert(name, column.collect());
    }
    let mut stamp = stamp("motion", 0, trace.complete, loaded, trace.warnings.clone());
    stamp.inputs.extend(file.map(digest_file));
    let energy = trace.energy;
    MotionDocument {
        stamp,
        reference: word.into(),
        nut_m: settings.operating.nut_m,
        parameters: machine.parameters.iter().map(|p| (p.id.clone(), p.start)).collect(),
        columns,
        energy: EnergyBalance {
            supplied_j: energy.supplied_j,
            stored_j: energy.stored_j,
            lost_j: energy.lost_j,
            imbalance: energy.imbalance(),
        },
        events: trace
            .events
            .iter()
            .map(|e| EventRow { time_s: e.time_s, kind: kind(e.kind).into(), joint: e.joint.clone(), direction: e.direction })
            .collect(),
        record: gap.map(|gap| RecordRow {
            name: given.record.clone().unwrap_or_default(),
            force_gap: gap.force,
            tracking_gap: gap.tracking,
        }),
        unstable: trace.unstable.map(|(time_s, error)| Instability { time_s, error }),
    }
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

/// Formats the columns as a CSV table.
fn table(document: &MotionDocument, machine: &Machine) -> String {
    let fixed = order(machine, std::iter::empty());
    let points = document.columns.keys().filter(|name| !fixed.contains(name)).cloned();
    let names = order(machine, points);
    let columns: Vec<&Vec<f64>> = names.iter().filter_map(|name| document.columns.get(name)).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..columns.first().map_or(0, |c| c.len()) {
        for (at, column) in columns.iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            // Rounds off the accumulated error of the times.
            let _ = if at == 0 { write!(text, "{:.9}", column[row]) } else { write!(text, "{comma}{:e}", column[row]) };
        }
        text.push('\n');
    }
    text
}

/// Summarises a simulation in a few lines.
fn summary(document: &MotionDocument) -> String {
    let mut text = String::new();
    let e = &document.energy;
    let _ = writeln!(
        text,
        "energy: {:.6} J supplied, {:.6} J stored, {:.6} J lost; relative imbalance {:.1e}",
        e.supplied_j, e.stored_j, e.lost_j, e.imbalance
    );
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    document.events.iter().for_each(|e| *counts.entry((&e.joint, &e.kind)).or_default() += 1);
    let counts: Vec<String> = counts.iter().map(|((joint, kind), count)| format!("{joint} {kind} {count} times")).collect();
    let _ = writeln!(text, "events: {}", if counts.is_empty() { "none".to_string() } else { counts.join(", ") });
    if let Some(record) = &document.record {
        let _ = writeln!(
            text,
            "record {}: rms prediction error {:.2} % of the force, {:.2} % of the tracking error",
            record.name,
            100.0 * record.force_gap,
            100.0 * record.tracking_gap
        );
    }
    if let Some(unstable) = &document.unstable {
        let _ = writeln!(
            text,
            "the loop diverges at {} s, with a tracking error of {:.3e} m or rad: it is unstable; lower its gains, its delay or its periods",
            unstable.time_s, unstable.error
        );
    }
    text
}
