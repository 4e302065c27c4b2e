//! The motor's winding and the loop of its current.

use schemars::JsonSchema;
use serde::Deserialize;

use super::friction::numbers;
use super::schema::words_alone;
use super::{NumberSource, Value};

/// The winding of a motor, which stands between the loops and the force.
///
/// ```text
/// direct current       L·i̇ = u − R·i − G·v                              F = G·i
/// dq axes, p pole      L_q·i̇_q = u_q − R·i_q − ω·(L_d·i_d + ψ)          F = G·i_q + 3/2·p·(L_d − L_q)·i_d·i_q
/// pairs                L_d·i̇_d = u_d − R·i_d + ω·L_q·i_q                ω = p·v,  ψ = 2·G/(3·p)
/// ```
///
/// v is the rate of the driven point and G the drive's constant: what the winding induces follows from its force, since neither makes energy.
///
/// # Units      Ω, H, V, A; amplitudes of the phases, so that power is 3/2·(u_d·i_d + u_q·i_q)
/// # Source     lumped servo axis, Eq. 1 (direct current); hybrid multi-domain, Eq. 16–20 (dq axes), with Eq. 18 and 19 as ψ_d = L_d·i_d + ψ, ψ_q = L_q·i_q
/// # Deviation  the lumped paper has k_e beside k_T: as numbers in SI they are one. Losses in iron are left out: the paper names them without a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// R (Ω) of the armature, or of a phase.
    pub resistance_ohm: Value,
    /// L (H) of the armature, or L_q.
    pub inductance_h: Value,
    /// L_d (H).
    pub inductance_d_h: Value,
    /// p of a synchronous motor; `None` for one with direct current.
    pub pole_pairs: Option<u32>,
    /// Voltage of the supply (V): the armature's |u| stays below it, the length of (u_d, u_q) below it over √3.
    pub dc_link_v: Value,
}

/// The current loop, proportional and integral: u = k_c·(e + ∫e dt/T_i), e = i_ref − i; i_ref = 0 along the d axis.
///
/// # Source     hybrid multi-domain, Eq. 15 and Tab. 2
/// # Deviation  the sum of Eq. 15 counts errors up to the sample before
#[derive(Debug, Clone, PartialEq)]
pub struct CurrentLoop {
    /// k_c (V/A).
    pub gain: Value,
    /// T_i (s); infinite for a loop that is proportional alone.
    pub integral_time_s: Value,
    /// Its period (s), of which the velocity loop's is a multiple.
    pub period_s: f64,
    /// Whether the inverter switches (space vectors, [`Inverter`]) or gives its mean over a period.
    pub inverter: Inverter,
}

/// How the inverter makes the voltage of a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename = "InverterFile", rename_all = "lowercase")]
#[schemars(transform = words_alone)]
pub enum Inverter {
    /// Its mean over the period, held in the dq axes.
    #[default]
    Averaged,
    /// By space vectors, a half of the carrier's period each: zero, two neighbours of the wanted vector, zero; and back.
    Switching,
}

/// The winding of a motor: direct current, or with pole_pairs synchronous in dq axes.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Of the armature, or of a phase.
    pub(super) resistance_ohm: NumberSource,
    /// Of the armature, or along the q axis.
    pub(super) inductance_h: NumberSource,
    /// Along the d axis; inductance_h by default.
    pub(super) inductance_d_h: Option<NumberSource>,
    /// Pole pairs of a synchronous motor; direct current by default.
    pub(super) pole_pairs: Option<u32>,
    /// Voltage of the supply (V); without limit by default.
    pub(super) dc_link_v: Option<NumberSource>,
}

/// The current loop: V = gain·(e + ∫e dt/integral_time_s), e = i_ref − i.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentFile {
    /// V/A.
    pub(super) gain: NumberSource,
    /// None by default: proportional alone.
    pub(super) integral_time_s: Option<NumberSource>,
    /// Period of the loop (s); the velocity loop's is a multiple of it.
    pub(super) period_s: f64,
    /// `averaged` over a period (default), or `switching` by space vectors.
    #[serde(default)]
    pub(super) inverter: Inverter,
}

numbers!(Motor:
    "motor.resistance_ohm" resistance_ohm,
    "motor.inductance_h" inductance_h,
    "motor.inductance_d_h" inductance_d_h,
    "motor.dc_link_v" dc_link_v,
);

numbers!(CurrentLoop:
    "current.gain" gain,
    "current.integral_time_s" integral_time_s,
);
