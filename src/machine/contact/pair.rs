//! Two sides preloaded against each other: a double nut, or a bearing set in DB or DF arrangement.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::{finite, positive};
use super::side::two_thirds;
use super::{ContactError, Side, Stiffness};
use crate::schema::enum_without_descriptions;
use numeric::root::bracketed_root;

/// How an external force is shared, and which stiffness results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "RuleFile", rename_all = "kebab-case")]
#[schemars(description = "How a contact shares its load.")]
pub enum Rule {
    /// Equilibrium P_A − P_B = F, compatible deflections, stiffnesses of the two sides added.
    #[schemars(description = "Equilibrium, both sides in parallel.")]
    Physics,
    /// As printed in the papers: the loaded side carries P + |F|, and [`Printed`] combines the two
    /// stiffnesses.
    #[schemars(description = "As the papers print it.")]
    AsPrinted,
}

/// How a paper combines the stiffnesses of the two sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "PrintedFile", rename_all = "lowercase")]
#[schemars(transform = enum_without_descriptions)]
pub enum Printed {
    /// The larger of the two: Duan, Eq. 17; vertical, Eq. 8, 11, 17–18, 24–25.
    Larger,
    /// The two in series at the preload, independent of the external force: Duan, Eq. 18–20.
    Series,
}

/// Distribution of an external force over the two sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Load of side A (N), 0 when separated.
    pub load_a_n: f64,
    /// Load of side B (N), 0 when separated.
    pub load_b_n: f64,
    /// Displacement (m) from the preloaded state, with the sign of the force.
    pub displacement_m: f64,
}

/// Two sides preloaded against each other; a positive external force F loads A and relieves B.
///
/// ```text
/// P_A − P_B = F          c_A·P_A^(2/3) + c_B·P_B^(2/3) = (c_A + c_B)·P^(2/3)          while both carry
///
/// B unloads at  F = +P·(1 + c_B/c_A)^(3/2),   A at  F = −P·(1 + c_A/c_B)^(3/2):   2^(3/2)·P = 2.83·P for equal sides
///
/// dF/dx = 3/2·P_A/δ_A + 3/2·P_B/δ_B          beyond: the side that still carries alone, P = |F|
/// ```
///
/// Load, displacement and tangent stiffness are continuous where a side unloads. There the tangent stiffness
/// has a vertical slope on the preloaded side, since that of the unloading contact falls with the cube root
/// of its load.
///
/// As printed the loaded side carries P + |F|, so that B unloads at F = P·((1 + c_B/c_A)^(3/2) − 1) = 1.83·P
/// for equal sides. That is the increment of side A's load, not the external force.
///
/// # Units      F, P in N, x in m, stiffness in N/m
/// # Limits     F → 0 gives the sum of both tangents at the preload (test
///   `limit_small_forces_see_both_tangents`)
/// # Errors     [`ContactError::BeyondValidity`] if the loaded side exceeds its pressure limit
/// # Source     Duan, Eq. 12–17 and 20; vertical, Eq. 2–11 and 12–25. Deviation: [`Rule::Physics`] satisfies
///   equilibrium, which P_A = P + F
/// violates, and adds the stiffnesses of the parallel sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreloadedPair {
    side_a: Side,
    side_b: Side,
    preload_n: f64,
    printed: Printed,
}

impl PreloadedPair {
    /// Creates a pair with the axial preload P between its sides.
    ///
    /// # Errors  a preload that is not positive or beyond the pressure limit of a side.
    pub fn new(
        side_a: Side,
        side_b: Side,
        preload_n: f64,
        printed: Printed,
    ) -> Result<PreloadedPair, ContactError> {
        positive("the preload (N)", preload_n)?;
        side_a.check_load_n(preload_n)?;
        side_b.check_load_n(preload_n)?;
        Ok(PreloadedPair { side_a, side_b, preload_n, printed })
    }

    /// Creates a pair of two equal nuts with a spacer between them; as printed the larger stiffness counts.
    ///
    /// # Errors  see [`PreloadedPair::new`].
    pub fn double_nut(nut: Side, preload_n: f64) -> Result<PreloadedPair, ContactError> {
        PreloadedPair::new(nut, nut, preload_n, Printed::Larger)
    }

    /// Creates a bearing set of `count_a` bearings in tandem against `count_b`; 1 and 1 is a DB or DF pair.
    ///
    /// As printed by Duan the sides are in series; the vertical-axis paper needs [`PreloadedPair::printed`]
    /// with [`Printed::Larger`].
    ///
    /// # Errors  a count of zero; see [`PreloadedPair::new`].
    pub fn bearing_set(
        bearing: Side,
        count_a: usize,
        count_b: usize,
        preload_n: f64,
    ) -> Result<PreloadedPair, ContactError> {
        PreloadedPair::new(bearing.tandem(count_a)?, bearing.tandem(count_b)?, preload_n, Printed::Series)
    }

