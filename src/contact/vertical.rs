//! A vertical axis: weight and acceleration as the load of its nut and bearings.

use super::error::{finite, positive, within};
use super::{ContactError, Pair, Rule, Share, Stiffness};

/// Weight coefficients the paper multiplies printed stiffnesses by.
///
/// # Source  vertical, Eq. 8 (c_wn) and 14 (c_wb), both 0.9, without a reason given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Factor of the nut's stiffness.
    pub nut: f64,
    /// Factor of the stiffness of each bearing set.
    pub bearing: f64,
}

impl Weights {
    /// No weights: what physics uses.
    pub const NONE: Weights = Weights { nut: 1.0, bearing: 1.0 };
    /// 0.9 each, once.
    pub const ONCE: Weights = Weights { nut: 0.9, bearing: 0.9 };
    /// As printed: c_wb is in Eq. 14, 16, 21, 23 and again in Eq. 17–18, 24–25.
    pub const AS_PRINTED: Weights = Weights { nut: 0.9, bearing: 0.81 };
}

/// A vertical axis with a double nut and a bearing set at each end of the screw.
///
/// ```text
/// F_nut = m·(g + a)      F_upper = s·F_nut      F_lower = (1 − s)·F_nut
/// ```
///
/// a is positive upward: «upward acceleration» of the paper; its «upward deceleration» of magnitude a is −a here, so that
/// the force turns round at a = −g, where nut B and bearings B and C become the loaded ones (Eq. 9–10, 19–23). Side A of the
/// nut and of the upper set, and side A of the lower set (the paper's bearing D), carry the weight. Friction is left out.
///
/// # Units      m in kg, a and g in m/s², F in N
/// # Limits     a = −g leaves the preload alone (test `limit_free_fall_leaves_the_preload`)
/// # Source     vertical, Eq. 2–25; s = 1/2 there («equally divided»). Deviations: one c_wb by choice of [`Weights`]; the
/// exponent of Eq. 9's second branch as in Eq. 7; N_b·n_b of Eq. 14, 16, 23 read as n_b of Eq. 21 ([`super::Side::tandem`]
/// stands for several bearings).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerticalAxis {
    /// Moved mass m (kg).
    pub mass_kg: f64,
    /// Gravity g (m/s²).
    pub gravity_m_per_s2: f64,
    /// Double nut.
    pub nut: Pair,
    /// Bearing set at the upper end.
    pub upper: Pair,
    /// Bearing set at the lower end.
    pub lower: Pair,
    /// Share s of the force that the upper end takes, 0…1.
    pub upper_share: f64,
    /// Weights of the stiffnesses.
    pub weights: Weights,
}

/// Loads and stiffnesses of a vertical axis at one acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerticalState {
    /// Outside force of the nut (N).
    pub nut_force_n: f64,
    /// Outside force of the upper bearings (N).
    pub upper_force_n: f64,
    /// Outside force of the lower bearings (N).
    pub lower_force_n: f64,
    /// How the nuts share it.
    pub nut: Share,
    /// How the upper bearings share it.
    pub upper: Share,
    /// How the lower bearings share it.
    pub lower: Share,
    /// Stiffness of the double nut (N/m), weighted.
    pub nut_stiffness_n_per_m: f64,
    /// Stiffness of the upper bearings (N/m), weighted.
    pub upper_stiffness_n_per_m: f64,
    /// Stiffness of the lower bearings (N/m), weighted.
    pub lower_stiffness_n_per_m: f64,
}

impl VerticalAxis {
    /// Outside forces (N) of nut, upper and lower bearings at an acceleration, positive upward.
    ///
    /// # Errors  a mass or gravity that is not positive, a share outside 0…1, an acceleration that is not finite.
    pub fn forces_n(&self, acceleration_m_per_s2: f64) -> Result<[f64; 3], ContactError> {
        positive("the moved mass (kg)", self.mass_kg)?;
        positive("gravity (m/s²)", self.gravity_m_per_s2)?;
        within("the share of the upper bearings", self.upper_share, 0.0, 1.0)?;
        let force_n = self.mass_kg * (self.gravity_m_per_s2 + finite("the acceleration (m/s²)", acceleration_m_per_s2)?);
        Ok([force_n, self.upper_share * force_n, (1.0 - self.upper_share) * force_n])
    }

