//! An independent truth of a driven feed axis in motion: a chain of bodies with its own laws and its own integrator, a sampled drive,
//! encoders, and sealed cases made of its records.
//!
//! ```text
//! plant     three bodies, friction of Maxwell elements, gap, waves along the screw, what lies outside every list; the step
//! path      reference motions: strokes with bell-shaped acceleration, dwells, sines
//! drive     the sampled cascade of position and velocity loop, dead time, lag of the current
//! run       a motion of the axis, and what encoder and force channel make of it
//! catalogue axes to draw from, ordinary nuisances
//! belief    what the engineer writes down of an axis
//! phase     dwell, breakaway, reversal …: by the reference alone
//! effect    what may be missing from the engineer's model, each in this module's own parametrisation
//! case      cases, strength by non-centrality, labels, folders
//! ```
//!
//! Masses and forces are those felt along the table's travel: kg, N, m, s. The force of a record is the force that the drive demands.

pub mod belief;
pub mod case;
pub mod catalogue;
pub mod drive;
pub mod effect;
pub mod path;
pub mod phase;
pub mod plant;
pub mod run;

pub use case::{Case, FULL, Plan, QUICK, generate, generate_one, write_case, write_quiet};

#[cfg(test)]
mod tests;
