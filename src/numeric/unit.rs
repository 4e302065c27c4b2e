//! Conversions between units, each in exactly one function.

use std::f64::consts::TAU;

/// Angular frequency (rad/s) of a frequency in Hz.
pub fn omega_rad_s(frequency_hz: f64) -> f64 {
    TAU * frequency_hz
}

/// Frequency in Hz of an angular frequency (rad/s).
pub fn frequency_hz(omega_rad_s: f64) -> f64 {
    omega_rad_s / TAU
}

/// Travel per radian (m/rad) of a screw with the given lead (m per turn).
///
/// # Source  Tian et al., Eq. 21: i_b = h/(2π).
pub fn travel_per_radian_m(lead_m: f64) -> f64 {
    lead_m / TAU
}
