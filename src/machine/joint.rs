//! Spring–dampers, with friction, play and lead error.

use super::{Friction, LeadError, Value};

/// A spring–damper that acts on the combination Σ cᵢ·qᵢ of points: its force on point i is −cᵢ·(k + iωc)·Σ cⱼ·qⱼ.
///
/// A joint between two points has the coefficients 1 and −1; one to the ground a single 1; a screw–nut joint
/// 1, −1 and −lead/2π (Tian et al., Eq. 19–20: K_W = k_n·v·vᵀ with v = (1, −1, −i_b).
/// Deviation: the printed extra i_b in the (1,2) entries is left out, since it resists rigid-body motion).
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// The points (index) and their coefficients.
    pub on: Vec<(usize, f64)>,
    /// Share of the joint's work that is done here, 1 unless several joints of one name share it; the coefficients contain its square root.
    pub share: f64,
    /// Stiffness k (N/m on translations, N·m/rad on rotations).
    pub stiffness: Value,
    /// Viscous damping c (N·s/m or N·m·s/rad).
    pub damping: Value,
    /// Loss factor η: k times 1 + η·(i + s·2/π·ln(ω/ω₀)), s as in [`Machine::loss_dispersion`](super::Machine).
    pub loss_factor: Value,
    /// Integral action ω_i (1/s) of a servo that holds: k times 1 + ω_i/(iω), which feeds slow motion. Frequency responses alone know of it.
    pub integral_rate: Value,
    /// Relaxation stiffness (N/m or N·m/rad) in series with the damper: c acts through it. `None`: a plain damper.
    pub relaxation_stiffness: Option<Value>,
    /// Friction beside it. Frequency responses and modes know nothing of it: they are those of the joint as it moves without reversal.
    pub friction: Friction,
    /// Play (m or rad): width of the dead zone in which spring and damper do not act. Frequency responses and modes are those of the
    /// joint in contact.
    pub gap: Value,
    /// Error of the lead.
    pub lead_error: LeadError,
}
