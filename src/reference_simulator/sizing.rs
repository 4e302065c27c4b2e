//! The size at which an effect has a strength, or makes a gap.

use super::TruthError;

/// Enlarges an effect from the least to the largest size until `grown`, the gap over that without it, is about `ratio`: the size, and
/// what it gives.
pub fn enlarged(
    [least, largest]: [f64; 2],
    ratio: f64,
    trials: usize,
    mut grown: impl FnMut(f64) -> Result<f64, TruthError>,
) -> Result<(f64, f64), TruthError> {
    let mut size = least;
    let mut value = grown(size)?;
    for _ in 0..trials {
        if (value / ratio - 1.0).abs() < 0.05 || (value < ratio && size >= largest) {
            break;
        }
        // The added gap grows about in proportion to the size.
        let excess = (value * value - 1.0).max(0.01).sqrt();
        let factor = ((ratio * ratio - 1.0).sqrt() / excess).clamp(0.2, 6.0);
        let next = (size * factor.powf(0.8)).clamp(least, largest);
        if (next / size - 1.0).abs() < 1e-3 {
            break;
        }
        size = next;
        value = grown(size)?;
    }
    Ok((size, value))
}

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
