//! The drive of an axis: motor, encoders, position loop and velocity loop.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    CurrentFile, CurrentLoop, Machine, Motor, MotorFile, NumberSource, PointMotion, Value, Wave, WaveFile,
};

/// The encoder of a control loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    /// The point (index) at which it is mounted.
    pub at: usize,
    /// Reading per unit of that point: lead/2π (m/rad) on a screw, else 1.
    pub travel: f64,
    /// Resolution in units of the reading (m or rad); 0 for an ideal encoder.
    pub step: Value,
}

impl Encoder {
    /// Whether it reads an angle (rad): it stands on a rotating point whose angle is not converted to a travel.
    pub fn reads_angle(&self, machine: &Machine) -> bool {
        machine.points[self.at].motion == PointMotion::Rotation && self.travel == 1.0
    }
}

/// The proportional position loop: v_ref = k_p·(r − x) + f·ṙ.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLoop {
    /// Its encoder.
    pub encoder: Encoder,
    /// k_p (1/s).
    pub gain_per_s: Value,
    /// f: velocity feed-forward, as a share of the command's velocity.
    pub feed_forward: Value,
    /// Limits of the command in encoder units; `None` where they are unknown.
    pub limits: Option<[f64; 2]>,
    /// Sampling period (s).
    pub period_s: f64,
}

/// How the velocity is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tachometry {
    /// By the difference of the encoder readings now and this many loop periods ago.
    Difference(usize),
    /// By a tachometer, without the resolution of the encoder.
    Direct,
}

/// The proportional–integral velocity loop: u = k_v·(e + ∫e dt/T_i) + a·r̈, e = v_ref − v.
///
/// Its output is a current (A) where a motor with a current loop follows, else a voltage (V).
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityLoop {
    /// Its encoder.
    pub encoder: Encoder,
    /// How the velocity is obtained.
    pub tachometry: Tachometry,
    /// k_v (V or A per m/s, or per rad/s).
    pub gain: Value,
    /// T_i (s); infinite for a proportional loop.
    pub integral_time_s: Value,
    /// a: acceleration feed-forward (V per m/s²).
    pub acceleration_feed_forward: Value,
    /// Sampling period (s); the position loop's is a multiple of it.
    pub period_s: f64,
}

/// A drive: the sampled loops, and a motor whose force follows their output.
///
/// The force follows instantaneously, held between samples, or through the motor's winding.
///
/// ```text
/// F = (1 + e)·G·u(t − τ) + wave(x),     |u| ≤ saturation
/// ```
///
/// The recorded force is G·u. With a [`Motor`] the force is F = (1 + e)·G·i + wave(x), and the recorded one
/// G·i. The output of the loops is then a voltage, or with a [`CurrentLoop`] the reference current.
///
/// # Units      u in V (or another output unit of the loops), G in N/V or N·m/V; with a winding in N/A or
///   N·m/A
/// # Source     EMPS data set (Janot, Gautier, Brunot 2019): P position and P velocity loop; lumped servo
///   axis, Fig. 3: PI and feed-forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The point (index) the motor moves.
    pub on: usize,
    /// G (N/V or N·m/V).
    pub constant: Value,
    /// 1 + e: actual force over recorded force; 1 for a calibrated drive.
    pub force_factor: Value,
    /// τ (s): delay from a sample to its force.
    pub delay_s: Value,
    /// Largest |u|; infinite without a limit.
    pub saturation: Value,
    /// Ripple of force or torque along the travel of `on`.
    pub ripple: Wave,
    /// Winding of the motor; `None` where the force follows the loops instantaneously.
    pub motor: Option<Motor>,
    /// Current loop; `None` where the velocity loop outputs the voltage.
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
    /// Force or torque per output of the velocity loop (N/V or N·m/V); with a motor per current (N/A or
    /// N·m/A).
    pub(super) constant: NumberSource,
    /// Delay from a sample to its force (s); with a motor, to its voltage.
    pub(super) delay_s: Option<NumberSource>,
    /// Largest output of the velocity loop (V); unlimited by default.
    pub(super) saturation: Option<NumberSource>,
    /// Ripple of force or torque along the travel of `on`.
    #[serde(default)]
    pub(super) ripple: WaveFile,
    /// Winding of the motor; without one the force follows the loops instantaneously.
    pub(super) motor: Option<MotorFile>,
    /// Current loop; without one the velocity loop outputs the motor's voltage.
    pub(super) current: Option<CurrentFile>,
    pub(super) position: PositionLoopFile,
    pub(super) velocity: VelocityFile,
}

/// The position loop: v_ref = gain·(command − position) + feed_forward·(velocity of the command).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionLoopFile {
    /// The point that carries its encoder; that of the motor by default.
    pub(super) at: Option<String>,
    /// Travel per turn (m) where that point rotates and positions are in m.
    pub(super) lead_m: Option<f64>,
    /// Resolution of the encoder (m or rad, in units of its reading); none by default.
    pub(super) encoder_step: Option<NumberSource>,
    pub(super) gain_per_s: NumberSource,
    pub(super) feed_forward: Option<NumberSource>,
    /// Limits of the command (m or rad, in units of the encoder's reading).
    pub(super) limits_m: Option<[f64; 2]>,
    /// Sampling period (s).
    pub(super) period_s: f64,
}

/// The velocity loop: V = gain·(e + ∫e dt/integral_time_s) + acceleration_feed_forward·(acceleration of the
/// command), e = v_ref − velocity.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityFile {
    /// The point that carries its encoder; that of the position loop by default.
    pub(super) at: Option<String>,
    /// Travel per turn (m) where that point rotates and positions are in m; by default that of the position
    /// loop at the same point.
    pub(super) lead_m: Option<f64>,
    /// Resolution of the encoder (m or rad, in units of its reading); by default that of the position loop at
    /// the same point.
    pub(super) encoder_step: Option<NumberSource>,
    /// `difference` of encoder readings (default), or a `tachometer`.
    #[serde(default)]
    measured: Measured,
    /// Time (s) over which readings are differenced, a multiple of the loop's period; one period by default.
    over_s: Option<f64>,
    /// V (or A) per m/s (or rad/s).
    pub(super) gain: NumberSource,
    /// Absent by default: a proportional loop.
    pub(super) integral_time_s: Option<NumberSource>,
    pub(super) acceleration_feed_forward: Option<NumberSource>,
    /// Sampling period (s); the position loop's is a multiple of it.
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
    /// Returns how the velocity is measured. A time `over_s` that is no multiple of the period gives a
    /// difference over 0 periods, which the check of the machine rejects.
    pub(super) fn tachometry(&self) -> Tachometry {
        if self.measured == Measured::Tachometer {
            return Tachometry::Direct;
        }
        let ratio = self.over_s.unwrap_or(self.period_s) / self.period_s;
        let whole = ratio.round();
        Tachometry::Difference(if (ratio - whole).abs() < 1e-6 * whole && whole < 1e6 {
            whole as usize
        } else {
            0
        })
    }
}

impl Drive {
    /// Returns the shortest period of its loops (s).
    pub fn period_s(&self) -> f64 {
        self.current.as_ref().map_or(self.velocity.period_s, |c| c.period_s)
    }
}
