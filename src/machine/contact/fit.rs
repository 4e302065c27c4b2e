//! Fit of a Stribeck curve to friction measured at constant velocities.

use super::error::positive;
use super::interval::{self, Free};
use super::projection::{non_negative, unbounded};
use super::{ContactError, ParameterEstimate, ParameterInterval, StribeckCurve};
use numeric::distribution::t_quantile_95;

/// Reduction of the squares by signs that no Stribeck curve has, over the residual variance and the square of
/// Student's t, above which the runs contradict the curve (1): v_s and several signs are chosen.
const CONTRADICTION: f64 = 3.0;

/// Parameters of the curve.
const PARAMETERS: usize = 4;

/// One run at constant velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Velocity (m/s), of either sign.
    pub velocity_m_per_s: f64,
    /// Friction (N) with the sign of the velocity; [`super::ScrewDrive::force_n`] converts a torque.
    pub force_n: f64,
    /// Standard deviation (N), if known.
    pub sd_n: Option<f64>,
}

/// Model of the measurement noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StribeckNoise {
    /// Equal standard deviation in all observations, estimated from the residuals.
    Uniform,
    /// Standard deviation proportional to the friction, estimated from the residuals.
    Proportional,
    /// Given standard deviation of each observation.
    Known,
}

/// Options of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckOptions {
    /// Model of the measurement noise.
    pub noise: StribeckNoise,
    /// Search range of v_s (m/s); by default half the smallest to the largest measured speed.
    pub stribeck_range_m_per_s: Option<(f64, f64)>,
}

impl StribeckOptions {
    /// Returns the options with the default range and this noise.
    pub fn new(noise: StribeckNoise) -> StribeckOptions {
        StribeckOptions { noise, stribeck_range_m_per_s: None }
    }
}

/// A fitted curve with the uncertainty of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckFit {
    /// The best curve.
    pub curve: StribeckCurve,
    /// F_c (N).
    pub coulomb_n: ParameterEstimate,
    /// F_s (N).
    pub static_n: ParameterEstimate,
    /// d (N·s/m).
    pub viscous_n_s_per_m: ParameterEstimate,
    /// v_s (m/s).
    pub stribeck_velocity_m_per_s: ParameterEstimate,
    /// Scatter of the residuals: in N for [`StribeckNoise::Uniform`], relative for
    /// [`StribeckNoise::Proportional`]. For
    /// [`StribeckNoise::Known`] it is relative to the given standard deviations and should be near 1.
    pub residual_scatter: f64,
    /// Number of observations minus number of free parameters.
    pub degrees_of_freedom: usize,
    /// The curve with F_s < F_c or d < 0 that explains the runs where no Stribeck curve does.
    pub contradicted: Option<StribeckCurve>,
}

/// Fits F_c, F_s ≥ F_c, d ≥ 0 and v_s in its range by least squares, with 95 % intervals.
///
/// For a given v_s the curve is linear in (F_c, F_s − F_c, d). These three follow exactly (see `projection`),
/// and the residual sum of squares is a function of v_s alone. It is scanned over ln v_s, and its lowest
/// minima are refined by golden section. The fit therefore needs no start value and does not stop at a local
/// minimum. Noise proportional to the friction is weighted by the previously fitted friction, iteratively.
///
/// Intervals are Student's t times the linearised standard error, that of v_s in the logarithm; the normal
/// quantile with known standard deviations.
///
/// # Units      velocities m/s, forces N
/// # Limits     noise-free data reproduce their curve (test `recover_without_noise`)
/// # Errors     fewer than five observations or four different speeds, numbers that are not finite, a run at
///   rest, a missing
/// or non-positive standard deviation, forces that oppose their velocities, an empty range of v_s
/// # Source     Duan, Eq. 11, Tab. 2 («nonlinear identification», method not stated); Golub and Pereyra, SIAM
///   J. Numer. Anal. 10 (1973)
/// 413–432 for the projection.
pub fn fit_stribeck(
    observations: &[Observation],
    options: &StribeckOptions,
) -> Result<StribeckFit, ContactError> {
    let range = check(observations, options)?;
    let largest_n = observations.iter().fold(0.0_f64, |most, row| most.max(row.force_n.abs()));
    // Friction and speed without their common sign.
    let mut rows: Vec<(f64, f64, f64)> = observations
        .iter()
        .map(|row| {
            let sd = match options.noise {
                StribeckNoise::Uniform => 1.0,
                StribeckNoise::Proportional => row.force_n.abs().max(1e-3 * largest_n),
                StribeckNoise::Known => row.sd_n.unwrap_or(1.0),
            };
            (row.velocity_m_per_s.abs(), row.force_n * row.velocity_m_per_s.signum(), 1.0 / (sd * sd))
        })
        .collect();
    let mut best = search(&rows, range, non_negative);
    if options.noise == StribeckNoise::Proportional {
        for _ in 0..8 {
            let previous = best.curve;
            for (speed, _, weight) in &mut rows {
                *weight = previous.force_n(*speed).max(1e-3 * largest_n).powi(-2);
            }
            best = search(&rows, range, non_negative);
            if (best.curve.stribeck_velocity_m_per_s / previous.stribeck_velocity_m_per_s - 1.0).abs() < 1e-7
                && (best.curve.coulomb_n - previous.coulomb_n).abs() < 1e-9 * largest_n
            {
                break;
            }
        }
    }
    let contradicted = contradiction(&best, &rows, range, options.noise);
    Ok(StribeckFit { contradicted, ..with_intervals(&best, &rows, range, options.noise) })
}

