//! Hertz contact of two bodies at a point.

use super::elliptic::Complete;
use super::error::{finite, positive, within};
use super::{ContactError, Stiffness};
use numeric::root::bracketed_root;

/// Contact pressure (Pa) at the static load rating of a ball bearing. The total permanent deformation is then
/// about 1e-4 of the ball diameter, and above it the elastic formulae do not hold.
///
/// # Source  ISO 76:2006, clause 5 (4200 MPa for ball bearings other than self-aligning ones); ISO 3408-5
///   rates ball screws by
/// the same permanent deformation.
pub const BALL_PRESSURE_LIMIT_PA: f64 = 4.2e9;

/// Largest curvature difference F(ρ) of a point contact: the ellipse is then about 2500 times as long as
/// wide.
const LARGEST_DIFFERENCE: f64 = 1.0 - 1e-6;

/// The steel of balls, screw, nut and rings: E = 210 GPa, ν = 0.3.
///
/// # Source  Duan, below Eq. 9.
pub const STEEL: ContactMaterial = ContactMaterial { youngs_modulus_pa: 210e9, poisson_ratio: 0.3 };

/// An isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMaterial {
    /// Young's modulus (Pa).
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
}

impl ContactMaterial {
    /// Returns (1 − ν²)/E (1/Pa) after a check of the material.
    fn compliance_per_pa(&self) -> Result<f64, ContactError> {
        positive("Young's modulus (Pa)", self.youngs_modulus_pa)?;
        within("Poisson's ratio", self.poisson_ratio, -1.0, 0.5)?;
        Ok((1.0 - self.poisson_ratio * self.poisson_ratio) / self.youngs_modulus_pa)
    }
}

/// Principal curvatures of two bodies at their contact; convex is positive, a flat is 0, a groove negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curvatures {
    /// Curvatures of the first body in its two principal planes (1/m).
    pub body_1_per_m: [f64; 2],
    /// Curvatures of the second body in its two principal planes (1/m).
    pub body_2_per_m: [f64; 2],
    /// Angle between the first principal plane of one body and that of the other (rad).
    pub angle_rad: f64,
}

impl Curvatures {
    /// Returns A ≤ B (1/m) of the gap A·x² + B·y² between the bodies.
    ///
    /// ```text
    /// A + B = ½ Σρ     B − A = ½ √( (ρ11−ρ12)² + (ρ21−ρ22)² + 2 (ρ11−ρ12)(ρ21−ρ22) cos 2ω )
    /// ```
    ///
    /// # Source  Johnson, «Contact Mechanics», Eq. 4.4–4.5.
    fn gap_per_m(&self) -> Result<(f64, f64), ContactError> {
        let ([r11, r12], [r21, r22]) = (self.body_1_per_m, self.body_2_per_m);
        for curvature in [r11, r12, r21, r22] {
            finite("a principal curvature (1/m)", curvature)?;
        }
        finite("the angle between the principal planes (rad)", self.angle_rad)?;
        let (first, second) = if self.angle_rad == 0.0 {
            (0.5 * (r11 + r21), 0.5 * (r12 + r22))
        } else {
            let (d1, d2) = (r11 - r12, r21 - r22);
            // This form of the root avoids the cancellation in 1 + cos 2ω.
            let (sin, cos) = self.angle_rad.sin_cos();
            let root = ((d1 + d2) * cos).hypot((d1 - d2) * sin);
            let sum = r11 + r12 + r21 + r22;
            (0.25 * (sum - root), 0.25 * (sum + root))
        };
        Ok((first.min(second), first.max(second)))
    }
}

