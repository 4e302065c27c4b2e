//! What a further point of a machine reads, and what the loops tell of it.

use numeric::statistics::root_mean_square;

/// What one further point of a machine reads along a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraChannel {
    /// The point (index).
    pub point: usize,
    /// Column it stood in.
    pub column: String,
    /// m or rad.
    pub unit: &'static str,
    /// Transmission error, thinned: the reading less that of the rigid machine for the encoder's position.
    pub error: Vec<f64>,
    /// Command less reading, thinned, in the point's unit.
    pub tracking: Vec<f64>,
    /// Thinned likewise: a constant, the time, and the velocity of the encoder.
    pub beside: Vec<Vec<f64>>,
    /// Whether each thinned sample counts: it moves, and is far enough from turns and rests for play and wind-up to be over to their side.
    pub counts: Vec<bool>,
    /// Force (N or N·m) that its unit weighs as much as, in sums of both.
    pub weight: f64,
    /// How the loops tell the encoder's side of it, where that was not recorded.
    pub told: Option<EncoderEstimate>,
}

impl ExtraChannel {
    /// The transmission error as recorded, as it counts.
    pub fn recorded(&self) -> Vec<f64> {
        self.weighed(&self.error)
    }

    pub(super) fn weighed(&self, thinned: &[f64]) -> Vec<f64> {
        let mut taken: Vec<Vec<f64>> = Vec::new();
        let without = |mut x: Vec<f64>, taken: &[Vec<f64>]| {
            for unit in taken {
                let share: f64 = unit.iter().zip(&x).map(|(u, x)| u * x).sum();
                x.iter_mut().zip(unit).for_each(|(x, u)| *x -= share * u);
            }
            x
        };
        for column in &self.beside {
            let own = without(self.counted(column), &taken);
            let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-9 * column.iter().map(|x| x * x).sum::<f64>().sqrt() {
                taken.push(own.into_iter().map(|x| x / length).collect());
            }
        }
        without(self.counted(thinned), &taken).into_iter().map(|x| self.weight * x).collect()
    }

    fn counted(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.counts).map(|(x, counts)| if *counts { *x } else { 0.0 }).collect()
    }

    /// Root mean square of what is tracked badly: command less reading, without its mean.
    pub fn tracking_rms(&self) -> f64 {
        let counted = || self.tracking.iter().zip(&self.counts).filter(|(_, c)| **c).map(|(x, _)| *x);
        let mean = counted().sum::<f64>() / counted().count().max(1) as f64;
        root_mean_square(counted().map(|x| x - mean)).unwrap_or(0.0)
    }

    /// Whether the encoder's side of it was not recorded, but follows from the loops.
    pub fn is_identifiable(&self) -> bool {
        self.told.is_some()
    }
}

/// What a loop tells of its encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct EncoderEstimate {
    /// k_p times the step of the record.
    pub(super) lag: f64,
    /// G·k_v·k_p (N/m).
    pub(super) stiffness: f64,
    /// Reading (m) where the force recorded is a standard deviation more than what the loops give, at the record's rate.
    pub factor_m: Vec<f64>,
    /// Periods of both loops (s).
    pub periods_s: f64,
}
