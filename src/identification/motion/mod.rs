//! Parameters from motion records.
//!
//! Inverse dynamics fits the force that a rigid machine needs for the measured motion. The output-error
//! method fits the force of the simulated closed loop.

mod discrepancy;
mod force_fit;
mod interval;
mod marginal;
pub mod nuisance_prior;
mod output_error;
mod residual_noise;
mod single_frequency;
mod small_print;
mod tolerances;
mod tolerant_fit;

pub use force_fit::{
    ForceFit, best_anywhere, correlation, estimate, estimate_identifiable, estimate_weighted,
};
pub use interval::half_widths;
pub use marginal::ToleranceSize;
pub use output_error::{output_error, simulated_gaps};
pub use single_frequency::SingleFrequency;
pub use small_print::SmallPrint;
pub use tolerances::Tolerances;
pub use tolerant_fit::{TolerantFit, estimate_with_tolerances};
