//! Minimisation of a function on the unit cube, independent of drives and data.
//!
//! The global search is a differential evolution written as an argmin [`Solver`](argmin::core::Solver). The
//! local optimisation is argmin's Nelder–Mead, or for sums of squares a bounded Levenberg–Marquardt. Nearly
//! linear predictions use a bounded Gauss–Newton. Random numbers are drawn sequentially and costs are
//! evaluated in parallel, so that the result does not depend on the number of threads.

mod differential_evolution;
mod gauss_newton;
mod least_squares;
mod polish;
mod search;

pub use differential_evolution::{DifferentialEvolution, Trial};
pub use gauss_newton::{
    Coordinate, GaussNewton, GaussNewtonError, GaussNewtonFit, PredictionFunction, nonzero_columns,
};
pub use least_squares::{
    LeastSquares, LevenbergMarquardt, NormalEquations, Polished, least_squares, least_squares_within,
};
pub use polish::simplex;
pub use search::{SearchResult, SearchSettings, search};

/// A function on the unit cube, finite everywhere.
pub trait Cost: Sync {
    /// Returns the number of coordinates.
    fn dimension(&self) -> usize;
    /// Computes its value at a point of the unit cube.
    fn at(&self, place: &[f64]) -> f64;
    /// Computes its value where that is at most `limit`, otherwise any number above `limit`. A cost with
    /// non-negative terms may stop its sum there.
    fn at_most(&self, place: &[f64], limit: f64) -> f64 {
        let _ = limit;
        self.at(place)
    }
}
