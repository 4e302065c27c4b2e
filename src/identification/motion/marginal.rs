//! Parameters of a force fit and their intervals, with the small print of friction and force as tolerances.
//!
//! Records with a repeating command enter as their mean over periods: a misfit that repeats is not reduced by
//! further periods. The recorded samples y are projected on the columns of parameters and tolerances, W =
//! Q·R. Their noise has the covariance Γ of the residual:
//!
//! ```text
//! u = Qᵀ·y = R·(β, γ) + Qᵀe        cov(Qᵀe) = Qᵀ·Γ·Q        γ ~ N(0, s²·Λ)
//! ```
//!
//! β is estimated by generalised least squares for each combination of the sizes s of the tolerances, and
//! averaged with the likelihood of that combination. Small tolerances that the records do not show hardly
//! widen the intervals; those that they show do.
//!
//! # Source  likelihood of variance components: Harville, Journal of the American Statistical Association 72
//!   (1977) 320–338, restricted maximum
//!   likelihood; the average over sizes in place of its maximum: Gelman, Bayesian Analysis 1 (2006) 515–534.

use nalgebra::{DMatrix, DVector};

use super::residual_noise::ResidualNoise;
use super::small_print::{SIZE_SD, SmallPrint, Tolerance};
use numeric::distribution::t_quantile_95;

/// Sizes of a kind of tolerance over the stated size.
const SIZES: [f64; 5] = [0.0, 0.1, 0.3, 1.0, 3.0];
/// Least independent share of a direction of the columns.
const INDEPENDENT: f64 = 1e-6;

/// One channel of the samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    /// Samples, and samples of the period with which they repeat.
    pub length: usize,
    pub period: Option<usize>,
    /// Mask of the samples.
    pub used: Vec<bool>,
}

/// Estimated size of a kind of tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToleranceSize {
    /// Kind.
    pub kind: SmallPrint,
    /// Size over the stated one; for a kind without estimated size its value over its standard deviation.
    pub value: f64,
    /// Standard deviation of `value`.
    pub sd: f64,
    /// Stated size: standard deviation of the delay (s), root mean square of the ripple, or standard
    /// deviation of friction (N or N·m).
    pub stated: f64,
}

/// Correction of a fit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marginal {
    /// Change of the parameters.
    pub change: DVector<f64>,
    /// Half widths of their 95 % intervals.
    pub half_widths: Vec<f64>,
    /// Estimated sizes of the tolerances.
    pub sizes: Vec<ToleranceSize>,
    /// Residual of parameters and tolerances, folded to one period.
    pub residual: DVector<f64>,
    /// Orthonormal columns of parameters and tolerances, folded.
    pub basis: DMatrix<f64>,
}

impl Marginal {
    /// Returns the size of the delay, if it is a tolerance.
    pub fn delay(&self) -> Option<ToleranceSize> {
        self.sizes.iter().copied().find(|size| size.kind == SmallPrint::Delay)
    }
}

/// Estimates the change of parameters with the given `columns` that explains a `residual`, next to
/// tolerances. `None` if the columns are dependent or the samples too few.
pub(super) fn marginal(
    columns: &DMatrix<f64>,
    residual: &DVector<f64>,
    tolerances: &[Tolerance],
    channels: &[Channel],
) -> Option<Marginal> {
    let count = columns.ncols();
    let all =
        DMatrix::from_fn(columns.nrows(), count + tolerances.len(), |i, j| match j.checked_sub(count) {
            None => columns[(i, j)],
            Some(at) => tolerances[at].force.get(i).copied().unwrap_or(0.0),
        });
    let (all, channels) = (folded(&all, channels), folded_channels(channels, residual));
    let y = DVector::from_iterator(all.nrows(), channels.iter().flat_map(|c| c.1.iter().copied()));
    let scale: Vec<f64> = all.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let qr = DMatrix::from_fn(all.nrows(), all.ncols(), |i, j| all[(i, j)] / scale[j]).qr();
    let small = qr.r().svd(true, true);
    let (u, v) = (small.u?, small.v_t?);
    let order: Vec<usize> = (0..small.singular_values.len())
        .filter(|i| small.singular_values[*i] > INDEPENDENT * small.singular_values.max())
        .collect();
    let basis = qr.q() * u.select_columns(&order);
    let mut reduced = DMatrix::from_fn(order.len(), all.ncols(), |i, j| {
        small.singular_values[order[i]] * v[(order[i], j)] * scale[j]
    });
    let projected = basis.tr_mul(&y);
    let left = &y - &basis * &projected;
    let mut covariance = DMatrix::zeros(order.len(), order.len());
    let mut freedom = 0.0;
    let mut from = 0;
    for (used, own) in &channels {
        let noise =
            ResidualNoise::new(left.rows(from, own.len()).as_slice(), used, &basis, (from, own.len()))?;
        let rows = basis.rows(from, own.len()).into_owned();
        covariance += rows.tr_mul(&noise.times(&rows));
        freedom += noise.freedom;
        from += own.len();
    }
    let covariance = 0.5 * (&covariance + covariance.transpose());
    let tolerance_columns = reduced.columns(count, tolerances.len()).into_owned();
    let parameters = reduced.columns_mut(0, count).into_owned();
    let kinds: Vec<SmallPrint> =
        SmallPrint::SIZED.into_iter().filter(|kind| tolerances.iter().any(|t| t.kind == *kind)).collect();
    let mut found: Vec<SizedFit> = Vec::new();
    for number in 0..SIZES.len().pow(kinds.len() as u32) {
        let sizes: Vec<f64> =
            (0..kinds.len()).map(|k| SIZES[number / SIZES.len().pow(k as u32) % SIZES.len()]).collect();
        let size_of = |t: &Tolerance| kinds.iter().position(|k| *k == t.kind).map_or(1.0, |k| sizes[k]);
        let weights: Vec<f64> = tolerances.iter().map(size_of).collect();
        let mut fit = SizedFit::new(&covariance, (&parameters, &tolerance_columns), &weights, &projected)?;
        fit.log_weight += sizes.iter().map(|s| -0.5 * (s / SIZE_SD).powi(2)).sum::<f64>();
        found.push(SizedFit { sizes, ..fit });
    }
    let best = found.iter().fold(f64::NEG_INFINITY, |m, f| m.max(f.log_weight));
    let total: f64 = found.iter().map(|f| (f.log_weight - best).exp()).sum();
    let mean = |of: &dyn Fn(&SizedFit) -> f64| {
        found.iter().map(|f| (f.log_weight - best).exp() / total * of(f)).sum::<f64>()
    };
    let change = DVector::from_fn(count, |i, _| mean(&|f| f.change[i]));
    let quantile = t_quantile_95(Some((freedom.floor() as usize).max(1)));
    let sd = |i: usize| mean(&|f| f.covariance[(i, i)] + (f.change[i] - change[i]).powi(2)).sqrt();
    let half_widths = (0..count).map(|i| quantile * sd(i)).collect();
    let mut sizes: Vec<ToleranceSize> = Vec::new();
    for (at, tolerance) in tolerances.iter().enumerate().filter(|(_, t)| !t.kind.is_sized()) {
        let value = mean(&|f| f.tolerances[at].0);
        let sd = mean(&|f| f.tolerances[at].1 + (f.tolerances[at].0 - value).powi(2)).sqrt();
        sizes.push(ToleranceSize { kind: tolerance.kind, value, sd, stated: tolerance.stated });
    }
    for (k, kind) in kinds.iter().enumerate() {
        let value = mean(&|f| f.sizes[k]);
        let sd = mean(&|f| (f.sizes[k] - value).powi(2)).sqrt();
        let of_kind = tolerances.iter().find(|t| t.kind == *kind);
        sizes.push(ToleranceSize { kind: *kind, value, sd, stated: of_kind.map_or(0.0, |t| t.stated) });
    }
    Some(Marginal { change, half_widths, sizes, residual: left, basis })
}

