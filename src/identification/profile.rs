//! Profile likelihood: intervals of one parameter while all others are re-optimised.

use std::sync::Mutex;

use rayon::prelude::*;

use super::uncertainty::Certainty;
use long_work::Control;
use optimizer::{LeastSquares, Polished, least_squares_within};

/// Rise of χ² at the ends of a 95 % interval of one parameter: the 95 % quantile of χ² with one degree of
/// freedom.
pub const CHI_SQUARE_95: f64 = 3.841_458_820_694_124;
/// Largest number of least-squares steps at one value of the profiled parameter.
const ITERATIONS: u64 = 40;
/// Accuracy of the minimum of χ² over the other coordinates, as a share of the rise.
const ACCURACY: f64 = 1e-3;
/// χ² below that of the best minimum, as a share of the rise, at which a point is deeper and not merely
/// within the accuracy.
const DEEPER: f64 = 0.02;
/// Accuracy of an end of an interval, as a share of its distance from the minimum.
const END_ACCURACY: f64 = 0.01;
/// Largest number of evaluations of a profile to find an end of an interval.
const EVALUATIONS: usize = 25;

/// Values of a unit-cube coordinate that the data do not reject: intervals in rising order that do not touch.
/// An end at 0 or 1 is that of the range.
pub type Region = Vec<(f64, f64)>;

/// A minimum about which a profile starts, and the first-order uncertainty there.
pub struct ProfileStart {
    /// The minimum.
    pub minimum: Polished,
    /// Uncertainty there.
    pub certainty: Certainty,
}

/// Result of the profiles.
pub enum Profiles {
    /// Regions of the coordinates.
    Regions(Vec<Region>),
    /// A point of lower χ² than any of the minima, met on the way: the search had missed it.
    Deeper(Vec<f64>),
    /// Stopped.
    Stopped,
}

/// Profiles of some coordinates of a sum of squares with several minima, the best first.
pub struct Profiler<'p> {
    /// χ².
    pub squares: &'p dyn LeastSquares,
    /// Its minima, the best first.
    pub minima: &'p [ProfileStart],
    /// Rise of χ² above the best minimum at the ends of an interval.
    pub rise: f64,
    /// Control.
    pub control: &'p Control,
}

