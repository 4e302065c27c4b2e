//! Readings of an extra point of a machine, and the encoder position reconstructed from the loops.

use numeric::statistics::root_mean_square;

/// Reading of one extra point of a machine along a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraChannel {
    /// Index of the point.
    pub point: usize,
    /// Column of the record.
    pub column: String,
    /// Unit: m or rad.
    pub unit: &'static str,
    /// Transmission error, decimated: the reading less that of the rigid machine for the encoder's position.
    pub error: Vec<f64>,
    /// Command less reading, decimated, in the point's unit.
    pub tracking: Vec<f64>,
    /// Decimated columns that are projected out: a constant, the time, and the velocity of the encoder.
    pub projected_out: Vec<Vec<f64>>,
    /// Whether each decimated sample is used: the axis moves, and after the last reversal or rest backlash
    /// and wind-up have changed sides.
    pub is_used: Vec<bool>,
    /// Force (N or N·m) equivalent to one unit of the reading in a common sum of squares.
    pub weight: f64,
    /// Reconstruction of the encoder position from the loops, where it was not recorded.
    pub encoder_estimate: Option<EncoderEstimate>,
}

impl ExtraChannel {
    /// Returns the recorded transmission error, masked and weighted.
    pub fn recorded(&self) -> Vec<f64> {
        self.weighted_all(std::slice::from_ref(&self.error)).swap_remove(0)
    }

    /// Returns decimated columns, masked and weighted, without what is projected out.
    pub(super) fn weighted_all(&self, thinned: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let without = |mut x: Vec<f64>, basis: &[Vec<f64>]| {
            for unit in basis {
                let share: f64 = unit.iter().zip(&x).map(|(u, x)| u * x).sum();
                x.iter_mut().zip(unit).for_each(|(x, u)| *x -= share * u);
            }
            x
        };
        for column in &self.projected_out {
            let own = without(self.masked(column), &basis);
            let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-9 * column.iter().map(|x| x * x).sum::<f64>().sqrt() {
                basis.push(own.into_iter().map(|x| x / length).collect());
            }
        }
        let weighted = |column: &Vec<f64>| {
            without(self.masked(column), &basis).into_iter().map(|x| self.weight * x).collect()
        };
        thinned.iter().map(weighted).collect()
    }

    fn masked(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.is_used).map(|(x, counts)| if *counts { *x } else { 0.0 }).collect()
    }

    /// Computes the root mean square of the tracking error, command less reading, without its mean.
    pub fn tracking_rms(&self) -> f64 {
        let masked = || self.tracking.iter().zip(&self.is_used).filter(|(_, c)| **c).map(|(x, _)| *x);
        let mean = masked().sum::<f64>() / masked().count().max(1) as f64;
        root_mean_square(masked().map(|x| x - mean)).unwrap_or(0.0)
    }

    /// Whether the encoder position was not recorded, but follows from the loops.
    pub fn is_identifiable(&self) -> bool {
        self.encoder_estimate.is_some()
    }
}

/// Reconstruction of an encoder position from the loops.
#[derive(Debug, Clone, PartialEq)]
pub struct EncoderEstimate {
    /// k_p times the step of the record.
    pub(super) lag: f64,
    /// G·k_v·k_p (N/m).
    pub(super) stiffness: f64,
    /// Change of the reading (m) if the recorded force exceeds the loops' output by one standard deviation of
    /// their ratio, at the record's rate.
    pub factor_m: Vec<f64>,
    /// Periods of both loops (s).
    pub periods_s: f64,
}
