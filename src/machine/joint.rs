//! Spring–dampers with friction, backlash and lead error.

use super::{Friction, LeadError, Value};

/// A spring–damper that acts on the combination Σ cᵢ·qᵢ of points: its force on point i is −cᵢ·(k + iωc)·Σ
/// cⱼ·qⱼ.
///
/// A joint between two points has the coefficients 1 and −1, a joint to the ground a single 1. A screw–nut
/// joint has 1, −1 and −lead/2π (Tian et al., Eq. 19–20: K_W = k_n·v·vᵀ with v = (1, −1, −i_b)). Deviation:
/// the printed extra i_b in the (1,2) entries is omitted, since it resists rigid-body motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// The points (index) and their coefficients.
    pub on: Vec<(usize, f64)>,
    /// Share of the joint's stiffness and damping that acts here. It is 1 unless several joints of one name
    /// share them; the coefficients contain its square root.
    pub share: f64,
    /// Stiffness k (N/m on translations, N·m/rad on rotations).
    pub stiffness: Value,
    /// Viscous damping c (N·s/m or N·m·s/rad).
    pub damping: Value,
    /// Loss factor η: k is multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)), s as in
    /// [`Machine::loss_dispersion`](super::Machine).
    pub loss_factor: Value,
    /// Integral action ω_i (1/s) of a holding servo: k is multiplied by 1 + ω_i/(iω), which amplifies slow
    /// motion. Only frequency responses use it.
    pub integral_rate: Value,
    /// Relaxation stiffness (N/m or N·m/rad) in series with the damper: c acts through it. `None`: a plain
    /// damper.
    pub relaxation_stiffness: Option<Value>,
    /// Friction in parallel. Frequency responses and modes ignore it: they hold for motion without reversal.
    pub friction: Friction,
    /// Backlash (m or rad): width of the dead zone in which spring and damper do not act. Frequency responses
    /// and modes hold for the closed joint.
    pub gap: Value,
    /// Lead error. Frequency responses and modes ignore its periodic part.
    pub lead_error: LeadError,
}

impl Joint {
    /// Creates a joint on points (index) with these coefficients; its numbers are 0.
    pub(super) fn new(name: String, on: Vec<(usize, f64)>) -> Self {
        Joint {
            name,
            on,
            share: 1.0,
            stiffness: Value::default(),
            damping: Value::default(),
            loss_factor: Value::default(),
            integral_rate: Value::default(),
            relaxation_stiffness: None,
            friction: Friction::default(),
            gap: Value::default(),
            lead_error: LeadError::default(),
        }
    }
}
