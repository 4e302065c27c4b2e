//! Why the force of a simulated and a measured motion disagree: the same questions as for FRFs, asked of time records by inverse dynamics.
//!
//! Where further points of the machine were recorded, their transmission errors stand beside the force, weighed by the noise of each. The force is linear in most parameters, so that a candidate is a few columns beside those of the machine. What else it needs (a velocity, a
//! period, a delay) runs over a lattice. Candidates are ranked by how they foretell parts of the motion that were left out of the fit; thresholds come
//! from nulls: the machine with ordinary nuisances and noise that keeps the colour of what is left.

mod cell;
mod conclude;
mod data;
mod design;
mod floor;
mod free;
mod gap;
mod lattice;
mod noise;
mod nuisance;
mod null;
mod record;
mod stage;
mod survey;
mod verdict;
mod weight;
mod work;

pub use cell::{Cell, CellKind, cells};
pub use data::MotionData;
pub use gap::{MotionPart, gap_of, part};
pub use nuisance::Nuisance;
pub use null::Null;
pub use record::{Contradiction, RecordShift};
pub use survey::{MotionCandidate, Ranked, Survey};
pub use verdict::{LocatedMotion, MotionDiagnosis, MotionSettings, TriedMotion, diagnose_motion};
