//! The drive of an axis: motor, encoders, position and velocity loop.

use schemars::JsonSchema;
use serde::Deserialize;

use super::friction::numbers;
use super::{CurrentFile, CurrentLoop, Motor, MotorFile, NumberSource, Value, Wave, WaveFile};

/// What a loop measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    /// The point (index) it sits at.
    pub at: usize,
    /// What it reads per unit of that point: lead/2π (m/rad) where it turns a screw, else 1.
    pub travel: f64,
    /// Its step, in what it reads (m or rad); 0 for one without.
    pub step: Value,
}

/// The position loop, proportional: v_ref = k_p·(r − x) + f·ṙ.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLoop {
    /// What it measures.
    pub encoder: Encoder,
    /// k_p (1/s).
    pub gain_per_s: Value,
    /// f: share of the command's velocity that is fed forward.
    pub feed_forward: Value,
    /// Ends of the stroke as the encoder reads it, which no command may leave; `None` where they are not known.
    pub limits: Option<[f64; 2]>,
    /// Its period (s).
    pub period_s: f64,
}

/// How a velocity is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tachometry {
    /// By the encoder's readings now and this many periods of the loop ago.
    Difference(usize),
    /// Itself, by a tachometer; the encoder's step does not show.
    Direct,
}

/// The velocity loop, proportional and integral: u = k_v·(e + ∫e dt/T_i) + a·r̈, e = v_ref − v. What it gives is a current (A) where a motor with a
/// current loop follows, else a voltage (V).
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityLoop {
    /// What it measures.
    pub encoder: Encoder,
    /// How it comes to the velocity.
    pub tachometry: Tachometry,
    /// k_v (V or A per m/s, or per rad/s).
    pub gain: Value,
    /// T_i (s); infinite for a loop that is proportional alone.
    pub integral_time_s: Value,
    /// a: what is fed forward of the command's acceleration (V per m/s²).
    pub acceleration_feed_forward: Value,
    /// Its period (s), of which the position loop's is a multiple.
    pub period_s: f64,
}

/// A drive: the sampled loops, and a motor whose force follows their output at once, held between samples, or through its winding.
///
/// ```text
/// F = (1 + e)·G·u(t − τ) + wave(x),     |u| ≤ saturation
/// ```
///
/// The force recorded of it is G·u. With a [`Motor`] F = (1 + e)·G·i + wave(x), recorded is G·i, and the output of the loops is a voltage, or with a
/// [`CurrentLoop`] the current it has to bring about.
///
/// # Units      u in V (or what else the loops give), G in N/V or N·m/V; with a winding in N/A or N·m/A
/// # Source     EMPS data set (Janot, Gautier, Brunot 2019): P position and P velocity loop; lumped servo axis, Fig. 3: PI and feed-forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The point (index) the motor moves.
    pub on: usize,
    /// G (N/V or N·m/V).
    pub constant: Value,
    /// 1 + e: what the force truly is of what is recorded; 1 for a drive that is known.
    pub force_factor: Value,
    /// τ (s): from a sample to the force it makes.
    pub delay_s: Value,
    /// Largest |u|; infinite for none.
    pub saturation: Value,
    /// Ripple of force or torque over the travel of `on`.
    pub ripple: Wave,
    /// Winding of the motor; `None` where force follows the loops at once.
    pub motor: Option<Motor>,
    /// Loop of its current; `None` where the velocity loop gives the voltage.
    pub current: Option<CurrentLoop>,
    /// Position loop.
    pub position: PositionLoop,
    /// Velocity loop.
    pub velocity: VelocityLoop,
}

