//! Time records of a driven axis: command, position, and the force or torque that drives it.

use std::collections::BTreeMap;

use super::MeasurementError;
use super::table::Table;
use numeric::statistics::{extremes, median};

/// What drives the axis.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveEffort {
    /// Axial force (N), sample by sample.
    Force(Vec<f64>),
    /// Motor torque (N·m), sample by sample.
    Torque(Vec<f64>),
}

impl DriveEffort {
    /// Its samples, N or N·m.
    pub fn samples(&self) -> &[f64] {
        match self {
            DriveEffort::Force(samples) | DriveEffort::Torque(samples) => samples,
        }
    }

    /// Its column.
    pub fn column(&self) -> &'static str {
        match self {
            DriveEffort::Force(_) => "force_n",
            DriveEffort::Torque(_) => "torque_nm",
        }
    }
}

/// One motion, sampled evenly.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionRecord {
    /// Name of the record.
    pub name: String,
    /// File it came from.
    pub source: String,
    /// Time between samples (s).
    pub step_s: f64,
    /// Time stamps (s).
    pub time_s: Vec<f64>,
    /// Commanded position (m).
    pub command_m: Vec<f64>,
    /// Measured position (m).
    pub position_m: Vec<f64>,
    /// What drives it.
    pub load: DriveEffort,
    /// Other columns, by name.
    pub others: BTreeMap<String, Vec<f64>>,
}

impl MotionRecord {
    /// Samples.
    pub fn samples(&self) -> usize {
        self.time_s.len()
    }
}

/// Share of a step by which time stamps may be uneven: they are printed with few digits.
const UNEVEN: f64 = 0.02;
/// Samples in a row at one end of its range that say that a channel is saturated.
const SATURATED: usize = 20;
/// Columns a record must have, and of which it has one.
const NEEDED: [&str; 3] = ["time_s", "command_m", "position_m"];
const LOADS: [&str; 2] = ["force_n", "torque_nm"];

/// Reads a time record: columns `time_s,command_m,position_m` and `force_n` or `torque_nm`; others are kept by their names.
///
/// # Errors  a column is missing, a cell is no number; time stamps repeat, run backward, are uneven or leave a gap (with the line); a channel
/// is constant; force or torque is saturated (with the line where that begins).
pub fn read_motion(path: &str, name: &str, text: &str) -> Result<MotionRecord, MeasurementError> {
    let table = Table::read_open(path, text, &NEEDED, &LOADS)?;
    let load_column = match (table.has(LOADS[0]), table.has(LOADS[1])) {
        (true, false) => LOADS[0],
        (false, true) => LOADS[1],
        (true, true) => return Err(MeasurementError::line(path, 1, "has both force_n and torque_nm; keep one of them")),
        (false, false) => return Err(MeasurementError::line(path, 1, "has neither force_n nor torque_nm; write one of them")),
    };
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut lines = Vec::new();
    let names: Vec<String> = table.columns().into_iter().map(str::to_string).collect();
    let mut cells: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for row in table.rows() {
        lines.push(row.line());
        for (name, cells) in names.iter().zip(&mut cells) {
            cells.push(row.number(name)?);
        }
    }
    for (name, cells) in names.into_iter().zip(cells) {
        columns.insert(name, cells);
    }
    let mut take = |name: &str| columns.remove(name).unwrap_or_default();
    let (time_s, command_m, position_m, load) = (take(NEEDED[0]), take(NEEDED[1]), take(NEEDED[2]), take(load_column));
    let step_s = step(path, &time_s, &lines)?;
    for (name, channel) in [("position_m", &position_m), (load_column, &load)] {
        if channel.iter().all(|x| *x == channel[0]) {
            let fault = format!("{name} is constant ({}); record the channel while the axis moves", channel[0]);
            return Err(MeasurementError::file(path, fault));
        }
    }
    if let Some((at, count, value)) = saturated(&load) {
        let fault = format!(
            "{load_column} stays at its extreme value {value} for {count} samples: the channel is saturated; record it with a wider range, or a \
             gentler motion"
        );
        return Err(MeasurementError::line(path, lines[at], fault));
    }
    let load = if load_column == LOADS[0] { DriveEffort::Force(load) } else { DriveEffort::Torque(load) };
    Ok(MotionRecord { name: name.into(), source: path.into(), step_s, time_s, command_m, position_m, load, others: columns })
}

