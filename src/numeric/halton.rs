//! Halton sequence: evenly distributed points in a unit cube.

const PRIMES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// Returns a point of the Halton sequence in the unit cube; `index` from 1. Beyond sixteen dimensions
/// coordinates repeat.
///
/// # Source  Halton, Numerische Mathematik 2 (1960) 84–90.
pub fn halton_point(index: usize, dimension: usize) -> Vec<f64> {
    let coordinate = |base: usize| {
        let (mut i, mut f, mut x) = (index, 1.0, 0.0);
        while i > 0 {
            f /= base as f64;
            x += f * (i % base) as f64;
            i /= base;
        }
        x
    };
    (0..dimension).map(|d| coordinate(PRIMES[d % PRIMES.len()])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_first_points() {
        assert_eq!(halton_point(1, 2), [0.5, 1.0 / 3.0]);
        assert_eq!(halton_point(6, 1), [0.375]);
    }
}
