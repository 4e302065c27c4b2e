//! Result documents of the control loops of a drive: frequency response, gains, servo impedance, circles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// Frequency response from command to position at one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeRow {
    /// Frequency (Hz), chosen so that whole periods fit into whole periods of the position loop.
    pub frequency_hz: f64,
    /// Magnitude |position/command| by linearisation (unit of the position per unit of the command).
    pub magnitude: f64,
    /// Phase by linearisation (degrees, −180 to 180).
    pub phase_deg: f64,
    /// Magnitude by simulation, in the unit of `magnitude`; absent without simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated_magnitude: Option<f64>,
    /// Phase by simulation (degrees, −180 to 180); absent without simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated_phase_deg: Option<f64>,
    /// Largest share of the evaluated time in which the friction of a joint sticks (1); absent where none
    /// does. At 1 the axis sticks: the simulated response is that of a machine held by friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck_share: Option<f64>,
}

/// A pole of the closed control loops.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoleRow {
    /// Frequency of oscillation |Im s|/2π (Hz).
    pub frequency_hz: f64,
    /// Damping ratio (1); below 0 the pole is unstable.
    pub damping_ratio: f64,
    /// Name of the point with the largest deflection.
    pub point: String,
}

/// Frequency response from command to position (`bode.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodeDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the point whose travel is the output; `null` for the reading of the position encoder.
    pub response: Option<String>,
    /// Amplitude of the simulated command (m or rad); `null` without simulation.
    pub amplitude: Option<f64>,
    /// Response in ascending frequency.
    pub rows: Vec<BodeRow>,
    /// Poles of the closed control loops in ascending damping ratio.
    pub poles: Vec<PoleRow>,
    /// Bandwidth: highest frequency (Hz) at which the magnitude by linearisation falls below 1/√2.
    pub bandwidth_hz: Option<f64>,
    /// Largest relative difference |simulated/linearised magnitude − 1| (1), at frequencies at which the axis
    /// does not stick.
    pub largest_difference: Option<f64>,
    /// Largest |difference| between simulated and linearised phase (degrees), at the same frequencies.
    pub largest_phase_difference_deg: Option<f64>,
}

/// Duration, accuracy and energy of a cycle with one gain of the position loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyRow {
    /// Gain k_v of the position loop (1/s).
    pub gain_per_s: f64,
    /// Gain k_v in the unit of controllers (1/min).
    pub gain_per_min: f64,
    /// Time from the start of the travel to 99 % of it (s); `null` where it is not reached.
    pub time_s: Option<f64>,
    /// Mean |command − position| over the last fifth of the rest (m or rad); `null` where the loop is
    /// unstable or the axis not at rest.
    pub static_error: Option<f64>,
    /// Whether the axis is at rest over the last fifth of the rest: the encoder's reading is constant, and
    /// equals the command where the velocity loop integrates.
    pub settled: bool,
    /// Energy supplied by the drive while it drives, braking not counted (J); `null` where the loop is
    /// unstable.
    pub energy_j: Option<f64>,
    /// Cost C = e/e_max − (1 − E/E_max) − (1 − τ/τ_max) (1); `null` where the loop is unstable, or the axis
    /// misses the target or is not at rest.
    pub cost: Option<f64>,
}

/// Study of the gain of the position loop (`gain.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainStudyDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the point whose position is evaluated; `null` for the reading of the position encoder.
    pub response: Option<String>,
    /// Cycles in ascending gain.
    pub rows: Vec<GainStudyRow>,
    /// Gain of lowest cost among `rows` (1/s).
    pub optimum_per_s: Option<f64>,
}

/// Servo impedance Z of the drive (force per displacement) at one frequency, as spring and damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldRow {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Servo stiffness k_s = Re Z (N·m/rad or N/m).
    pub stiffness: f64,
    /// Servo damping c_s = Im Z/ω (N·m·s/rad or N·s/m).
    pub damping: f64,
    /// Phase of Z (degrees).
    pub phase_deg: f64,
}

/// Gains of the drive that correspond to an identified spring and damper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldGains {
    /// Servo stiffness k_s (N·m/rad).
    pub stiffness: f64,
    /// Servo damping c_s (N·m·s/rad).
    pub damping: f64,
    /// Gain k_p of the position loop (1/s).
    pub position_gain_per_s: f64,
    /// Gain k_v of the velocity loop (output of the loop per m/s).
    pub velocity_gain: f64,
}

/// Servo impedance of the drive (`hold.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HoldDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the driven point; `null` for gains from an identified spring and damper.
    pub point: Option<String>,
    /// Servo impedance by frequency, from the gains of the drive.
    pub rows: Vec<HoldRow>,
    /// Gains that correspond to an identified spring and damper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gains: Option<HoldGains>,
}

/// Contour error of a circle at one speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CircleRow {
    /// Angular speed (rad/min).
    pub speed_rad_min: f64,
    /// Largest |distance from the circle| (m).
    pub largest_m: f64,
    /// Mean distance from the circle (m), positive outside.
    pub mean_m: f64,
    /// Largest |distance from the circle − `mean_m`| just after the reversal of an axis (m); `null` without a
    /// reversal.
    pub largest_at_quadrants_m: Option<f64>,
}

/// Contour errors of circles of two axes (`circle.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CirclesDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the point whose travel is evaluated; `null` for the reading of the position encoders.
    pub response: Option<String>,
    /// Radius of the commanded circle (m).
    pub radius_m: f64,
    /// Contour errors by speed.
    pub rows: Vec<CircleRow>,
}
