//! Positions foretold by a fit without them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::domain::{Compared, Domain};
use super::fit::{Fitted, Fitter, SCATTERED_WITHOUT_ONE, place_of};
use super::hypothesis::Hypothesis;
use crate::numeric::parallel::OrFirstError;
use crate::objective::ObjectiveError;
use crate::optimizer::{Control, LeastSquares, Normal, least_squares_within};

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
pub fn left_out(fitter: &Fitter<'_>, hypothesis: &Hypothesis, fitted: &Fitted, control: &Control) -> Result<f64, ObjectiveError> {
    let blocks = fitter.blocks();
    // One record alone leaves nothing to fit.
    if blocks.len() < 2 {
        return Ok(0.0);
    }
    let piece = fitter.piece("left out", hypothesis, std::slice::from_ref(fitted));
    control.kept_or_failed(&piece, || left_out_anew(fitter, hypothesis, fitted, control))
}

fn left_out_anew(fitter: &Fitter<'_>, hypothesis: &Hypothesis, fitted: &Fitted, control: &Control) -> Result<f64, ObjectiveError> {
    let blocks = fitter.blocks();
    let parts: Result<Vec<f64>, ObjectiveError> = blocks
        .into_par_iter()
        .map(|(kept, left)| {
            let kept = fitter.on(kept);
            let objective = kept.objective(hypothesis)?;
            let part = kept.descend(&objective, fitted, STEPS, control);
            let left = fitter.on(left);
            match fitter.domain {
                Domain::Frf(_) => Ok(surprise((&objective, &left.objective(hypothesis)?), &part, control)),
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

/// −2 ln of the density of one part of the data, but for what its weights give, where the parameters are as a fit to the others leaves them: the least
/// of χ² and of what it costs to move them, and how much of them was open (Laplace's approximation).
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, §27–28 (evidence of a further datum).
fn surprise((kept, left): (&Compared<'_>, &Compared<'_>), part: &Fitted, control: &Control) -> f64 {
    let told = kept.squares(|squares| squares.normal(&place_of(kept, part)).information);
    let place = place_of(left, part);
    // Coordinates of both: parameters and gain, and the channels; nut positions are each part's own.
    let shared = |of: &Compared<'_>| -> Vec<usize> { (0..of.nut_coordinates().start).chain(of.nut_coordinates().end..of.dimension()).collect() };
    let (mut there, mut here) = (shared(kept), shared(left));
    if there.len() != here.len() {
        there.truncate(kept.nut_coordinates().start);
        here.truncate(left.nut_coordinates().start);
    }
    let size = told.nrows();
    let known = DMatrix::from_fn(size, size, |a, b| told[(a, b)] + if a == b { IN_RANGE } else { 0.0 });
    let Some(open) = known.try_inverse() else { return f64::INFINITY };
    let open = DMatrix::from_fn(there.len(), there.len(), |a, b| open[(there[a], there[b])]);
    let Some(precision) = open.clone().try_inverse() else { return f64::INFINITY };
    left.squares(|squares| {
        let within = Within { squares, centre: &place, coordinates: &here, precision };
        let found = least_squares_within(&within, &place, &[], OPEN_STEPS, control.stop());
        let felt = squares.normal(&found.place).information;
        let felt = DMatrix::from_fn(here.len(), here.len(), |a, b| felt[(here[a], here[b])]);
        let opened = (DMatrix::identity(here.len(), here.len()) + open * felt).determinant();
        found.normal.chi_square + opened.max(1.0).ln()
    })
}

/// A sum of squares beside what is known of some coordinates.
struct Within<'a> {
    squares: &'a dyn LeastSquares,
    centre: &'a [f64],
    coordinates: &'a [usize],
    precision: DMatrix<f64>,
}

impl Within<'_> {
    fn moved(&self, place: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.coordinates.len(), self.coordinates.iter().map(|at| place[*at] - self.centre[*at]))
    }
}

impl LeastSquares for Within<'_> {
    fn dimension(&self) -> usize {
        self.squares.dimension()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let moved = self.moved(place);
        self.squares.chi_square(place) + moved.dot(&(&self.precision * &moved))
    }

    fn normal(&self, place: &[f64]) -> Normal {
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
