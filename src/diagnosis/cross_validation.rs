//! Cross-validation over positions: each is predicted by a fit without it.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::evidence::{Domain, DomainObjective};
use super::fit::{Fitted, Fitter, coordinates_of};
use super::hypothesis::Hypothesis;
use identification::objective::ObjectiveError;
use long_work::Control;
use numeric::parallel::OrFirstError;
use optimizer::{LeastSquares, NormalEquations, least_squares_within};

/// Steps of a fit without one position.
const STEPS: u64 = 12;
/// Steps within the covariance of a fit, and the relative decrease of χ² at which they end.
const COVARIANCE_STEPS: (u64, f64) = (10, 1e-3);
/// Seed of the global search without a position of modes.
const SEED: u64 = 1;
/// Prior precision of a coordinate: its range, the unit interval, has variance 1/12.
const PRIOR_PRECISION: f64 = 12.0;

/// Returns the cross-validation loss: how badly each position (or record) is predicted by a fit without it,
/// summed. For modes it is χ². For FRFs it is −2 ln of the predictive density up to the constant of the
/// weights: uncertainty of the retained data does not count as prediction error.
///
/// # Errors  as [`Fitter::objective`].
pub fn cross_validation(
    fitter: &Fitter<'_>,
    hypothesis: &Hypothesis,
    fitted: &Fitted,
    control: &Control,
) -> Result<f64, ObjectiveError> {
    let blocks = fitter.blocks();
    if control.stopped() {
        return Ok(f64::INFINITY);
    }
    // With a single record nothing remains to fit.
    if blocks.len() < 2 {
        return Ok(0.0);
    }
    let key = fitter.cache_key("left out", hypothesis, std::slice::from_ref(fitted));
    control.try_cached(&key, || cross_validation_from_all_starts(fitter, hypothesis, fitted, control))
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
            if control.stopped() {
                return Ok(f64::INFINITY);
            }
            let kept = fitter.on(kept);
            let objective = kept.objective(hypothesis)?;
            let part = kept.descend(&objective, fitted, STEPS, control);
            let left = fitter.on(left);
            match fitter.domain {
                Domain::Frf(_) => Ok(log_predictive_loss(
                    (&objective, &left.objective(hypothesis)?),
                    usize::MAX,
                    &part,
                    control,
                )),
                Domain::Modes(_) => {
                    // With few numbers another basin may be the deepest.
                    let other = kept.search_globally(hypothesis, (SEED, 0), control)?;
                    let deeper = other.filter(|other| other.chi_square < part.chi_square);
                    left.loss(hypothesis, deeper.as_ref().unwrap_or(&part))
                }
            }
        })
        .or_first_error();
    Ok(parts?.into_iter().sum())
}

/// Returns the loss of a fit to the retained data on the left-out data: see [`predictive_loss`]. Of the
/// coordinates of both, at most the first `shared` have the uncertainty of the fit; further ones, the
/// channels, are then those of the left-out data alone, within their tolerances.
pub(super) fn log_predictive_loss(
    (kept, left): (&DomainObjective<'_>, &DomainObjective<'_>),
    shared: usize,
    part: &Fitted,
    control: &Control,
) -> f64 {
    let information = kept.squares(|squares| squares.normal(&coordinates_of(kept, part)).information);
    // Coordinates of both: parameters, gain and channels; nut positions belong to each part alone.
    let of_both = |of: &DomainObjective<'_>| -> Vec<usize> {
        (0..of.nut_coordinates().start).chain(of.nut_coordinates().end..of.dimension()).take(shared).collect()
    };
    let (mut retained_coordinates, mut left_out_coordinates) = (of_both(kept), of_both(left));
    if retained_coordinates.len() != left_out_coordinates.len() {
        retained_coordinates.truncate(kept.nut_coordinates().start);
        left_out_coordinates.truncate(left.nut_coordinates().start);
    }
    let size = information.nrows();
    let Some(covariance) = (information + DMatrix::identity(size, size) * PRIOR_PRECISION).try_inverse()
    else {
        return f64::INFINITY;
    };
    let covariance = covariance.select_rows(&retained_coordinates).select_columns(&retained_coordinates);
    let place = coordinates_of(left, part);
    left.squares(|squares| {
        predictive_loss(squares, &place, &left_out_coordinates, covariance, control).unwrap_or(f64::INFINITY)
    })
}

