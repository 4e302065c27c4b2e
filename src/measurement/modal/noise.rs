//! Noise estimate of lines without given noise: first from the curve alone, then from the residual of the
//! fit.

use num_complex::Complex64;

use super::curve::CurveLines;
use super::model::ModalModel;

/// Smallest number of lines of a running estimate.
const WINDOW: usize = 41;
/// Lower bound on the relative standard deviation before a fit (1): it represents the misfit of a first
/// model.
const FIRST_FLOOR: f64 = 0.005;
/// Relative standard deviation below which residuals are rounding errors (1).
pub(super) const SD_FLOOR: f64 = 1e-7;
/// Lower bound on the standard deviation of a line, as a share of the overall one (1).
const LINE_FLOOR_SHARE: f64 = 0.2;
/// Median of a χ² variable with two degrees of freedom.
const MEDIAN_CHI2_2: f64 = 1.386_294_361_119_890_6;
/// Residuals beyond this many standard deviations are weighted down (Huber).
const OUTLIER: f64 = 4.0;

/// Estimates the relative standard deviation per component from the error of interpolating each line by a
/// cubic through four neighbours.
///
/// Noise-free curves give the lower bound of 0.5 % on all lines.
pub(super) fn from_curve(lines: &CurveLines) -> Vec<f64> {
    let n = lines.len();
    let mut squares = vec![0.0; n];
    for (at, square) in squares.iter_mut().enumerate() {
        let first = at.saturating_sub(2).min(n - 5);
        let x = lines.omega[at];
        let mut estimate = Complex64::ZERO;
        let mut variance = lines.h[at].norm_sqr();
        for i in (first..first + 5).filter(|i| *i != at) {
            let factor: f64 = (first..first + 5)
                .filter(|j| *j != at && *j != i)
                .map(|j| (x - lines.omega[j]) / (lines.omega[i] - lines.omega[j]))
                .product();
            estimate += lines.h[i] * factor;
            variance += factor * factor * lines.h[i].norm_sqr();
        }
        *square = (lines.h[at] - estimate).norm_sqr() / variance;
    }
    let local = running_median(&squares, WINDOW);
    let overall = median(local.clone()).max(FIRST_FLOOR * FIRST_FLOOR * MEDIAN_CHI2_2);
    local.iter().map(|s| ((s + overall) / MEDIAN_CHI2_2).sqrt()).collect()
}

/// Estimates the relative standard deviation per component from the residual of a model, as a running median
/// over the lines.
pub(super) fn from_residual(lines: &CurveLines, model: &ModalModel) -> Vec<f64> {
    let squares: Vec<f64> = relative(lines, model).iter().map(|e| e.norm_sqr()).collect();
    let window = WINDOW.max(lines.len() / 12);
    let overall = median(squares.clone());
    running_median(&squares, window)
        .iter()
        .map(|s| (s.max(LINE_FLOOR_SHARE * LINE_FLOOR_SHARE * overall) / MEDIAN_CHI2_2).sqrt().max(SD_FLOOR))
        .collect()
}

/// Returns the weights 1/(s·|Ĥ|) of the next fit. They use |Ĥ| of the model instead of |H|, so that noise
/// does not affect its own weight.
///
/// Lines far from the model are weighted down (Huber), and |Ĥ| is kept within a factor of 4 of |H|.
pub(super) fn weights(lines: &CurveLines, sd: &[f64], model: Option<&ModalModel>) -> Vec<f64> {
    let size = |line: usize| {
        let measured = lines.h[line].norm();
        let Some(model) = model else { return (measured, 1.0) };
        let fitted = model.at(lines.omega[line]);
        let deviation = (fitted - lines.h[line]).norm() / (sd[line] * fitted.norm().max(measured));
        (fitted.norm().clamp(0.25 * measured, 4.0 * measured), (OUTLIER / deviation).min(1.0).sqrt())
    };
    (0..lines.len()).map(size).zip(sd).map(|((size, share), sd)| share / (sd * size)).collect()
}

/// Returns (Ĥ − H)/|Ĥ|, with |Ĥ| kept within a factor of 4 of |H|.
fn relative(lines: &CurveLines, model: &ModalModel) -> Vec<Complex64> {
    let relative_error = |(omega, h): (&f64, &Complex64)| {
        let fitted = model.at(*omega);
        (fitted - h) / fitted.norm().clamp(0.25 * h.norm(), 4.0 * h.norm())
    };
    lines.omega.iter().zip(&lines.h).map(relative_error).collect()
}

/// Returns the root mean square of |Ĥ − H|/|H| (1), and the correlation of neighbouring weighted residuals
/// (1).
pub(super) fn misfit(lines: &CurveLines, model: &ModalModel, weight: &[f64]) -> (f64, f64) {
    let residual: Vec<Complex64> = lines
        .omega
        .iter()
        .zip(&lines.h)
        .zip(weight)
        .map(|((omega, h), w)| (model.at(*omega) - h) * w)
        .collect();
    let squares: f64 = residual.iter().map(|e| e.norm_sqr()).sum();
    let neighbours: f64 = residual.windows(2).map(|e| (e[0] * e[1].conj()).re).sum();
    let relative: f64 =
        lines.omega.iter().zip(&lines.h).map(|(omega, h)| ((model.at(*omega) - h) / h).norm_sqr()).sum();
    ((relative / lines.len() as f64).sqrt(), if squares > 0.0 { neighbours / squares } else { 0.0 })
}

/// Returns the median of the values; 0 without values.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// Returns the median over a window around each value, computed at steps of an eighth of the window and
/// interpolated linearly.
fn running_median(values: &[f64], window: usize) -> Vec<f64> {
    let window = window.min(values.len());
    let step = (window / 8).max(1);
    let mut knots: Vec<usize> = (0..values.len()).step_by(step).collect();
    if knots.last() != Some(&(values.len() - 1)) {
        knots.push(values.len() - 1);
    }
    let at_knot: Vec<f64> = knots
        .iter()
        .map(|k| {
            let from = k.saturating_sub(window / 2).min(values.len() - window);
            median(values[from..from + window].to_vec())
        })
        .collect();
    (0..values.len())
        .map(|at| {
            let next = knots.partition_point(|k| *k <= at).min(knots.len() - 1);
            let before = next.saturating_sub(1);
            let width = (knots[next] - knots[before]).max(1) as f64;
            let share = (at - knots[before]) as f64 / width;
            at_knot[before] * (1.0 - share) + at_knot[next] * share
        })
        .collect()
}
