//! Does it hold elsewhere: single against multi-position, objectives by leaving positions out.

mod compare;
mod left_out;

pub use compare::{ObjectiveScore, frequency_errors, leave_one_out};
pub use left_out::{LeftOut, left_out};
