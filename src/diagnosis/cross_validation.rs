//! Positions foretold by a fit without them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::evidence::{Domain, DomainObjective};
use super::fit::{Fitted, Fitter, SCATTERED_WITHOUT_ONE, place_of};
use super::hypothesis::Hypothesis;
use identification::objective::ObjectiveError;
use numeric::parallel::OrFirstError;
use optimizer::{Control, LeastSquares, NormalEquations, least_squares_within};

/// Steps of a fit without one position.
const STEPS: u64 = 12;
/// Steps within what a fit leaves open, and the share of χ² at which they end.
const OPEN_STEPS: (u64, f64) = (10, 1e-3);
/// What is known of a parameter before anything is measured: that it lies in its range (one over the variance of a place in the unit interval).
const IN_RANGE: f64 = 12.0;

/// How badly each position (or record) is foretold by a fit without it, summed: χ², and of FRFs −2 times the logarithm of their density but for what
/// the lines' weights give, since what the others leave open must not count as foretold wrongly.
///
/// # Errors  as [`Fitter::objective`].
pub fn cross_validation(fitter: &Fitter<'_>, hypothesis: &Hypothesis, fitted: &Fitted, control: &Control) -> Result<f64, ObjectiveError> {
    let blocks = fitter.blocks();
    // One record alone leaves nothing to fit.
    if blocks.len() < 2 {
        return Ok(0.0);
    }
    let piece = fitter.piece("left out", hypothesis, std::slice::from_ref(fitted));
    control.kept_or_failed(&piece, || cross_validation_from_all_starts(fitter, hypothesis, fitted, control))
}

fn cross_validation_from_all_starts(
    fitter: &Fitter<'_>,
    hypothesis: &Hypothesis,
    fitted: &Fitted,
    control: &Control,
) -> Result<f64, ObjectiveError> {
    let blocks = fitter.blocks();
    let parts: Result<Vec<f64>, ObjectiveError> = blocks
        .into_par_iter()
        .map(|(kept, left)| {
            let kept = fitter.on(kept);
            let objective = kept.objective(hypothesis)?;
            let part = kept.descend(&objective, fitted, STEPS, control);
            let left = fitter.on(left);
            match fitter.domain {
                Domain::Frf(_) => Ok(log_predictive_loss((&objective, &left.objective(hypothesis)?), &part, control)),
                Domain::Modes(_) => {
                    // Of few numbers the deepest basin may be another one.
                    let other = kept.scatter_anew(hypothesis, fitted, SCATTERED_WITHOUT_ONE, control)?;
                    left.loss(hypothesis, if other.chi_square < part.chi_square { &other } else { &part })
                }
            }
        })
        .or_first_error();
    Ok(parts?.into_iter().sum())
}

/// How badly a fit to what is kept foretells what is left: see [`foretold`].
fn log_predictive_loss((kept, left): (&DomainObjective<'_>, &DomainObjective<'_>), part: &Fitted, control: &Control) -> f64 {
    let told = kept.squares(|squares| squares.normal(&place_of(kept, part)).information);
    // Coordinates of both: parameters and gain, and the channels; nut positions are each part's own.
    let shared = |of: &DomainObjective<'_>| -> Vec<usize> {
        (0..of.nut_coordinates().start).chain(of.nut_coordinates().end..of.dimension()).collect()
    };
    let (mut there, mut here) = (shared(kept), shared(left));
    if there.len() != here.len() {
        there.truncate(kept.nut_coordinates().start);
        here.truncate(left.nut_coordinates().start);
    }
    let size = told.nrows();
    let Some(open) = (told + DMatrix::identity(size, size) * IN_RANGE).try_inverse() else { return f64::INFINITY };
    let open = open.select_rows(&there).select_columns(&there);
    let place = place_of(left, part);
    left.squares(|squares| predicted(squares, &place, &here, open, control).unwrap_or(f64::INFINITY))
}

