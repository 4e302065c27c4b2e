//! Unit conversions, each in exactly one function.

use std::f64::consts::TAU;

/// Converts a frequency in Hz to an angular frequency (rad/s).
pub fn omega_rad_s(frequency_hz: f64) -> f64 {
    TAU * frequency_hz
}

/// Converts an angular frequency (rad/s) to a frequency in Hz.
pub fn frequency_hz(omega_rad_s: f64) -> f64 {
    omega_rad_s / TAU
}

/// Converts the lead of a screw (m per turn) to travel per radian (m/rad).
///
/// # Source  Tian et al., Eq. 21: i_b = h/(2π).
pub fn travel_per_radian_m(lead_m: f64) -> f64 {
    lead_m / TAU
}
