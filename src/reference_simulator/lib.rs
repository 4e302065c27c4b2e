//! An independent truth for the blind check: machines of finite elements, struck by a simulated hammer, and driven axes in motion.
//!
//! ```text
//! element   rods, beams, laws of branches, dense complex solve, the assembled structure
//! machine   screws, nuts and joints in numbers; what an engineer believes of them; ordinary nuisances; from numbers to structure
//! effect    what may be missing from the engineer's model, each in this module's own parametrisation, and where it sits
//! hammer    the test in time: pulse, response, converter, noise, windows, averages, H1 and coherence
//! case      plans of cases, strength by non-centrality, sealed labels, measurement sets on disk
//! motion    the same for a driven axis in motion: its own mechanics, drive, sensors and cases
//! servo     a servo axis with its electrics, whose records the analytical model of it is held against
//! ```
//!
//! Nothing here may import from the rest of the crate, and the models under test may not import from here: a check of a model
//! against itself proves nothing. Responses are response / force with e^{+iωt}; SI units throughout.

mod attempt;
pub mod case;
pub mod draw;
pub mod effect;
pub mod element;
mod error;
mod file;
pub mod hammer;
pub mod machine;
pub mod motion;
mod named;
mod projection;
pub mod servo;
mod sizing;

#[cfg(test)]
mod tests;

pub use case::{
    Case, Counts, Exact, Gap, HammerTest, Kind, Label, Layout, Ordinary, Plan, Slot, Strength, generate, generate_one, labels_json,
    ordinary, write_case,
};
pub use error::TruthError;