/// Returns the curve with coefficients of either sign where it fits significantly better (F test).
fn contradiction(
    best: &StribeckCandidate,
    rows: &[(f64, f64, f64)],
    range: (f64, f64),
    noise: StribeckNoise,
) -> Option<StribeckCurve> {
    let StribeckCandidate { curve, squares: free } = search(rows, range, unbounded);
    let degrees_of_freedom = rows.len() - PARAMETERS;
    let level = match noise {
        StribeckNoise::Known => t_quantile_95(None).powi(2),
        StribeckNoise::Uniform | StribeckNoise::Proportional => {
            t_quantile_95(Some(degrees_of_freedom)).powi(2) * free / degrees_of_freedom as f64
        }
    };
    // Rounding: without noise both are exact.
    let rounding = 1e-18 * rows.iter().map(|(_, force, weight)| weight * force * force).sum::<f64>();
    (best.squares - free > CONTRADICTION * level + rounding).then_some(curve)
}

/// Checks the data and returns the range of v_s.
fn check(observations: &[Observation], options: &StribeckOptions) -> Result<(f64, f64), ContactError> {
    for (row, observation) in observations.iter().enumerate() {
        let sd = observation.sd_n.unwrap_or(1.0);
        if !(observation.velocity_m_per_s.is_finite() && observation.force_n.is_finite() && sd.is_finite()) {
            return Err(ContactError::NonFiniteData { row });
        }
        if observation.velocity_m_per_s == 0.0 {
            return Err(ContactError::ZeroVelocity { row });
        }
        if !(sd > 0.0) {
            return Err(ContactError::StandardDeviation { row, value: sd });
        }
        if options.noise == StribeckNoise::Known && observation.sd_n.is_none() {
            return Err(ContactError::MissingStandardDeviation { row });
        }
    }
    if observations.len() <= PARAMETERS {
        return Err(ContactError::TooFewData { found: observations.len(), needed: PARAMETERS + 1 });
    }
    let mut speeds: Vec<f64> = observations.iter().map(|row| row.velocity_m_per_s.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    let (least, most) = (speeds[0], speeds[speeds.len() - 1]);
    // Set points, not readings: speeds that differ by less than 1e-6 come from the same command.
    speeds.dedup_by(|next, kept| *next <= *kept * (1.0 + 1e-6));
    if speeds.len() < PARAMETERS {
        return Err(ContactError::TooFewSpeeds { found: speeds.len(), needed: PARAMETERS });
    }
    let along: f64 = observations.iter().map(|row| row.force_n * row.velocity_m_per_s.signum()).sum();
    if !(along > 0.0) {
        return Err(ContactError::OpposingForces);
    }
    let (lower, upper) = options.stribeck_range_m_per_s.unwrap_or((0.5 * least, most));
    positive("the lower end of the range of the Stribeck velocity (m/s)", lower)?;
    positive("the upper end of the range of the Stribeck velocity (m/s)", upper)?;
    if lower < upper { Ok((lower, upper)) } else { Err(ContactError::EmptyRange { lower, upper }) }
}

/// A curve and its weighted sum of squares.
#[derive(Clone, Copy)]
struct StribeckCandidate {
    curve: StribeckCurve,
    squares: f64,
}

/// Least squares in (F_c, F_s − F_c, d), with or without bounds.
type Solve = fn(&[([f64; 3], f64, f64)]) -> ([f64; 3], f64);

/// Returns the best curve for a given ln v_s.
fn project(
    rows: &[(f64, f64, f64)],
    scratch: &mut Vec<([f64; 3], f64, f64)>,
    log_velocity: f64,
    solve: Solve,
) -> StribeckCandidate {
    let velocity = log_velocity.exp();
    scratch.clear();
    scratch.extend(rows.iter().map(|&(speed, force, weight)| {
        ([1.0, (-(speed / velocity) * (speed / velocity)).exp(), speed], force, weight)
    }));
    let ([coulomb_n, excess_n, viscous_n_s_per_m], squares) = solve(scratch);
    let curve = StribeckCurve {
        coulomb_n,
        static_n: coulomb_n + excess_n,
        viscous_n_s_per_m,
        stribeck_velocity_m_per_s: velocity,
    };
    StribeckCandidate { curve, squares }
}

/// Returns the best curve over the range of v_s: a scan at 24 points per decade with refinement of its three
/// lowest minima.
fn search(rows: &[(f64, f64, f64)], (lower, upper): (f64, f64), solve: Solve) -> StribeckCandidate {
    let mut scratch = Vec::with_capacity(rows.len());
    let (from, to) = (lower.ln(), upper.ln());
    let count = ((to - from) / std::f64::consts::LN_10 * 24.0).ceil().clamp(8.0, 2000.0) as usize;
    let at =
        |index: usize| if index == count { to } else { from + (to - from) * index as f64 / count as f64 };
    let scan: Vec<StribeckCandidate> =
        (0..=count).map(|index| project(rows, &mut scratch, at(index), solve)).collect();
    let level = |index: usize| scan[index].squares;
    let mut minima: Vec<usize> = (0..=count)
        .filter(|&index| {
            (index == 0 || level(index) <= level(index - 1))
                && (index == count || level(index) <= level(index + 1))
        })
        .collect();
    minima.sort_by(|a, b| level(*a).total_cmp(&level(*b)));
    let mut best = scan[minima.first().copied().unwrap_or(0)];
    for &minimum in minima.iter().take(3) {
        let ends = (at(minimum.saturating_sub(1)), at((minimum + 1).min(count)));
        let refined = golden(ends, |log_velocity| project(rows, &mut scratch, log_velocity, solve));
        if refined.squares < best.squares {
            best = refined;
        }
    }
    best
}

/// Returns the lowest point of one minimum by golden section.
fn golden(
    (mut low, mut high): (f64, f64),
    mut project: impl FnMut(f64) -> StribeckCandidate,
) -> StribeckCandidate {
    let section = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left_at, mut right_at) = (high - section * (high - low), low + section * (high - low));
    let (mut left, mut right) = (project(left_at), project(right_at));
    while high - low > 1e-9 {
        if left.squares <= right.squares {
            (high, right_at, right) = (right_at, left_at, left);
            left_at = high - section * (high - low);
            left = project(left_at);
        } else {
            (low, left_at, left) = (left_at, right_at, right);
            right_at = low + section * (high - low);
            right = project(right_at);
        }
    }
    if left.squares <= right.squares { left } else { right }
}