/// The even step (s) of time stamps.
pub(super) fn step(path: &str, time_s: &[f64], lines: &[u64]) -> Result<f64, MeasurementError> {
    let Some(usual) = median(time_s.windows(2).map(|w| w[1] - w[0])) else {
        return Err(MeasurementError::file(path, "holds one sample; a motion needs thousands"));
    };
    let last = time_s.len() - 1;
    for (at, pair) in time_s.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let fault = if to == from {
            format!("time_s repeats {to} of the line before; give each sample its own time")
        } else if to < from {
            format!("time_s falls from {from} to {to}; write samples in the order of time")
        } else if to - from > 1.5 * usual {
            let missing = ((to - from) / usual).round() - 1.0;
            format!(
                "time_s leaves a gap: {from} to {to} where samples are {usual:.6} s apart, {missing:.0} missing; split the record there"
            )
        } else if (to - from - usual).abs() > UNEVEN * usual {
            format!(
                "time_s is uneven: {:.9} s after the sample before where {usual:.9} s is usual; resample evenly, or write more digits",
                to - from
            )
        } else {
            continue;
        };
        return Err(MeasurementError::line(path, lines[at + 1], fault));
    }
    Ok((time_s[last] - time_s[0]) / last as f64)
}

/// Where a channel stays at its largest or smallest value for long: sample, count, value.
fn saturated(channel: &[f64]) -> Option<(usize, usize, f64)> {
    let (low, high) = extremes(channel);
    let mut begin = 0;
    for at in 0..=channel.len() {
        if at == channel.len() || channel[at] != channel[begin] {
            let count = at - begin;
            if count >= SATURATED && (channel[begin] == low || channel[begin] == high) {
                return Some((begin, count, channel[begin]));
            }
            begin = at;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(mut change: impl FnMut(usize, &mut [f64; 4])) -> String {
        let mut text = String::from("time_s,command_m,position_m,force_n,spindle\n");
        for i in 0..200 {
            let t = 0.001 * i as f64;
            let mut row = [t, (20.0 * t).sin(), (20.0 * t - 0.01).sin(), 50.0 * (20.0 * t).cos()];
            change(i, &mut row);
            text += &format!("{},{},{},{},7\n", row[0], row[1], row[2], row[3]);
        }
        text
    }

    fn fault(text: &str) -> String {
        read_motion("m.csv", "m", text).unwrap_err().to_string()
    }

    #[test]
    fn a_record_is_read_with_its_other_columns() {
        let record = read_motion("m.csv", "m", &text(|_, _| {})).unwrap();
        assert_eq!((record.samples(), record.load.column()), (200, "force_n"));
        assert!((record.step_s - 1e-3).abs() < 1e-12);
        assert_eq!(record.others["spindle"].len(), 200);
    }

    #[test]
    fn faults_are_reported_with_their_line() {
        for (change, words) in [
            (
                Box::new(|i: usize, r: &mut [f64; 4]| {
                    if i == 50 {
                        r[0] = 0.049
                    }
                }) as Box<dyn FnMut(usize, &mut [f64; 4])>,
                "line 52: time_s repeats",
            ),
            (
                Box::new(|i, r| {
                    if i == 50 {
                        r[0] = 0.04
                    }
                }),
                "line 52: time_s falls",
            ),
            (
                Box::new(|i, r| {
                    if i >= 50 {
                        r[0] += 0.003
                    }
                }),
                "line 52: time_s leaves a gap: 0.049 to 0.053",
            ),
            (
                Box::new(|i, r| {
                    if i == 50 {
                        r[0] += 2e-4
                    }
                }),
                "line 52: time_s is uneven",
            ),
            (Box::new(|_, r| r[2] = 0.1), "position_m is constant (0.1)"),
            (Box::new(|_, r| r[3] = r[3].clamp(-30.0, 30.0)), "line 2: force_n stays at its extreme value 30"),
            (
                Box::new(|i, r| {
                    if i == 9 {
                        r[1] = f64::NAN
                    }
                }),
                "line 11: command_m is «NaN»",
            ),
        ] {
            let told = fault(&text(change));
            assert!(told.contains(words), "{told}");
        }
        assert!(fault("time_s,command_m,position_m\n0,0,0\n").contains("neither force_n nor torque_nm"));
        assert!(fault("time_s,command_m,position_m,force_n\n0,0,0,1\n").contains("one sample"));
    }
}