/// The drive of an axis.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveFile {
    /// The point the motor moves.
    pub(super) on: String,
    /// Force or torque per unit of what the velocity loop gives (N/V or N·m/V); with a motor per current (N/A or N·m/A).
    pub(super) constant: NumberSource,
    /// From a sample to the force it makes (s); with a motor, to its voltage.
    pub(super) delay_s: Option<NumberSource>,
    /// Largest size of what the velocity loop gives (V); without limit by default.
    pub(super) saturation: Option<NumberSource>,
    /// Ripple of force or torque over the travel of `on`.
    pub(super) ripple: Option<WaveFile>,
    /// Winding of the motor; without one the force follows the loops at once.
    pub(super) motor: Option<MotorFile>,
    /// Loop of its current; without one the velocity loop gives the motor's voltage.
    pub(super) current: Option<CurrentFile>,
    pub(super) position: PositionLoopFile,
    pub(super) velocity: VelocityFile,
}

/// The position loop: v_ref = gain·(command − position) + feed_forward·(rate of the command).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionLoopFile {
    /// The point its encoder sits at; that of the motor by default.
    pub(super) at: Option<String>,
    /// Travel per turn (m) where that point turns and positions are in m.
    pub(super) lead_m: Option<f64>,
    /// Step of the encoder (m or rad, as it reads); none by default.
    pub(super) encoder_step: Option<NumberSource>,
    pub(super) gain_per_s: NumberSource,
    pub(super) feed_forward: Option<NumberSource>,
    /// Ends of the stroke (m or rad, as the encoder reads it), which no command may leave.
    pub(super) limits_m: Option<[f64; 2]>,
    /// Period of the loop (s).
    pub(super) period_s: f64,
}

/// The velocity loop: V = gain·(e + ∫e dt/integral_time_s) + acceleration_feed_forward·(second rate of the command), e = v_ref − velocity.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityFile {
    /// The point its encoder sits at; that of the position loop by default.
    pub(super) at: Option<String>,
    /// Travel per turn (m) where that point turns and positions are in m; that of the position loop with its point.
    pub(super) lead_m: Option<f64>,
    /// Step of the encoder (m or rad, as it reads); that of the position loop with its point.
    pub(super) encoder_step: Option<NumberSource>,
    /// `difference` of encoder readings (default), or a `tachometer`.
    #[serde(default)]
    measured: Measured,
    /// Time (s) over which readings are differenced, a multiple of the loop's period; one period by default.
    over_s: Option<f64>,
    /// V (or A) per m/s (or rad/s).
    pub(super) gain: NumberSource,
    /// None by default: proportional alone.
    pub(super) integral_time_s: Option<NumberSource>,
    pub(super) acceleration_feed_forward: Option<NumberSource>,
    /// Period of the loop (s); the position loop's is a multiple of it.
    pub(super) period_s: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "MeasuredFile", rename_all = "lowercase")]
enum Measured {
    #[default]
    Difference,
    Tachometer,
}

impl VelocityFile {
    /// How it comes to the velocity; by a difference over 0 periods where the time for it is no multiple of them, which the machine refuses.
    pub(super) fn tachometry(&self) -> Tachometry {
        if self.measured == Measured::Tachometer {
            return Tachometry::Direct;
        }
        let ratio = self.over_s.unwrap_or(self.period_s) / self.period_s;
        let whole = ratio.round();
        Tachometry::Difference(if (ratio - whole).abs() < 1e-6 * whole && whole < 1e6 { whole as usize } else { 0 })
    }
}

numbers!(Drive:
    "constant" constant,
    "force_factor" force_factor,
    "delay_s" delay_s,
    "saturation" saturation,
    "ripple.cosine" ripple.cosine,
    "ripple.sine" ripple.sine,
    "ripple.period" ripple.period,
    "position.encoder_step" position.encoder.step,
    "position.gain_per_s" position.gain_per_s,
    "position.feed_forward" position.feed_forward,
    "velocity.encoder_step" velocity.encoder.step,
    "velocity.gain" velocity.gain,
    "velocity.integral_time_s" velocity.integral_time_s,
    "velocity.acceleration_feed_forward" velocity.acceleration_feed_forward,
    ; motor, current
);

impl Drive {
    /// The shortest period of its loops (s).
    pub fn period_s(&self) -> f64 {
        self.current.as_ref().map_or(self.velocity.period_s, |c| c.period_s)
    }
}
