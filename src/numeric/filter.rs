//! Zero-phase low-pass filters, run forward and backward over complete records.
//!
//! Second-order sections in the transposed direct form II. The crate sci-rs 0.4 lacks the Chebyshev design,
//! and other crates pad the record differently from the published evaluations used for comparison.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;

/// A digital low-pass filter of second-order sections.
#[derive(Debug, Clone, PartialEq)]
pub struct LowPass {
    /// b₀ b₁ b₂ a₁ a₂ of each section, a₀ = 1.
    sections: Vec<[f64; 5]>,
    order: usize,
}

impl LowPass {
    /// Designs a Butterworth filter; `cutoff` (−3 dB) as a share of half the sampling rate, between 0 and 1.
    ///
    /// # Source  poles e^{iπ(2k+n+1)/(2n)}, k = 0…n−1, prewarped and mapped by the bilinear transform s = (z
    ///   − 1)/(z + 1).
    pub fn butterworth(order: usize, cutoff: f64) -> Self {
        let pole = |k: usize| Complex64::cis(PI * (2 * k + order + 1) as f64 / (2 * order) as f64);
        Self::of_poles(order, cutoff, pole, 1.0)
    }

    /// Designs a Chebyshev filter of the first kind with `ripple_db` in the pass band, which ends at
    /// `cutoff`, a share of half the sampling rate.
    ///
    /// # Source  poles −sinh(asinh(1/ε)/n)·sin θₖ + i·cosh(asinh(1/ε)/n)·cos θₖ, θₖ = π(2k+1)/(2n), ε² =
    ///   10^(ripple/10) − 1; for even
    /// orders the gain at 0 Hz is the minimum of the ripple.
    pub fn chebyshev(order: usize, ripple_db: f64, cutoff: f64) -> Self {
        let epsilon = (10f64.powf(0.1 * ripple_db) - 1.0).sqrt();
        let a = (1.0 / epsilon).asinh() / order as f64;
        let pole = |k: usize| {
            let theta = PI * (2 * k + 1) as f64 / (2 * order) as f64;
            Complex64::new(-a.sinh() * theta.sin(), a.cosh() * theta.cos())
        };
        let dc_gain = if order.is_multiple_of(2) { 10f64.powf(-0.05 * ripple_db) } else { 1.0 };
        Self::of_poles(order, cutoff, pole, dc_gain)
    }

    fn of_poles(order: usize, cutoff: f64, pole: impl Fn(usize) -> Complex64, dc_gain: f64) -> Self {
        let warped = (FRAC_PI_2 * cutoff).tan();
        let digital = |k: usize| {
            let s = warped * pole(k);
            (1.0 + s) / (1.0 - s)
        };
        // Pole k and pole n − 1 − k are conjugate; the one in the middle of an odd order is real.
        let mut sections: Vec<[f64; 5]> = (0..order / 2)
            .map(|k| {
                let z = digital(k);
                let (a1, a2) = (-2.0 * z.re, z.norm_sqr());
                let gain = 0.25 * (1.0 + a1 + a2);
                [gain, 2.0 * gain, gain, a1, a2]
            })
            .collect();
        if order % 2 == 1 {
            let z = digital(order / 2).re;
            let gain = 0.5 * (1.0 - z);
            sections.push([gain, gain, 0.0, -z, 0.0]);
        }
        if let Some(first) = sections.first_mut() {
            first[..3].iter_mut().for_each(|b| *b *= dc_gain);
        }
        LowPass { sections, order }
    }

    /// Returns the number of samples by which a record is extended at both ends: three times the order.
    pub fn padding(&self) -> usize {
        3 * self.order
    }