    /// Accelerations (m/s²) at which a side of nut, upper and lower set unloads: downward first, upward second. A set that
    /// takes no share of the force never unloads: infinite.
    ///
    /// # Errors  see [`VerticalAxis::forces_n`].
    pub fn unloading_accelerations_m_per_s2(&self, rule: Rule) -> Result<[(f64, f64); 3], ContactError> {
        self.forces_n(0.0)?;
        let of = |pair: &Pair, share: f64| {
            let (low_n, high_n) = pair.unloading_forces_n(rule);
            let effective_kg = share * self.mass_kg;
            (low_n / effective_kg - self.gravity_m_per_s2, high_n / effective_kg - self.gravity_m_per_s2)
        };
        Ok([of(&self.nut, 1.0), of(&self.upper, self.upper_share), of(&self.lower, 1.0 - self.upper_share)])
    }

    /// Loads and stiffnesses at an acceleration, positive upward.
    ///
    /// # Errors  see [`VerticalAxis::forces_n`] and [`Pair::share`]; a weight that is not positive.
    pub fn at(&self, acceleration_m_per_s2: f64, rule: Rule, stiffness: Stiffness) -> Result<VerticalState, ContactError> {
        let [nut_force_n, upper_force_n, lower_force_n] = self.forces_n(acceleration_m_per_s2)?;
        positive("the weight of the nut", self.weights.nut)?;
        positive("the weight of the bearings", self.weights.bearing)?;
        Ok(VerticalState {
            nut_force_n,
            upper_force_n,
            lower_force_n,
            nut: self.nut.share(nut_force_n, rule)?,
            upper: self.upper.share(upper_force_n, rule)?,
            lower: self.lower.share(lower_force_n, rule)?,
            nut_stiffness_n_per_m: self.weights.nut * self.nut.stiffness_n_per_m(nut_force_n, rule, stiffness)?,
            upper_stiffness_n_per_m: self.weights.bearing * self.upper.stiffness_n_per_m(upper_force_n, rule, stiffness)?,
            lower_stiffness_n_per_m: self.weights.bearing * self.lower.stiffness_n_per_m(lower_force_n, rule, stiffness)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::published::{self, BEARING_PRELOAD_N, NUT_BALLS, NUT_PRELOAD_N};
    use crate::contact::{AngularContactBearing, Nut, Printed};

    const G: f64 = 9.80665;

    fn axis(weights: Weights) -> VerticalAxis {
        let nut = Nut::new(&published::nut(NUT_BALLS)).unwrap().side();
        let bearing = AngularContactBearing::new(&published::bearing()).unwrap().side();
        let set = Pair::bearing_set(bearing, 1, 1, BEARING_PRELOAD_N).unwrap().printed(Printed::Larger);
        VerticalAxis {
            mass_kg: 80.0,
            gravity_m_per_s2: G,
            nut: Pair::double_nut(nut, NUT_PRELOAD_N).unwrap(),
            upper: set,
            lower: set,
            upper_share: 0.5,
            weights,
        }
    }

    #[test]
    fn limit_free_fall_leaves_the_preload() {
        let state = axis(Weights::NONE).at(-G, Rule::Physics, Stiffness::Tangent).unwrap();
        assert_eq!(state.nut_force_n, 0.0);
        assert!((state.nut.load_a_n / NUT_PRELOAD_N - 1.0).abs() < 1e-14);
        assert!((state.upper.load_b_n / BEARING_PRELOAD_N - 1.0).abs() < 1e-14);
    }

    #[test]
    fn published_eq_5_9_10_14_as_printed() {
        let axis = axis(Weights::AS_PRINTED);
        let (nut, _) = axis.nut.sides();
        let (bearing, _) = axis.upper.sides();
        for a in [0.0, 5.0, 12.0] {
            let state = axis.at(a, Rule::AsPrinted, Stiffness::Tangent).unwrap();
            let expected = 0.9 * nut.stiffness_n_per_m(NUT_PRELOAD_N + 80.0 * (G + a), Stiffness::Tangent).unwrap();
            assert!((state.nut_stiffness_n_per_m / expected - 1.0).abs() < 1e-13);
            let expected = 0.81 * bearing.stiffness_n_per_m(BEARING_PRELOAD_N + 40.0 * (G + a), Stiffness::Tangent).unwrap();
            assert!((state.upper_stiffness_n_per_m / expected - 1.0).abs() < 1e-13);
            assert_eq!(state.upper_stiffness_n_per_m, state.lower_stiffness_n_per_m);
        }
        // Deceleration beyond g: nut B is the loaded one.
        let state = axis.at(-15.0, Rule::AsPrinted, Stiffness::Tangent).unwrap();
        assert!((state.nut.load_b_n / (NUT_PRELOAD_N + 80.0 * (15.0 - G)) - 1.0).abs() < 1e-13);
        assert!(state.nut.load_a_n < NUT_PRELOAD_N);
    }

    #[test]
    fn published_eq_15_and_19_unloading() {
        let [nut, upper, lower] = axis(Weights::NONE).unloading_accelerations_m_per_s2(Rule::AsPrinted).unwrap();
        // m·a/2 = 1.83·P − m·g/2 upward, m·a/2 = 1.83·P + m·g/2 in deceleration.
        assert!((40.0 * upper.1 - (1.8284 * BEARING_PRELOAD_N - 40.0 * G)).abs() < 0.1);
        assert!((-40.0 * upper.0 - (1.8284 * BEARING_PRELOAD_N + 40.0 * G)).abs() < 0.1);
        assert_eq!(upper, lower);
        assert!((80.0 * (nut.1 + G) - 1.8284 * NUT_PRELOAD_N).abs() < 0.1);
        let axis = VerticalAxis { upper_share: 1.0, ..axis(Weights::NONE) };
        let [_, _, lower] = axis.unloading_accelerations_m_per_s2(Rule::Physics).unwrap();
        assert_eq!(lower, (f64::NEG_INFINITY, f64::INFINITY));
    }

    #[test]
    fn limit_physics_and_print_differ_where_notes_say() {
        let axis = axis(Weights::ONCE);
        let physics = axis.at(0.0, Rule::Physics, Stiffness::Tangent).unwrap();
        let printed = axis.at(0.0, Rule::AsPrinted, Stiffness::Tangent).unwrap();
        assert!((physics.nut.load_a_n - physics.nut.load_b_n - 80.0 * G).abs() < 1e-9);
        assert!(printed.nut.load_a_n - printed.nut.load_b_n > 80.0 * G + 100.0);
        let ratio = physics.nut_stiffness_n_per_m / printed.nut_stiffness_n_per_m;
        assert!(ratio > 1.5 && ratio < 2.0, "{ratio}");
    }

    #[test]
    fn bad_axes_are_named() {
        let good = axis(Weights::NONE);
        let of = |axis: VerticalAxis, a| axis.at(a, Rule::Physics, Stiffness::Tangent).unwrap_err().to_string();
        assert!(of(VerticalAxis { mass_kg: 0.0, ..good }, 0.0).contains("mass"));
        assert!(of(VerticalAxis { gravity_m_per_s2: -1.0, ..good }, 0.0).contains("gravity"));
        assert!(of(VerticalAxis { upper_share: 1.1, ..good }, 0.0).contains("share"));
        assert!(of(VerticalAxis { weights: Weights { nut: 0.0, bearing: 1.0 }, ..good }, 0.0).contains("weight"));
        assert!(of(good, f64::NAN).contains("acceleration"));
        assert!(of(good, 1e6).contains("beyond the validity"));
    }
}
