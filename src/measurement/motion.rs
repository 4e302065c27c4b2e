//! Time records of a driven axis: command, position, and drive force or torque.

use std::collections::BTreeMap;

use super::MeasurementError;
use super::table::Table;
use numeric::statistics::{extremes, median};

/// Drive force or torque.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveEffort {
    /// Axial force (N), sample by sample.
    Force(Vec<f64>),
    /// Motor torque (N·m), sample by sample.
    Torque(Vec<f64>),
}

impl DriveEffort {
    /// Returns its samples (N or N·m).
    pub fn samples(&self) -> &[f64] {
        match self {
            DriveEffort::Force(samples) | DriveEffort::Torque(samples) => samples,
        }
    }

    /// Returns the name of its column.
    pub fn column(&self) -> &'static str {
        match self {
            DriveEffort::Force(_) => "force_n",
            DriveEffort::Torque(_) => "torque_nm",
        }
    }
}

/// One motion with a constant sampling step.
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
    /// Whether positions are angles (rad), those of a rotary axis; else they are travels.
    pub is_angle: bool,
    /// Commanded position (m, or rad of an angle).
    pub command_m: Vec<f64>,
    /// Measured position (m, or rad of an angle).
    pub position_m: Vec<f64>,
    /// Drive force or torque.
    pub load: DriveEffort,
    /// Other columns, by name.
    pub others: BTreeMap<String, Vec<f64>>,
}

impl MotionRecord {
    /// Returns the number of samples.
    pub fn samples(&self) -> usize {
        self.time_s.len()
    }
}

/// Largest deviation of a time step from the median step, relative (1): time stamps are printed with few
/// digits.
const STEP_TOLERANCE: f64 = 0.02;
/// Smallest number of consecutive samples at an extreme value by which a channel counts as saturated.
const SATURATED_SAMPLES: usize = 20;
/// Columns that a record must have: those of a travel, and those of an angle.
const REQUIRED: [[&str; 3]; 2] =
    [["time_s", "command_m", "position_m"], ["time_s", "command_rad", "position_rad"]];
/// Columns of the drive effort; a record has exactly one of them.
pub(super) const EFFORT_COLUMNS: [&str; 2] = ["force_n", "torque_nm"];

/// Reads a time record: columns `time_s,command_m,position_m`, or `time_s,command_rad,position_rad` of a rotary
/// axis, and `force_n` or `torque_nm`; other columns are kept by name.
///
/// # Errors  a column is missing, a cell is not a number; time stamps repeat, decrease, are uneven or skip
///   samples (with the line); a
/// channel is constant; force or torque is saturated (with the first line of the saturation).
pub fn read_motion(path: &str, name: &str, text: &str) -> Result<MotionRecord, MeasurementError> {
    let [travel, angle] = REQUIRED;
    let optional = [&travel[1..], &angle[1..], &EFFORT_COLUMNS].concat();
    let is_angle = Table::read_open(path, text, &travel[..1], &optional)?.has(angle[2]);
    let required = if is_angle { angle } else { travel };
    let table = Table::read_open(path, text, &required, &EFFORT_COLUMNS)?;
    let load_column = table.one_of(EFFORT_COLUMNS)?;
    let mut lines = Vec::new();
    let names: Vec<String> = table.columns().into_iter().map(str::to_string).collect();
    let mut cells: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for row in table.rows() {
        let row = row?;
        lines.push(row.line());
        for (name, cells) in names.iter().zip(&mut cells) {
            cells.push(row.number(name)?);
        }
    }
    let mut columns: BTreeMap<String, Vec<f64>> = names.into_iter().zip(cells).collect();
    let mut take = |name: &str| columns.remove(name).unwrap_or_default();
    let (time_s, command_m, position_m, load) =
        (take(required[0]), take(required[1]), take(required[2]), take(load_column));
    let load =
        if load_column == EFFORT_COLUMNS[0] { DriveEffort::Force(load) } else { DriveEffort::Torque(load) };
    let record = MotionRecord {
        name: name.into(),
        source: path.into(),
        step_s: 0.0,
        time_s,
        is_angle,
        command_m,
        position_m,
        load,
        others: columns,
    };
    record.checked(&lines)
}

