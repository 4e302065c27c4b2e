//! Profile likelihood: intervals of one parameter while all others are re-optimised.

use rayon::prelude::*;

use super::uncertainty::Certainty;
use optimizer::{Control, LeastSquares, Polished, least_squares_within};

/// Rise of χ² at the ends of a 95 % interval of one parameter: the 95 % quantile of χ² with one degree of freedom.
pub const CHI_SQUARE_95: f64 = 3.841_458_820_694_124;
/// Largest number of least-squares steps at one value of the profiled parameter.
const ITERATIONS: u64 = 40;
/// Accuracy of the minimum of χ² over the other coordinates, as a share of the rise.
const ACCURACY: f64 = 1e-3;
/// Largest number of evaluations of a profile to find an end of an interval.
const EVALUATIONS: usize = 25;

/// Computes intervals of some unit-cube coordinates, in which χ² rises by less than `rise` with all other coordinates re-optimised.
///
/// An end at 0 or 1 is the end of the range. `None` if stopped.
///
/// # Source  Raue et al., Bioinformatics 25 (2009) 1923–1929, Eq. 6–7.
pub fn profiles(
    squares: &dyn LeastSquares,
    best: &Polished,
    certainty: &Certainty,
    (coordinates, rise): (&[usize], f64),
    control: &Control,
) -> Option<Vec<(f64, f64)>> {
    let end = |at: usize| {
        let (coordinate, edge) = (coordinates[at / 2], (at % 2) as f64);
        profile_end(squares, best, (coordinate, edge), certainty, rise, control)
    };
    let ends: Vec<f64> = (0..2 * coordinates.len()).into_par_iter().map(end).collect();
    (!control.stopped()).then(|| ends.chunks_exact(2).map(|ends| (ends[0], ends[1])).collect())
}

