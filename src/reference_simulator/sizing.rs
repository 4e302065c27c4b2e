//! The size at which an effect has a strength.

use super::TruthError;

/// How a size is looked for, on a logarithmic scale.
#[derive(Clone, Copy, Debug)]
pub struct Sizing {
    /// First size, unless half the largest is less.
    pub start: f64,
    /// Most trials.
    pub trials: usize,
    /// ln(strength/wanted) that is close enough.
    pub close: f64,
    /// Longest step of ln(size); and the one down while nothing too weak is known.
    pub steps: [f64; 2],
    /// Width of ln(size) at which a strength that leaps is no longer followed.
    pub narrow: f64,
    /// ln(strength/wanted) that is accepted beside a leap.
    pub leap: f64,
}

impl Sizing {
    /// The size, at most `largest`, at which `strength` is the one wanted of an effect.
    ///
    /// Strength grows with the square of a small effect; bisection where a step by that law leaves the bracket.
    pub fn size_for(
        &self,
        effect: &str,
        largest: f64,
        wanted: f64,
        strength: impl Fn(f64) -> Result<f64, TruthError>,
    ) -> Result<f64, TruthError> {
        let [longest, down] = self.steps;
        let (mut low, mut high) = (f64::NEG_INFINITY, largest.ln());
        let (mut trial, mut reached) = (self.start.min(0.5 * largest).ln(), 0.0);
        for _ in 0..self.trials {
            let value = strength(trial.exp())?;
            let error = (value / wanted).ln();
            if error.abs() < self.close {
                return Ok(trial.exp());
            }
            reached = if value > reached { value } else { reached };
            if error < 0.0 {
                low = trial;
            } else {
                high = trial;
            }
            if high - low < self.narrow {
                if error.abs() < self.leap {
                    return Ok(trial.exp());
                }
                break;
            }
            let next = trial - (0.5 * error).clamp(-longest, longest);
            trial = if next > low && next < high {
                next
            } else if low.is_finite() {
                0.5 * (low + high)
            } else {
                high - down
            };
        }
        Err(TruthError::TooWeak { effect: effect.to_owned(), reached, wanted })
    }
}
