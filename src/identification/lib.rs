//! Identifies machine parameters from measurements: repeated global searches, least squares, intervals and
//! identifiability.

mod bootstrap;
mod combination;
mod contained;
mod doubt;
mod estimate;
mod measurement_plan;
mod mode_evidence;
pub mod motion;
pub mod neural_residual;
pub mod objective;
mod place;
mod plan_discrimination;
mod posterior;
mod problem;
mod profile;
mod result;
mod run;
mod search;
mod settings;
mod tolerance;
mod uncertainty;
pub mod validation;

pub use bootstrap::{Bootstrap, Drawn};
pub use combination::{Combination, CombinationKind};
pub use doubt::Doubt;
pub use measurement_plan::{Choice, FrfPlan, PlanDesign, PlannedMeasurement};
pub use mode_evidence::ModeResidual;
pub use place::{Coordinate, Place, Tail};
pub use plan_discrimination::{Discrimination, RivalMachine};
pub use posterior::{Drawing, Posterior, PosteriorDraw, PosteriorSample, draw_posterior};
pub use problem::{Basin, Surroundings};
pub use profile::{CHI_SQUARE_95, ProfileStart, Profiler, Profiles};
pub use result::{DerivedEstimate, Identification};
pub use run::identify;
pub use search::{SearchEffort, frf_search_minima, mode_search_end};
pub use settings::{IdentificationSettings, REPEATS, Repeat};
pub use tolerance::{ToleranceEstimate, channels_of, idle_priors, tolerances_at};
pub use uncertainty::{Certainty, Estimate, certainty, narrow_width};