/// The contact of two bodies at a point.
///
/// ```text
///           3 Q η                              2 K  ⎛   π    ⎞ ⅓  ⎛ 3 Q η ⎞ ⅔  Σρ
/// a³ = κ² E ─────      b = a/κ            δ =  ──── ⎜ ────── ⎟    ⎜ ───── ⎟   ────
///           π Σρ                                π   ⎝ 2 κ² E ⎠    ⎝ 2 Σρ  ⎠     2
///
///         3 Q                  1 − ν1²   1 − ν2²           A               D(m)                  1
/// p0 = ───────             η = ─────── + ───────           ─  =  (1 − m) · ────          m = 1 − ──
///       2 π a b                  E1        E2              B               B(m)                  κ²
/// ```
///
/// κ = a/b ≥ 1 solves the last equation exactly. The equation is F(ρ) = [(κ²+1)E − 2K]/[(κ²−1)E] of the
/// curvature difference, written with Legendre's associate integrals to avoid cancellation at κ = 1 and for
/// slender ellipses.
///
/// # Units      load N, lengths m, pressure Pa, stiffness N/m
/// # Limits     κ = 1 gives the sphere on a flat, δ³ = 9Q²η²/(16 R) (test `limit_sphere_on_a_flat`)
/// # Errors     [`ContactError::LineContact`] as the curvature difference reaches 1
/// # Source     Harris, Eq. 6.29–6.43; Johnson, Eq. 4.24–4.32; Duan, Eq. 7 and its table of K/a. Deviation:
///   elliptic integrals instead of
/// tabulated K_i and a_i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointContact {
    sum_per_m: f64,
    difference: f64,
    ellipticity: f64,
    /// δ/Q^(2/3) (m/N^(2/3)).
    approach: f64,
    /// a/Q^(1/3) (m/N^(1/3)).
    semi_axis: f64,
    /// p0/Q^(1/3) (Pa/N^(1/3)).
    pressure: f64,
}

impl PointContact {
    /// Computes the contact of two bodies with the given curvatures.
    ///
    /// # Errors  curvatures that are not finite or give a line contact; an invalid material.
    pub fn new(
        curvatures: &Curvatures,
        material_1: &ContactMaterial,
        material_2: &ContactMaterial,
    ) -> Result<PointContact, ContactError> {
        let compliance_per_pa = material_1.compliance_per_pa()? + material_2.compliance_per_pa()?;
        let (least, most) = curvatures.gap_per_m()?;
        let sum_per_m = 2.0 * (least + most);
        let difference = (most - least) / (most + least);
        if !(least > 0.0 && difference < LARGEST_DIFFERENCE) {
            return Err(ContactError::LineContact { difference, limit: LARGEST_DIFFERENCE });
        }
        let log_ellipticity = log_ellipticity(least / most)?;
        let ellipticity = log_ellipticity.exp();
        let complete = Complete::of_complement((-2.0 * log_ellipticity).exp());
        let stretch = ellipticity * ellipticity * complete.second;
        let semi_axis = (3.0 * stretch * compliance_per_pa / (std::f64::consts::PI * sum_per_m)).cbrt();
        Ok(PointContact {
            sum_per_m,
            difference,
            ellipticity,
            approach: 1.5 * compliance_per_pa * complete.first / (std::f64::consts::PI * semi_axis),
            semi_axis,
            pressure: 1.5 * ellipticity / (std::f64::consts::PI * semi_axis * semi_axis),
        })
    }

    /// Returns Σρ (1/m).
    pub fn curvature_sum_per_m(&self) -> f64 {
        self.sum_per_m
    }

    /// Returns F(ρ) = (B − A)/(B + A).
    pub fn curvature_difference(&self) -> f64 {
        self.difference
    }

    /// Returns κ = a/b ≥ 1.
    pub fn ellipticity(&self) -> f64 {
        self.ellipticity
    }

    /// Returns δ/Q^(2/3) (m/N^(2/3)), the load-independent compliance coefficient.
    pub fn approach_per_two_thirds(&self) -> f64 {
        self.approach
    }

    /// Returns p0/Q^(1/3) (Pa/N^(1/3)).
    pub fn pressure_per_cube_root(&self) -> f64 {
        self.pressure
    }

