//! Gauss–Newton on bounded parameters, for predictions that are linear in most of them. A fully linear
//! prediction needs a single step.

use nalgebra::{DMatrix, DVector};

use numeric::linear_fit::LinearFit;

/// A prediction that is fitted to observations.
pub trait PredictionFunction {
    /// Error of the model.
    type Error;

    /// Computes the prediction at these values; `None` where the work was stopped.
    ///
    /// # Errors  those of the model. A step that leads to an error is shortened.
    fn at(&self, values: &[f64]) -> Result<Option<DVector<f64>>, Self::Error>;

    /// Computes its derivatives with respect to the coordinates, in their order, at values that predict
    /// `here`; `None` where the work was stopped.
    ///
    /// # Errors  those of the model.
    fn derivatives(&self, values: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, Self::Error>;
}

/// A fitted value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Index of the value.
    pub index: usize,
    /// Its range; the lower end is above zero where `inverse`.
    pub range: (f64, f64),
    /// Whether steps are made in its inverse, in which the prediction is linear.
    pub inverse: bool,
}

impl Coordinate {
    /// Returns its value and range, inverted where steps are made in the inverse.
    fn place(&self, values: &[f64]) -> (f64, f64, f64) {
        let ((lower, upper), value) = (self.range, values[self.index]);
        if self.inverse { (1.0 / value, 1.0 / upper, 1.0 / lower) } else { (value, lower, upper) }
    }
}

/// Settings of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewton {
    /// Maximum number of steps.
    pub steps: usize,
    /// Number of step lengths tried, each half of the previous one.
    pub lengths: usize,
    /// Least relative reduction of the sum of squares by a step, below which the fit has converged.
    pub gain: f64,
}

/// Result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussNewtonFit {
    /// All values.
    pub values: Vec<f64>,
    /// The prediction at these values.
    pub prediction: DVector<f64>,
    /// Observed minus predicted values.
    pub residual: DVector<f64>,
    /// Derivatives of the prediction with respect to the coordinates at the start of the last step; zero
    /// where the fit stopped before the first.
    pub derivatives: DMatrix<f64>,
    /// Whether the last step reduced nothing, so that the derivatives are those at the result.
    pub at_end: bool,
    /// Number of predictions made.
    pub evaluations: u64,
    /// Whether the fit converged: neither stopped nor out of steps.
    pub converged: bool,
}

/// Why a fit failed.
#[derive(Debug, Clone, PartialEq)]
pub enum GaussNewtonError<E> {
    /// The model or its derivatives fail at the start.
    Model(E),
    /// Stopped before the first step.
    Stopped,
    /// Coordinates are linearly dependent, or one has no influence at the start: the coordinates that were to
    /// move, and the derivatives.
    Dependent(Vec<usize>, DMatrix<f64>),
}

impl GaussNewton {
    /// Minimises the sum of squares of `observed` minus the prediction. Steps stay within the ranges and are
    /// shortened where they do not reduce the sum. A coordinate that loses its influence on the way keeps its
    /// value.
    ///
    /// # Errors  see [`GaussNewtonError`].
    pub fn fit<P: PredictionFunction>(
        &self,
        prediction: &P,
        observed: &DVector<f64>,
        start: &[f64],
        coordinates: &[Coordinate],
    ) -> Result<GaussNewtonFit, GaussNewtonError<P::Error>> {
        let mut values = start.to_vec();
        let mut here =
            prediction.at(&values).map_err(GaussNewtonError::Model)?.ok_or(GaussNewtonError::Stopped)?;
        let mut residual = observed - &here;
        let mut evaluations = 1;
        let mut derivatives = DMatrix::zeros(observed.len(), coordinates.len());
        let (mut at_end, mut converged) = (false, false);
        for round in 0..self.steps {
            let found = prediction.derivatives(&values, &here).map_err(GaussNewtonError::Model)?;
            evaluations += coordinates.len() as u64;
            let Some(found) = found else { break };
            let step = step(&values, coordinates, &found, &residual, round == 0).ok_or_else(|| {
                // The first step needs all coordinates; later steps need those that still have an influence.
                let moving =
                    if round == 0 { (0..coordinates.len()).collect() } else { nonzero_columns(&found) };
                GaussNewtonError::Dependent(moving.clone(), found.select_columns(&moving))
            })?;
            (derivatives, at_end) = (found, true);
            let squares = residual.norm_squared();
            let mut gained = None;
            for halvings in 0..self.lengths {
                let next = moved(&values, coordinates, &step, 0.5_f64.powi(halvings as i32));
                evaluations += 1;
                let there = match prediction.at(&next) {
                    Ok(None) => {
                        return Ok(GaussNewtonFit {
                            values,
                            prediction: here,
                            residual,
                            derivatives,
                            at_end,
                            evaluations,
                            converged: false,
                        });
                    }
                    Ok(there) => there,
                    Err(_) => None,
                };
                let candidate = there.map(|there| (observed - &there, there));
                if let Some((next_residual, there)) =
                    candidate.filter(|(residual, _)| residual.norm_squared() < squares)
                {
                    gained = Some((next, next_residual, there));
                    break;
                }
            }
            let Some(next) = gained else {
                converged = true;
                break;
            };
            (values, residual, here) = next;
            at_end = false;
            if squares - residual.norm_squared() <= self.gain * squares {
                converged = true;
                break;
            }
        }
        Ok(GaussNewtonFit { values, prediction: here, residual, derivatives, at_end, evaluations, converged })
    }
}

