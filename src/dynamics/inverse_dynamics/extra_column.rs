//! Columns of extra points of a machine, in addition to that of the position loop's encoder.

use std::collections::BTreeMap;

use super::error::InverseError;
use super::extra_channel::ExtraChannel;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{Machine, PointMotion as Kind};
use measurement::MotionRecord;
use numeric::statistics::{extremes, root_mean_square};

/// Periods of the filter's cut-off frequency that are masked around a reversal.
const FILTER_PERIODS: f64 = 2.0;
/// Share of the largest speed below which the axis rests.
const REST_SHARE: f64 = 0.005;
/// Share of the backlash by which the position is inside its ends while the backlash is crossed.
const CROSSING_MARGIN: f64 = 1e-6;
/// Largest share of the travel that is masked after a reversal.
const MAX_TRAVEL_SHARE: f64 = 0.2;

impl ExtraChannel {
    /// Decimates, masks and weights a column of the record's rate, without the components that carry no
    /// information on the transmission.
    ///
    /// Two scales have different zeros, drift apart with time, and are not read at the same instant. A
    /// constant, a drift in time and a term proportional to the velocity are therefore projected out of
    /// recorded and predicted columns alike. The result equals least squares with all three free.
    pub fn thinned(&self, motion: &MotionSignal, column: &[f64]) -> Option<Vec<f64>> {
        self.thinned_all(motion, &[column])?.pop()
    }

    /// As [`ExtraChannel::thinned`], of several columns.
    pub(super) fn thinned_all(
        &self,
        motion: &MotionSignal,
        columns: &[impl AsRef<[f64]>],
    ) -> Option<Vec<Vec<f64>>> {
        Some(self.weighted_all(&motion.decimated_all(columns)?))
    }
}

/// The point that a column names, or the warning about a column that names none.
enum ColumnName {
    Point(usize),
    Unknown(String),
    Other,
}

fn column_name(machine: &Machine, record: &MotionRecord, column: &str) -> Result<ColumnName, InverseError> {
    let Some((name, suffix)) = column.rsplit_once('_').filter(|(_, suffix)| ["m", "rad"].contains(suffix))
    else {
        return Ok(ColumnName::Other);
    };
    let Some(point) = machine.point(name) else {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        let warning = format!(
            "{}: column {column} names no point of the machine ({}) and is not used",
            record.source,
            known.join(", ")
        );
        return Ok(ColumnName::Unknown(warning));
    };
    let (wanted, moves) = match machine.points[point].motion {
        Kind::Translation => ("m", "moves linearly"),
        Kind::Rotation => ("rad", "rotates"),
    };
    if suffix != wanted {
        let fault = format!(
            "{}: column {column}: point «{name}» {moves}; write it as {name}_{wanted}",
            record.source
        );
        return Err(InverseError::Data(fault));
    }
    Ok(ColumnName::Point(point))
}

impl MotionSignal {
    /// Adds the columns of a record that name extra points of the machine (`<point>_m`, `<point>_rad`).
    /// Returns warnings about other columns.
    ///
    /// Around a reversal or a rest backlash and wind-up change sides. Neither they nor the force then
    /// correspond to the rigid motion: these samples are masked.
    ///
    /// # Errors  a column has the unit of the other kind of point, or is constant; the machine's springs
    ///   leave a part unconstrained.
    pub fn with_points(
        mut self,
        record: &MotionRecord,
        machine: &Machine,
        rigid: &Rigid,
    ) -> Result<(Self, Vec<String>), InverseError> {
        let (mut found, mut warnings) = (Vec::new(), Vec::new());
        let encoder = machine.drive.as_ref().ok_or(InverseError::NoDrive)?.position.encoder.at;
        for (column, samples) in &record.others {
            let point = match column_name(machine, record, column)? {
                ColumnName::Point(point) => point,
                ColumnName::Unknown(warning) => {
                    warnings.push(warning);
                    continue;
                }
                ColumnName::Other => continue,
            };
            let ratio = rigid.point_ratio(point);
            if point == encoder || ratio.abs() < 1e-12 {
                continue;
            }
            if samples.iter().all(|x| *x == samples[0]) {
                let fault = format!(
                    "{}: {column} is constant ({}); record the channel while the axis moves, or leave it out",
                    record.source, samples[0]
                );
                return Err(InverseError::Data(fault));
            }
            found.push((point, column.clone(), self.filtered(column, samples)?, ratio));
        }
        if found.is_empty() {
            return Ok((self, warnings));
        }
        if !Rigid::is_constrained(machine, &machine.start()) {
            let fault = "the springs leave a part of the machine unconstrained, so that its transmission error is not determined";
            return Err(InverseError::NotRigid { fault: fault.into() });
        }
        let mut reversing = vec![false; self.position_m.len()];
        for (_, _, reading, ratio) in &found {
            let error: Vec<f64> = reading.iter().zip(&self.position_m).map(|(y, x)| y / ratio - x).collect();
            let (low, high) = extremes(&error);
            reversing.iter_mut().zip(self.near_reversals(high - low)).for_each(|(all, own)| *all |= own);
        }
        self.excluded.iter_mut().zip(&reversing).for_each(|(excluded, reversing)| *excluded |= reversing);
        self.is_moving =
            self.kept().zip(&self.is_moving).map(|(at, moves)| *moves && !reversing[at]).collect();
        let short = || {
            InverseError::Data(format!(
                "{}: is shorter than its filters need; record for longer",
                self.source
            ))
        };
        self.load = self.thinned(record.load.samples()).ok_or_else(short)?;
        for (point, column, reading, ratio) in found {
            let channel = self
                .extra_channel(point, column, &reading, (&self.position_m, ratio), machine)
                .ok_or_else(short)?;
            self.extra_channels.push(channel);
        }
        Ok((self, warnings))
    }