    /// Filters some columns in place, from the steady state at the first sample. All sections advance sample
    /// by sample: their recursions do not wait for each other.
    fn run<const COLUMNS: usize>(&self, x: &mut [[f64; COLUMNS]]) {
        let Some(&first) = x.first() else { return };
        let mut level = first;
        let start = |[b0, b1, b2, a1, a2]: &[f64; 5]| {
            let gain = (b0 + b1 + b2) / (1.0 + a1 + a2);
            let rest = level.map(|level| gain * level);
            let z1: [f64; COLUMNS] = std::array::from_fn(|c| rest[c] - b0 * level[c]);
            let z2: [f64; COLUMNS] = std::array::from_fn(|c| b2 * level[c] - a2 * rest[c]);
            level = rest;
            (z1, z2)
        };
        let mut states: Vec<([f64; COLUMNS], [f64; COLUMNS])> = self.sections.iter().map(start).collect();
        for x in x.iter_mut() {
            for ([b0, b1, b2, a1, a2], (z1, z2)) in self.sections.iter().zip(&mut states) {
                for c in 0..COLUMNS {
                    let y = b0 * x[c] + z1[c];
                    z1[c] = (b1 * x[c] + z2[c]) - a1 * y;
                    z2[c] = b2 * x[c] - a2 * y;
                    x[c] = y;
                }
            }
        }
    }

    /// Filters columns of equal length forward and backward over records extended at both ends by their point
    /// reflections.
    fn forward_backward_abreast<const COLUMNS: usize>(
        &self,
        columns: [&[f64]; COLUMNS],
    ) -> Option<[Vec<f64>; COLUMNS]> {
        let (pad, count) = (self.padding(), columns[0].len());
        let last = count.checked_sub(1).filter(|last| *last >= pad)?;
        let at = |i: usize| columns.map(|x| x[i]);
        let reflected = |end: usize, i: usize| columns.map(|x| 2.0 * x[end] - x[i]);
        let before = (1..=pad).rev().map(|i| reflected(0, i));
        let after = (1..=pad).map(|i| reflected(last, last - i));
        let mut all: Vec<[f64; COLUMNS]> = before.chain((0..count).map(at)).chain(after).collect();
        self.run(&mut all);
        all.reverse();
        self.run(&mut all);
        all.reverse();
        Some(std::array::from_fn(|c| all[pad..pad + count].iter().map(|x| x[c]).collect()))
    }

    /// Filters forward and backward over a record extended at both ends by its point reflection; `None` where
    /// it has no more samples than
    /// [`LowPass::padding`].
    ///
    /// # Source  `filtfilt` of MATLAB; the default of SciPy pads by three more samples.
    pub fn forward_backward(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.forward_backward_abreast([x]).map(|[x]| x)
    }
}

/// Number of records that are filtered together: their recursions do not wait for each other.
const ABREAST: usize = 4;

/// Decimates records of equal length: keeps every `step`-th sample, counted from the last, after a zero-phase
/// Chebyshev filter of order 8 (0.05 dB up to 0.8 of half the rate over `factor`). A factor of one does not
/// filter; `None` where they are too short.
///
/// # Source  `decimate` of MATLAB, where step and factor are equal.
pub fn decimate(records: &[Vec<f64>], factor: usize, step: usize) -> Option<Vec<Vec<f64>>> {
    let kept =
        |smooth: &[f64]| smooth.iter().copied().skip((smooth.len() - 1) % step).step_by(step).collect();
    if factor <= 1 {
        return Some(records.iter().map(|record| kept(record)).collect());
    }
    let filter = LowPass::chebyshev(8, 0.05, 0.8 / factor as f64);
    let mut decimated = Vec::with_capacity(records.len());
    for group in records.chunks(ABREAST) {
        match group {
            [record] => decimated.push(kept(&filter.forward_backward(record)?)),
            _ => {
                let at = |c: usize| group.get(c).unwrap_or(&group[0]).as_slice();
                let smooth: [Vec<f64>; ABREAST] = filter.forward_backward_abreast(std::array::from_fn(at))?;
                decimated.extend(smooth.iter().take(group.len()).map(|x| kept(x)));
            }
        }
    }
    Some(decimated)
}

