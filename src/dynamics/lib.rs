//! Physical predictions for a machine: frequency responses and modes ([`model`]), motion in time
//! ([`motion`]), and the force that a measured motion requires ([`inverse_dynamics`]).
//!
//! The crate knows nothing of fitting: a machine and values of its parameters go in, predictions come out.

pub mod inverse_dynamics;
mod law;
pub mod model;
pub mod motion;
