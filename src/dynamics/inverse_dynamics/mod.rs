//! Inverse dynamics: from a measured motion the force that a rigid machine needs, set against the force its drive gave.
//!
//! Position is filtered and differentiated, the machine's force predicted along it, both thinned alike; parameters follow by least squares.
//! Where further points of the machine were recorded, what their springs, plays and leads put between them and the encoder is fitted along,
//! each channel in units of its noise.

mod beyond;
mod channel;
mod curve;
mod error;
mod force;
mod friction;
mod further;
mod phase;
mod play;
mod prediction;
mod recipe;
mod rigid;
mod told;
mod transmission;

pub use channel::{Further, Told};
pub use curve::{CurvePoint, friction_curve};
pub use error::InverseError;
pub use further::{leave_crossings_out, weights};
pub use phase::Phase;
pub use prediction::{Columns, derivatives, free_parameters, inverse, prediction, recorded, unseen};
pub use recipe::{Motion, Recipe, phases};
pub use rigid::Rigid;