    /// Replaces the printed way of combining the two stiffnesses.
    pub fn printed(self, printed: Printed) -> PreloadedPair {
        PreloadedPair { printed, ..self }
    }

    /// Returns the preload P (N).
    pub fn preload_n(&self) -> f64 {
        self.preload_n
    }

    /// Returns sides A and B.
    pub fn sides(&self) -> (Side, Side) {
        (self.side_a, self.side_b)
    }

    /// Returns the external forces (N) at which a side unloads: A at the first, negative, B at the second,
    /// positive.
    pub fn unloading_forces_n(&self, rule: Rule) -> (f64, f64) {
        let ratio = self.side_b.compliance_m_per_two_thirds_n() / self.side_a.compliance_m_per_two_thirds_n();
        (-self.preload_n * unloading_ratio(1.0 / ratio, rule), self.preload_n * unloading_ratio(ratio, rule))
    }

    /// Computes the loads of both sides and the displacement under an external force of either sign.
    ///
    /// As printed the displacement is that of the loaded side, δ_AT − δ_A of Eq. 14.
    ///
    /// # Errors  a force that is not finite, or one that takes the loaded side beyond its pressure limit.
    pub fn share(&self, force_n: f64, rule: Rule) -> Result<Share, ContactError> {
        finite("the external force (N)", force_n)?;
        let share = self.unchecked_share(force_n, rule);
        let loaded = if force_n < 0.0 { &self.side_b } else { &self.side_a };
        loaded.check_load_n(share.load_a_n.max(share.load_b_n))?;
        Ok(share)
    }

    /// Computes the displacement (m) from the preloaded state by [`Rule::Physics`], whatever the contact
    /// pressure.
    pub(crate) fn displacement_m(&self, force_n: f64) -> f64 {
        self.unchecked_share(force_n, Rule::Physics).displacement_m
    }

    fn unchecked_share(&self, force_n: f64, rule: Rule) -> Share {
        let swapped = force_n < 0.0;
        let (loaded, relieved) =
            if swapped { (&self.side_b, &self.side_a) } else { (&self.side_a, &self.side_b) };
        let ratio = relieved.compliance_m_per_two_thirds_n() / loaded.compliance_m_per_two_thirds_n();
        let relative = force_n.abs() / self.preload_n;
        // Loads relative to the preload; displacement relative to the loaded side's deflection at the
        // preload.
        let (high, low, travel) = match rule {
            Rule::Physics if relative >= unloading_ratio(ratio, rule) => {
                (relative, 0.0, two_thirds(relative) - 1.0)
            }
            Rule::Physics => {
                let balance = |relief: f64| rise(ratio * relief) - rise(-relief) - relative;
                // Without a change of sign the force equals the unloading force within rounding error.
                let relief = bracketed_root(0.0, 1.0, balance).unwrap_or(1.0);
                (1.0 + rise(ratio * relief), (1.0 - relief).powf(1.5), ratio * relief)
            }
            Rule::AsPrinted => {
                let travel = (2.0 / 3.0 * relative.ln_1p()).exp_m1();
                (1.0 + relative, (1.0 - travel / ratio).max(0.0).powf(1.5), travel)
            }
        };
        let (high_n, low_n) = (high * self.preload_n, low * self.preload_n);
        let displacement_m = (travel * loaded.deflection(self.preload_n)).copysign(force_n);
        if swapped {
            Share { load_a_n: low_n, load_b_n: high_n, displacement_m }
        } else {
            Share { load_a_n: high_n, load_b_n: low_n, displacement_m }
        }
    }

