//! An independent reference simulator of a driven feed axis in motion. It has its own mechanics, integrator,
//! sampled drive and encoders, and makes sealed cases of its records.
//!
//! ```text
//! plant     three bodies, friction of elastic elements, backlash, waves along the travel, unlisted effects; the integration step
//! path      reference motions: strokes with bell-shaped acceleration, dwells, sines
//! drive     the sampled cascade of position and velocity loop, dead time, lag of the current
//! run       a motion of the axis, and its record by encoder and force channel
//! catalogue random axes, nuisance parameters
//! layout    encoders, belts, loops and commands beside those of the catalogue
//! belief    the engineer's description of an axis
//! phase     dwell, breakaway, reversal …, from the reference alone
//! effect    effects that may be missing from the engineer's model, in this crate's own parametrisation
//! case      cases, strength by non-centrality, labels, folders
//! ```
//!
//! Masses and forces are reduced to the table's travel: kg, N, m, s. The force of a record is the drive's
//! demand.

pub mod belief;
pub mod case;
pub mod catalogue;
pub mod drive;
pub mod effect;
pub mod layout;
pub mod path;
pub mod phase;
pub mod plant;
pub mod run;

pub use case::{Case, FULL, Plan, QUICK, generate_one, write_case, write_quiet};
pub use layout::MotionLayout;

#[cfg(test)]
mod tests;
