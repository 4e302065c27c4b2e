//! Parameters from motion records: by inverse dynamics, the force that a rigid machine needs for the measured motion, and by the output error of the
//! simulated loop.

mod force_fit;
mod interval;
mod output_error;

pub use force_fit::{Estimated, ForceFit, correlation, estimate, estimate_identifiable, estimate_weighed};
pub use interval::{CoefficientInterval, intervals};
pub use output_error::{OutputError, output_error, simulated_gaps};