    /// Computes the approach δ (m) of the bodies under a load.
    ///
    /// # Errors  a load that is not positive.
    pub fn approach_m(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.approach * load(load_n)?.cbrt().powi(2))
    }

    /// Computes the load (N) for an approach δ.
    ///
    /// # Errors  an approach that is not positive.
    pub fn load_n(&self, approach_m: f64) -> Result<f64, ContactError> {
        let ratio = positive("the approach of the bodies (m)", approach_m)? / self.approach;
        Ok(ratio * ratio.sqrt())
    }

    /// Computes the semi-axes (m) of the contact ellipse, the longer one first.
    ///
    /// # Errors  a load that is not positive.
    pub fn semi_axes_m(&self, load_n: f64) -> Result<(f64, f64), ContactError> {
        let semi_axis_m = self.semi_axis * load(load_n)?.cbrt();
        Ok((semi_axis_m, semi_axis_m / self.ellipticity))
    }

    /// Computes the largest pressure (Pa), at the centre of the ellipse.
    ///
    /// # Errors  a load that is not positive.
    pub fn max_pressure_pa(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.pressure * load(load_n)?.cbrt())
    }

    /// Computes the secant stiffness Q/δ or the tangent stiffness dQ/dδ = 3/2·Q/δ (N/m).
    ///
    /// # Errors  a load that is not positive.
    pub fn stiffness_n_per_m(&self, load_n: f64, stiffness: Stiffness) -> Result<f64, ContactError> {
        Ok(stiffness.factor() * load(load_n)?.cbrt() / self.approach)
    }
}

fn load(load_n: f64) -> Result<f64, ContactError> {
    positive("the load of the contact (N)", load_n)
}