/// Returns −2 ln of the predictive density of data, up to the constant of their weights, for coordinates with
/// a Gaussian distribution about given values. It is the least sum of χ² and of the squared deviation from
/// these values, plus a determinant for the remaining uncertainty. Exact for linear residuals.
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, §27–28 (Laplace's approximation
///   of the evidence).
fn predictive_loss(
    squares: &dyn LeastSquares,
    place: &[f64],
    coordinates: &[usize],
    covariance: DMatrix<f64>,
    control: &Control,
) -> Option<f64> {
    let precision = covariance.clone().try_inverse()?;
    let constrained = ConstrainedFit { squares, centre: place, coordinates, precision };
    let found = least_squares_within(&constrained, place, &[], COVARIANCE_STEPS, control.stop());
    let information = squares.normal(&found.place).information;
    let information = information.select_rows(coordinates).select_columns(coordinates);
    let widening =
        (DMatrix::identity(covariance.nrows(), covariance.nrows()) + covariance * information).determinant();
    Some(found.normal.chi_square + widening.max(1.0).ln())
}

/// A sum of squares with a Gaussian prior on some coordinates.
struct ConstrainedFit<'a> {
    squares: &'a dyn LeastSquares,
    centre: &'a [f64],
    coordinates: &'a [usize],
    precision: DMatrix<f64>,
}

impl ConstrainedFit<'_> {
    fn deviation(&self, place: &[f64]) -> DVector<f64> {
        DVector::from_iterator(
            self.coordinates.len(),
            self.coordinates.iter().map(|at| place[*at] - self.centre[*at]),
        )
    }
}

impl LeastSquares for ConstrainedFit<'_> {
    fn dimension(&self) -> usize {
        self.squares.dimension()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let deviation = self.deviation(place);
        self.squares.chi_square(place) + deviation.dot(&(&self.precision * &deviation))
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let mut normal = self.squares.normal(place);
        let deviation = self.deviation(place);
        let pull = &self.precision * &deviation;
        normal.chi_square += deviation.dot(&pull);
        for (a, at) in self.coordinates.iter().enumerate() {
            normal.gradient[*at] += pull[a];
            for (b, other) in self.coordinates.iter().enumerate() {
                normal.information[(*at, *other)] += self.precision[(a, b)];
            }
        }
        normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two readings r = A·(x − x₀), the second of which depends on the second coordinate alone.
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
            NormalEquations {
                chi_square: residuals.norm_squared(),
                gradient,
                information: self.0.transpose() * &self.0,
            }
        }
    }

    /// For linear residuals: rᵀ·S⁻¹·r + ln det S with S = 1 + A·V·Aᵀ, written out.
    #[test]
    fn limit_the_predictive_loss_of_linear_residuals_is_their_density() {
        let slopes = DMatrix::from_row_slice(3, 2, &[3.0, -1.0, 0.0, 20.0, 5.0, 2.0]);
        let linear = Linear(slopes.clone(), DVector::from_column_slice(&[0.52, 0.43]));
        let covariance = DMatrix::from_row_slice(2, 2, &[4e-4, 1e-4, 1e-4, 9e-3]);
        let place = [0.5, 0.5];
        let residuals = &slopes * (DVector::from_column_slice(&place) - &linear.1);
        let spread = DMatrix::identity(3, 3) + &slopes * &covariance * slopes.transpose();
        let exact =
            residuals.dot(&(spread.clone().try_inverse().unwrap() * &residuals)) + spread.determinant().ln();
        let found = predictive_loss(&linear, &place, &[0, 1], covariance, &Control::default()).unwrap();
        assert!((found - exact).abs() < 1e-6 * exact, "{found} instead of {exact}");
        // With certain coordinates it is χ².
        let certain =
            predictive_loss(&linear, &place, &[0, 1], DMatrix::identity(2, 2) * 1e-14, &Control::default())
                .unwrap();
        assert!((certain - residuals.norm_squared()).abs() < 1e-6);
    }
}
