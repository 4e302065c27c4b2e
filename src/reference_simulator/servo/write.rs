//! Records as measurement sets.

use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;

use super::nominal::Axis;
use super::path::{Circle, Feed};
use super::run::{STEPS, run_in};
use super::sensor::{Record, Sensors};
use crate::Result;
use crate::draw::Draw;
use crate::file::write_motions;
use crate::parallel::in_order;

/// Runs an axis along sines and writes the records as a measurement set. The first and the last record are
/// fitted: for
/// [`Feed::standard`], F1000 and F6000.
///
/// # Errors     As [`run`](super::run()); `SimulatorError::Write` if a file cannot be written. All runs end
///   before the first file is written.
pub fn write_sines(folder: &Path, axis: &Axis, sensors: &Sensors, feeds: &[Feed], seed: u64) -> Result<()> {
    let commands =
        feeds.iter().map(|feed| Ok((feed.name(), feed.commands_m()?))).collect::<Result<Vec<_>>>()?;
    let records = drive(axis, sensors, &commands, &Draw::new(seed))?;
    write_set(folder, "ball-screw axis, sines", &records)
}

/// Runs two axes, x and y, along circles and writes one measurement set for each in the folders `x` and `y`.
/// The first and the last circle are fitted: for [`Circle::standard`], the slowest and the fastest.
///
/// # Errors     As [`write_sines`].
pub fn write_circles(
    folder: &Path,
    axes: [&Axis; 2],
    sensors: &Sensors,
    circles: &[Circle],
    seed: u64,
) -> Result<()> {
    let mut commands: [Vec<(String, Vec<f64>)>; 2] = Default::default();
    for circle in circles {
        for (all, one) in commands.iter_mut().zip(circle.commands_m()?) {
            all.push((circle.name(), one));
        }
    }
    let draw = Draw::new(seed);
    let x = drive(axes[0], sensors, &commands[0], &draw.branch(0))?;
    let y = drive(axes[1], sensors, &commands[1], &draw.branch(1))?;
    write_set(&folder.join("x"), "ball-screw axis x, circles", &x)?;
    write_set(&folder.join("y"), "ball-screw axis y, circles", &y)
}

/// Records the runs along named commands, each with its own noise.
fn drive(
    axis: &Axis,
    sensors: &Sensors,
    commands: &[(String, Vec<f64>)],
    draw: &Draw,
) -> Result<Vec<(String, Record)>> {
    let one = |(number, (name, command)): (usize, &(String, Vec<f64>))| {
        let record = run_in(axis, sensors, command, &mut draw.branch(number as u64), STEPS)?;
        Ok((name.clone(), record))
    };
    in_order(commands.par_iter().enumerate().map(one))
}

fn write_set(folder: &Path, title: &str, records: &[(String, Record)]) -> Result<()> {
    let ends: Vec<String> =
        records.first().into_iter().chain(records.last()).map(|(name, _)| name.clone()).collect();
    let rows = records.iter().map(|(name, record)| (name.as_str(), rows(record)));
    write_motions(folder, &format!("title = \"{title}\"\n"), &ends, rows)
}

fn rows(record: &Record) -> String {
    let mut text = String::from("time_s,command_m,position_m,table_m,torque_nm\n");
    for k in 0..record.time_s.len() {
        let _ = writeln!(
            text,
            "{:.3},{:.9e},{:.9e},{:.9e},{:.6e}",
            record.time_s[k],
            record.command_m[k],
            record.position_m[k],
            record.table_m[k],
            record.torque_nm[k]
        );
    }
    text
}
