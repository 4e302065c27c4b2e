//! Bounded least squares: Levenberg–Marquardt on the unit cube as an argmin solver.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::core::{
    CostFunction, Error, Executor, IterState, Jacobian, KV, Problem, Solver, State, TerminationReason,
    TerminationStatus,
};
use nalgebra::{DMatrix, DVector};

/// The normal equations of a sum of squares χ² = Σ r² at a place. They suffice for a step, for the covariance
/// and for a sum over data sets.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    /// χ².
    pub chi_square: f64,
    /// Jᵀ·r, with J = dr/d(place).
    pub gradient: DVector<f64>,
    /// Jᵀ·J.
    pub information: DMatrix<f64>,
}

impl NormalEquations {
    /// Returns the normal equations of no residuals.
    pub fn zero(dimension: usize) -> Self {
        NormalEquations {
            chi_square: 0.0,
            gradient: DVector::zeros(dimension),
            information: DMatrix::zeros(dimension, dimension),
        }
    }

    /// Adds one residual and its derivatives, with a weight on its square. Only the lower triangle of the
    /// information is filled: see
    /// [`NormalEquations::mirror`].
    #[inline]
    pub fn add(&mut self, weight: f64, residual: f64, row: &[f64]) {
        self.chi_square += weight * residual * residual;
        for (i, a) in row.iter().enumerate() {
            let scaled = weight * a;
            self.gradient[i] += scaled * residual;
            for (j, b) in row[..=i].iter().enumerate() {
                self.information[(i, j)] += scaled * b;
            }
        }
    }

    /// Adds the normal equations of other residuals.
    pub fn merge(&mut self, other: &NormalEquations) {
        self.chi_square += other.chi_square;
        self.gradient += &other.gradient;
        self.information += &other.information;
    }

    /// Fills in the upper triangle of the information.
    pub fn mirror(&mut self) {
        self.information.fill_upper_triangle_with_lower_triangle();
    }
}

/// A sum of squares on the unit cube, finite everywhere, with accurate derivatives.
pub trait LeastSquares: Sync {
    /// Returns the number of coordinates.
    fn dimension(&self) -> usize;
    /// Computes χ² at a place.
    fn chi_square(&self, place: &[f64]) -> f64;
    /// Computes χ² and its normal equations.
    fn normal(&self, place: &[f64]) -> NormalEquations;
}

struct Problemwise<'p, P: LeastSquares + ?Sized>(&'p P);

impl<P: LeastSquares + ?Sized> CostFunction for Problemwise<'_, P> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, place: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0.chi_square(place))
    }
}

impl<P: LeastSquares + ?Sized> Jacobian for Problemwise<'_, P> {
    type Param = Vec<f64>;
    type Jacobian = NormalEquations;
    fn jacobian(&self, place: &Vec<f64>) -> Result<NormalEquations, Error> {
        Ok(self.0.normal(place))
    }
}

type PolishState = IterState<Vec<f64>, (), (), (), (), f64>;

/// Longest step in any coordinate, as a share of the unit cube.
const LONGEST_STEP: f64 = 0.25;

/// Levenberg–Marquardt with Nielsen's damping, inside the unit cube.
///
/// Coordinates at a face with a descent direction pointing outward are excluded from a step. Those that would
/// cross a face stop there, and the others are solved again. The gain is measured relative to the actual
/// step.
///
/// # Source  Madsen, Nielsen, Tingleff, Methods for Non-Linear Least Squares Problems, IMM 2004, Alg. 3.16;
/// bounds by projection: Kanzow, Yamashita, Fukushima, J. Comput. Appl. Math. 172 (2004) 375–397.
pub struct LevenbergMarquardt {
    held: Vec<bool>,
    damping: f64,
    growth: f64,
    here: Option<(Vec<f64>, NormalEquations)>,
    tolerance: f64,
    converged: bool,
    stop: Arc<AtomicBool>,
}

impl LevenbergMarquardt {
    /// Creates a solver. Coordinates marked in `held` keep their place; the solver ends when a step reduces
    /// χ² by less than `tolerance` (relative).
    pub fn new(held: Vec<bool>, tolerance: f64) -> Self {
        LevenbergMarquardt {
            held,
            damping: 1e-3,
            growth: 2.0,
            here: None,
            tolerance,
            converged: false,
            stop: Arc::default(),
        }
    }

    /// Sets the flag that ends the solver after the current step.
    pub fn with_stop_flag(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = stop;
        self
    }

