//! Complex discrete Fourier transform of a power-of-two length, the same on every machine.

use num_complex::Complex64;

/// Tables for one length.
#[derive(Clone, Debug)]
pub struct Fft {
    /// Twiddle factors of each stage, starting with the stage of pairs.
    twiddles: Vec<Vec<Complex64>>,
    swaps: Vec<(u32, u32)>,
    size: usize,
}

impl Fft {
    /// Computes the tables for a length, rounded up to a power of two.
    pub fn new(size: usize) -> Self {
        let size = size.next_power_of_two().max(2);
        let of_stage = |half: usize| {
            (0..half)
                .map(|k| Complex64::from_polar(1.0, -std::f64::consts::PI * k as f64 / half as f64))
                .collect()
        };
        let twiddles = (0..size.trailing_zeros()).map(|stage| of_stage(1 << stage)).collect();
        let bits = size.trailing_zeros();
        let swaps = (0..size as u32)
            .map(|index| (index, index.reverse_bits() >> (32 - bits)))
            .filter(|(a, b)| a < b)
            .collect();
        Self { twiddles, swaps, size }
    }

    /// Computes X_k = Σ x_n e^{−2πi k n / N} in place; `values` must have the length of the tables.
    pub fn forward(&self, values: &mut [Complex64]) {
        assert_eq!(values.len(), self.size, "the values have another length than the tables");
        for &(a, b) in &self.swaps {
            values.swap(a as usize, b as usize);
        }
        for twiddles in &self.twiddles {
            let half = twiddles.len();
            for chunk in values.chunks_exact_mut(2 * half) {
                let (low, high) = chunk.split_at_mut(half);
                for ((a, b), twiddle) in low.iter_mut().zip(high).zip(twiddles) {
                    let turned = *b * twiddle;
                    *b = *a - turned;
                    *a += turned;
                }
            }
        }
    }

    /// Computes x_n = Σ X_k e^{+2πi k n / N} in place, without the factor 1/N.
    pub fn backward(&self, values: &mut [Complex64]) {
        for value in values.iter_mut() {
            *value = value.conj();
        }
        self.forward(values);
        for value in values.iter_mut() {
            *value = value.conj();
        }
    }
}
