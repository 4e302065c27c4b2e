//! Springs made of rolling contacts whose load follows from the operating condition.

use std::sync::Arc;

use super::{Operating, Segment};
use crate::contact::{ContactError, PreloadedPair, Rule, Share, Stiffness, StribeckCurve};
use numeric::root::bracketed_root;

/// A preloaded pair of contacts (a double nut, a bearing set) as a spring with load-dependent stiffness.
///
/// ```text
/// F = s·( f(v) + m·(g + a) + F_outside )
/// ```
///
/// f is the friction at the velocity v, m the moved mass, and a its acceleration (positive where it loads
/// side A). g is the gravity along a vertical axis, and s the share of the force that this pair carries.
/// Where two screw ends carry the force, s follows from their compatibility ([`ScrewEnd`]).
///
/// # Units      F in N, v in m/s, a and g in m/s²
/// # Limits     at rest without gravity only the preload acts
/// # Source     Duan et al., Eq. 10–17; vertical feed system, Eq. 2–25 (a positive upward, share 1/2 of each
///   bearing set).
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedPair {
    /// Unique name.
    pub name: String,
    /// The two sides and their preload.
    pub pair: PreloadedPair,
    /// Rule of load sharing.
    pub rule: Rule,
    /// Tangent or secant.
    pub stiffness: Stiffness,
    /// Factor on the stiffness; 1 for the physical stiffness.
    pub weight: f64,
    /// Friction that loads it, if any.
    pub friction: Option<StribeckCurve>,
    /// Mass (kg) whose inertia and weight it carries.
    pub moved_mass_kg: f64,
    /// Gravity along the axis (m/s²); 0 for a horizontal axis.
    pub gravity_m_s2: f64,
    /// Share of the force that this pair carries, where its end does not follow from [`LoadedPair::end`].
    pub share: f64,
    /// The screw end that it holds, where both ends of the screw carry the force: by [`Rule::Physics`] they
    /// share it by compatibility.
    pub end: Option<Arc<ScrewEnd>>,
    /// Share of an external force on the table that reaches this axis: 1/2 where two screws carry it.
    pub outside_share: f64,
}

/// One of two screw ends that together carry the force on the nut: the segment of the screw and the contact
/// of the other end.
///
/// ```text
/// F₁ + F₂ = F          F₁/K₁(z) + x₁(F₁) = F₂/K₂(z) + x₂(F₂)
/// ```
///
/// K is the stiffness of a segment, x the displacement of a preloaded pair. The stiffer path, that of the
/// shorter segment, carries more.
///
/// # Source     compatibility at the nut. Deviation from the vertical feed system, Eq. 12, which gives each
///   end half of the force.
#[derive(Debug, Clone, PartialEq)]
pub struct ScrewEnd {
    /// Segment between the nut and this end.
    pub segment: Segment,
    /// The pair that holds the other end.
    pub other_pair: PreloadedPair,
    /// Segment between the nut and the other end.
    pub other_segment: Segment,
}

impl ScrewEnd {
    /// Computes the force (N) on the pair of this end out of the force on the nut.
    fn force_n(&self, pair: &PreloadedPair, whole_n: f64, operating: &Operating) -> f64 {
        let [own, other] =
            [&self.segment, &self.other_segment].map(|segment| segment.stiffness_n_per_m(operating));
        let mismatch = |own_n: f64| {
            let other_n = whole_n - own_n;
            own_n / own + pair.displacement_m(own_n)
                - other_n / other
                - self.other_pair.displacement_m(other_n)
        };
        // The mismatch rises with the own force and has opposite signs where one end carries everything.
        bracketed_root(whole_n.min(0.0), whole_n.max(0.0), mismatch).unwrap_or(0.0)
    }
}

/// State of a loaded pair at one operating condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairState {
    /// External force on the pair (N).
    pub force_n: f64,
    /// Distribution of the load over its sides.
    pub share: Share,
    /// Its stiffness (N/m).
    pub stiffness_n_per_m: f64,
}

impl LoadedPair {
    /// Computes the external force (N) on the pair.
    pub fn force_n(&self, operating: &Operating) -> f64 {
        let friction_n =
            self.friction.map_or(0.0, |curve| curve.force_n(operating.velocity_m_s.unwrap_or(0.0)));
        let inertia_n = self.moved_mass_kg * (self.gravity_m_s2 + operating.acceleration_m_s2.unwrap_or(0.0));
        let whole_n = friction_n + inertia_n + self.outside_share * operating.force_n.unwrap_or(0.0);
        match &self.end {
            Some(end) if self.rule == Rule::Physics => end.force_n(&self.pair, whole_n, operating),
            _ => self.share * whole_n,
        }
    }

    /// Computes load, load shares and stiffness.
    ///
    /// # Errors  a load beyond the validity of the contact formula, or one that is not finite.
    pub fn at(&self, operating: &Operating) -> Result<PairState, ContactError> {
        let force_n = self.force_n(operating);
        let share = self.pair.share(force_n, self.rule)?;
        let stiffness_n_per_m =
            self.weight * self.pair.stiffness_n_per_m(force_n, self.rule, self.stiffness)?;
        Ok(PairState { force_n, share, stiffness_n_per_m })
    }

    /// Computes the stiffness (N/m); NaN where [`LoadedPair::at`] fails.
    /// [`Machine::check_operating`](super::Machine::check_operating) reports that case beforehand.
    pub(super) fn stiffness(&self, operating: &Operating) -> f64 {
        self.at(operating).map_or(f64::NAN, |state| state.stiffness_n_per_m)
    }
}
