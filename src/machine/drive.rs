//! The drive of an axis: motor, encoders, position and velocity loop.

use super::friction::numbers;
use super::{CurrentLoop, Motor, Value, Wave};

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
