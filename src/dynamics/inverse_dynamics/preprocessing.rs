//! Preprocessing of a record: filtering, differentiation, decimation.

use super::error::InverseError;
use super::extra_channel::ExtraChannel;
use super::friction::sign;
use super::phase::{Phase, phases_along};
use measurement::MotionRecord;
use numeric::filter::{LowPass, central_differences, decimate};
use numeric::statistics::extremes;

/// Settings of filtering and decimation.
///
/// # Source  Gautier, Janot and co-workers for the EMPS records: Butterworth of order 4 at 100 Hz forward and
///   backward on the position, central
///   differences, the first samples dropped, a parallel decimation by 10 of all columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preprocessing {
    /// Cut-off frequency of the position filter (Hz).
    pub cutoff_hz: f64,
    /// Order of the position filter.
    pub order: usize,
    /// Number of samples dropped at the start.
    pub dropped: usize,
    /// Decimation factor: every n-th sample is kept.
    pub factor: usize,
}

/// Cut-off frequency (Hz) of the position filter, and its upper limit as a share of the sampling rate.
const CUTOFF_HZ: f64 = 100.0;
const CUTOFF_SHARE: f64 = 0.2;
/// Periods of the cut-off frequency that are dropped at the start.
const DROPPED_PERIODS: f64 = 5.0;

impl Preprocessing {
    /// Returns the default settings for a sampling step (s): at 1 kHz those of the source.
    pub fn default_for(step_s: f64) -> Self {
        let cutoff_hz = CUTOFF_HZ.min(CUTOFF_SHARE / step_s);
        let per_period = 1.0 / (cutoff_hz * step_s);
        Preprocessing {
            cutoff_hz,
            order: 4,
            dropped: ((DROPPED_PERIODS * per_period).round() as usize).saturating_sub(1),
            factor: (per_period.round() as usize).max(1),
        }
    }

    /// Returns the position filter for a sampling step (s).
    pub(super) fn low_pass(&self, step_s: f64) -> LowPass {
        LowPass::butterworth(self.order, 2.0 * self.cutoff_hz * step_s)
    }

    /// Smallest number of samples of a record.
    fn needed(&self) -> usize {
        self.dropped + 20 * self.factor.max(2) + 3 * 8 + 1
    }
}

/// The motion of a record, at the record's own rate.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionSignal {
    /// Name of the record.
    pub name: String,
    /// File of the record.
    pub source: String,
    /// Time between samples (s).
    pub step_s: f64,
    /// Index of the point whose position was recorded; `None` for that of the position loop's encoder.
    pub point: Option<usize>,
    /// Position (m), filtered.
    pub position_m: Vec<f64>,
    /// Velocity (m/s).
    pub velocity_m_s: Vec<f64>,
    /// Acceleration (m/s²).
    pub acceleration_m_s2: Vec<f64>,
    /// Command (m).
    pub command_m: Vec<f64>,
    /// Recorded force (N) or torque (N·m), decimated; 0 at rest.
    pub load: Vec<f64>,
    /// Whether the axis moves at each decimated sample. At rest friction takes any force up to its level, so
    /// that the force does not follow from the motion. Those samples, and 50 ms before and after, are masked.
    pub is_moving: Vec<bool>,
    /// Samples at the record's rate that are set to 0 before decimation, so that its filter does not spread
    /// them. The axis rests there, or has just reversed where extra points were recorded.
    pub excluded: Vec<bool>,
    /// Column of the record with the load.
    pub load_column: &'static str,
    /// Whether the recorded positions are angles (rad).
    pub is_angle: bool,
    /// Settings of the preprocessing.
    pub preprocessing: Preprocessing,
    /// Period of the command in decimated samples, if it repeats.
    pub period: Option<usize>,
    /// Readings of extra points of the machine.
    pub extra_channels: Vec<ExtraChannel>,
}

impl MotionSignal {
    /// Filters and differentiates a record.
    ///
    /// # Errors  the record is shorter than its filters need.
    pub fn new(record: &MotionRecord, recipe: Preprocessing) -> Result<Self, InverseError> {
        let short = || InverseError::Short {
            path: record.source.clone(),
            samples: record.samples(),
            needed: recipe.needed(),
        };
        if record.samples() < recipe.needed() {
            return Err(short());
        }
        let low_pass = recipe.low_pass(record.step_s);
        let position_m = low_pass.forward_backward(&record.position_m).ok_or_else(short)?;
        let slope =
            |x: &[f64]| central_differences(x).into_iter().map(|d| d / record.step_s).collect::<Vec<f64>>();
        let velocity_m_s = slope(&position_m);
        let acceleration_m_s2 = slope(&velocity_m_s);
        let mut motion = MotionSignal {
            name: record.name.clone(),
            source: record.source.clone(),
            step_s: record.step_s,
            point: None,
            position_m,
            velocity_m_s,
            acceleration_m_s2,
            command_m: record.command_m.clone(),
            load: Vec::new(),
            is_moving: Vec::new(),
            excluded: Vec::new(),
            load_column: record.load.column(),
            is_angle: record.is_angle,
            preprocessing: recipe,
            period: None,
            extra_channels: Vec::new(),
        };
        motion.excluded = phases(&motion).into_iter().map(|phase| phase == Phase::Dwell).collect();
        motion.is_moving =
            motion.within_filter_reach(&motion.excluded, 0.0).into_iter().map(|rests| !rests).collect();
        motion.load = motion.thinned(record.load.samples()).ok_or_else(short)?;
        motion.period = period(&record.command_m, recipe.factor);
        Ok(motion)
    }

