//! Simulations that repeat figures of the papers, each with its request and its result document.

mod circle;
mod contour;
mod gain;
mod gain_study;
mod matrices;
mod sensitivity;
mod servo_machine;

pub use circle::{CircleRequest, circle};
pub use contour::{Circle, contour_error};
pub use gain::{GainRequest, gain};
pub use gain_study::{GainCycle, gain_study};
pub use matrices::{MatricesRequest, matrices};
pub(crate) use sensitivity::mode_energy;
pub use sensitivity::{SensitivityRequest, sensitivity};
pub use servo_machine::{MissingEffect, ServoMachineRequest, ServoMachineSets, write_servo_machine};
