//! Inverse dynamics: from a measured motion the force that a rigid machine needs, set against the force its drive gave.
//!
//! Position is filtered and differentiated, the machine's force predicted along it, both thinned alike; parameters follow by least squares.
//! Where further points of the machine were recorded, what their springs, plays and leads put between them and the encoder is fitted along,
//! each channel in units of its noise.

mod backlash;
mod compliant_load;
mod curve;
mod error;
mod extra_channel;
mod extra_column;
mod force;
mod friction;
mod loop_observer;
mod phase;
mod prediction;
mod preprocessing;
mod rigid;
mod transmission;

pub use curve::{CurvePoint, friction_curve};
pub use error::InverseError;
pub use extra_channel::{EncoderEstimate, ExtraChannel};
pub use extra_column::{mask_backlash_crossings, weights};
pub use phase::Phase;
pub use prediction::{LinearForce, derivatives, free_parameters, inverse, prediction, recorded, unseen};
pub use preprocessing::{MotionSignal, Preprocessing, phases};
pub use rigid::Rigid;
