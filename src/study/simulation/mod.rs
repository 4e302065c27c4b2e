//! Simulations of a machine at its start values, each with its request and its result document.

mod bode;
mod drive;
mod frf;
mod hold;
mod modes;
mod motion;
mod operating;
mod stiffness;
mod travel;

pub use bode::{BodeRequest, bode};
pub use drive::{describe_pole, find_drive, find_response, travel_factor};
pub use frf::{FrfRequest, frf, identified_frf};
pub use hold::{GainsRequest, gains_of_identified, hold, impedance_units};
pub use modes::{ModesRequest, modes};
pub use motion::{MotionRequest, Reference, displacement_unit, motion};
pub use operating::{Load, Place, checked_nut, find_operating, load_warnings, require_count};
pub use stiffness::{StiffnessRequest, SweepVariable, separations, static_stiffness, stiffness};
pub use travel::TravelProfile;
