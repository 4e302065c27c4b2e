//! Parameters from data: the search repeated from several seeds, and what the data determine.

mod run;
mod uncertainty;

pub use run::{Estimate, GAIN_RANGE, Identification, Plan, Repeat, identify};
pub use uncertainty::{Certainty, certainty};