impl Profiler<'_> {
    /// Finds the values of some coordinates at which χ², with all other coordinates re-optimised, rises by
    /// less than [`Profiler::rise`].
    ///
    /// The profile starts from every minimum. Before a value is rejected the others are re-optimised from
    /// every minimum, too.
    ///
    /// # Source  Raue et al., Bioinformatics 25 (2009) 1923–1929, Eq. 6–7.
    pub fn regions(&self, coordinates: &[usize]) -> Profiles {
        let deeper = Mutex::new(None);
        let regions: Vec<Region> =
            coordinates.par_iter().map(|coordinate| self.region(*coordinate, &deeper)).collect();
        if self.control.stopped() {
            return Profiles::Stopped;
        }
        match deeper.into_inner() {
            Ok(Some((_, place))) => Profiles::Deeper(place),
            _ => Profiles::Regions(regions),
        }
    }

    fn region(&self, coordinate: usize, deeper: &Deeper) -> Region {
        let mut region: Region = Vec::new();
        for start in self.minima {
            let here = start.minimum.place[coordinate];
            if self.control.stopped() || region.iter().any(|(low, high)| (*low..=*high).contains(&here)) {
                continue;
            }
            let (low, high) = rayon::join(
                || self.end(start, (coordinate, 0.0), deeper),
                || self.end(start, (coordinate, 1.0), deeper),
            );
            region = joined(region, (low.min(here), high.max(here)));
        }
        region
    }

    /// Minimises χ² over all coordinates but one, from a start.
    fn refitted(&self, mut place: Vec<f64>, (coordinate, at): (usize, f64), deeper: &Deeper) -> Polished {
        place[coordinate] = at;
        let held: Vec<bool> = (0..place.len()).map(|i| i == coordinate).collect();
        let least = self.minima[0].minimum.normal.chi_square;
        let tolerance = (ACCURACY * self.rise / least.max(f64::MIN_POSITIVE)).clamp(1e-9, 1e-3);
        let found =
            least_squares_within(self.squares, &place, &held, (ITERATIONS, tolerance), self.control.stop());
        let chi_square = found.normal.chi_square;
        if chi_square < least - DEEPER * self.rise
            && let Ok(mut best) = deeper.lock()
            && best.as_ref().is_none_or(|(lowest, place)| (chi_square, &found.place) < (*lowest, place))
        {
            *best = Some((chi_square, found.place.clone()));
        }
        found
    }

    /// Returns √(Δχ²/rise) − 1, which is linear in the coordinate for a parabola, and negative inside.
    fn height(&self, chi_square: f64) -> f64 {
        ((chi_square - self.minima[0].minimum.normal.chi_square).max(0.0) / self.rise).sqrt() - 1.0
    }

    /// Finds the end of an interval about a minimum in the direction of a face of the unit cube.
    fn end(&self, from: &ProfileStart, (coordinate, edge): (usize, f64), deeper: &Deeper) -> f64 {
        let start = from.minimum.place[coordinate];
        // To first order χ² is a parabola: its 95 % limit lies 1.96 standard deviations from the minimum.
        let reach = 1.96 * from.certainty.sd[coordinate];
        // Direction of the search: toward 1 or toward 0.
        let toward = if edge > 0.5 { 1.0 } else { -1.0 };
        let clamp = |u: f64| u.clamp(0.0, 1.0);
        if start == edge {
            return edge;
        }
        let (mut inside, mut outside): ((f64, f64), Option<(f64, f64)>) =
            ((start, self.height(from.minimum.normal.chi_square)), None);
        let mut warm = from.minimum.place.clone();
        let mut next = clamp(start + toward * reach.max(1e-6));
        // Where the first-order end is, unless the range or the least step moves it.
        let first = start + toward * reach;
        // Which bracket the last evaluation replaced, to halve the ordinate of the one that stays (Illinois
        // rule).
        let mut stayed = 0_i8;
        for _ in 0..EVALUATIONS {
            if self.control.stopped() || (next - inside.0).abs() < 1e-9 {
                break;
            }
            let tried = followed(&warm, from, (coordinate, next));
            let mut polished = self.refitted(tried.clone(), (coordinate, next), deeper);
            // A refit that ended in a wrong minimum must not reject a value.
            for other in self.minima {
                if self.height(polished.normal.chi_square) < 0.0 {
                    break;
                }
                let start = followed(&other.minimum.place, other, (coordinate, next));
                if start == tried {
                    continue;
                }
                let again = self.refitted(start, (coordinate, next), deeper);
                if again.normal.chi_square < polished.normal.chi_square {
                    polished = again;
                }
            }
            let height = self.height(polished.normal.chi_square);
            if height.abs() < END_ACCURACY {
                return next;
            }
            if inside == (start, -1.0) && next == first && height.powi(2) < END_ACCURACY {
                // √Δχ² departs from the straight line to first order by the share `height` here: a straight
                // line to its end leaves the square of it.
                return clamp(start + (next - start) / (1.0 + height));
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
}

/// The lowest χ² met on the way below that of the best minimum, and its place.
type Deeper = Mutex<Option<(f64, Vec<f64>)>>;

/// Returns a place with one coordinate at a new value and the others following to first order.
fn followed(warm: &[f64], from: &ProfileStart, (coordinate, next): (usize, f64)) -> Vec<f64> {
    let covariance = &from.certainty.covariance;
    let variance = covariance[(coordinate, coordinate)];
    let by = next - warm[coordinate];
    let follow = |i: usize| if variance > 0.0 { covariance[(i, coordinate)] / variance } else { 0.0 };
    warm.iter().enumerate().map(|(i, u)| (u + by * follow(i)).clamp(0.0, 1.0)).collect()
}

/// Adds an interval to a region; intervals that touch become one.
pub fn joined(region: Region, interval: (f64, f64)) -> Region {
    let (mut low, mut high) = interval;
    let mut rest: Region = Vec::new();
    for (a, b) in region {
        if a <= high && b >= low {
            (low, high) = (low.min(a), high.max(b));
        } else {
            rest.push((a, b));
        }
    }
    rest.push((low, high));
    rest.sort_by(|a, b| a.0.total_cmp(&b.0));
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::certainty;
    use optimizer::{NormalEquations, least_squares};

    /// Returns the hulls of the regions about one minimum.
    fn ends(squares: &dyn LeastSquares, best: Polished, coordinates: &[usize]) -> Vec<(f64, f64)> {
        regions(squares, vec![best], coordinates)
            .iter()
            .map(|region| (region[0].0, region[region.len() - 1].1))
            .collect()
    }

    fn regions(squares: &dyn LeastSquares, minima: Vec<Polished>, coordinates: &[usize]) -> Vec<Region> {
        let start = |minimum: Polished| ProfileStart {
            certainty: certainty(&minimum.normal.information, 1.0),
            minimum,
        };
        let minima: Vec<ProfileStart> = minima.into_iter().map(start).collect();
        let profiler =
            Profiler { squares, minima: &minima, rise: CHI_SQUARE_95, control: &Control::default() };
        match profiler.regions(coordinates) {
            Profiles::Regions(regions) => regions,
            Profiles::Deeper(place) => panic!("deeper at {place:?}"),
            Profiles::Stopped => panic!("stopped"),
        }
    }

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
        let ends = ends(&TwoParameters, best, &[0, 1]);
        let half = 1.96 * f64::hypot(0.05, 0.01);
        assert!((ends[0].0 - (0.5 - 0.098)).abs() < 2e-3 && (ends[0].1 - 0.598).abs() < 2e-3, "{ends:?}");
        assert!(
            (ends[1].0 - (0.5 - half)).abs() < 2e-3 && (ends[1].1 - (0.5 + half)).abs() < 2e-3,
            "{ends:?}"
        );
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
        let ends = ends(&SteepRise, best, &[0]);
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
        let ends = ends(&BeyondRange, best, &[0]);
        // χ² = ((x − 1.05)/0.1)² rises by 3.84 from 0.25 at x = 1.
        let exact = 1.05 - 0.1 * (0.25 + CHI_SQUARE_95).sqrt();
        assert!(ends[0].1 == 1.0 && (ends[0].0 - exact).abs() < 3e-3, "{ends:?}, {exact}");
    }

    #[test]
    fn limit_open_interval_ends_at_the_range() {
        let best = least_squares(&Flat, &[0.9], &[], 50, &std::sync::Arc::default());
        let ends = ends(&Flat, best, &[0]);
        assert!(ends[0].1 == 1.0 && (ends[0].0 - (0.8 - 0.196)).abs() < 4e-3, "{ends:?}");
    }

    /// Two minima of equal χ² at x = 0.25 and 0.75, with a barrier of 100 between them: r = (x − 0.25)(x −
    /// 0.75)/0.00625.
    struct TwoMinima;

    impl LeastSquares for TwoMinima {
        fn dimension(&self) -> usize {
            1
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(1);
            normal.add(1.0, (x[0] - 0.25) * (x[0] - 0.75) / 0.00625, &[(2.0 * x[0] - 1.0) / 0.00625]);
            normal
        }
    }

    #[test]
    fn limit_two_minima_give_two_intervals() {
        let at = |x: f64| least_squares(&TwoMinima, &[x], &[], 50, &std::sync::Arc::default());
        let found = regions(&TwoMinima, vec![at(0.2), at(0.8)], &[0]);
        // (x − 0.5)² = 0.0625 ± 0.00625·√3.84.
        let inner = (0.0625 - 0.00625 * CHI_SQUARE_95.sqrt()).sqrt();
        let outer = (0.0625 + 0.00625 * CHI_SQUARE_95.sqrt()).sqrt();
        assert_eq!(found[0].len(), 2, "{found:?}");
        for ((low, high), exact) in
            found[0].iter().zip([(0.5 - outer, 0.5 - inner), (0.5 + inner, 0.5 + outer)])
        {
            assert!((low - exact.0).abs() < 1e-3 && (high - exact.1).abs() < 1e-3, "{found:?}, {exact:?}");
        }
    }

    /// χ² of x and y has its least value, 0, at y = 0.9; a profile from the shallower minimum at y = 0.1 must
    /// say so.
    struct Shallow;

    impl LeastSquares for Shallow {
        fn dimension(&self) -> usize {
            2
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(2);
            // The barrier between the minima of y vanishes as x leaves 0.5.
            let bend = 1.0 - 20.0 * (x[0] - 0.5).abs();
            normal.add(1.0, (x[0] - 0.5) / 0.1, &[10.0, 0.0]);
            normal.add(
                1.0,
                10.0 * (0.9 - x[1]) - bend.max(0.0) * 30.0 * (-((x[1] - 0.1) / 0.2).powi(2)).exp(),
                &[0.0, -10.0],
            );
            normal.mirror();
            normal
        }
    }

    #[test]
    fn a_deeper_minimum_met_by_a_profile_is_returned() {
        let minimum = Polished {
            place: vec![0.5, 0.1],
            normal: Shallow.normal(&[0.5, 0.1]),
            evaluations: 0,
            converged: true,
        };
        let start = ProfileStart { certainty: certainty(&minimum.normal.information, 1.0), minimum };
        let profiler = Profiler {
            squares: &Shallow,
            minima: &[start],
            rise: CHI_SQUARE_95,
            control: &Control::default(),
        };
        let Profiles::Deeper(place) = profiler.regions(&[0]) else { panic!("no deeper minimum") };
        assert!(Shallow.chi_square(&place) < 100.0, "{place:?}");
    }
}
