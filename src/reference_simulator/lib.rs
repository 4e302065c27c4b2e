//! An independent reference simulator for the blind check: finite-element machines in a simulated hammer
//! test, and driven axes in motion.
//!
//! ```text
//! element   rods, beams, branch laws, dense complex solver, the assembled structure
//! machine   screws, nuts and joints as numbers; the engineer's description; nuisance parameters; assembly of the structure
//! effect    effects that may be missing from the engineer's model, in this crate's own parametrisation, and their locations
//! hammer    the test in time: pulse, response, converter, noise, windows, averages, H1 and coherence
//! case      plans of cases, strength by non-centrality, sealed labels, measurement sets on disk
//! motion    a driven axis in motion: its own mechanics, drive, sensors and cases
//! servo     a servo axis with its electrics, for tests of the analytical model
//! ```
//!
//! This crate imports no model under test, and no model under test may import this crate: a check of a model
//! against itself proves nothing. Responses are response / force with e^{+iωt}; SI units throughout.

#[macro_use]
mod named;

mod attempt;
pub mod case;
pub mod draw;
pub mod effect;
pub mod element;
mod error;
mod file;
pub mod hammer;
mod least_squares;
pub mod machine;
pub mod motion;
mod parallel;
pub mod parameter;
mod projection;
pub mod servo;
mod sizing;

#[cfg(test)]
mod tests;

pub use case::{
    Case, ChannelSet, Counts, Gap, HammerTest, Imitation, Kind, Label, Ordinary, Plan, Scatter, Slot,
    Strength, VISIBLE, generate_one, labels_json, measured_again, ordinary, ordinary_on_guide, write_case,
};
pub use error::{Result, SimulatorError};
pub use machine::layout::Layout;