    fn filtered(&self, column: &str, samples: &[f64]) -> Result<Vec<f64>, InverseError> {
        let short = || {
            InverseError::Data(format!(
                "{}: {column} is shorter than its filters need; record for longer",
                self.source
            ))
        };
        self.preprocessing.low_pass(self.step_s).forward_backward(samples).ok_or_else(short)
    }

    /// Computes the channel of an extra point from its reading and that of the loop's encoder; the point
    /// moves by `ratio` times the encoder.
    pub(super) fn extra_channel(
        &self,
        point: usize,
        column: String,
        reading: &[f64],
        (encoder, ratio): (&[f64], f64),
        machine: &Machine,
    ) -> Option<ExtraChannel> {
        // Two scales have different zeros; removing the offset here avoids cancellation later.
        let level = reading[0] - ratio * encoder[0];
        let error: Vec<f64> = reading.iter().zip(encoder).map(|(y, x)| y - ratio * x - level).collect();
        let tracking: Vec<f64> = reading.iter().zip(&self.command_m).map(|(y, r)| ratio * r - y).collect();
        let count = self.position_m.len();
        let time: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
        let mut channel = ExtraChannel {
            point,
            column,
            unit: if machine.points[point].motion == Kind::Translation { "m" } else { "rad" },
            error: self.decimated(&error)?,
            tracking: self.kept().map(|at| tracking[at]).collect(),
            projected_out: vec![
                self.decimated(&vec![1.0; count])?,
                self.decimated(&time)?,
                self.decimated(&self.velocity_m_s)?,
            ],
            is_used: self.is_moving.clone(),
            weight: 1.0,
            encoder_estimate: None,
        };
        let (force, own) =
            (root_mean_square(self.load.iter().copied()), root_mean_square(channel.recorded()));
        channel.weight = force.zip(own).filter(|(_, own)| *own > 0.0).map_or(1.0, |(force, own)| force / own);
        Some(channel)
    }

    /// Marks the samples around a reversal, a rest and the start of the record. Afterwards they last until
    /// the encoder has moved by `travel_m` and the filter's transient has decayed. Before a reversal they
    /// cover the same travel, where the table may stand while the motor moves on.
    pub(super) fn near_reversals(&self, travel_m: f64) -> Vec<bool> {
        let (v, x) = (&self.velocity_m_s, &self.position_m);
        let (low, high) = extremes(x);
        let travel_m = travel_m.min(MAX_TRAVEL_SHARE * (high - low));
        let rest = REST_SHARE * v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let around = (FILTER_PERIODS / (self.preprocessing.cutoff_hz * self.step_s)).ceil() as usize;
        let mut reversing = vec![false; v.len()];
        let (mut direction, mut last, mut until) = (0.0, 0, None::<(usize, f64)>);
        for at in 0..v.len() {
            if self.excluded[at] {
                direction = 0.0;
            } else if v[at].abs() > rest {
                if v[at].signum() != direction {
                    direction = v[at].signum();
                    let turn = x[last..=at]
                        .iter()
                        .copied()
                        .fold(x[at], |a, b| if direction > 0.0 { a.min(b) } else { a.max(b) });
                    let before = (0..last).rev().take_while(|i| (x[*i] - turn).abs() < travel_m).count();
                    reversing[last.saturating_sub(before.max(around))..at].fill(true);
                    until = Some((at + around, turn));
                }
                last = at;
            }
            if let Some((time, turn)) = until {
                reversing[at] = true;
                if at >= time && (x[at] - turn).abs() >= travel_m {
                    until = None;
                }
            }
        }
        reversing
    }