    /// Returns the coordinates that may move: neither held nor pushed out of the cube at a face.
    fn active(&self, place: &[f64], normal: &NormalEquations) -> Vec<usize> {
        let moves = |i: &usize| {
            let slope = normal.gradient[*i];
            let pushed_out = (place[*i] <= 0.0 && slope > 0.0) || (place[*i] >= 1.0 && slope < 0.0);
            !self.held[*i] && !pushed_out
        };
        (0..place.len()).filter(moves).collect()
    }

    /// Computes the step from a place with the present damping, and the predicted decrease of χ².
    ///
    /// Coordinates whose step would leave the cube stop at its face, and the others are solved again with
    /// those fixed there. The clipping thus does not distort the rest of the step.
    fn step(&self, place: &[f64], normal: &NormalEquations) -> Option<(Vec<f64>, f64)> {
        let mut active = self.active(place, normal);
        let mut made = DVector::zeros(place.len());
        while !active.is_empty() {
            let direction = within(LONGEST_STEP, |ridge| self.solved(normal, &made, &active, ridge))?;
            let outside = |at: usize| {
                let next = place[active[at]] + direction[at];
                if next < 0.0 { Some(0.0) } else { (next > 1.0).then_some(1.0) }
            };
            let cut: Vec<(usize, f64)> =
                (0..active.len()).filter_map(|at| Some((at, outside(at)?))).collect();
            if cut.is_empty() {
                active.iter().enumerate().for_each(|(at, &i)| made[i] = direction[at]);
                break;
            }
            for (at, face) in cut.iter().rev() {
                let i = active.remove(*at);
                made[i] = face - place[i];
            }
        }
        let next = (0..place.len()).map(|i| (place[i] + made[i]).clamp(0.0, 1.0)).collect();
        let predicted = -2.0 * made.dot(&normal.gradient) - made.dot(&(&normal.information * &made));
        Some((next, predicted))
    }

    /// Solves for the damped step of the active coordinates, with the coordinates moved by `made` at their
    /// new places.
    fn solved(
        &self,
        normal: &NormalEquations,
        made: &DVector<f64>,
        active: &[usize],
        ridge: f64,
    ) -> Option<DVector<f64>> {
        let slopes = &normal.gradient + &normal.information * made;
        let largest = active.iter().map(|i| normal.information[(*i, *i)]).fold(f64::MIN_POSITIVE, f64::max);
        let damped = DMatrix::from_fn(active.len(), active.len(), |a, b| {
            let entry = normal.information[(active[a], active[b])];
            if a == b { entry + self.damping * entry.max(1e-9 * largest) + ridge } else { entry }
        });
        let slope = DVector::from_fn(active.len(), |a, _| -slopes[active[a]]);
        Some(damped.cholesky()?.solve(&slope))
    }

    /// Computes the decrease of χ² by an undamped step of the active coordinates without regard to the faces;
    /// zero at a minimum.
    fn remaining_gain(&self, place: &[f64], normal: &NormalEquations) -> f64 {
        let active = self.active(place, normal);
        let largest = active.iter().map(|i| normal.information[(*i, *i)]).fold(f64::MIN_POSITIVE, f64::max);
        let slope = DVector::from_fn(active.len(), |a, _| -normal.gradient[active[a]]);
        // The limit of 1 keeps a step in a poorly determined direction inside the cube.
        let step = within(1.0, |ridge| {
            let information = DMatrix::from_fn(active.len(), active.len(), |a, b| {
                normal.information[(active[a], active[b])]
                    + if a == b { 1e-12 * largest + ridge } else { 0.0 }
            });
            Some(information.cholesky()?.solve(&slope))
        });
        step.map_or(f64::INFINITY, |step| slope.dot(&step))
    }
}

impl NormalEquations {
    /// Computes χ² after one linear step with no coordinate longer than `longest`.
    pub fn cost_after_step(&self, longest: f64) -> f64 {
        let size = self.gradient.len();
        let largest = (0..size).map(|d| self.information[(d, d)]).fold(f64::MIN_POSITIVE, f64::max);
        let step = within(longest, |ridge| {
            let damped = DMatrix::from_fn(size, size, |a, b| {
                self.information[(a, b)] + if a == b { 1e-9 * largest + ridge } else { 0.0 }
            });
            Some(-damped.cholesky()?.solve(&self.gradient))
        });
        step.map_or(self.chi_square, |step| {
            (self.chi_square + 2.0 * step.dot(&self.gradient) + step.dot(&(&self.information * &step)))
                .max(0.0)
        })
    }
}

