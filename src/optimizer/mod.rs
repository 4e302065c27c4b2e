//! Search for the minimum of a function on the unit cube; knows no drives and no data.
//!
//! The global search is a differential evolution written as an argmin [`Solver`](argmin::core::Solver); the polish is argmin's
//! Nelder–Mead, or for sums of squares a bounded Levenberg–Marquardt. Random numbers are drawn in sequence, costs are evaluated in parallel, so that the result does not depend on the number
//! of threads.

mod differential_evolution;
mod least_squares;
mod polish;
mod search;

pub use differential_evolution::{DifferentialEvolution, Strategy};
pub use least_squares::{LeastSquares, LevenbergMarquardt, Normal, Polished, least_squares, least_squares_within};
pub use search::{Control, Found, Listener, Progressed, SearchSettings, Watcher, search};

/// A function on the unit cube, finite everywhere.
pub trait Cost: Sync {
    /// Number of coordinates.
    fn dimension(&self) -> usize;
    /// Its value at a point of the unit cube.
    fn at(&self, place: &[f64]) -> f64;
}