/// Computes ln κ from A/B ≤ 1: the root of ln(D/B) − 2 ln κ − ln(A/B).
fn log_ellipticity(ratio: f64) -> Result<f64, ContactError> {
    let target = ratio.ln();
    let equation = |log_ellipticity: f64| {
        let complete = Complete::of_complement((-2.0 * log_ellipticity).exp());
        (complete.sine / complete.cosine).ln() - 2.0 * log_ellipticity - target
    };
    // A/B = 1 within rounding error: a circle.
    if equation(0.0) <= 0.0 {
        return Ok(0.0);
    }
    // D/B increases with ln κ: ln κ = −ln(A/B) + 1 lies above the root.
    bracketed_root(0.0, 1.0 - target, equation)
        .ok_or(ContactError::NoRoot { what: "the ellipticity of the contact" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    const CERAMIC: ContactMaterial = ContactMaterial { youngs_modulus_pa: 310e9, poisson_ratio: 0.26 };

    fn contact(body_1: [f64; 2], body_2: [f64; 2], angle_rad: f64) -> PointContact {
        PointContact::new(
            &Curvatures { body_1_per_m: body_1, body_2_per_m: body_2, angle_rad },
            &STEEL,
            &CERAMIC,
        )
        .unwrap()
    }

    fn compliance() -> f64 {
        STEEL.compliance_per_pa().unwrap() + CERAMIC.compliance_per_pa().unwrap()
    }

    #[test]
    fn limit_sphere_on_a_flat() {
        let radius = 0.004;
        let contact = contact([1.0 / radius; 2], [0.0; 2], 0.0);
        let modulus = 1.0 / compliance();
        for load in [0.1_f64, 25.0, 4000.0] {
            let expected = (9.0 * load * load / (16.0 * radius * modulus * modulus)).cbrt();
            assert!((contact.approach_m(load).unwrap() / expected - 1.0).abs() < 1e-14);
            let expected = (0.75 * load * radius / modulus).cbrt();
            let (a, b) = contact.semi_axes_m(load).unwrap();
            assert!((a / expected - 1.0).abs() < 1e-14 && (b / expected - 1.0).abs() < 1e-14);
            let expected = (6.0 * load * modulus * modulus / (PI.powi(3) * radius * radius)).cbrt();
            assert!((contact.max_pressure_pa(load).unwrap() / expected - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn limit_equal_crossed_cylinders_are_a_sphere_on_a_flat() {
        let sphere = contact([200.0; 2], [0.0; 2], 0.0);
        for crossed in
            [contact([200.0, 0.0], [0.0, 200.0], 0.0), contact([200.0, 0.0], [200.0, 0.0], FRAC_PI_2)]
        {
            assert!((crossed.approach / sphere.approach - 1.0).abs() < 1e-14);
            assert!((crossed.ellipticity - 1.0).abs() < 1e-14);
        }
    }

    /// The displacement under the Hertz pressure must be δ − A·x² on the long axis and δ − B·y² on the short
    /// one. Quadrature along chords, independent of K, E and κ.
    #[test]
    fn limit_pressure_reproduces_the_gap_it_closes() {
        for (body_1, body_2, angle) in [
            ([629.9, 629.9], [-605.7, 80.9], 0.0),
            ([300.0, 300.0], [0.0, 150.0], 0.0),
            ([300.0, 100.0], [20.0, 250.0], 0.7),
            ([629.9, 629.9], [-629.0, 80.9], 0.0),
        ] {
            let curvatures = Curvatures { body_1_per_m: body_1, body_2_per_m: body_2, angle_rad: angle };
            let (least, most) = curvatures.gap_per_m().unwrap();
            let contact = contact(body_1, body_2, angle);
            let load = 120.0;
            let (a, b) = contact.semi_axes_m(load).unwrap();
            let pressure = contact.max_pressure_pa(load).unwrap();
            assert!((pressure * 2.0 * PI * a * b / (3.0 * load) - 1.0).abs() < 1e-14);
            let displacement = |x: f64, y: f64| {
                let count = 40_000;
                let sum: f64 = (0..count)
                    .map(|index| {
                        let (sin, cos) = (PI * f64::from(index) / f64::from(count)).sin_cos();
                        let square = (cos / a).powi(2) + (sin / b).powi(2);
                        let linear = x * cos / (a * a) + y * sin / (b * b);
                        let constant = 1.0 - (x / a).powi(2) - (y / b).powi(2);
                        (linear * linear + square * constant) / (square * square.sqrt())
                    })
                    .sum();
                0.5 * PI * compliance() * pressure * sum / f64::from(count)
            };
            let approach = contact.approach_m(load).unwrap();
            assert!((displacement(0.0, 0.0) / approach - 1.0).abs() < 1e-11);
            for fraction in [0.3, 0.8, 1.0] {
                let (x, y) = (fraction * a, fraction * b);
                assert!((displacement(x, 0.0) + least * x * x - approach).abs() < 1e-11 * approach);
                assert!((displacement(0.0, y) + most * y * y - approach).abs() < 1e-11 * approach);
            }
        }
    }

    #[test]
    fn limit_work_is_two_fifths_of_load_times_approach() {
        let contact = contact([629.9, 629.9], [-605.7, 80.9], 0.0);
        let approach = contact.approach_m(80.0).unwrap();
        let count = 2000;
        let work: f64 = (1..=count)
            .map(|index| contact.load_n((f64::from(index) - 0.5) / f64::from(count) * approach).unwrap())
            .sum::<f64>()
            * approach
            / f64::from(count);
        assert!((work / (0.4 * 80.0 * approach) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn limit_ellipticity_solves_harris_equation() {
        for ratio in [1.0, 0.999_999, 0.7, 0.1, 0.03, 1e-3, 1e-6] {
            let square = (2.0 * log_ellipticity(ratio).unwrap()).exp();
            let complete = Complete::of_complement(1.0 / square);
            let difference = (1.0 - ratio) / (1.0 + ratio);
            let (left, right) =
                ((square + 1.0) * complete.second - 2.0 * complete.first, (square - 1.0) * complete.second);
            assert!((left - difference * right).abs() < 1e-14 * (square + 1.0) * complete.second, "{ratio}");
        }
    }

    #[test]
    fn published_harris_table() {
        // F(ρ), a*, b*, δ* of Harris, Table 6.1 (four digits), with a* = (2κ²E/π)^(1/3), b* =
        // (2E/(πκ))^(1/3), δ* = (2K/π)(π/(2κ²E))^(1/3).
        for (difference, a, b, approach) in [
            (0.1075, 1.0760, 0.9318, 0.9974),
            (0.3204, 1.2623, 0.8114, 0.9761),
            (0.5916, 1.6440, 0.6687, 0.9077),
            (0.7948, 2.265, 0.5480, 0.7961),
            (0.90999, 3.233, 0.4499, 0.6636),
            (0.95738, 4.395, 0.3830, 0.5551),
        ] {
            let log = log_ellipticity((1.0 - difference) / (1.0 + difference)).unwrap();
            let complete = Complete::of_complement((-2.0 * log).exp());
            let stretch = (2.0 * (2.0 * log).exp() * complete.second / PI).cbrt();
            let got = [stretch, stretch * (-log).exp(), 2.0 * complete.first / PI / stretch];
            for (got, printed) in got.into_iter().zip([a, b, approach]) {
                assert!((got / printed - 1.0).abs() < 5e-4, "{difference}: {got} {printed}");
            }
        }
    }

    #[test]
    fn bad_contacts_are_named() {
        let make = |body_1, body_2| {
            PointContact::new(
                &Curvatures { body_1_per_m: body_1, body_2_per_m: body_2, angle_rad: 0.0 },
                &STEEL,
                &STEEL,
            )
        };
        assert!(matches!(make([100.0, 0.0], [50.0, 0.0]), Err(ContactError::LineContact { .. })));
        assert!(matches!(make([100.0, 100.0], [-100.0, 0.0]), Err(ContactError::LineContact { .. })));
        assert!(matches!(make([100.0, 100.0], [-120.0, 0.0]), Err(ContactError::LineContact { .. })));
        assert!(matches!(make([0.0, 0.0], [0.0, 0.0]), Err(ContactError::LineContact { .. })));
        assert!(matches!(make([f64::NAN, 1.0], [0.0, 0.0]), Err(ContactError::NotFinite { .. })));
        let contact = contact([100.0; 2], [0.0; 2], 0.0);
        for load in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(contact.approach_m(load), Err(ContactError::NotPositive { .. })));
            assert!(matches!(contact.max_pressure_pa(load), Err(ContactError::NotPositive { .. })));
            assert!(matches!(contact.load_n(load), Err(ContactError::NotPositive { .. })));
        }
        let liquid = ContactMaterial { poisson_ratio: 0.6, ..STEEL };
        let curvatures = Curvatures { body_1_per_m: [100.0; 2], body_2_per_m: [0.0; 2], angle_rad: 0.0 };
        assert!(matches!(
            PointContact::new(&curvatures, &liquid, &STEEL),
            Err(ContactError::OutOfRange { .. })
        ));
    }

    proptest! {
        #[test]
        fn load_and_approach_are_inverse_and_scale(
            curvature in 10.0..1000.0_f64, groove in 0.0..0.97_f64, other in 0.0..500.0_f64, load in 0.01..1e4_f64, factor in 0.1..10.0_f64
        ) {
            let contact = contact([curvature; 2], [-groove * curvature, other], 0.0);
            let approach = contact.approach_m(load).unwrap();
            prop_assert!((contact.load_n(approach).unwrap() / load - 1.0).abs() < 1e-12);
            prop_assert!((contact.approach_m(load * factor).unwrap() / approach / factor.powf(2.0 / 3.0) - 1.0).abs() < 1e-12);
            let pressure = contact.max_pressure_pa(load).unwrap();
            prop_assert!((contact.max_pressure_pa(load * factor).unwrap() / pressure / factor.cbrt() - 1.0).abs() < 1e-12);
            let secant = contact.stiffness_n_per_m(load, Stiffness::Secant).unwrap();
            prop_assert!((secant * approach / load - 1.0).abs() < 1e-12);
            let step = 1e-5 * approach;
            let slope = (contact.load_n(approach + step).unwrap() - contact.load_n(approach - step).unwrap()) / (2.0 * step);
            prop_assert!((contact.stiffness_n_per_m(load, Stiffness::Tangent).unwrap() / slope - 1.0).abs() < 1e-8);
            // All lengths scaled by s at the same pressure: load s², approach s.
            let larger = self::contact([curvature / factor; 2], [-groove * curvature / factor, other / factor], 0.0);
            let scaled = larger.approach_m(load * factor * factor).unwrap();
            prop_assert!((scaled / (approach * factor) - 1.0).abs() < 1e-11);
        }

        #[test]
        fn the_angle_and_the_order_of_bodies_are_conventions(
            x1 in 50.0..500.0_f64, y1 in 50.0..500.0_f64, x2 in -20.0..500.0_f64, y2 in -20.0..500.0_f64, angle in 0.0..3.0_f64
        ) {
            let here = contact([x1, y1], [x2, y2], angle);
            let turned = contact([x1, y1], [y2, x2], angle + FRAC_PI_2);
            let mirrored = contact([x1, y1], [x2, y2], -angle);
            prop_assert!((turned.approach / here.approach - 1.0).abs() < 1e-11);
            prop_assert!((mirrored.approach / here.approach - 1.0).abs() < 1e-11);
        }
    }
}
