//! Does it hold elsewhere: single against multi-position, objectives by leaving positions out.

mod compare;

pub use compare::{ObjectiveScore, frequency_errors, leave_one_out};