/// Returns the indices of nonzero columns.
pub fn nonzero_columns(derivatives: &DMatrix<f64>) -> Vec<usize> {
    (0..derivatives.ncols()).filter(|at| derivatives.column(*at).norm() > 0.0).collect()
}

/// Computes the step of each coordinate, zero for one without influence.
///
/// `None` where moving coordinates are linearly dependent, or where `all` must move and one has no influence.
fn step(
    values: &[f64],
    coordinates: &[Coordinate],
    derivatives: &DMatrix<f64>,
    residual: &DVector<f64>,
    all: bool,
) -> Option<Vec<f64>> {
    let influential = nonzero_columns(derivatives);
    if all && influential.len() < coordinates.len() {
        return None;
    }
    let mut columns = derivatives.select_columns(&influential);
    for (mut column, at) in columns.column_iter_mut().zip(&influential) {
        let coordinate = &coordinates[*at];
        if coordinate.inverse {
            // d/d(1/p) = −p²·d/dp.
            column *= -values[coordinate.index].powi(2);
        }
    }
    let places: Vec<(f64, f64, f64)> = influential.iter().map(|at| coordinates[*at].place(values)).collect();
    let mut step = vec![0.0; coordinates.len()];
    let within = step_within(&places, &columns, residual)?;
    influential.into_iter().zip(within).for_each(|(at, moved)| step[at] = moved);
    Some(step)
}

/// Moves the values by a share of a step. A value that does not move stays bit-identical, which a double
/// inversion would not preserve.
fn moved(values: &[f64], coordinates: &[Coordinate], step: &[f64], share: f64) -> Vec<f64> {
    let mut next = values.to_vec();
    for (coordinate, delta) in coordinates.iter().zip(step).filter(|(_, delta)| **delta != 0.0) {
        let (at, lower, upper) = coordinate.place(values);
        let there = (at + share * delta).clamp(lower, upper);
        next[coordinate.index] = if coordinate.inverse { 1.0 / there } else { there };
    }
    next
}

