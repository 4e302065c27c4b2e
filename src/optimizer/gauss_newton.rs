//! Gauss–Newton on parameters within ranges, for predictions that are linear in most of them: then one step is the end.

use nalgebra::{DMatrix, DVector};

use numeric::linear_fit::LinearFit;

/// What is fitted to numbers that were observed.
pub trait PredictionFunction {
    /// Why a prediction fails.
    type Error;

    /// The prediction with these values; `None` where the work was stopped.
    ///
    /// # Errors  as the model says. A step that leads to an error is shortened.
    fn at(&self, values: &[f64]) -> Result<Option<DVector<f64>>, Self::Error>;

    /// Its derivatives with the coordinates, in their order, at values that predict `here`; `None` where the work was stopped.
    ///
    /// # Errors  as the model says.
    fn derivatives(&self, values: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, Self::Error>;
}

/// A value that is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Which of the values.
    pub index: usize,
    /// Its ends, the lower above zero where `inverse`.
    pub range: (f64, f64),
    /// Steps are made in its inverse, since the prediction is linear in that.
    pub inverse: bool,
}

impl Coordinate {
    /// Where it stands, and its ends: of the inverse where steps are made in that.
    fn place(&self, values: &[f64]) -> (f64, f64, f64) {
        let ((lower, upper), value) = (self.range, values[self.index]);
        if self.inverse { (1.0 / value, 1.0 / upper, 1.0 / lower) } else { (value, lower, upper) }
    }
}

/// When a fit ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewton {
    /// Most steps.
    pub steps: usize,
    /// Lengths at which a step is tried, each half of the one before.
    pub lengths: usize,
    /// Share of the sum of squares that a step must take for another to follow.
    pub gain: f64,
}

/// Where a fit ended.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussNewtonFit {
    /// All values.
    pub values: Vec<f64>,
    /// The prediction with them.
    pub prediction: DVector<f64>,
    /// Observed less predicted.
    pub residual: DVector<f64>,
    /// Derivatives of the prediction with the coordinates from which the last step was made; zero where it was stopped before the first.
    pub derivatives: DMatrix<f64>,
    /// Whether that step gained nothing, so that they are those of the end.
    pub at_end: bool,
    /// Predictions made.
    pub evaluations: u64,
    /// Came to rest; not stopped, and not out of steps.
    pub converged: bool,
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq)]
pub enum GaussNewtonError<E> {
    /// The model fails at the start, or its derivatives do.
    Model(E),
    /// Stopped before the first step.
    Stopped,
    /// The data do not tell coordinates apart, or one of them does nothing at the start: which were to move, and the derivatives with them.
    Dependent(Vec<usize>, DMatrix<f64>),
}

