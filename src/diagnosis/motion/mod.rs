//! Why the force of a simulated and a measured motion disagree: the same questions as for FRFs, asked of time records by inverse dynamics.
//!
//! Where further points of the machine were recorded, their transmission errors stand beside the force, weighed by the noise of each. The force is linear in most parameters, so that a candidate is a few columns beside those of the machine. What else it needs (a velocity, a
//! period, a delay) runs over a lattice. Candidates are ranked by how they foretell parts of the motion that were left out of the fit; thresholds come
//! from nulls: the machine with ordinary nuisances and noise that keeps the colour of what is left.

mod channel_weight;
mod context;
mod data;
mod data_fault;
mod decision;
mod design;
mod diagnosis;
mod free_function;
mod gap;
mod grid;
mod misfit_map;
mod noise_floor;
mod nuisance;
mod null_distribution;
mod residual_bootstrap;
mod screening;
mod selection;

pub use data::MotionData;
pub use data_fault::{Contradiction, RecordShift};
pub use diagnosis::{LocatedMotion, MotionDiagnosis, MotionSettings, TriedMotion, diagnose_motion};
pub use gap::{MotionPart, gap_of, part};
pub use misfit_map::{MisfitAxis, MisfitCell, misfit_map};
pub use nuisance::Nuisance;
pub use null_distribution::MotionNullDistribution;
pub use screening::{MotionCandidate, MotionScreening, Ranked};
