//! Inverse dynamics: from a measured motion the force that a rigid machine needs, set against the force its drive gave.
//!
//! Position is filtered and differentiated, the machine's force predicted along it, both thinned alike; parameters follow by least squares.

mod curve;
mod error;
mod fit;
mod force;
mod interval;
mod phase;
mod recipe;

pub use curve::{CurvePoint, friction_curve};
pub use error::InverseError;
pub use fit::{Columns, Estimated, Fit, Projected, bounded_step, correlation, dependent, estimate, free_parameters, prediction, recorded};
pub use force::Rigid;
pub use interval::{Interval, hac_covariance, intervals};
pub use phase::{Phase, phases};
pub use recipe::{Motion, Recipe};