/// Generalised least squares at given sizes of the tolerances.
struct SizedFit {
    change: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Mean and variance of each tolerance, in its stated standard deviation.
    tolerances: Vec<(f64, f64)>,
    /// Sizes of the kinds of tolerance.
    sizes: Vec<f64>,
    /// Restricted log-likelihood of the sizes, plus the logarithm of their prior.
    log_weight: f64,
}

impl SizedFit {
    fn new(
        noise: &DMatrix<f64>,
        (parameters, tolerances): (&DMatrix<f64>, &DMatrix<f64>),
        weights: &[f64],
        projected: &DVector<f64>,
    ) -> Option<Self> {
        let mut weighted = tolerances.clone();
        weighted.column_iter_mut().zip(weights).for_each(|(mut column, weight)| column *= *weight);
        let lower = (noise + &weighted * weighted.transpose()).cholesky()?.unpack();
        let x = lower.solve_lower_triangular(parameters)?;
        let u = lower.solve_lower_triangular(projected)?;
        let normal = x.tr_mul(&x).cholesky()?;
        let change = normal.solve(&x.tr_mul(&u));
        let left = &u - &x * &change;
        let log_determinant = |l: &DMatrix<f64>| l.diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let log_weight = -log_determinant(&lower) - log_determinant(&normal.l()) - 0.5 * left.norm_squared();
        let covariance = normal.inverse();
        let z = lower.solve_lower_triangular(&weighted)?;
        let of = |column: DVector<f64>| {
            let shared = x.tr_mul(&column);
            (column.dot(&left), 1.0 - column.norm_squared() + shared.dot(&(&covariance * &shared)))
        };
        let tolerances = z.column_iter().map(|c| of(c.into_owned())).collect();
        Some(SizedFit { change, covariance, tolerances, sizes: Vec::new(), log_weight })
    }
}

/// Length of a channel after folding.
fn folded_length(channel: &Channel) -> usize {
    channel.period.unwrap_or(channel.length)
}

/// Averages the rows of each channel over its periods.
pub(super) fn folded(columns: &DMatrix<f64>, channels: &[Channel]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(channels.iter().map(folded_length).sum(), columns.ncols());
    let (mut from, mut to) = (0, 0);
    for channel in channels {
        let length = folded_length(channel);
        for i in 0..channel.length {
            let share = 1.0 / repeats(channel, i % length) as f64;
            for j in 0..columns.ncols() {
                all[(to + i % length, j)] += share * columns[(from + i, j)];
            }
        }
        from += channel.length;
        to += length;
    }
    all
}

/// Number of samples of a channel with the same phase.
fn repeats(channel: &Channel, phase: usize) -> usize {
    (channel.length - phase).div_ceil(folded_length(channel))
}

/// Averages mask and samples of each channel over its periods. A phase is used if half of its samples are.
fn folded_channels(channels: &[Channel], samples: &DVector<f64>) -> Vec<(Vec<bool>, Vec<f64>)> {
    let mut from = 0;
    let of = |channel: &Channel| {
        let length = folded_length(channel);
        let (mut used, mut mean) = (vec![0; length], vec![0.0; length]);
        for i in 0..channel.length {
            used[i % length] += usize::from(channel.used[i]);
            mean[i % length] += samples[from + i] / repeats(channel, i % length) as f64;
        }
        from += channel.length;
        (used.iter().enumerate().map(|(phase, used)| 2 * used >= repeats(channel, phase)).collect(), mean)
    };
    channels.iter().map(of).collect()
}