/// Computes a step with no coordinate longer than `longest`.
///
/// A ridge on the information shortens the step in poorly determined directions and leaves the others nearly
/// unchanged. It is the smallest sufficient one of 1e-6, 1e-5, …, found by bisection: a larger ridge gives a
/// shorter step.
///
/// # Source  Levenberg's damping as a trust region in the unit cube: Nocedal and Wright, Numerical
///   Optimization, 2nd ed., §4.3.
fn within(longest: f64, solve: impl Fn(f64) -> Option<DVector<f64>>) -> Option<DVector<f64>> {
    let step = solve(0.0)?;
    if step.amax() <= longest {
        return Some(step);
    }
    // Exponents of ten: the largest that is too small, the smallest that is sufficient, and the one to try.
    let (mut too_small, mut sufficient, mut power): (i32, Option<(i32, DVector<f64>)>, i32) = (-7, None, -2);
    loop {
        let step = solve(10_f64.powi(power))?;
        let reach = step.amax();
        if reach <= longest {
            sufficient = Some((power, step));
        } else if power > 50 {
            return Some(step * (longest / reach));
        } else {
            too_small = power;
        }
        power = match &sufficient {
            None => too_small + 4,
            Some((least, _)) if *least > too_small + 1 => (least + too_small).div_euclid(2),
            Some(_) => return sufficient.map(|(_, step)| step),
        };
    }
}

