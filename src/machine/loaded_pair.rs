//! Springs made of rolling contacts, loaded by the operating condition.

use super::Operating;
use crate::contact::{ContactError, PreloadedPair, Rule, Share, Stiffness, StribeckCurve};

/// A preloaded pair of contacts (a double nut, a bearing set) as a spring whose stiffness follows from its load.
///
/// ```text
/// F = s·( f(v) + m·(g + a) + F_outside )
/// ```
///
/// f is the friction at the velocity v, m the mass the pair moves, a its acceleration (positive where it loads side A), g what
/// gravity adds to it on an upright axis, s the share of the force that this pair takes.
///
/// # Units      F in N, v in m/s, a and g in m/s²
/// # Limits     an axis at rest without gravity leaves the preload alone
/// # Source     Duan et al., Eq. 10–17; vertical feed system, Eq. 2–25 (a positive upward, share 1/2 of each bearing set).
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedPair {
    /// Unique name.
    pub name: String,
    /// The two sides and their preload.
    pub pair: PreloadedPair,
    /// How the load is shared.
    pub rule: Rule,
    /// Tangent or secant.
    pub stiffness: Stiffness,
    /// Factor on the stiffness; 1 where physics decides.
    pub weight: f64,
    /// Friction that loads it, where it has some.
    pub friction: Option<StribeckCurve>,
    /// Mass (kg) whose inertia and weight it carries.
    pub moved_mass_kg: f64,
    /// Gravity along the axis (m/s²); 0 for a level one.
    pub gravity_m_s2: f64,
    /// Share of the force it takes.
    pub share: f64,
    /// Share of an outside force on the table that reaches this axis: 1/2 where two screws carry it.
    pub outside_share: f64,
}

/// A loaded pair at one operating condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairState {
    /// Outside force of the pair (N).
    pub force_n: f64,
    /// How its sides carry it.
    pub share: Share,
    /// Its stiffness (N/m).
    pub stiffness_n_per_m: f64,
}

impl LoadedPair {
    /// Outside force (N) of the pair.
    pub fn force_n(&self, operating: &Operating) -> f64 {
        let friction_n = self.friction.map_or(0.0, |curve| curve.force_n(operating.velocity_m_s.unwrap_or(0.0)));
        let inertia_n = self.moved_mass_kg * (self.gravity_m_s2 + operating.acceleration_m_s2.unwrap_or(0.0));
        self.share * (friction_n + inertia_n + self.outside_share * operating.force_n.unwrap_or(0.0))
    }

    /// Load, shares and stiffness.
    ///
    /// # Errors  a load beyond the validity of the contact formula, or one that is not finite.
    pub fn at(&self, operating: &Operating) -> Result<PairState, ContactError> {
        let force_n = self.force_n(operating);
        let share = self.pair.share(force_n, self.rule)?;
        let stiffness_n_per_m = self.weight * self.pair.stiffness_n_per_m(force_n, self.rule, self.stiffness)?;
        Ok(PairState { force_n, share, stiffness_n_per_m })
    }

    /// Stiffness (N/m); NaN where [`LoadedPair::at`] refuses, which [`Machine::check_operating`](super::Machine::check_operating)
    /// says beforehand.
    pub(super) fn stiffness(&self, operating: &Operating) -> f64 {
        self.at(operating).map_or(f64::NAN, |state| state.stiffness_n_per_m)
    }
}
