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
    /// Decimation factor whose filter predicted and recorded force pass.
    pub band: usize,
    /// Decimation factor: every n-th of the filtered samples is kept.
    pub factor: usize,
    /// Time around rests (s) whose samples are not used: the filters spread the force of a rest.
    pub reach_s: f64,
}

/// Cut-off frequency (Hz) of the position filter, and its upper limit as a share of the sampling rate.
const CUTOFF_HZ: f64 = 100.0;
const CUTOFF_SHARE: f64 = 0.2;
/// Periods of the cut-off frequency that are dropped at the start.
const DROPPED_PERIODS: f64 = 5.0;
/// Time around a rest (s) whose samples are not used.
const FILTER_REACH_S: f64 = 0.05;
/// Least share of the moving samples that is used, and, of shorter moves, least number of them that decimation keeps.
const LEAST_USED: (f64, usize) = (0.5, 100);
/// Way (m, or rad at a radius of 0.1 m) beyond which friction has followed a reversal.
///
/// # Source  Dahl's friction has reversed by 1 − e^(−2·x/z), 99 % after 2.5 times the presliding length z, commonly 10 to
///   100 µm.
const SLIDING: (f64, f64) = (0.25e-3, 2.5e-3);
/// Ratio of the ways in both directions above which the shorter one is a rebound.
const REBOUND: f64 = 10.0;

impl Preprocessing {
    /// Returns the default settings for a sampling step (s): at 1 kHz those of the source.
    pub fn default_for(step_s: f64) -> Self {
        let cutoff_hz = CUTOFF_HZ.min(CUTOFF_SHARE / step_s);
        let per_period = 1.0 / (cutoff_hz * step_s);
        let factor = (per_period.round() as usize).max(1);
        Preprocessing {
            cutoff_hz,
            order: 4,
            dropped: ((DROPPED_PERIODS * per_period).round() as usize).saturating_sub(1),
            band: factor,
            factor,
            reach_s: FILTER_REACH_S,
        }
    }

    /// Returns the settings for short moves, of a motion of which the reach leaves less than half: those within a period
    /// of the cut-off are left out alone, where the filter has settled to 1 %.
    fn of_short_moves(self) -> Self {
        Preprocessing { reach_s: self.reach_s.min(1.0 / self.cutoff_hz), ..self }
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
    /// Filters and differentiates a record with the default settings, adapted to short moves.
    ///
    /// # Errors  as [`MotionSignal::new`].
    pub fn of(record: &MotionRecord) -> Result<Self, InverseError> {
        let recipe = Preprocessing::default_for(record.step_s);
        let motion = MotionSignal::new(record, recipe)?;
        if (motion.used() as f64) >= LEAST_USED.0 * motion.moving() as f64 {
            return Ok(motion);
        }
        let recipe = recipe.of_short_moves();
        let motion = MotionSignal::new(record, recipe)?;
        let factor = recipe.factor.min(motion.used() / LEAST_USED.1).max(1);
        MotionSignal::new(record, Preprocessing { factor, ..recipe })
    }

    /// Whether the axis slides forward, and backward.
    pub fn slides(&self) -> [bool; 2] {
        let used = || {
            self.kept().zip(&self.is_moving).filter(|(_, moves)| **moves).map(|(at, _)| self.velocity_m_s[at])
        };
        [used().any(|v| v > 0.0), used().any(|v| v < 0.0)]
    }

    /// Number of the record's samples at which the axis moves.
    pub fn moving(&self) -> usize {
        self.excluded.iter().skip(self.preprocessing.dropped).filter(|excluded| !**excluded).count()
    }

    /// Number of the record's samples that are used.
    pub fn used(&self) -> usize {
        self.preprocessing.factor * self.is_moving.iter().filter(|moves| **moves).count()
    }

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
        let rests = phases(&motion).into_iter().map(|phase| phase == Phase::Dwell);
        let rebounds = rebounds(&motion);
        motion.excluded = rests.zip(rebounds).map(|(rests, rebounds)| rests || rebounds).collect();
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
        decimate(
            &columns.iter().map(masked).collect::<Vec<Vec<f64>>>(),
            self.preprocessing.band,
            self.preprocessing.factor,
        )
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
        let edge = (self.preprocessing.reach_s / self.decimated_step_s()).ceil() as usize;
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
        let reach_s = self.preprocessing.reach_s;
        let (before, after) = (samples(reach_s), samples(reach_s.max(after_s)));
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

/// Marks the samples of a direction in which the axis rebounds only: friction does not follow its sign there, and says
/// nothing about this direction.
fn rebounds(motion: &MotionSignal) -> Vec<bool> {
    let direction = motion.direction();
    let mut longest = [0.0_f64; 2];
    for run in direction.chunk_by(|a, b| a == b).scan(0, |from, run| {
        *from += run.len();
        Some(*from - run.len()..*from)
    }) {
        let way = (motion.position_m[run.end - 1] - motion.position_m[run.start]).abs();
        let way_of = &mut longest[usize::from(direction[run.start] < 0.0)];
        *way_of = way_of.max(way);
    }
    let sliding = if motion.is_angle { SLIDING.1 } else { SLIDING.0 };
    let is_rebound = |own: f64, other: f64| own < sliding && REBOUND * own < other;
    let rebound = match longest {
        [forward, backward] if is_rebound(forward, backward) => 1.0,
        [forward, backward] if is_rebound(backward, forward) => -1.0,
        _ => return vec![false; direction.len()],
    };
    direction.into_iter().map(|sign| sign == rebound).collect()
}

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
