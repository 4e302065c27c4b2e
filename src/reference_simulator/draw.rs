//! Random numbers that depend only on a seed and on branch numbers, never on the order of threads.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// A seeded source of random numbers that splits into independent sources by number.
#[derive(Clone, Debug)]
pub struct Draw {
    seed: u64,
    source: Xoshiro256PlusPlus,
    spare: Option<f64>,
}

impl Draw {
    /// Creates the source of a seed.
    pub fn new(seed: u64) -> Self {
        Self { seed, source: Xoshiro256PlusPlus::seed_from_u64(seed), spare: None }
    }

    /// Returns the source of branch `number`, which does not depend on the numbers drawn so far.
    pub fn branch(&self, number: u64) -> Self {
        Self::new(scramble(self.seed ^ scramble(number.wrapping_add(0x51ed_270b_9f31_77c5))))
    }

    /// Draws a uniform number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.source.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Draws a uniform number between two limits.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Draws a number between two positive limits, uniform in the logarithm.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Draws a uniform number within ± `half`.
    pub fn within(&mut self, half: f64) -> f64 {
        self.between(-half, half)
    }

    /// Draws one of 0 … count − 1.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Shuffles a slice.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.index(last + 1));
        }
    }

    /// Draws a factor between two limits above 1, or its reciprocal, equally often.
    pub fn factor(&mut self, low: f64, high: f64) -> f64 {
        if self.chance(0.5) { self.between(low, high) } else { 1.0 / self.between(low, high) }
    }

    /// Draws +1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { 1.0 } else { -1.0 }
    }

    /// Returns true with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Draws a standard normal number by the polar method.
    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        loop {
            let (a, b) = (self.within(1.0), self.within(1.0));
            let square = a * a + b * b;
            if square > 0.0 && square < 1.0 {
                let scale = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(b * scale);
                return a * scale;
            }
        }
    }
}

/// Applies the finalising mix of SplitMix64.
fn scramble(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
