//! Cases in motion: published records, sealed labels, and their generation.

mod fault;
mod fit;
mod gauge;
mod make;
mod plan;
mod record;
mod rows;
mod tour;
mod write;

pub use make::generate_one;
pub use plan::{FULL, Plan, QUICK, Slot};
pub use record::{Case, Record};
pub use write::{write_case, write_quiet};

#[cfg(test)]
pub(super) use {gauge::Gauge, make::Choice};
