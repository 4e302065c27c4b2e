//! Parameters from motion records.
//!
//! Inverse dynamics fits the force that a rigid machine needs for the measured motion. The output-error method fits the force of the
//! simulated closed loop.

mod force_fit;
mod interval;
mod output_error;

pub use force_fit::{Estimated, ForceFit, correlation, estimate, estimate_identifiable, estimate_weighted};
pub use interval::{CoefficientInterval, intervals};
pub use output_error::{OutputError, output_error, simulated_gaps};
