//! Random numbers beyond those of the generators.

use rand::{Rng, RngExt};

/// Draws a standard normal number (Box–Muller).
pub fn normal(generator: &mut impl Rng) -> f64 {
    let u: f64 = 1.0 - generator.random::<f64>();
    let v: f64 = generator.random();
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
