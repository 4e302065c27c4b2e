//! Noise of FRFs that state none, estimated from neighbouring lines or from repeated measurements.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::frf::{Frf, FrfLine, FrfNoise};
use numeric::statistics::median;

/// Number of lines to either side of the middle of a window in which the variance components are constant.
const HALF_WINDOW: usize = 40;
/// Number of lines between the middles of neighbouring windows.
const WINDOW_STEP: usize = 20;
/// Least number of differences in a window: the standard deviation of eight overlapping ones scatters by a
/// third.
const LEAST_SAMPLES: usize = 8;
/// Ratio of a squared difference to its expectation at which it is cut (1): 5 % of the differences of normal
/// noise exceed it.
const CUT: f64 = 3.0;
/// Largest number of multiplicative updates of the variance components.
const UPDATES: usize = 60;
/// Largest relative change by an update at which the components have settled (1): far below their scatter.
const SETTLED: f64 = 3e-3;
/// Largest standard deviation of one component of ln H (1). A line with more noise carries no information.
const LARGEST_SD: f64 = 1.0;
/// Smallest variance of one component of ln H (1): rounding of the logarithm.
const LEAST_VARIANCE: f64 = 1e-24;

/// Variance components: equal share of |H|, equal power of the response, curvature of ln H.
const COMPONENTS: usize = 3;

/// A squared difference of lines with the expectation of each variance component at unit size.
struct Sample {
    /// Position in the record (index of a line).
    at: f64,
    /// Estimate of the variance of one component of ln H.
    square: f64,
    share: [f64; COMPONENTS],
}

