//! Diagnosis of the discrepancy between simulated and recorded motion by inverse dynamics, with the same
//! questions as for FRFs.
//!
//! The recorded force is compared with that of the rigid machine. Transmission errors of extra measuring
//! points, where recorded, are compared in addition, weighted by the noise of each. The force is linear in
//! most parameters: a candidate adds a few columns to those of the machine. Its other parameters (a velocity,
//! a period, a delay) are searched on a grid. Misfits beside the nuisance parameters,
//! in units of the noise with its autocorrelation, the prediction of parts of the motion that are left out of the
//! fit, and null simulations of the machine are the facts on which the common rules judge.

mod candidate;
mod channel_weight;
mod closed_interval;
mod common_cause;
mod context;
mod data;
mod data_fault;
mod design;
mod diagnosis;
mod force_fault;
mod free_function;
mod gap;
mod gather;
mod grid;
mod misfit_map;
mod noise_floor;
mod nominal_fit;
mod nuisance;
mod residual_bootstrap;
mod screening;
mod two_clocks;

pub use context::MotionSettings;
pub use diagnosis::{MotionDiagnosis, TriedMotion, diagnose_motion};
pub use gap::{MotionPart, gap_of, part};
pub use misfit_map::{MisfitAxis, MisfitCell, misfit_map};