impl<O> Solver<O, PolishState> for LevenbergMarquardt
where
    O: CostFunction<Param = Vec<f64>, Output = f64> + Jacobian<Param = Vec<f64>, Jacobian = NormalEquations>,
{
    fn name(&self) -> &str {
        "bounded Levenberg–Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        state: PolishState,
    ) -> Result<(PolishState, Option<KV>), Error> {
        let start: Vec<f64> =
            state.get_param().cloned().unwrap_or_default().iter().map(|x: &f64| x.clamp(0.0, 1.0)).collect();
        let normal = problem.jacobian(&start)?;
        let cost = normal.chi_square;
        self.here = Some((start.clone(), normal));
        Ok((state.param(start).cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        state: PolishState,
    ) -> Result<(PolishState, Option<KV>), Error> {
        let Some((place, normal)) = self.here.take() else {
            self.converged = true;
            return Ok((state, None));
        };
        let before = normal.chi_square;
        let stepped = self.step(&place, &normal);
        let least_gain = self.tolerance * before.max(f64::MIN_POSITIVE);
        let Some((next, predicted)) = stepped.filter(|(_, predicted)| *predicted > least_gain) else {
            // Either a minimum, or a step distorted by faces and damping; then a shorter step, closer to the
            // gradient, is tried.
            self.converged = self.remaining_gain(&place, &normal) <= least_gain || self.damping > 1e12;
            self.damping = (self.damping * self.growth).max(1e-3);
            self.growth *= 2.0;
            self.here = Some((place.clone(), normal));
            return Ok((state.param(place).cost(before), None));
        };
        let after = problem.cost(&next)?;
        let gain = (before - after) / predicted;
        if gain > 1e-4 && after.is_finite() {
            let normal = problem.jacobian(&next)?;
            self.converged = before - after <= self.tolerance * before
                && self.remaining_gain(&next, &normal) <= 10.0 * self.tolerance * after;
            self.damping =
                (self.damping * (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0)).max(1e-12);
            self.growth = 2.0;
            self.here = Some((next.clone(), normal));
            return Ok((state.param(next).cost(after), None));
        }
        self.damping *= self.growth;
        self.growth *= 2.0;
        self.converged = self.damping > 1e12;
        self.here = Some((place.clone(), normal));
        Ok((state.param(place).cost(before), None))
    }

    fn terminate(&mut self, _state: &PolishState) -> TerminationStatus {
        if self.stop.load(Ordering::Relaxed) {
            return TerminationStatus::Terminated(TerminationReason::Interrupt);
        }
        if self.converged {
            TerminationStatus::Terminated(TerminationReason::SolverConverged)
        } else {
            TerminationStatus::NotTerminated
        }
    }
}

/// Result of a local optimisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Polished {
    /// Place in the unit cube.
    pub place: Vec<f64>,
    /// χ² and its normal equations there.
    pub normal: NormalEquations,
    /// Number of evaluations of χ² or of the normal equations.
    pub evaluations: u64,
    /// Whether it converged before the iterations ran out.
    pub converged: bool,
}

/// Minimises χ² from a place, with some coordinates held.
pub fn least_squares<P: LeastSquares + ?Sized>(
    problem: &P,
    start: &[f64],
    held: &[bool],
    iterations: u64,
    stop: &Arc<AtomicBool>,
) -> Polished {
    least_squares_within(problem, start, held, (iterations, 1e-9), stop)
}

/// As [`least_squares`], with the maximum number of iterations and the relative reduction of χ² below which a
/// step is the last.
pub fn least_squares_within<P: LeastSquares + ?Sized>(
    problem: &P,
    start: &[f64],
    held: &[bool],
    (iterations, tolerance): (u64, f64),
    stop: &Arc<AtomicBool>,
) -> Polished {
    let held = if held.is_empty() { vec![false; start.len()] } else { held.to_vec() };
    let solver = LevenbergMarquardt::new(held, tolerance).with_stop_flag(Arc::clone(stop));
    let run = Executor::new(Problemwise(problem), solver)
        .configure(|state| state.param(start.to_vec()).max_iters(iterations).counting(true))
        .timer(false)
        .run();
    match run {
        Ok(mut result) => {
            let counts = &result.problem.counts;
            let evaluations = ["cost_count", "jacobian_count"].iter().filter_map(|k| counts.get(*k)).sum();
            let converged =
                matches!(result.state.get_termination_reason(), Some(TerminationReason::SolverConverged));
            let (place, normal) =
                result.solver.here.take().unwrap_or_else(|| (start.to_vec(), problem.normal(start)));
            Polished { place, normal, evaluations, converged }
        }
        // A `LeastSquares` problem returns no errors; the start is the fallback.
        Err(_) => Polished {
            place: start.to_vec(),
            normal: problem.normal(start),
            evaluations: 1,
            converged: false,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley with its minimum at (0.4, 0.16) of the unit square.
    struct Valley;

    impl LeastSquares for Valley {
        fn dimension(&self) -> usize {
            2
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(2);
            normal.add(1.0, 10.0 * (x[1] - x[0] * x[0]), &[-20.0 * x[0], 10.0]);
            normal.add(1.0, 0.4 - x[0], &[-1.0, 0.0]);
            normal.mirror();
            normal
        }
    }

    fn run(start: &[f64], held: &[bool]) -> Polished {
        least_squares(&Valley, start, held, 200, &Arc::default())
    }

    #[test]
    fn a_valley_is_followed_to_its_minimum() {
        let found = run(&[0.95, 0.05], &[]);
        assert!(found.converged && found.normal.chi_square < 1e-16, "{found:?}");
        assert!((found.place[0] - 0.4).abs() < 1e-6);
    }

    #[test]
    fn a_held_coordinate_stays_and_the_others_are_minimised() {
        let found = run(&[0.7, 0.9], &[true, false]);
        assert!((found.place[0] - 0.7).abs() < 1e-15);
        // χ² = 0.09 to a relative 1e-9, with a curvature of 100.
        assert!((found.normal.chi_square / 0.09 - 1.0).abs() < 1e-9 && (found.place[1] - 0.49).abs() < 1e-6);
    }

    /// r = (x + 1, y − 0.5 + x): the minimum inside the square is at x = 0, y = 0.5.
    struct Outside;

    impl LeastSquares for Outside {
        fn dimension(&self) -> usize {
            2
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(2);
            normal.add(1.0, x[0] + 1.0, &[1.0, 0.0]);
            normal.add(1.0, x[1] - 0.5 + x[0], &[1.0, 1.0]);
            normal.mirror();
            normal
        }
    }

    /// r = (100·(x − 5y), x + y − 12): a narrow valley that leaves the square at (1, 0.2).
    struct Slanted;

    impl LeastSquares for Slanted {
        fn dimension(&self) -> usize {
            2
        }
        fn chi_square(&self, x: &[f64]) -> f64 {
            self.normal(x).chi_square
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut normal = NormalEquations::zero(2);
            normal.add(1.0, 100.0 * (x[0] - 5.0 * x[1]), &[100.0, -500.0]);
            normal.add(1.0, x[0] + x[1] - 12.0, &[1.0, 1.0]);
            normal.mirror();
            normal
        }
    }

    #[test]
    fn limit_a_valley_that_leaves_the_square_is_followed_to_the_face() {
        for start in [[0.5, 0.1], [0.0, 0.0], [0.1, 0.9], [0.99, 0.01]] {
            let found = least_squares(&Slanted, &start, &[], 200, &Arc::default());
            assert!(found.converged && found.place[0] == 1.0, "{found:?}");
            assert!((found.normal.chi_square - 116.64).abs() < 0.01, "{found:?}");
        }
    }

    #[test]
    fn limit_a_minimum_outside_the_square_is_reached_at_the_face() {
        let found = least_squares(&Outside, &[0.9, 0.9], &[], 100, &Arc::default());
        assert!(
            found.converged && found.place[0] == 0.0 && (found.normal.chi_square - 1.0).abs() < 1e-9,
            "{found:?}"
        );
    }
}