    /// Computes the axial stiffness (N/m) of the pair under an external force of either sign.
    ///
    /// By [`Rule::Physics`] the tangent is dF/dx, the sum of both sides' tangents. The secant is F/x from the
    /// preloaded state, which tends to that sum as F → 0. As printed, [`Stiffness`] selects the stiffness of
    /// each side that enters [`Printed`]: Duan uses secants P/δ, the vertical-axis paper tangents.
    ///
    /// # Errors  see [`PreloadedPair::share`].
    pub fn stiffness_n_per_m(
        &self,
        force_n: f64,
        rule: Rule,
        stiffness: Stiffness,
    ) -> Result<f64, ContactError> {
        let share = self.share(force_n, rule)?;
        let sides = |kind, load_a_n, load_b_n| {
            (self.side_a.stiffness(load_a_n, kind), self.side_b.stiffness(load_b_n, kind))
        };
        Ok(match (rule, self.printed) {
            (Rule::Physics, _) if stiffness == Stiffness::Secant && share.displacement_m != 0.0 => {
                force_n / share.displacement_m
            }
            (Rule::Physics, _) => {
                let (a, b) = sides(Stiffness::Tangent, share.load_a_n, share.load_b_n);
                a + b
            }
            (Rule::AsPrinted, Printed::Larger) => {
                let (a, b) = sides(stiffness, share.load_a_n, share.load_b_n);
                a.max(b)
            }
            (Rule::AsPrinted, Printed::Series) => {
                let (a, b) = sides(stiffness, self.preload_n, self.preload_n);
                a * b / (a + b)
            }
        })
    }
}

/// Returns force over preload at which the relieved side unloads; `ratio` is its c divided by that of the
/// loaded side.
fn unloading_ratio(ratio: f64, rule: Rule) -> f64 {
    match rule {
        Rule::Physics => (1.0 + ratio) * (1.0 + ratio).sqrt(),
        Rule::AsPrinted => rise(ratio),
    }
}