impl MotionRecord {
    /// Checks the channels, and determines the step. `lines` holds the line (or number) of each sample in its
    /// source.
    ///
    /// # Errors  as [`read_motion`].
    pub(super) fn checked(mut self, lines: &[u64]) -> Result<Self, MeasurementError> {
        let path = &self.source;
        self.step_s = step(path, &self.time_s, lines)?;
        let (column, load) = (self.load.column(), self.load.samples());
        let position = REQUIRED[usize::from(self.is_angle)][2];
        for (name, channel) in [(position, self.position_m.as_slice()), (column, load)] {
            if channel.iter().all(|x| *x == channel[0]) {
                let fault =
                    format!("{name} is constant ({}); record the channel while the axis moves", channel[0]);
                return Err(MeasurementError::file(path, fault));
            }
        }
        if let Some((at, count, value)) = saturated(load) {
            let fault = format!(
                "{column} stays at its extreme value {value} for {count} samples: the channel is saturated; record it with a wider range, or a \
                 gentler motion"
            );
            return Err(MeasurementError::line(path, lines[at], fault));
        }
        Ok(self)
    }
}

/// Returns the constant step (s) of time stamps.
pub(super) fn step(path: &str, time_s: &[f64], lines: &[u64]) -> Result<f64, MeasurementError> {
    let Some(median_step) = median(time_s.windows(2).map(|w| w[1] - w[0])) else {
        return Err(MeasurementError::file(path, "holds one sample; a motion needs thousands"));
    };
    let last = time_s.len() - 1;
    for (at, pair) in time_s.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let fault = if to == from {
            format!("time_s repeats {to} of the previous line; give each sample its own time")
        } else if to < from {
            format!("time_s falls from {from} to {to}; write the samples in order of time")
        } else if to - from > 1.5 * median_step {
            let missing = ((to - from) / median_step).round() - 1.0;
            format!(
                "time_s skips samples: {from} to {to} at a step of {median_step:.6} s, {missing:.0} missing; split the record there"
            )
        } else if (to - from - median_step).abs() > STEP_TOLERANCE * median_step {
            format!(
                "time_s is uneven: a step of {:.9} s, the median is {median_step:.9} s; resample evenly, or write more digits",
                to - from
            )
        } else {
            continue;
        };
        return Err(MeasurementError::line(path, lines[at + 1], fault));
    }
    Ok((time_s[last] - time_s[0]) / last as f64)
}

/// Finds the first saturated run of samples at the channel's largest or smallest value: first sample, count,
/// value.
fn saturated(channel: &[f64]) -> Option<(usize, usize, f64)> {
    let (low, high) = extremes(channel);
    let mut begin = 0;
    for at in 0..=channel.len() {
        if at == channel.len() || channel[at] != channel[begin] {
            let count = at - begin;
            if count >= SATURATED_SAMPLES && (channel[begin] == low || channel[begin] == high) {
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
    fn a_record_is_read_with_its_extra_columns() {
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
                "line 52: time_s skips samples: 0.049 to 0.053",
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
            (
                Box::new(|_, r| r[3] = r[3].clamp(-30.0, 30.0)),
                "line 2: force_n stays at its extreme value 30",
            ),
            (
                Box::new(|i, r| {
                    if i == 9 {
                        r[1] = f64::NAN
                    }
                }),
                "line 11: command_m is «NaN»",
            ),
        ] {
            let message = fault(&text(change));
            assert!(message.contains(words), "{message}");
        }
        assert!(fault("time_s,command_m,position_m\n0,0,0\n").contains("neither force_n nor torque_nm"));
        assert!(fault("time_s,command_m,position_m,force_n\n0,0,0,1\n").contains("one sample"));
    }
}