/// Estimates the noise of the FRFs that state none and attaches it to their lines.
///
/// Repeated measurements have the same points, quantity and condition. Their spread about their mean is the
/// noise. Without repeats it is the third difference of ln H over four neighbouring lines: the residual of a
/// local polynomial of second order, with the phase unwrapped.
///
/// The variance of one component of ln H is the sum of three parts: a² (noise in proportion to |H|), b²/|H|²
/// (noise of the response, which is largest at antiresonances), and the square of the third difference by
/// curvature. A single pole or zero at a distance 1/g of lines has the slope g and the third derivative 2g³,
/// so the slope of ln H predicts the last part up to a factor. Only the first two parts are noise. The three
/// factors are constant over a window of lines and are estimated from its differences.
///
/// # Limits  noise correlated between neighbouring lines, as by a window or zero padding, is estimated too
///   low or too high by that correlation.
///
/// # Source  Pintelon and Schoukens, System Identification (2012), chapter 7: noise from the residual of
///   local polynomials. Maximum likelihood of
/// squared normal differences with a sum of variances: Févotte, Bertin and Durrieu, Neural Comput. 21 (2009)
/// 793–830, multiplicative updates.
pub(super) fn estimate_unstated_noise(frfs: &mut [Frf]) {
    let unstated: Vec<usize> =
        (0..frfs.len()).filter(|at| frfs[*at].lines.iter().all(|line| line.noise.is_none())).collect();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &at in &unstated {
        match groups.iter_mut().find(|group| is_repeat(&frfs[at], &frfs[group[0]])) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    let mut found: Vec<(usize, Vec<FrfNoise>)> = Vec::new();
    for group in groups {
        let repeats: Vec<&Frf> = group.iter().map(|at| &frfs[*at]).collect();
        let spread = spread(&repeats);
        for &at in &group {
            let frf = &frfs[at];
            let shape = response_shape(frf);
            let noise = if spread.len() >= LEAST_SAMPLES {
                smooth(&shape, &samples_of(frf, &shape, &spread), group.len() - 1)
                    .map(|sds| sds.into_iter().map(FrfNoise::Repeats).collect())
            } else {
                smooth(&shape, &third_differences(frf, &shape), 1)
                    .map(|sds| sds.into_iter().map(FrfNoise::Neighbours).collect())
            };
            found.extend(noise.map(|noise: Vec<FrfNoise>| (at, noise)));
        }
    }
    for (at, noise) in found {
        frfs[at].lines.iter_mut().zip(noise).for_each(|(line, noise)| line.noise = Some(noise));
    }
}

/// Warns of files whose coherence states nothing.
pub(super) fn single_average_warning(files: &[String]) -> Option<String> {
    let remedy = "that of a single average or a computed FRF; it counts as no statement of the noise; average several blows";
    (!files.is_empty()).then(|| format!("the coherence is 1 at every line, {remedy}: {}", files.join(", ")))
}

/// Drops a coherence of exactly 1 at every line, which a single average or a computed FRF has. Returns
/// whether it did.
pub(super) fn drop_coherence_of_one(lines: &mut [FrfLine]) -> bool {
    let is_one = lines.iter().all(|line| line.noise == Some(FrfNoise::Coherence(1.0)));
    if is_one {
        lines.iter_mut().for_each(|line| line.noise = None);
    }
    is_one
}

/// Whether two FRFs measure the same under the same condition.
fn is_repeat(a: &Frf, b: &Frf) -> bool {
    let key = |f: &Frf| (f.position, f.quantity, f.condition);
    key(a) == key(b) && a.response == b.response && a.excitation == b.excitation
}

/// Returns |H|⁻² of each line over its geometric mean: the shape of the variance by noise of the response.
fn response_shape(frf: &Frf) -> Vec<f64> {
    let logs: Vec<f64> = frf.lines.iter().map(|line| frf.receptance(line).norm().ln()).collect();
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    logs.iter().map(|log| (2.0 * (mean - log)).exp()).collect()
}

/// Returns the squared third differences of ln H over four neighbouring lines, unevenly spaced ones included.
fn third_differences(frf: &Frf, shape: &[f64]) -> Vec<Sample> {
    let logs = frf.logarithms();
    let frequency = |at: usize| frf.lines[at].frequency_hz;
    (0..frf.lines.len().saturating_sub(3))
        .map(|first| {
            let step = (frequency(first + 3) - frequency(first)) / 3.0;
            let x: [f64; 4] = std::array::from_fn(|i| (frequency(first + i) - frequency(first)) / step - 1.5);
            let divided: [f64; 4] =
                std::array::from_fn(|i| (0..4).filter(|j| *j != i).map(|j| 1.0 / (x[i] - x[j])).product());
            let norm = divided.iter().map(|c| c * c).sum::<f64>();
            let (mean, square) = (x.iter().sum::<f64>() / 4.0, x.iter().map(|x| x * x).sum::<f64>());
            let mut difference = Complex64::ZERO;
            let mut slope = Complex64::ZERO;
            let mut by_response = 0.0;
            for i in 0..4 {
                difference += logs[first + i] * divided[i];
                slope += logs[first + i] * ((x[i] - mean) / (square - 4.0 * mean * mean));
                by_response += divided[i] * divided[i] * shape[first + i];
            }
            Sample {
                at: first as f64 + 1.5,
                square: difference.norm_sqr() / (2.0 * norm),
                share: [1.0, by_response / norm, slope.norm().powi(6) / (18.0 * norm)],
            }
        })
        .collect()
}

/// Whether two lines have one frequency.
fn is_same(line: &FrfLine, frequency_hz: f64) -> bool {
    (line.frequency_hz - frequency_hz).abs() <= frequency_hz * 1e-9
}

/// Returns the frequencies (Hz) of the lines that all repeated measurements have, each with the variance of
/// one component of ln H about the mean. Empty for a single measurement.
fn spread(repeats: &[&Frf]) -> Vec<(f64, f64)> {
    let [first, _, ..] = repeats else { return Vec::new() };
    let mut next = vec![0; repeats.len()];
    let mut variances = Vec::new();
    let mut values = Vec::with_capacity(repeats.len());
    for line in &first.lines {
        values.clear();
        for (repeat, next) in repeats.iter().zip(&mut next) {
            while repeat
                .lines
                .get(*next)
                .is_some_and(|other| other.frequency_hz < line.frequency_hz * (1.0 - 1e-9))
            {
                *next += 1;
            }
            values.extend(
                repeat.lines.get(*next).filter(|other| is_same(other, line.frequency_hz)).map(|l| l.value),
            );
        }
        if values.len() < repeats.len() {
            continue;
        }
        // Logarithms relative to the first repeat lie about 0, so that no phase wraps.
        let reference = values[0];
        values.iter_mut().for_each(|value| *value = (*value / reference).ln());
        let mean = values.iter().sum::<Complex64>() / repeats.len() as f64;
        let square =
            values.iter().map(|r| (r - mean).norm_sqr()).sum::<f64>() / (2.0 * (repeats.len() - 1) as f64);
        debug_assert!(values.iter().all(|r| r.im.abs() <= PI));
        variances.push((line.frequency_hz, square));
    }
    variances
}

/// Returns the variances of repeated measurements as samples of one of them.
fn samples_of(frf: &Frf, shape: &[f64], variances: &[(f64, f64)]) -> Vec<Sample> {
    let mut lines = frf.lines.iter().enumerate();
    let of_line = |&(frequency_hz, square): &(f64, f64)| {
        let (at, _) = lines.find(|(_, line)| is_same(line, frequency_hz))?;
        Some(Sample { at: at as f64, square, share: [1.0, shape[at], 0.0] })
    };
    variances.iter().filter_map(of_line).collect()
}

/// Estimates the standard deviation of one component of ln H at each line; `None` with too few samples.
/// `freedom`: half the degrees of freedom of each squared difference.
fn smooth(shape: &[f64], samples: &[Sample], freedom: usize) -> Option<Vec<f64>> {
    if samples.len() < LEAST_SAMPLES {
        return None;
    }
    let count = shape.len();
    let middles: Vec<f64> = match count > 2 * HALF_WINDOW {
        false => vec![0.5 * count as f64],
        true => {
            let last = count - HALF_WINDOW;
            let steps = (last - HALF_WINDOW).div_ceil(WINDOW_STEP).max(1);
            (0..=steps)
                .map(|k| HALF_WINDOW as f64 + (last - HALF_WINDOW) as f64 * k as f64 / steps as f64)
                .collect()
        }
    };
    let windows: Vec<[f64; COMPONENTS]> = middles
        .iter()
        .map(|middle| {
            // Records with few common lines have windows as wide as needed.
            let mut half = (HALF_WINDOW + 1) as f64;
            loop {
                // Samples stand in the order of their lines.
                let from = samples.partition_point(|s| s.at - middle <= -half);
                let to = samples.partition_point(|s| s.at - middle < half);
                if to - from >= LEAST_SAMPLES {
                    return variance_components(&samples[from..to], freedom);
                }
                half *= 2.0;
            }
        })
        .collect();
    let variance = |window: usize, at: usize| windows[window][0] + windows[window][1] * shape[at];
    let sd = |at: usize| {
        let right = middles.partition_point(|middle| *middle < at as f64);
        let (left, right) = (right.saturating_sub(1), right.min(middles.len() - 1));
        let share =
            if left == right { 0.0 } else { (at as f64 - middles[left]) / (middles[right] - middles[left]) };
        let here = variance(left, at).max(LEAST_VARIANCE).powf(1.0 - share)
            * variance(right, at).max(LEAST_VARIANCE).powf(share);
        here.sqrt().min(LARGEST_SD)
    };
    Some((0..count).map(sd).collect())
}

/// Estimates the variance components of the samples of a window by maximum likelihood, with large squares
/// cut.
fn variance_components(samples: &[Sample], freedom: usize) -> [f64; COMPONENTS] {
    let middle = |of: &dyn Fn(&Sample) -> f64| median(samples.iter().map(of)).unwrap_or(0.0);
    let level = middle(&|s| s.square).max(LEAST_VARIANCE);
    let used: [bool; COMPONENTS] = std::array::from_fn(|i| samples.iter().any(|s| s.share[i] > 0.0));
    let mut components = [0.5 * level, 0.5 * level / middle(&|s| s.share[1]).max(f64::MIN_POSITIVE), 1.0];
    components.iter_mut().zip(used).filter(|(_, used)| !used).for_each(|(component, _)| *component = 0.0);
    let kept = mean_of_cut(freedom);
    for _ in 0..UPDATES {
        let (mut above, mut below) = ([0.0; COMPONENTS], [0.0; COMPONENTS]);
        for sample in samples {
            let expected =
                components.iter().zip(sample.share).map(|(c, s)| c * s).sum::<f64>().max(LEAST_VARIANCE);
            let ratio = (sample.square / expected).min(CUT) / kept;
            for i in 0..COMPONENTS {
                above[i] += ratio * sample.share[i] / expected;
                below[i] += sample.share[i] / expected;
            }
        }
        let mut change = 0.0_f64;
        for i in (0..COMPONENTS).filter(|i| below[*i] > 0.0) {
            components[i] *= above[i] / below[i];
            change = change.max((above[i] / below[i] - 1.0).abs());
        }
        if change < SETTLED {
            break;
        }
    }
    components
}

/// Returns the mean of min(x, [`CUT`]), where x has mean 1 and is χ² with 2·`freedom` degrees of freedom over
/// their number.
///
/// # Source  E[min(x, c)] = P(n + 1, nc) + c·(1 − P(n, nc)), with the incomplete gamma function P as a
///   Poisson sum for whole n.
fn mean_of_cut(freedom: usize) -> f64 {
    let scaled = freedom as f64 * CUT;
    // Poisson probability of fewer than n events: 1 − P(n, scaled).
    let fewer = |n: usize| {
        let (mut term, mut sum) = ((-scaled).exp(), 0.0);
        for k in 0..n {
            sum += term;
            term *= scaled / (k + 1) as f64;
        }
        sum
    };
    1.0 - fewer(freedom + 1) + CUT * fewer(freedom)
}

#[cfg(test)]
mod tests;