/// Computes (1 + x)^(3/2) − 1 for x ≥ −1, exact for small x.
fn rise(x: f64) -> f64 {
    (1.5 * x.ln_1p()).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::LoadedBalls;
    use crate::contact::published::{
        self, BEARING_PRELOAD_N, NUT_PRELOAD_N, friction_axis_1, friction_axis_2,
    };
    use proptest::prelude::*;

    const RULES: [Rule; 2] = [Rule::Physics, Rule::AsPrinted];

    fn nuts() -> PreloadedPair {
        PreloadedPair::double_nut(
            LoadedBalls::of_nut(&published::nut(published::NUT_BALLS)).unwrap().side(),
            NUT_PRELOAD_N,
        )
        .unwrap()
    }

    fn bearings() -> PreloadedPair {
        PreloadedPair::bearing_set(
            LoadedBalls::of_bearing(&published::bearing()).unwrap().side(),
            1,
            1,
            BEARING_PRELOAD_N,
        )
        .unwrap()
    }

    fn unequal() -> PreloadedPair {
        PreloadedPair::new(
            Side::from_point(1e3, 1e-5).unwrap(),
            Side::from_point(1e3, 0.4e-5).unwrap(),
            700.0,
            Printed::Larger,
        )
        .unwrap()
    }

    #[test]
    fn published_unloading_at_2_83_and_1_83_preloads() {
        for (rule, factor) in [(Rule::Physics, 8.0_f64.sqrt()), (Rule::AsPrinted, 8.0_f64.sqrt() - 1.0)] {
            let (a, b) = nuts().unloading_forces_n(rule);
            assert!((b / (factor * NUT_PRELOAD_N) - 1.0).abs() < 1e-14 && (a + b).abs() < 1e-11);
        }
    }

    #[test]
    fn published_velocities_at_which_nut_b_unloads() {
        for (curve, printed, physics) in [(friction_axis_1(), 30.2, 49.4), (friction_axis_2(), 18.9, 32.0)] {
            for (rule, m_per_min) in [(Rule::AsPrinted, printed), (Rule::Physics, physics)] {
                let velocity =
                    curve.rising_branch_velocity_m_per_s(nuts().unloading_forces_n(rule).1).unwrap();
                assert!((60.0 * velocity - m_per_min).abs() < 0.06, "{rule:?} {}", 60.0 * velocity);
            }
        }
    }

    #[test]
    fn published_bearing_pair_in_series_and_in_parallel() {
        let series = bearings().stiffness_n_per_m(0.0, Rule::AsPrinted, Stiffness::Secant).unwrap();
        assert!((series / 4.65e7 - 1.0).abs() < 0.01, "{series:e}");
        let parallel = bearings().stiffness_n_per_m(0.0, Rule::Physics, Stiffness::Tangent).unwrap();
        assert!((parallel / 2.8e8 - 1.0).abs() < 0.01, "{parallel:e}");
        assert!((parallel / series - 6.0).abs() < 1e-12);
    }

    #[test]
    fn limit_at_just_below_and_just_above_unloading() {
        for pair in [nuts(), bearings(), unequal()] {
            for sign in [1.0, -1.0] {
                let (a, b) = pair.unloading_forces_n(Rule::Physics);
                let force = if sign > 0.0 { b } else { a };
                let at = |force: f64| {
                    let share = pair.share(force, Rule::Physics).unwrap();
                    let relieved = if sign > 0.0 { share.load_b_n } else { share.load_a_n };
                    (
                        share,
                        relieved,
                        pair.stiffness_n_per_m(force, Rule::Physics, Stiffness::Tangent).unwrap(),
                    )
                };
                let ((below, low, k_below), (here, zero, k_here), (above, none, k_above)) =
                    (at(force * (1.0 - 1e-9)), at(force), at(force * (1.0 + 1e-9)));
                assert!(low > 0.0 && zero == 0.0 && none == 0.0);
                // The relieved side has travelled exactly its preload deflection.
                let side = if sign > 0.0 { pair.side_b } else { pair.side_a };
                assert!((here.displacement_m * sign / side.deflection(pair.preload_n) - 1.0).abs() < 1e-12);
                for other in [below, above] {
                    assert!((other.displacement_m / here.displacement_m - 1.0).abs() < 1e-8);
                    assert!(((other.load_a_n - other.load_b_n) / force - 1.0).abs() < 2e-9);
                }
                // Continuous with a kink: the stiffness falls by the cube root of the remaining load of the
                // unloading contact.
                assert!(
                    k_below > k_here
                        && k_above > k_here
                        && (k_below / k_here - 1.0) < 1e-3
                        && (k_above / k_here - 1.0) < 1e-9
                );
                let drop_9 = k_below - k_here;
                let drop_6 = at(force * (1.0 - 1e-6)).2 - k_here;
                assert!(
                    (drop_6 / drop_9 / 1e3_f64.sqrt() - 1.0).abs() < 0.05,
                    "square root of the distance: {}",
                    drop_6 / drop_9
                );
            }
        }
    }

    #[test]
    fn limit_small_forces_see_both_tangents() {
        for pair in [nuts(), bearings(), unequal()] {
            let sum = pair.side_a.stiffness(pair.preload_n, Stiffness::Tangent)
                + pair.side_b.stiffness(pair.preload_n, Stiffness::Tangent);
            for force in [0.0, 1e-9, -1e-9, 1e-3] {
                for kind in [Stiffness::Secant, Stiffness::Tangent] {
                    let got = pair.stiffness_n_per_m(force, Rule::Physics, kind).unwrap();
                    assert!((got / sum - 1.0).abs() < 1e-6, "{force} {kind:?}");
                }
            }
        }
        // Without an external force the two rules agree on the loads.
        assert_eq!(nuts().share(0.0, Rule::Physics).unwrap(), nuts().share(0.0, Rule::AsPrinted).unwrap());
    }

    #[test]
    fn published_eq_12_and_16_as_printed() {
        let pair = nuts();
        for force in [50.0_f64, 900.0, 2000.0, 2100.0] {
            let share = pair.share(force, Rule::AsPrinted).unwrap();
            assert!((share.load_a_n / (NUT_PRELOAD_N + force) - 1.0).abs() < 1e-13);
            let root = (2.0 * two_thirds(NUT_PRELOAD_N) - two_thirds(NUT_PRELOAD_N + force)).max(0.0).sqrt();
            let printed_b = root / pair.side_b.compliance_m_per_two_thirds_n();
            assert!(
                (pair.side_b.stiffness(share.load_b_n, Stiffness::Secant) - printed_b).abs()
                    < 1e-6 * printed_b.max(1.0)
            );
            let k = pair.stiffness_n_per_m(force, Rule::AsPrinted, Stiffness::Secant).unwrap();
            assert!(
                (k / pair.side_a.stiffness(NUT_PRELOAD_N + force, Stiffness::Secant) - 1.0).abs() < 1e-13
            );
            let mirrored = pair.share(-force, Rule::AsPrinted).unwrap();
            assert_eq!((mirrored.load_b_n, mirrored.load_a_n), (share.load_a_n, share.load_b_n));
        }
    }

    #[test]
    fn limit_sets_of_several() {
        let bearing = LoadedBalls::of_bearing(&published::bearing()).unwrap().side();
        let (two, set) =
            (bearings(), PreloadedPair::bearing_set(bearing, 2, 2, 2.0 * BEARING_PRELOAD_N).unwrap());
        let one = two.share(800.0, Rule::Physics).unwrap();
        let both = set.share(1600.0, Rule::Physics).unwrap();
        assert!((both.displacement_m / one.displacement_m - 1.0).abs() < 1e-12);
        assert!((both.load_a_n / (2.0 * one.load_a_n) - 1.0).abs() < 1e-12);
        // Two against one: c_A = c_B·2^(−2/3).
        let (a, b) = PreloadedPair::bearing_set(bearing, 2, 1, BEARING_PRELOAD_N)
            .unwrap()
            .unloading_forces_n(Rule::Physics);
        assert!((b / BEARING_PRELOAD_N - (1.0 + 4.0_f64.cbrt()).powf(1.5)).abs() < 1e-12);
        assert!((a / BEARING_PRELOAD_N + (1.0 + 0.25_f64.cbrt()).powf(1.5)).abs() < 1e-12);
    }

    #[test]
    fn bad_pairs_and_forces_are_named() {
        let side = LoadedBalls::of_bearing(&published::bearing()).unwrap().side();
        assert!(matches!(PreloadedPair::double_nut(side, 0.0), Err(ContactError::NotPositive { .. })));
        assert!(matches!(PreloadedPair::double_nut(side, 1e6), Err(ContactError::BeyondValidity { .. })));
        assert!(PreloadedPair::bearing_set(side, 0, 1, 100.0).is_err());
        for rule in RULES {
            assert!(matches!(bearings().share(f64::NAN, rule), Err(ContactError::NotFinite { .. })));
            assert!(matches!(bearings().share(-1e6, rule), Err(ContactError::BeyondValidity { .. })));
        }
        let limit = side.load_limit_n();
        assert!(bearings().share(limit * 0.999, Rule::Physics).is_ok());
        assert!(bearings().share(limit * 1.001, Rule::Physics).is_err());
    }

    proptest! {
        #[test]
        fn equilibrium_compatibility_and_slope(force in -9.0..9.0_f64, ratio in 0.2..5.0_f64, preload in 10.0..3000.0_f64) {
            let (a, b) = (Side::from_point(1e3, 1e-5).unwrap(), Side::from_point(1e3, 1e-5 * ratio).unwrap());
            let pair = PreloadedPair::new(a, b, preload, Printed::Larger).unwrap();
            let force = force * preload;
            let share = pair.share(force, Rule::Physics).unwrap();
            prop_assert!((share.load_a_n - share.load_b_n - force).abs() < 1e-12 * preload * 10.0);
            let total = a.deflection(preload) + b.deflection(preload);
            if share.load_a_n > 0.0 && share.load_b_n > 0.0 {
                prop_assert!((a.deflection(share.load_a_n) + b.deflection(share.load_b_n) - total).abs() < 1e-11 * total);
            }
            if share.load_a_n > 0.0 {
                prop_assert!((a.deflection(share.load_a_n) - a.deflection(preload) - share.displacement_m).abs() < 1e-11 * total);
            }
            // Symmetry: exchanging the sides and the sign of the force changes only the sign of the
            // displacement.
            let mirror = PreloadedPair::new(b, a, preload, Printed::Larger).unwrap().share(-force, Rule::Physics).unwrap();
            prop_assert!((mirror.displacement_m + share.displacement_m).abs() < 1e-13 * total);
            // The tangent equals the slope, away from the kinks.
            let (low, high) = pair.unloading_forces_n(Rule::Physics);
            let step = 1e-5 * preload;
            if (force - low).abs() > 0.01 * preload && (force - high).abs() > 0.01 * preload {
                let slope = 2.0 * step
                    / (pair.share(force + step, Rule::Physics).unwrap().displacement_m
                        - pair.share(force - step, Rule::Physics).unwrap().displacement_m);
                prop_assert!((pair.stiffness_n_per_m(force, Rule::Physics, Stiffness::Tangent).unwrap() / slope - 1.0).abs() < 1e-5);
            }
        }

        #[test]
        fn the_last_number_below_unloading_is_carried(ratio in 0.05..20.0_f64, steps in 0_u64..6) {
            let (a, b) = (Side::from_point(1e3, 1e-5).unwrap(), Side::from_point(1e3, 1e-5 * ratio).unwrap());
            let pair = PreloadedPair::new(a, b, 1.0, Printed::Larger).unwrap();
            let force = f64::from_bits(pair.unloading_forces_n(Rule::Physics).1.to_bits() - steps);
            let share = pair.share(force, Rule::Physics).unwrap();
            prop_assert!((share.load_a_n / force - 1.0).abs() < 1e-13 && share.load_b_n < 1e-20);
        }

        #[test]
        fn displacement_rises_with_force(first in -6.0..6.0_f64, step in 1e-6..1.0_f64, rule in prop::sample::select(RULES.to_vec())) {
            let pair = unequal();
            let (low, high) = (first * 700.0, (first + step) * 700.0);
            prop_assert!(pair.share(low, rule).unwrap().displacement_m < pair.share(high, rule).unwrap().displacement_m);
        }
    }
}
