//! Parameters from data: the search repeated from several seeds, and what the data determine.

mod bootstrap;
mod combination;
mod design;
mod estimate;
pub mod motion;
pub mod network;
pub mod objective;
mod problem;
mod profile;
mod run;
mod uncertainty;
pub mod validation;

pub use bootstrap::{Bootstrap, Drawn};
pub use combination::{Combination, Kind as CombinationKind};
pub use design::{Candidate, Choice, Design, FrfPlan};
pub use run::{DerivedEstimate, Estimate, Identification, Plan, Repeat, identify};
pub use uncertainty::{Certainty, NARROWING, RANGE_SD, certainty};