/// Computes scatter and intervals of the best curve.
fn with_intervals(
    best: &StribeckCandidate,
    rows: &[(f64, f64, f64)],
    (lower, upper): (f64, f64),
    noise: StribeckNoise,
) -> StribeckFit {
    let curve = best.curve;
    let velocity = curve.stribeck_velocity_m_per_s;
    let falls = curve.static_n > curve.coulomb_n;
    let inside = falls && velocity > lower * (1.0 + 1e-6) && velocity < upper * (1.0 - 1e-6);
    let free: Free = [curve.coulomb_n > 0.0, falls, curve.viscous_n_s_per_m > 0.0, inside];
    let degrees_of_freedom = rows.len() - free.iter().filter(|free| **free).count();
    let residual_scatter = (best.squares / degrees_of_freedom as f64).sqrt();
    let half = match noise {
        StribeckNoise::Known => t_quantile_95(None),
        StribeckNoise::Uniform | StribeckNoise::Proportional => {
            t_quantile_95(Some(degrees_of_freedom)) * residual_scatter
        }
    };
    let errors =
        interval::standard_errors(&curve, rows.iter().map(|&(speed, _, weight)| (speed, weight)), free);
    let estimate =
        |index: usize, value: f64, interval: fn(f64, f64) -> ParameterInterval| ParameterEstimate {
            value,
            interval_95: errors[index].map(|error| interval(value, half * error)),
            at_bound: !free[index],
        };
    StribeckFit {
        curve,
        coulomb_n: estimate(0, curve.coulomb_n, interval::symmetric),
        static_n: estimate(1, curve.static_n, interval::symmetric),
        viscous_n_s_per_m: estimate(2, curve.viscous_n_s_per_m, interval::symmetric),
        stribeck_velocity_m_per_s: estimate(3, velocity, interval::in_logarithm),
        residual_scatter,
        degrees_of_freedom,
        contradicted: None,
    }
}

#[cfg(test)]
mod tests;
