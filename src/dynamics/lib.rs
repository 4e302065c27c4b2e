//! What physics predicts of a machine: frequency responses and modes ([`model`]), motion in time ([`motion`]), and the force that a measured motion
//! needs ([`inverse_dynamics`]).
//!
//! Nothing here knows what is fitted to what: a machine and numbers for its parameters go in, predictions come out.

pub mod inverse_dynamics;
pub mod model;
pub mod motion;
