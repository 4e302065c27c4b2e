//! Result documents of a drive's loops: frequency response, gains, hold.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// One frequency of a response from command to position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeRow {
    /// Frequency (Hz), of which whole periods fit into whole periods of the position loop.
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
    /// Damping ratio; below 0 it grows.
    pub damping_ratio: f64,
    /// Where it moves most.
    pub point: String,
}

/// `bode.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose travel is the output; `null` for what the position encoder reads.
    pub response: Option<String>,
    /// Amplitude of the simulated command (m or rad).
    pub amplitude: Option<f64>,
    /// Response by frequency.
    pub rows: Vec<BodeRow>,
    /// Poles of the loops, the least damped first.
    pub poles: Vec<PoleRow>,
    /// Frequency (Hz) at which the magnitude falls below 1/√2 for good, by linearisation.
    pub bandwidth_hz: Option<f64>,
    /// Largest difference between both magnitudes, relative.
    pub largest_difference: Option<f64>,
    /// Largest difference between both phases (degrees).
    pub largest_phase_difference_deg: Option<f64>,
}

/// What a gain of the position loop gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyRow {
    /// Gain (1/s).
    pub gain_per_s: f64,
    /// The same in 1/min, as controllers have it.
    pub gain_per_min: f64,
    /// To 99 % of the travel (s); `null` where it is not reached.
    pub time_s: Option<f64>,
    /// Mean |command − position| at rest (m or rad); `null` where the loop is unstable.
    pub static_error: Option<f64>,
    /// What the drive puts in while it drives (J); `null` where the loop is unstable.
    pub energy_j: Option<f64>,
    /// C; `null` where the loop is unstable or does not arrive.
    pub cost: Option<f64>,
}

/// `gain.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose position is judged; `null` for what the position encoder reads.
    pub response: Option<String>,
    /// Gains, rising.
    pub rows: Vec<GainStudyRow>,
    /// Gain with the least cost (1/s), of those in the table.
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

/// Gains that hold like an identified spring and damper.
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
    /// The point that is held.
    pub point: Option<String>,
    /// By frequency, from the drive's gains.
    pub rows: Vec<HoldRow>,
    /// Gains, from an identified hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gains: Option<HoldGains>,
}

/// A circle at one speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CircleRow {
    /// Speed of the angle (rad/min).
    pub speed_rad_min: f64,
    /// Largest |distance from the circle| (m).
    pub largest_m: f64,
    /// Its mean: above 0 outside (m).
    pub mean_m: f64,
    /// Largest |distance from the mean| just after an axis has turned (m); `null` where none turned.
    pub largest_at_quadrants_m: Option<f64>,
}

/// `circle.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CirclesDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Point whose travel is judged; `null` for what the position encoders read.
    pub response: Option<String>,
    /// Radius (m).
    pub radius_m: f64,
    /// By speed.
    pub rows: Vec<CircleRow>,
}
