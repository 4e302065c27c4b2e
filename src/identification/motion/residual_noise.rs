//! Noise of a residual as an autoregression, which states how the noise of neighbouring samples is
//! correlated.

use nalgebra::{DMatrix, DVector};

/// Autocovariance of the noise of one channel, and the degrees of freedom of its spectrum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ResidualNoise {
    /// Autocovariance by lag (samples), from lag 0 to the lag where it has decayed.
    pub autocovariance: Vec<f64>,
    /// Degrees of freedom of the power at low frequencies, whose relative variance is 4·p/n for n samples and
    /// order p.
    ///
    /// # Source  Berk, Annals of Statistics 2 (1974) 489–502.
    pub freedom: f64,
}

/// Largest order of the autoregression over log₁₀ of the number of samples.
///
/// # Source  the default of `ar` in R.
const ORDERS_PER_DECADE: f64 = 10.0;
/// White noise added to the autocovariance at lag 0, over that autocovariance. Decimation removes frequencies
/// above 80 % of the new half rate; without the white noise, the autoregression would spend most of its order
/// on this gap of the spectrum.
///
/// # Source  white noise correction: Makhoul, Proceedings of the IEEE 63 (1975) 561–580.
const WHITE_SHARE: f64 = 0.01;
/// Autocorrelation (1) below which the noise is uncorrelated.
const DECAYED: f64 = 1e-3;
/// Number of corrections for what the fit took from the residual.
const CORRECTIONS: usize = 2;

impl ResidualNoise {
    /// Estimates the noise from the residual of least squares.
    ///
    /// `basis` has orthonormal columns that span the fitted columns of all channels; `rows` are those of this
    /// channel, `used` its mask. `residual` is that of the channel; 0 where masked. A fit takes noise from
    /// the residual, most of it at the low frequencies of its columns: the expected loss Γ − R·Γ·R, R = I −
    /// Q·Qᵀ, is added to the autocovariance, and the noise is estimated anew.
    ///
    /// # Source  autoregressive estimates of long-run covariance with an order by Schwarz' criterion: den
    ///   Haan and Levin, A practitioner's guide to
    /// robust covariance matrix estimation, Handbook of Statistics 15 (1997) 299–342.
    pub fn new(residual: &[f64], used: &[bool], basis: &DMatrix<f64>, rows: (usize, usize)) -> Option<Self> {
        let count = used.iter().filter(|u| **u).count();
        let own = basis.rows(rows.0, rows.1).into_owned();
        let free = count as f64 - own.norm_squared();
        let orders = (ORDERS_PER_DECADE * (count.max(1) as f64).log10()) as usize;
        if free < 2.0 || residual.len() <= 2 * orders {
            return None;
        }
        let mask = DVector::from_iterator(used.len(), used.iter().map(|u| f64::from(u8::from(*u))));
        let pairs = lagged(&mask, &mask, orders);
        let residual = DVector::from_column_slice(residual);
        let squares = lagged(&residual, &residual, orders);
        let mut lost: Vec<f64> = squares.iter().map(|c| c * (count as f64 / free - 1.0)).collect();
        let mut found = None;
        for _ in 0..=CORRECTIONS {
            let length = residual.len() as f64;
            let autocovariance: Vec<f64> = (0..=orders)
                .map(|k| {
                    (squares[k] + lost[k]) / pairs[k].max(1.0)
                        * (1.0 - k as f64 / length)
                        * if k == 0 { 1.0 + WHITE_SHARE } else { 1.0 }
                })
                .collect();
            if !(autocovariance[0] > 0.0) {
                return None;
            }
            let noise = Self::autoregressive(&autocovariance, free, residual.len());
            let mut through = noise.times(&own);
            through
                .row_iter_mut()
                .zip(used)
                .filter(|(_, used)| !**used)
                .for_each(|(mut row, _)| row.fill(0.0));
            let taken = &own * own.tr_mul(&through);
            lost = vec![0.0; orders + 1];
            for j in 0..own.ncols() {
                let (q, g, t) = (
                    own.column(j).into_owned(),
                    through.column(j).into_owned(),
                    taken.column(j).into_owned(),
                );
                let terms = [lagged(&q, &g, orders), lagged(&g, &q, orders), lagged(&t, &q, orders)];
                (0..=orders).for_each(|k| lost[k] += terms[0][k] + terms[1][k] - terms[2][k]);
            }
            found = Some(noise);
        }
        found
    }