/// Computes the derivative by central differences (per sample), one-sided at the ends; zeros for fewer than
/// two samples.
pub fn central_differences(x: &[f64]) -> Vec<f64> {
    let Some(last) = x.len().checked_sub(1).filter(|last| *last > 0) else { return vec![0.0; x.len()] };
    (0..x.len())
        .map(|i| {
            (x[(i + 1).min(last)] - x[i.saturating_sub(1)]) / ((i + 1).min(last) - i.saturating_sub(1)) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal() -> Vec<f64> {
        (0..200)
            .map(|i| (0.1 * i as f64).sin() + 0.01 * i as f64 + if i % 7 == 3 { 1.0 } else { 0.0 })
            .collect()
    }

    /// SciPy 1.17.1: `filtfilt(*design, x, padlen=3*order)` at samples 0, 1, 57, 100, 198, 199.
    #[test]
    fn published_scipy_figures() {
        let cases = [
            (
                LowPass::butterworth(4, 0.2),
                [
                    -2.070_262_717_027_851e-3,
                    1.986_107_435_258_787e-1,
                    1.595_489_561_965_037e-1,
                    6.061_699_105_459_343e-1,
                    3.390_169_420_338_62,
                    3.844_833_612_799_063,
                ],
            ),
            (
                LowPass::chebyshev(8, 0.05, 0.08),
                [
                    -3.414_287_971_513_983e-2,
                    1.069_485_443_826_824e-1,
                    1.690_018_828_075_66e-1,
                    5.924_127_268_323_941e-1,
                    3.258_377_160_649_763,
                    3.319_843_099_743_529,
                ],
            ),
            (
                LowPass::butterworth(3, 0.3),
                [
                    1.190_902_611_428_835e-3,
                    2.801_934_760_256_467e-1,
                    1.239_007_926_941_097e-1,
                    7.025_542_693_090_9e-1,
                    3.209_616_483_056_083,
                    3.855_664_796_188_932,
                ],
            ),
            (
                LowPass::chebyshev(5, 1.0, 0.25),
                [
                    1.770_696_793_549_824e-2,
                    2.718_498_997_251_687e-1,
                    2.025_343_158_773_298e-1,
                    6.501_045_982_102_647e-1,
                    3.299_428_529_416_658,
                    3.816_467_936_195_34,
                ],
            ),
        ];
        for (filter, figures) in cases {
            let y = filter.forward_backward(&signal()).unwrap();
            for (at, figure) in [0, 1, 57, 100, 198, 199].into_iter().zip(figures) {
                // SciPy's transfer function loses digits in its eighth-order polynomial.
                assert!((y[at] - figure).abs() < 1e-7, "{} at {at}: {} for {figure}", filter.order, y[at]);
            }
        }
    }

    #[test]
    fn limit_constants_and_straight_lines_pass_and_short_records_do_not() {
        let constant = LowPass::chebyshev(8, 0.05, 0.08).forward_backward(&[2.5; 60]).unwrap();
        let gain = 10f64.powf(-0.1 * 0.05);
        assert!(
            constant.iter().all(|y| (y - 2.5 * gain).abs() < 1e-9),
            "at 0 Hz an even Chebyshev filter has the minimum gain of its ripple"
        );
        let line: Vec<f64> = (0..400).map(|i| 3.0 - 0.2 * i as f64).collect();
        let y = LowPass::butterworth(4, 0.2).forward_backward(&line).unwrap();
        assert!((180..220).all(|i| (y[i] - line[i]).abs() < 1e-9));
        assert_eq!(LowPass::butterworth(4, 0.2).forward_backward(&line[..12]), None);
        assert!(LowPass::butterworth(4, 0.2).forward_backward(&line[..13]).is_some());
        let lines = vec![line.clone(); ABREAST + 1];
        assert_eq!(decimate(&lines, 1, 1).unwrap(), lines);
        let decimated = decimate(&lines, 10, 10).unwrap();
        assert!(
            decimated.iter().all(|x| x.len() == 40 && *x == decimated[0]),
            "a record filtered beside others is filtered as alone"
        );
        let slope = central_differences(&line);
        assert!(slope.iter().all(|s| (s + 0.2).abs() < 1e-12));
        assert!(central_differences(&[1.0]) == [0.0] && central_differences(&[]).is_empty());
    }
}
