//! The motor's winding and its current loop.

use schemars::JsonSchema;
use serde::Deserialize;

use super::schema::enum_without_descriptions;
use super::{NumberSource, Value};

/// The winding of a motor, between the output of the loops and the force.
///
/// ```text
/// direct current       L·i̇ = u − R·i − G·v                              F = G·i
/// dq axes, p pole      L_q·i̇_q = u_q − R·i_q − ω·(L_d·i_d + ψ)          F = G·i_q + 3/2·p·(L_d − L_q)·i_d·i_q
/// pairs                L_d·i̇_d = u_d − R·i_d + ω·L_q·i_q                ω = p·v,  ψ = 2·G/(3·p)
/// ```
///
/// v is the rate of the driven point and G the drive's constant. The same constant gives force and back-EMF,
/// since the conversion conserves energy.
///
/// # Units      Ω, H, V, A; amplitudes of the phases, so that power is 3/2·(u_d·i_d + u_q·i_q)
/// # Source     lumped servo axis, Eq. 1 (direct current); hybrid multi-domain, Eq. 16–20 (dq axes), with Eq.
///   18 and 19 as
/// ψ_d = L_d·i_d + ψ, ψ_q = L_q·i_q
/// # Deviation  the lumped paper distinguishes k_e from k_T; in SI units they are equal. Iron losses are
///   omitted: the paper names them
/// without a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// R (Ω) of the armature, or of a phase.
    pub resistance_ohm: Value,
    /// L (H) of the armature, or L_q.
    pub inductance_h: Value,
    /// L_d (H).
    pub inductance_d_h: Value,
    /// p of a synchronous motor; `None` for a DC motor.
    pub pole_pairs: Option<u32>,
    /// Supply voltage V (V): limits the armature's |u| to V, and the length of (u_d, u_q) to V/√3.
    pub dc_link_v: Value,
}

/// The proportional–integral current loop: u = k_c·(e + ∫e dt/T_i), e = i_ref − i; i_ref = 0 along the d
/// axis.
///
/// # Source     hybrid multi-domain, Eq. 15 and Tab. 2
/// # Deviation  the sum of Eq. 15 counts errors up to the previous sample
#[derive(Debug, Clone, PartialEq)]
pub struct CurrentLoop {
    /// k_c (V/A).
    pub gain: Value,
    /// T_i (s); infinite for a proportional loop.
    pub integral_time_s: Value,
    /// Sampling period (s); the velocity loop's is a multiple of it.
    pub period_s: f64,
    /// Whether the inverter switches (space-vector modulation, [`Inverter`]) or outputs its mean over a
    /// period.
    pub inverter: Inverter,
}

/// How the inverter generates the voltage of a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename = "InverterFile", rename_all = "lowercase")]
#[schemars(transform = enum_without_descriptions)]
pub enum Inverter {
    /// As its mean over the period, held in the dq axes.
    #[default]
    Averaged,
    /// By space-vector modulation; a loop period is half a carrier period. It applies zero, the two vectors
    /// adjacent to the reference, and zero; the next period reverses the order.
    Switching,
}

/// The winding of a motor: a DC motor, or with pole_pairs a synchronous motor in dq axes.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Resistance (Ω) of the armature, or of a phase.
    pub(super) resistance_ohm: NumberSource,
    /// Inductance (H) of the armature, or along the q axis.
    pub(super) inductance_h: NumberSource,
    /// Inductance (H) along the d axis; inductance_h by default.
    pub(super) inductance_d_h: Option<NumberSource>,
    /// Pole pairs of a synchronous motor; a DC motor by default.
    pub(super) pole_pairs: Option<u32>,
    /// Supply voltage (V); unlimited by default.
    pub(super) dc_link_v: Option<NumberSource>,
}

/// The current loop: V = gain·(e + ∫e dt/integral_time_s), e = i_ref − i.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentFile {
    /// Gain (V/A).
    pub(super) gain: NumberSource,
    /// Absent by default: a proportional loop.
    pub(super) integral_time_s: Option<NumberSource>,
    /// Sampling period (s); the velocity loop's is a multiple of it.
    pub(super) period_s: f64,
    /// `averaged` over a period (default), or `switching` by space-vector modulation.
    #[serde(default)]
    pub(super) inverter: Inverter,
}
