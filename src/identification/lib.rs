//! Parameters from data: the search repeated from several seeds, and what the data determine.

mod bootstrap;
mod combination;
mod design;
mod estimate;
pub mod motion;
pub mod network;
pub mod objective;
mod plan;
mod problem;
mod profile;
mod run;
mod tolerance;
mod uncertainty;
pub mod validation;

pub use bootstrap::{Bootstrap, Drawn};
pub use combination::{Combination, Kind as CombinationKind};
pub use design::{Candidate, Choice, Design, FrfPlan};
pub use estimate::{Basin, Estimate};
pub use plan::{Plan, Repeat};
pub use run::{DerivedEstimate, Identification, identify};
pub use tolerance::{ToleranceEstimate, channels_of, held_at, tolerances_at};
pub use uncertainty::{Certainty, NARROWING, RANGE_SD, certainty, counted};
