//! Random numbers beyond those of the generators.

use rand::{Rng, RngExt};

/// Draws a standard normal number (Box–Muller).
pub fn normal(generator: &mut impl Rng) -> f64 {
    let u: f64 = 1.0 - generator.random::<f64>();
    let v: f64 = generator.random();
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Draws `count` points of the unit cube, one in each of `count` equal strata of every coordinate.
///
/// # Source  McKay, Beckman and Conover, Technometrics 21 (1979) 239–245.
pub fn latin_hypercube(count: usize, dimension: usize, generator: &mut impl Rng) -> Vec<Vec<f64>> {
    let mut places = vec![vec![0.0; dimension]; count];
    for coordinate in 0..dimension {
        let mut strata: Vec<usize> = (0..count).collect();
        for at in (1..count).rev() {
            let other = generator.random_range(0..=at);
            strata.swap(at, other);
        }
        for (place, stratum) in places.iter_mut().zip(strata) {
            place[coordinate] = (stratum as f64 + generator.random::<f64>()) / count as f64;
        }
    }
    places
}