    /// Returns the motion with the rests of another record of the same motion; `record` is the source of this
    /// motion.
    ///
    /// # Errors  as [`MotionSignal::new`].
    pub fn with_rests_of(
        mut self,
        other: &MotionSignal,
        record: &MotionRecord,
    ) -> Result<Self, InverseError> {
        (self.excluded, self.is_moving) = (other.excluded.clone(), other.is_moving.clone());
        let short = || InverseError::Short {
            path: record.source.clone(),
            samples: record.samples(),
            needed: self.preprocessing.needed(),
        };
        self.load = self.thinned(record.load.samples()).ok_or_else(short)?;
        Ok(self)
    }

    /// Decimates a column of the record's rate, without the dropped start; 0 where the axis rests.
    pub fn thinned(&self, column: &[f64]) -> Option<Vec<f64>> {
        self.thinned_all(&[column])?.pop()
    }

    /// As [`MotionSignal::thinned`], of several columns.
    pub(super) fn thinned_all(&self, columns: &[impl AsRef<[f64]>]) -> Option<Vec<Vec<f64>>> {
        let mut thinned = self.decimated_all(columns)?;
        for column in &mut thinned {
            column.iter_mut().zip(&self.is_moving).filter(|(_, moves)| !**moves).for_each(|(x, _)| *x = 0.0);
        }
        Some(thinned)
    }

    /// Decimates a column that is set to 0 at the excluded samples.
    pub(super) fn decimated(&self, column: &[f64]) -> Option<Vec<f64>> {
        self.decimated_all(&[column])?.pop()
    }

    /// As [`MotionSignal::decimated`], of several columns.
    pub(super) fn decimated_all<C: AsRef<[f64]>>(&self, columns: &[C]) -> Option<Vec<Vec<f64>>> {
        let masked = |column: &C| {
            let masked = column
                .as_ref()
                .iter()
                .zip(&self.excluded)
                .map(|(x, excluded)| if *excluded { 0.0 } else { *x });
            masked.skip(self.preprocessing.dropped).collect()
        };
        decimate(&columns.iter().map(masked).collect::<Vec<Vec<f64>>>(), self.preprocessing.factor)
    }

    /// Returns the sign of the velocity: 1, −1, or 0.
    pub fn direction(&self) -> Vec<f64> {
        self.velocity_m_s.iter().map(|v| sign(*v)).collect()
    }

    /// Whether the record has extra points that were measured in addition to the encoder.
    pub fn has_extra_points(&self) -> bool {
        self.extra_channels.iter().any(|f| f.encoder_estimate.is_none())
    }

    /// Masks the first and the last 50 ms, where the filters lack the samples outside the record.
    #[must_use]
    pub fn without_edges(mut self) -> Self {
        let edge = (FILTER_REACH_S / self.decimated_step_s()).ceil() as usize;
        let last = self.load.len();
        for at in (0..edge.min(last)).chain(last.saturating_sub(edge)..last) {
            self.is_moving[at] = false;
            self.load[at] = 0.0;
            self.extra_channels.iter_mut().for_each(|f| f.is_used[at] = false);
        }
        self
    }

    /// Marks the decimated samples within the filters' reach of the given samples of the record, or within a
    /// time (s) after them.
    pub(super) fn within_filter_reach(&self, some: &[bool], after_s: f64) -> Vec<bool> {
        let samples = |time_s: f64| (time_s / self.step_s).ceil() as usize;
        let (before, after) = (samples(FILTER_REACH_S), samples(FILTER_REACH_S.max(after_s)));
        let mut all = vec![false; some.len()];
        for at in (0..some.len()).filter(|at| some[*at]) {
            all[at.saturating_sub(before)..(at + after + 1).min(some.len())].fill(true);
        }
        self.kept().map(|at| all[at]).collect()
    }

    /// Returns the record's sample for each decimated one.
    pub fn kept(&self) -> impl Iterator<Item = usize> + '_ {
        let (dropped, factor, samples) =
            (self.preprocessing.dropped, self.preprocessing.factor, self.position_m.len());
        (dropped + (samples - dropped - 1) % factor..samples).step_by(factor)
    }

    /// Time between decimated samples (s).
    pub fn decimated_step_s(&self) -> f64 {
        self.step_s * self.preprocessing.factor as f64
    }
}

/// Returns the phase of each sample of a motion, at the record's rate.
pub fn phases(motion: &MotionSignal) -> Vec<Phase> {
    phases_along((&motion.velocity_m_s, &motion.acceleration_m_s2), &motion.command_m, motion.step_s)
}

/// Time around a rest (s) over which the filters spread its force.
pub(super) const FILTER_REACH_S: f64 = 0.05;

/// Share of a command's range within which two values are equal.
const REPEAT_TOLERANCE: f64 = 1e-6;

/// Finds the shortest period, in decimated samples, with which a command repeats at least twice within the
/// record.
fn period(command_m: &[f64], factor: usize) -> Option<usize> {
    let (low, high) = extremes(command_m);
    let tolerance = REPEAT_TOLERANCE * (high - low);
    if !(tolerance > 0.0) {
        return None;
    }
    let moves = |from: usize, to: usize| {
        command_m[from..to].iter().any(|x| (x - command_m[from]).abs() > 0.5 * (high - low))
    };
    (1..=command_m.len() / (2 * factor)).find(|&thinned| {
        let shift = thinned * factor;
        moves(0, shift) && command_m.iter().zip(&command_m[shift..]).all(|(a, b)| (a - b).abs() <= tolerance)
    })
}