/// Computes the bounded least-squares step of linear columns from (value, lower, upper) triples.
///
/// Where coordinates would leave their ranges, the one that reaches its end first is held there, and the
/// others are solved again. Of two nearly dependent coordinates, the one with the narrow range is thus held.
fn step_within(
    places: &[(f64, f64, f64)],
    derivatives: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<Vec<f64>> {
    let mut step = vec![0.0; places.len()];
    let mut open: Vec<usize> = (0..places.len()).collect();
    let mut remaining = residual.clone();
    while !open.is_empty() {
        let solved = LinearFit::new(&derivatives.select_columns(&open), &remaining)?;
        let mut first: Option<(f64, usize)> = None;
        for (&at, &delta) in open.iter().zip(solved.coefficients.iter()) {
            let (value, lower, upper) = places[at];
            let wanted = value + delta;
            let kept = wanted.clamp(lower, upper);
            step[at] = kept - value;
            let share = step[at] / delta;
            if kept != wanted && first.is_none_or(|(least, _)| share < least) {
                first = Some((share, at));
            }
        }
        let Some((_, held)) = first else { break };
        remaining -= step[held] * derivatives.column(held);
        open.retain(|at| *at != held);
    }
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// c above its largest value.
    #[derive(Debug, PartialEq)]
    struct TooFast;

    /// y = a·t + 1e6/b + exp(−c·t): linear in a and 1/b, nonlinear in c.
    struct Decay;

    impl PredictionFunction for Decay {
        type Error = TooFast;
        fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, TooFast> {
            if v[2] > 40.0 {
                return Err(TooFast);
            }
            Ok(Some(DVector::from_fn(50, |i, _| {
                v[0] * 0.1 * i as f64 + 1e6 / v[1] + (-v[2] * 0.1 * i as f64).exp()
            })))
        }
        fn derivatives(&self, v: &[f64], _: &DVector<f64>) -> Result<Option<DMatrix<f64>>, TooFast> {
            Ok(Some(DMatrix::from_fn(50, 3, |i, j| {
                let t = 0.1 * i as f64;
                [t, -1e6 / (v[1] * v[1]), -t * (-v[2] * t).exp()][j]
            })))
        }
    }

    const SETTINGS: GaussNewton = GaussNewton { steps: 30, lengths: 10, gain: 1e-12 };

    fn coordinates() -> Vec<Coordinate> {
        let of = |index, range, inverse| Coordinate { index, range, inverse };
        vec![of(0, (-10.0, 10.0), false), of(1, (1e4, 1e9), true), of(2, (0.01, 100.0), false)]
    }

    #[test]
    fn limit_a_smooth_prediction_converges_from_a_distant_start() {
        let truth = [1.5, 2e5, 3.0];
        let observed = Decay.at(&truth).unwrap().unwrap();
        let found = SETTINGS.fit(&Decay, &observed, &[-3.0, 1e8, 20.0], &coordinates()).unwrap();
        assert!(
            found.converged && found.values.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 1e-8),
            "{found:?}"
        );
    }

    /// The same prediction, stopped after a number of evaluations.
    struct Stopped(std::cell::Cell<u64>);

    impl PredictionFunction for Stopped {
        type Error = TooFast;
        fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, TooFast> {
            let left = self.0.get();
            self.0.set(left.saturating_sub(1));
            if left == 0 { Ok(None) } else { Decay.at(v) }
        }
        fn derivatives(&self, v: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, TooFast> {
            Decay.derivatives(v, here)
        }
    }

    #[test]
    fn a_stopped_fit_keeps_its_progress() {
        let observed = Decay.at(&[1.5, 2e5, 3.0]).unwrap().unwrap();
        let run = |predictions: u64| {
            SETTINGS.fit(&Stopped(predictions.into()), &observed, &[-3.0, 1e8, 20.0], &coordinates())
        };
        assert_eq!(run(0), Err(GaussNewtonError::Stopped));
        let (first, third) = (run(1).unwrap(), run(3).unwrap());
        assert!(!first.converged && first.values == [-3.0, 1e8, 20.0] && first.derivatives.norm() > 0.0);
        assert!(
            !third.converged
                && third.residual.norm() < first.residual.norm()
                && third.derivatives.norm() > 0.0
        );
        assert_eq!(first.evaluations, 1 + 3 + 1);
    }

    #[test]
    fn dependent_coordinates_or_coordinates_without_influence_are_reported() {
        struct Twice(f64);
        impl PredictionFunction for Twice {
            type Error = TooFast;
            fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, TooFast> {
                Ok(Some(DVector::from_fn(9, |i, _| (v[0] + self.0 * v[1]) * i as f64)))
            }
            fn derivatives(&self, _: &[f64], _: &DVector<f64>) -> Result<Option<DMatrix<f64>>, TooFast> {
                Ok(Some(DMatrix::from_fn(9, 2, |i, j| [1.0, self.0][j] * i as f64)))
            }
        }
        for same in [2.0, 0.0] {
            let found = SETTINGS.fit(
                &Twice(same),
                &DVector::from_element(9, 1.0),
                &[0.0, 1e6, 0.0],
                &coordinates()[..2],
            );
            assert!(matches!(found, Err(GaussNewtonError::Dependent(moving, _)) if moving == [0, 1]));
        }
    }

    #[test]
    fn limit_a_minimum_outside_the_range_is_reached_at_its_end() {
        let observed = Decay.at(&[20.0, 2e5, 3.0]).unwrap().unwrap();
        let found = SETTINGS.fit(&Decay, &observed, &[0.0, 2e5, 3.0], &coordinates()).unwrap();
        assert_eq!(found.values[0], 10.0);
    }

    /// Two nearly dependent columns: the coordinate with the narrow range stops at its end, and the other
    /// takes the remaining step.
    #[test]
    fn limit_the_coordinate_with_the_narrow_range_is_held_first() {
        let wave = |n: f64, i: usize| (n * i as f64 / 50.0).sin();
        let columns =
            DMatrix::from_fn(400, 2, |i, column| wave(1.0, i) + 1e-3 * column as f64 * wave(3.0, i));
        let y = DVector::from_fn(400, |i, _| 0.2 * wave(1.0, i) - 0.05 * wave(3.0, i));
        let places = [(1.0, 0.97, 1.03), (0.0, -0.5, 0.5)];
        let step = step_within(&places, &columns, &y).unwrap();
        let misfit = |step: &[f64]| (&y - &columns * DVector::from_column_slice(step)).norm();
        let grid = (0..=60)
            .flat_map(|a| (0..=1000).map(move |b| [-0.03 + 1e-3 * f64::from(a), -0.5 + 1e-3 * f64::from(b)]));
        let least = grid.map(|step| misfit(&step)).fold(f64::INFINITY, f64::min);
        assert!(misfit(&step) < least + 1e-3, "{step:?}: {} for {least}", misfit(&step));
    }
}
