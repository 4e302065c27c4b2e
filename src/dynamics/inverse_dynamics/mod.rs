//! Inverse dynamics: the force that a rigid machine requires for a measured motion, compared with the
//! recorded force of its drive.
//!
//! The position is filtered and differentiated. The force predicted from it and the recorded force are
//! decimated alike; least squares gives the parameters. Where extra points of the machine were recorded,
//! their transmission error is fitted as well, with each channel in units of its noise. It consists of the
//! wind-up of springs, backlash and lead errors between encoder and point.

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
pub use force::shifted_earlier;
pub use phase::Phase;
pub use prediction::{
    LinearForce, derivatives, free_parameters, is_linear_in_inverse, parameters_without_influence,
    prediction, recorded,
};
pub use preprocessing::{MotionSignal, Preprocessing, phases};
pub use rigid::Rigid;