    /// Returns length and period of each channel in sums over all channels: the force, then each extra point.
    pub fn channels(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        std::iter::repeat_n((self.load.len(), self.period), 1 + self.extra_channels.len())
    }
}

/// Computes the force equivalent to one unit of each column from the residuals of a fit, so that each channel
/// is weighted by its own noise.
///
/// `residuals` covers the channels of all motions, with their current weights.
pub fn weights(residuals: &[f64], motions: &[&MotionSignal]) -> BTreeMap<String, f64> {
    // Sum of squares and number of samples of the force, and of each column.
    let mut force = (0.0, 0usize);
    let mut columns: BTreeMap<String, (f64, usize)> = BTreeMap::new();
    let mut from = 0;
    let mut squares = |length: usize| {
        let part = &residuals[from..from + length];
        from += length;
        part.iter().map(|e| e * e).sum::<f64>()
    };
    for motion in motions {
        force.0 += squares(motion.load.len());
        force.1 += motion.is_moving.iter().filter(|m| **m).count();
        for channel in &motion.extra_channels {
            let sum = columns.entry(channel.column.clone()).or_default();
            sum.0 += squares(motion.load.len()) / (channel.weight * channel.weight);
            sum.1 += channel.is_used.iter().filter(|c| **c).count();
        }
    }
    let level = |(squares, count): (f64, usize)| (squares / count.max(1) as f64).sqrt();
    let found = columns.into_iter().map(|(column, sum)| (column, level(force) / level(sum)));
    found.filter(|(_, weight)| *weight > 0.0 && weight.is_finite()).collect()
}

/// Masks the samples of extra points at which a backlash of the machine is crossed. Returns whether any
/// sample was masked.
pub fn mask_backlash_crossings(
    motions: &mut [MotionSignal],
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
) -> bool {
    motions.iter_mut().fold(false, |any, motion| any | motion.mask_crossings(rigid, machine, values))
}

impl MotionSignal {
    /// Masks the samples of extra points at which a backlash of the machine is crossed. These are the samples
    /// at which the machine predicts a crossing, and those at which the reading changes by half the backlash
    /// within the filters' reach. If they exceed half of the used samples, only the predicted ones are
    /// masked, or none. Returns whether any sample was masked.
    fn mask_crossings(&mut self, rigid: &Rigid, machine: &Machine, values: &[f64]) -> bool {
        let Some(played) = rigid.backlash_error(machine, values, self) else { return false };
        let mut masked = false;
        for (at, played) in played.into_iter().enumerate() {
            let (low, high) = extremes(&played);
            let between = |place: &f64| {
                (low + CROSSING_MARGIN * (high - low)..high - CROSSING_MARGIN * (high - low)).contains(place)
            };
            let predicted = self.within_filter_reach(&played.iter().map(between).collect::<Vec<bool>>(), 0.0);
            let steps_above = self.steps_above(&self.extra_channels[at].error, 0.5 * (high - low));
            let channel = &mut self.extra_channels[at];
            let without = |crossed: &dyn Fn(usize) -> bool| -> Vec<bool> {
                channel.is_used.iter().enumerate().map(|(i, counts)| *counts && !crossed(i)).collect()
            };
            let count = |of: &[bool]| of.iter().filter(|counts| **counts).count();
            let kept = [without(&|i| predicted[i] || steps_above[i]), without(&|i| predicted[i])];
            let Some(kept) = kept.into_iter().find(|kept| 2 * count(kept) >= count(&channel.is_used)) else {
                continue;
            };
            masked |= kept != channel.is_used;
            channel.is_used = kept;
        }
        masked
    }

    /// Marks the samples around which a decimated column changes by more than `most` within the filters'
    /// reach.
    fn steps_above(&self, column: &[f64], most: f64) -> Vec<bool> {
        let around = (self.preprocessing.reach_s / self.decimated_step_s()).ceil() as usize;
        let near = |i: usize| &column[i.saturating_sub(around)..(i + around + 1).min(column.len())];
        (0..column.len()).map(|i| extremes(near(i))).map(|(low, high)| high - low > most).collect()
    }

    /// Sets the weights of the extra points.
    pub fn set_weights(&mut self, weights: &BTreeMap<String, f64>) {
        for channel in &mut self.extra_channels {
            channel.weight = weights.get(&channel.column).copied().unwrap_or(channel.weight);
        }
    }
}