impl GaussNewton {
    /// Minimises the sum of squares of `observed` less the prediction. Steps are kept within the ranges and shortened where they do not gain; a coordinate
    /// that comes to do nothing on the way stays where it is.
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
        let mut here = prediction.at(&values).map_err(GaussNewtonError::Model)?.ok_or(GaussNewtonError::Stopped)?;
        let mut residual = observed - &here;
        let mut evaluations = 1;
        let mut derivatives = DMatrix::zeros(observed.len(), coordinates.len());
        let (mut at_end, mut converged) = (false, false);
        for round in 0..self.steps {
            let found = prediction.derivatives(&values, &here).map_err(GaussNewtonError::Model)?;
            evaluations += coordinates.len() as u64;
            let Some(found) = found else { break };
            let step = step(&values, coordinates, &found, &residual, round == 0).ok_or_else(|| {
                // At the start every coordinate is asked for; later those that still do something.
                let moving = if round == 0 { (0..coordinates.len()).collect() } else { live_columns(&found) };
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
                let left = there.map(|there| (observed - &there, there));
                if let Some((left, there)) = left.filter(|(left, _)| left.norm_squared() < squares) {
                    gained = Some((next, left, there));
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

/// Columns that are not nothing.
pub fn live_columns(derivatives: &DMatrix<f64>) -> Vec<usize> {
    (0..derivatives.ncols()).filter(|at| derivatives.column(*at).norm() > 0.0).collect()
}

/// The step of each coordinate, none of one that does nothing; `None` where those that move depend on each other, or where all must and one does nothing.
fn step(values: &[f64], coordinates: &[Coordinate], derivatives: &DMatrix<f64>, residual: &DVector<f64>, all: bool) -> Option<Vec<f64>> {
    let live = live_columns(derivatives);
    if all && live.len() < coordinates.len() {
        return None;
    }
    let mut columns = derivatives.select_columns(&live);
    for (mut column, at) in columns.column_iter_mut().zip(&live) {
        let coordinate = &coordinates[*at];
        if coordinate.inverse {
            // d/d(1/p) = −p²·d/dp.
            column *= -values[coordinate.index].powi(2);
        }
    }
    let places: Vec<(f64, f64, f64)> = live.iter().map(|at| coordinates[*at].place(values)).collect();
    let mut step = vec![0.0; coordinates.len()];
    let within = step_within(&places, &columns, residual)?;
    live.into_iter().zip(within).for_each(|(at, moved)| step[at] = moved);
    Some(step)
}

/// Values moved by a share of a step. One that does not move keeps all of its bits: an inverse of an inverse does not.
fn moved(values: &[f64], coordinates: &[Coordinate], step: &[f64], share: f64) -> Vec<f64> {
    let mut next = values.to_vec();
    for (coordinate, delta) in coordinates.iter().zip(step).filter(|(_, delta)| **delta != 0.0) {
        let (at, lower, upper) = coordinate.place(values);
        let there = (at + share * delta).clamp(lower, upper);
        next[coordinate.index] = if coordinate.inverse { 1.0 / there } else { there };
    }
    next
}

/// The step to the least squares of linear columns from places with their ends (place, lower, upper). Where some would leave their ranges, the one that
/// would be at its end first is held there, and the others are looked at anew: of two that do nearly the same, the one in the narrow range stays.
fn step_within(places: &[(f64, f64, f64)], derivatives: &DMatrix<f64>, residual: &DVector<f64>) -> Option<Vec<f64>> {
    let mut step = vec![0.0; places.len()];
    let mut open: Vec<usize> = (0..places.len()).collect();
    let mut left = residual.clone();
    while !open.is_empty() {
        let solved = LinearFit::new(&derivatives.select_columns(&open), &left)?;
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
        left -= step[held] * derivatives.column(held);
        open.retain(|at| *at != held);
    }
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = a·t + b/(c) with c fitted by its inverse, and a decay that is not linear.
    struct Decay;

    impl PredictionFunction for Decay {
        type Error = String;
        fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, String> {
            if v[2] > 40.0 {
                return Err("too fast".into());
            }
            Ok(Some(DVector::from_fn(50, |i, _| v[0] * 0.1 * i as f64 + 1e6 / v[1] + (-v[2] * 0.1 * i as f64).exp())))
        }
        fn derivatives(&self, v: &[f64], _: &DVector<f64>) -> Result<Option<DMatrix<f64>>, String> {
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
    fn limit_a_smooth_prediction_is_met_from_afar() {
        let truth = [1.5, 2e5, 3.0];
        let observed = Decay.at(&truth).unwrap().unwrap();
        let found = SETTINGS.fit(&Decay, &observed, &[-3.0, 1e8, 20.0], &coordinates()).unwrap();
        assert!(found.converged && found.values.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 1e-8), "{found:?}");
    }

    /// The same, stopped after some predictions.
    struct Stopped(std::cell::Cell<u64>);

    impl PredictionFunction for Stopped {
        type Error = String;
        fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, String> {
            let left = self.0.get();
            self.0.set(left.saturating_sub(1));
            if left == 0 { Ok(None) } else { Decay.at(v) }
        }
        fn derivatives(&self, v: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, String> {
            Decay.derivatives(v, here)
        }
    }

    #[test]
    fn a_stop_keeps_what_was_gained() {
        let observed = Decay.at(&[1.5, 2e5, 3.0]).unwrap().unwrap();
        let run = |predictions: u64| SETTINGS.fit(&Stopped(predictions.into()), &observed, &[-3.0, 1e8, 20.0], &coordinates());
        assert_eq!(run(0), Err(GaussNewtonError::Stopped));
        let (first, third) = (run(1).unwrap(), run(3).unwrap());
        assert!(!first.converged && first.values == [-3.0, 1e8, 20.0] && first.derivatives.norm() > 0.0);
        assert!(!third.converged && third.residual.norm() < first.residual.norm() && third.derivatives.norm() > 0.0);
        assert_eq!(first.evaluations, 1 + 3 + 1);
    }

    #[test]
    fn dependent_or_idle_coordinates_are_reported() {
        struct Twice(f64);
        impl PredictionFunction for Twice {
            type Error = String;
            fn at(&self, v: &[f64]) -> Result<Option<DVector<f64>>, String> {
                Ok(Some(DVector::from_fn(9, |i, _| (v[0] + self.0 * v[1]) * i as f64)))
            }
            fn derivatives(&self, _: &[f64], _: &DVector<f64>) -> Result<Option<DMatrix<f64>>, String> {
                Ok(Some(DMatrix::from_fn(9, 2, |i, j| [1.0, self.0][j] * i as f64)))
            }
        }
        for same in [2.0, 0.0] {
            let found = SETTINGS.fit(&Twice(same), &DVector::from_element(9, 1.0), &[0.0, 1e6, 0.0], &coordinates()[..2]);
            assert!(matches!(found, Err(GaussNewtonError::Dependent(moving, _)) if moving == [0, 1]));
        }
    }

    #[test]
    fn limit_a_minimum_outside_is_met_at_the_end_of_the_range() {
        let observed = Decay.at(&[20.0, 2e5, 3.0]).unwrap().unwrap();
        let found = SETTINGS.fit(&Decay, &observed, &[0.0, 2e5, 3.0], &coordinates()).unwrap();
        assert_eq!(found.values[0], 10.0);
    }

    /// Two columns that are nearly one: the number known within a narrow range ends at it, and the other takes what is left.
    #[test]
    fn limit_what_is_known_narrowly_is_held_first() {
        let wave = |n: f64, i: usize| (n * i as f64 / 50.0).sin();
        let columns = DMatrix::from_fn(400, 2, |i, column| wave(1.0, i) + 1e-3 * column as f64 * wave(3.0, i));
        let y = DVector::from_fn(400, |i, _| 0.2 * wave(1.0, i) - 0.05 * wave(3.0, i));
        let places = [(1.0, 0.97, 1.03), (0.0, -0.5, 0.5)];
        let step = step_within(&places, &columns, &y).unwrap();
        let left = |step: &[f64]| (&y - &columns * DVector::from_column_slice(step)).norm();
        let grid = (0..=60).flat_map(|a| (0..=1000).map(move |b| [-0.03 + 1e-3 * f64::from(a), -0.5 + 1e-3 * f64::from(b)]));
        let least = grid.map(|step| left(&step)).fold(f64::INFINITY, f64::min);
        assert!(left(&step) < least + 1e-3, "{step:?}: {} for {least}", left(&step));
    }
}
