//! Search for the size at which an effect has a given strength or a given gap.

use super::{Result, SimulatorError};

/// Searches between the least and the largest size until `gap_ratio` is about `ratio`, and returns the size
/// and its gap ratio. `gap_ratio` is the gap with the effect over the gap without it.
pub fn size_for_gap_ratio(
    [least, largest]: [f64; 2],
    ratio: f64,
    trials: usize,
    mut gap_ratio: impl FnMut(f64) -> Result<f64>,
) -> Result<(f64, f64)> {
    let mut size = least;
    let mut value = gap_ratio(size)?;
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
        value = gap_ratio(size)?;
    }
    Ok((size, value))
}

/// Returns the size for a wanted strength. The second of two effects may be weaker than drawn.
pub fn size_or_weaker(is_second: bool, wanted: f64, size_for: impl Fn(f64) -> Result<f64>) -> Result<f64> {
    match size_for(wanted) {
        Err(SimulatorError::TooWeak { reached, .. }) if is_second && reached > 0.2 * wanted => {
            size_for(0.9 * reached)
        }
        other => other,
    }
}

/// Settings of the search for a size, on a logarithmic scale.
#[derive(Clone, Copy, Debug)]
pub struct Sizing {
    /// First size; half the largest size where that is less.
    pub start: f64,
    /// Largest number of trials.
    pub trials: usize,
    /// Accepted deviation of ln(strength/wanted).
    pub close: f64,
    /// Longest step of ln(size), and the step down while no size is known to be too weak.
    pub steps: [f64; 2],
    /// Width of the bracket of ln(size) below which the strength counts as discontinuous.
    pub narrow: f64,
    /// Accepted deviation of ln(strength/wanted) at a discontinuity.
    pub leap: f64,
}

impl Sizing {
    /// Finds the size, at most `largest`, at which the effect has the strength `wanted`.
    ///
    /// The strength of a small effect grows with the square of its size. Where a step by that law leaves the
    /// bracket, the search bisects.
    pub fn size_for(
        &self,
        effect: &str,
        largest: f64,
        wanted: f64,
        strength: impl Fn(f64) -> Result<f64>,
    ) -> Result<f64> {
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
        Err(SimulatorError::TooWeak { effect: effect.to_owned(), reached, wanted })
    }
}
