//! Validation: cross-validation of a fit, and comparison of objectives by leaving positions out.

mod compare;
mod cross_validation;

pub use compare::{ObjectiveScore, frequency_errors, leave_one_out};
pub use cross_validation::{CrossValidation, cross_validation};
