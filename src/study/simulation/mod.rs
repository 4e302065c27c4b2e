//! Simulations of a machine at its start values, each with its request and its result document, and the published figures of the lumped models.

mod bode;
mod circle;
mod drive;
mod frf;
mod gain;
mod hold;
mod matrices;
mod modes;
mod motion;
mod operating;
mod published;
mod sensitivity;
mod servo_machine;
mod stiffness;
mod travel;

pub use bode::{BodeRequest, bode};
pub use circle::{CircleRequest, circle};
pub(crate) use drive::describe_pole;
pub use frf::{FrfRequest, frf, identified_frf};
pub use gain::{GainRequest, gain};
pub use hold::{GainsRequest, HoldRequest, gains_of_identified, hold, impedance_units};
pub use matrices::{MatricesRequest, matrices};
pub use modes::{ModesRequest, modes};
pub use motion::{MotionRequest, Reference, motion};
pub(crate) use operating::checked_nut;
pub use operating::{Load, Place};
pub use published::published;
pub use sensitivity::{SensitivityRequest, sensitivity};
pub use servo_machine::{MissingEffect, ServoMachineRequest, ServoMachineSets, write_servo_machine};
pub use stiffness::{StiffnessRequest, SweepVariable, stiffness};
pub use travel::TravelProfile;
