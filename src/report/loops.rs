//! Result documents of a drive's loops: frequency response, gains, servo impedance, circles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// One frequency of a response from command to position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeRow {
    /// Frequency (Hz). Whole periods of it fit into whole periods of the position loop.
    pub frequency_hz: f64,
    /// Magnitude by linearisation.
    pub magnitude: f64,
    /// Phase by linearisation (degrees, −180 to 180).
    pub phase_deg: f64,
    /// Magnitude by simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated_magnitude: Option<f64>,
    /// Phase by simulation (degrees).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated_phase_deg: Option<f64>,
}

/// A pole of the closed loops.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoleRow {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio; below 0 the pole is unstable.
    pub damping_ratio: f64,
    /// Point with the largest deflection.
    pub point: String,
}

/// `bode.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose travel is the output; `null` for the reading of the position encoder.
    pub response: Option<String>,
    /// Amplitude of the simulated command (m or rad).
    pub amplitude: Option<f64>,
    /// Response by frequency.
    pub rows: Vec<BodeRow>,
    /// Poles of the loops, the least damped first.
    pub poles: Vec<PoleRow>,
    /// Highest frequency (Hz) at which the magnitude falls below 1/√2, by linearisation.
    pub bandwidth_hz: Option<f64>,
    /// Largest relative difference between simulated and linearised magnitude.
    pub largest_difference: Option<f64>,
    /// Largest difference between simulated and linearised phase (degrees).
    pub largest_phase_difference_deg: Option<f64>,
}

/// Figures of a gain of the position loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyRow {
    /// Gain (1/s).
    pub gain_per_s: f64,
    /// The same in 1/min, the unit of controllers.
    pub gain_per_min: f64,
    /// Time to 99 % of the travel (s); `null` where it is not reached.
    pub time_s: Option<f64>,
    /// Mean |command − position| at rest (m or rad); `null` where the loop is unstable.
    pub static_error: Option<f64>,
    /// Energy supplied by the drive while it drives (J), not counting braking; `null` where the loop is unstable.
    pub energy_j: Option<f64>,
    /// Cost C; `null` where the loop is unstable or does not reach the target.
    pub cost: Option<f64>,
}

/// `gain.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose position is evaluated; `null` for the reading of the position encoder.
    pub response: Option<String>,
    /// Figures by gain, in ascending order.
    pub rows: Vec<GainStudyRow>,
    /// Gain with the minimum cost (1/s), of those in the table.
    pub optimum_per_s: Option<f64>,
}

/// The drive as a spring and damper at one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldRow {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// k_s = Re Z (N·m/rad or N/m).
    pub stiffness: f64,
    /// c_s = Im Z/ω (N·m·s/rad or N·s/m).
    pub damping: f64,
    /// Phase of Z (degrees).
    pub phase_deg: f64,
}

/// Gains that correspond to an identified spring and damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldGains {
    /// k_s.
    pub stiffness: f64,
    /// c_s.
    pub damping: f64,
    /// k_p (1/s).
    pub position_gain_per_s: f64,
    /// k_v (output of the velocity loop per m/s).
    pub velocity_gain: f64,
}

/// `hold.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// The driven point.
    pub point: Option<String>,
    /// Impedance by frequency, from the drive's gains.
    pub rows: Vec<HoldRow>,
    /// Gains from an identified spring and damper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gains: Option<HoldGains>,
}

/// A circle at one speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CircleRow {
    /// Angular speed (rad/min).
    pub speed_rad_min: f64,
    /// Largest |distance from the circle| (m).
    pub largest_m: f64,
    /// Mean distance from the circle, positive outside (m).
    pub mean_m: f64,
    /// Largest |distance from the mean| just after the reversal of an axis (m); `null` without a reversal.
    pub largest_at_quadrants_m: Option<f64>,
}

/// `circle.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CirclesDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose travel is evaluated; `null` for the reading of the position encoders.
    pub response: Option<String>,
    /// Radius (m).
    pub radius_m: f64,
    /// Circles by speed.
    pub rows: Vec<CircleRow>,
}