/// −2 ln of the density of data, but for what their weights give, where some coordinates are known to lie about a place with a covariance: the least of χ² and
/// of what it costs to move them, and how much of them was open. Exact where residuals are linear.
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, §27–28 (Laplace's approximation of the evidence).
fn predicted(squares: &dyn LeastSquares, place: &[f64], coordinates: &[usize], open: DMatrix<f64>, control: &Control) -> Option<f64> {
    let precision = open.clone().try_inverse()?;
    let within = ConstrainedFit { squares, centre: place, coordinates, precision };
    let found = least_squares_within(&within, place, &[], OPEN_STEPS, control.stop());
    let felt = squares.normal(&found.place).information;
    let felt = felt.select_rows(coordinates).select_columns(coordinates);
    let opened = (DMatrix::identity(open.nrows(), open.nrows()) + open * felt).determinant();
    Some(found.normal.chi_square + opened.max(1.0).ln())
}

/// A sum of squares beside what is known of some coordinates.
struct ConstrainedFit<'a> {
    squares: &'a dyn LeastSquares,
    centre: &'a [f64],
    coordinates: &'a [usize],
    precision: DMatrix<f64>,
}

impl ConstrainedFit<'_> {
    fn moved(&self, place: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.coordinates.len(), self.coordinates.iter().map(|at| place[*at] - self.centre[*at]))
    }
}

impl LeastSquares for ConstrainedFit<'_> {
    fn dimension(&self) -> usize {
        self.squares.dimension()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let moved = self.moved(place);
        self.squares.chi_square(place) + moved.dot(&(&self.precision * &moved))
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let mut normal = self.squares.normal(place);
        let moved = self.moved(place);
        let pull = &self.precision * &moved;
        normal.chi_square += moved.dot(&pull);
        for (a, at) in self.coordinates.iter().enumerate() {
            normal.gradient[*at] += pull[a];
            for (b, beside) in self.coordinates.iter().enumerate() {
                normal.information[(*at, *beside)] += self.precision[(a, b)];
            }
        }
        normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two readings r = A·(place − truth), of which the second sees the second coordinate alone.
    struct Linear(DMatrix<f64>, DVector<f64>);

    impl LeastSquares for Linear {
        fn dimension(&self) -> usize {
            self.0.ncols()
        }
        fn chi_square(&self, place: &[f64]) -> f64 {
            (&self.0 * (DVector::from_column_slice(place) - &self.1)).norm_squared()
        }
        fn normal(&self, place: &[f64]) -> NormalEquations {
            let residuals = &self.0 * (DVector::from_column_slice(place) - &self.1);
            let gradient = self.0.transpose() * &residuals;
            NormalEquations { chi_square: residuals.norm_squared(), gradient, information: self.0.transpose() * &self.0 }
        }
    }

    /// Of linear residuals: rᵀ·S⁻¹·r + ln det S with S = 1 + A·V·Aᵀ, written out.
    #[test]
    fn limit_the_predictive_loss_of_linear_residuals_is_their_density() {
        let slopes = DMatrix::from_row_slice(3, 2, &[3.0, -1.0, 0.0, 20.0, 5.0, 2.0]);
        let linear = Linear(slopes.clone(), DVector::from_column_slice(&[0.52, 0.43]));
        let open = DMatrix::from_row_slice(2, 2, &[4e-4, 1e-4, 1e-4, 9e-3]);
        let place = [0.5, 0.5];
        let residuals = &slopes * (DVector::from_column_slice(&place) - &linear.1);
        let spread = DMatrix::identity(3, 3) + &slopes * &open * slopes.transpose();
        let exact = residuals.dot(&(spread.clone().try_inverse().unwrap() * &residuals)) + spread.determinant().ln();
        let found = predicted(&linear, &place, &[0, 1], open, &Control::default()).unwrap();
        assert!((found - exact).abs() < 1e-6 * exact, "{found} instead of {exact}");
        // With the place for certain it is χ².
        let certain = predicted(&linear, &place, &[0, 1], DMatrix::identity(2, 2) * 1e-14, &Control::default()).unwrap();
        assert!((certain - residuals.norm_squared()).abs() < 1e-6);
    }
}
