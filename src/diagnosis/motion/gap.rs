//! Gap between predicted and recorded force.

use super::residual_bootstrap::period_mean;
use dynamics::inverse_dynamics::{MotionSignal, Rigid, prediction};
use machine::Machine;

/// One record with its prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionPart {
    /// Name of the record.
    pub name: String,
    /// Column of the force or of the extra channel.
    pub column: String,
    /// Recorded force (N or N·m), thinned; for an extra channel its transmission error, weighted as force.
    pub recorded: Vec<f64>,
    /// Recorded less predicted values.
    pub residual: Vec<f64>,
    /// Samples after which the command repeats.
    pub period: Option<usize>,
    /// Time between samples (s).
    pub step_s: f64,
    /// Number of samples in the mask.
    pub samples: usize,
    /// Weight of a unit; 1 for the force.
    pub weight: f64,
    /// Root mean square of command less reading (m or rad) of an extra channel, without its mean.
    pub tracking: Option<f64>,
    /// Extra channels.
    pub extra_channels: Vec<MotionPart>,
}

impl MotionPart {
    /// Returns rms(recorded − predicted)/rms(recorded) over all channels.
    pub fn gap(&self) -> f64 {
        let sum = |of: fn(&MotionPart) -> &Vec<f64>| self.channels().map(|c| square(of(c))).sum::<f64>();
        sum(|c| &c.residual).sqrt() / sum(|c| &c.recorded).sqrt()
    }

    /// Returns the gap of this channel alone.
    pub fn own_gap(&self) -> f64 {
        square(&self.residual).sqrt() / square(&self.recorded).sqrt()
    }

    /// Returns the force and the extra channels.
    pub fn channels(&self) -> impl Iterator<Item = &MotionPart> {
        std::iter::once(self).chain(&self.extra_channels)
    }

    /// Returns the root mean square of this channel's residual, in its unit.
    pub fn residual_rms(&self) -> f64 {
        (square(&self.residual) / self.samples.max(1) as f64).sqrt() / self.weight
    }

    /// Returns rms(predicted − measured)/rms(measured) of the tracking error of an extra channel. The
    /// prediction is the encoder's position with the predicted transmission error.
    pub fn tracking_gap(&self) -> Option<f64> {
        self.tracking.filter(|t| *t > 0.0).map(|t| self.residual_rms() / t)
    }

    /// Returns the gap of this channel due to noise, where the command repeats: the non-repeating part of the
    /// residual.
    pub fn noise_floor(&self) -> Option<f64> {
        let noise = non_repeating(&self.residual, self.period?);
        Some(square(&noise).sqrt() / square(&self.recorded).sqrt())
    }
}

/// Returns all channels of records.
pub(super) fn flat(parts: &[MotionPart]) -> impl Iterator<Item = &MotionPart> {
    parts.iter().flat_map(MotionPart::channels)
}

pub(super) fn square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// Returns the non-repeating part of a residual, scaled for the mean that was removed.
pub(super) fn non_repeating(residual: &[f64], period: usize) -> Vec<f64> {
    let mean = period_mean(residual, period);
    let scale = (residual.len() as f64 / (residual.len() - period) as f64).sqrt();
    residual.iter().enumerate().map(|(i, e)| scale * (e - mean[i % period])).collect()
}

/// Predicts a record by a machine.
pub fn part(rigid: &Rigid, machine: &Machine, values: &[f64], motion: &MotionSignal) -> MotionPart {
    let predicted = prediction(rigid, machine, values, &[motion]);
    let mut channels = predicted.as_slice().chunks_exact(motion.load.len().max(1));
    let mut of = |column: &str, recorded: Vec<f64>| MotionPart {
        name: motion.name.clone(),
        column: column.into(),
        residual: recorded.iter().zip(channels.next().unwrap_or_default()).map(|(m, p)| m - p).collect(),
        recorded,
        period: motion.period,
        step_s: motion.decimated_step_s(),
        samples: motion.is_moving.iter().filter(|m| **m).count(),
        weight: 1.0,
        tracking: None,
        extra_channels: Vec::new(),
    };
    let force = of(motion.load_column, motion.load.clone());
    let further = motion.extra_channels.iter().map(|f| MotionPart {
        samples: f.is_used.iter().filter(|c| **c).count(),
        weight: f.weight,
        tracking: Some(f.tracking_rms()),
        ..of(&f.column, f.recorded())
    });
    MotionPart { extra_channels: further.collect(), ..force }
}

/// Returns the gap over several records.
pub fn gap_of(parts: &[MotionPart]) -> Option<f64> {
    let force: f64 = flat(parts).map(|p| square(&p.recorded)).sum();
    (force > 0.0).then(|| (flat(parts).map(|p| square(&p.residual)).sum::<f64>() / force).sqrt())
}