    /// Fits autoregressions of all orders by Levinson's recursion, and extends the autocovariance of the best
    /// by Schwarz' criterion.
    fn autoregressive(autocovariance: &[f64], samples: f64, length: usize) -> Self {
        let mut coefficients: Vec<f64> = Vec::new();
        let mut variance = autocovariance[0];
        let mut best = (samples * variance.ln(), Vec::new());
        for order in 1..autocovariance.len() {
            let predicted: f64 =
                coefficients.iter().enumerate().map(|(i, a)| a * autocovariance[order - 1 - i]).sum();
            let reflection = (autocovariance[order] - predicted) / variance;
            if !(reflection.abs() < 1.0) {
                break;
            }
            let reversed: Vec<f64> = coefficients.iter().rev().map(|a| reflection * a).collect();
            coefficients.iter_mut().zip(reversed).for_each(|(a, r)| *a -= r);
            coefficients.push(reflection);
            variance *= 1.0 - reflection * reflection;
            let criterion = samples * variance.ln() + samples.ln() * order as f64;
            if criterion < best.0 {
                best = (criterion, coefficients.clone());
            }
        }
        let coefficients = best.1;
        let mut extended: Vec<f64> = autocovariance[..=coefficients.len()].to_vec();
        let recent = |all: &[f64]| {
            all.iter().rev().take(coefficients.len().max(1)).fold(0.0_f64, |m, c| m.max(c.abs()))
        };
        while extended.len() < length
            && recent(&extended) > DECAYED * autocovariance[0]
            && !coefficients.is_empty()
        {
            let next = coefficients.iter().zip(extended.iter().rev()).map(|(a, c)| a * c).sum();
            extended.push(next);
        }
        let freedom = samples / (2.0 * coefficients.len().max(1) as f64);
        ResidualNoise { autocovariance: extended, freedom }
    }

    /// Multiplies the covariance matrix of the samples by columns.
    pub fn times(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let rows = columns.nrows();
        let mut product = columns * self.autocovariance[0];
        for (lag, covariance) in
            self.autocovariance.iter().enumerate().skip(1).take_while(|(lag, _)| *lag < rows)
        {
            for j in 0..columns.ncols() {
                let (from, mut to) = (columns.column(j), product.column_mut(j));
                to.rows_mut(lag, rows - lag).axpy(*covariance, &from.rows(0, rows - lag), 1.0);
                to.rows_mut(0, rows - lag).axpy(*covariance, &from.rows(lag, rows - lag), 1.0);
            }
        }
        product
    }
}

/// Computes Σ_t a_{t+k}·b_t for lags k up to `last`.
fn lagged(a: &DVector<f64>, b: &DVector<f64>, last: usize) -> Vec<f64> {
    let length = a.len();
    (0..=last).map(|k| a.rows(k, length - k).dot(&b.rows(0, length - k))).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use numeric::random::normal;

    /// The long-run variance of an autoregression of order one is σ²·(1 + φ)/(1 − φ), although a fitted mean
    /// and trend took from the residual.
    #[test]
    fn limit_long_run_variance_of_an_autoregression() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
        let (samples, colour, draws) = (600, 0.8, 60);
        let columns =
            DMatrix::from_fn(samples, 2, |i, j| if j == 0 { 1.0 } else { i as f64 / samples as f64 - 0.5 });
        let basis = columns.qr().q();
        let mut mean = 0.0;
        for _ in 0..draws {
            let mut state = normal(&mut random);
            let noise = DVector::from_fn(samples, |_, _| {
                state = colour * state + (1.0_f64 - colour * colour).sqrt() * normal(&mut random);
                state
            });
            let residual = &noise - &basis * basis.tr_mul(&noise);
            let found =
                ResidualNoise::new(residual.as_slice(), &vec![true; samples], &basis, (0, samples)).unwrap();
            mean += (2.0 * found.autocovariance.iter().sum::<f64>() - found.autocovariance[0]) / draws as f64;
        }
        let expected = (1.0 + colour) / (1.0 - colour);
        assert!((mean / expected - 1.0).abs() < 0.1, "{mean} for {expected}");
    }
}