/// Finds the end of an interval in the direction of a face of the unit cube.
fn profile_end(
    squares: &dyn LeastSquares,
    best: &Polished,
    (coordinate, edge): (usize, f64),
    certainty: &Certainty,
    rise: f64,
    control: &Control,
) -> f64 {
    let start = best.place[coordinate];
    // To first order χ² is a parabola: its 95 % limit lies 1.96 standard deviations from the minimum.
    let reach = 1.96 * certainty.sd[coordinate];
    // First-order change of the other coordinates per unit change of this one.
    let variance = certainty.covariance[(coordinate, coordinate)];
    let follow = |i: usize| if variance > 0.0 { certainty.covariance[(i, coordinate)] / variance } else { 0.0 };
    let tolerance = (ACCURACY * rise / best.normal.chi_square.max(f64::MIN_POSITIVE)).clamp(1e-9, 1e-3);
    let held: Vec<bool> = (0..best.place.len()).map(|i| i == coordinate).collect();
    // Direction of the search: toward 1 or toward 0.
    let toward = if edge > 0.5 { 1.0 } else { -1.0 };
    let clamp = |u: f64| u.clamp(0.0, 1.0);
    if start == edge {
        return edge;
    }
    // Coordinate and √(Δχ²/rise) − 1, which is linear in the coordinate for a parabola.
    let (mut inside, mut outside): ((f64, f64), Option<(f64, f64)>) = ((start, -1.0), None);
    let mut warm = best.place.clone();
    let mut next = clamp(start + toward * reach.max(1e-6));
    // Which bracket the last evaluation replaced, to halve the ordinate of the one that stays (Illinois rule).
    let mut stayed = 0_i8;
    for _ in 0..EVALUATIONS {
        if control.stopped() || (next - inside.0).abs() < 1e-9 {
            break;
        }
        let by = next - warm[coordinate];
        let mut place: Vec<f64> = warm.iter().enumerate().map(|(i, u)| clamp(u + by * follow(i))).collect();
        place[coordinate] = next;
        let polished = least_squares_within(squares, &place, &held, (ITERATIONS, tolerance), control.stop());
        let height = ((polished.normal.chi_square - best.normal.chi_square).max(0.0) / rise).sqrt() - 1.0;
        if height.abs() < 0.01 {
            return next;
        }
        if height < 0.0 {
            if next == edge {
                return edge;
            }
            (inside, warm) = ((next, height), polished.place);
            if stayed == 1 {
                outside = outside.map(|(far, high)| (far, 0.5 * high));
            }
            stayed = 1;
        } else {
            outside = Some((next, height));
            if stayed == -1 {
                inside.1 *= 0.5;
            }
            stayed = -1;
        }
        next = match outside {
            Some((far, high)) => {
                let share = (-inside.1 / (high - inside.1)).clamp(0.05, 0.95);
                inside.0 + share * (far - inside.0)
            }
            // Extrapolate, to at most about four times the distance.
            None => clamp(start + (inside.0 - start) * (1.02 / (1.0 + inside.1).max(0.25)).max(1.3)),
        };
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::certainty;
    use optimizer::{NormalEquations, least_squares};

    /// r = ((x − 0.5)/0.05, (x + y − 1)/0.01): x and y are correlated.
    struct TwoParameters;

    impl LeastSquares for TwoParameters {
        fn dimension(&self) -> usize {
            2
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(2);
            normal.add(1.0, (x[0] - 0.5) / 0.05, &[20.0, 0.0]);
            normal.add(1.0, (x[0] + x[1] - 1.0) / 0.01, &[100.0, 100.0]);
            normal.mirror();
            normal
        }
    }

    #[test]
    fn limit_interval_of_a_parabola_is_that_of_its_covariance() {
        let best = least_squares(&TwoParameters, &[0.4, 0.4], &[], 50, &std::sync::Arc::default());
        let certainty = certainty(&best.normal.information, 1.0, &[]);
        let ends = profiles(&TwoParameters, &best, &certainty, (&[0, 1], CHI_SQUARE_95), &Control::default()).unwrap();
        let half = 1.96 * f64::hypot(0.05, 0.01);
        assert!((ends[0].0 - (0.5 - 0.098)).abs() < 2e-3 && (ends[0].1 - 0.598).abs() < 2e-3, "{ends:?}");
        assert!((ends[1].0 - (0.5 - half)).abs() < 2e-3 && (ends[1].1 - (0.5 + half)).abs() < 2e-3, "{ends:?}");
    }

    /// χ² is flat above 0.8: the interval ends at the end of the range.
    struct Flat;

    impl LeastSquares for Flat {
        fn dimension(&self) -> usize {
            1
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(1);
            let below = (0.8 - x[0]).max(0.0) / 0.1;
            normal.add(1.0, below, &[if below > 0.0 { -10.0 } else { 0.0 }]);
            normal
        }
    }

    /// χ² rises steeply only far from the minimum: √Δχ² is strongly curved.
    struct SteepRise;

    impl LeastSquares for SteepRise {
        fn dimension(&self) -> usize {
            1
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(1);
            let y = (x[0] - 0.2) / 0.4;
            normal.add(1.0, 2.0 * y.powi(9), &[45.0 * y.powi(8)]);
            normal
        }
    }

    #[test]
    fn limit_end_of_a_steep_rise_is_exact() {
        let best = least_squares(&SteepRise, &[0.2], &[], 50, &std::sync::Arc::default());
        let certainty = certainty(&best.normal.information, 1.0, &[]);
        let ends = profiles(&SteepRise, &best, &certainty, (&[0], CHI_SQUARE_95), &Control::default()).unwrap();
        let exact = 0.2 + 0.4 * (0.98_f64).powf(1.0 / 9.0);
        assert!((ends[0].1 - exact).abs() < 2e-3 && ends[0].0 == 0.0, "{ends:?}, {exact}");
    }

    /// The minimum lies beyond the upper end of the range.
    struct BeyondRange;

    impl LeastSquares for BeyondRange {
        fn dimension(&self) -> usize {
            1
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(1);
            normal.add(1.0, (x[0] - 1.05) / 0.1, &[10.0]);
            normal
        }
    }

    #[test]
    fn limit_interval_at_the_upper_bound_extends_inward_only() {
        let best = least_squares(&BeyondRange, &[0.5], &[], 50, &std::sync::Arc::default());
        let certainty = certainty(&best.normal.information, 1.0, &[]);
        let ends = profiles(&BeyondRange, &best, &certainty, (&[0], CHI_SQUARE_95), &Control::default()).unwrap();
        // χ² = ((x − 1.05)/0.1)² rises by 3.84 from 0.25 at x = 1.
        let exact = 1.05 - 0.1 * (0.25 + CHI_SQUARE_95).sqrt();
        assert!(ends[0].1 == 1.0 && (ends[0].0 - exact).abs() < 3e-3, "{ends:?}, {exact}");
    }

    #[test]
    fn limit_open_interval_ends_at_the_range() {
        let best = least_squares(&Flat, &[0.9], &[], 50, &std::sync::Arc::default());
        let certainty = certainty(&best.normal.information, 1.0, &[]);
        let ends = profiles(&Flat, &best, &certainty, (&[0], CHI_SQUARE_95), &Control::default()).unwrap();
        assert!(ends[0].1 == 1.0 && (ends[0].0 - (0.8 - 0.196)).abs() < 4e-3, "{ends:?}");
    }
}
