//! A ball between the grooves of two races.

use std::f64::consts::FRAC_PI_2;

use super::error::positive;
use super::hertz::{ContactMaterial, Curvatures, PointContact};
use super::{ContactError, Side, Stiffness};

/// The geometry and materials of the two contacts of a ball.
#[derive(Debug, Clone, Copy)]
pub(super) struct RaceGeometry {
    /// Ball diameter d_b (m).
    pub ball_diameter_m: f64,
    /// Diameter of the ball centres d (m).
    pub pitch_diameter_m: f64,
    /// Contact angle β (rad).
    pub contact_angle_rad: f64,
    /// Helix angle λ (rad), 0 in a bearing.
    pub helix_angle_rad: f64,
    /// Groove radius over ball diameter of the convex race (screw, inner ring) and of the concave one (nut,
    /// outer ring).
    pub conformity: [f64; 2],
    /// Names of the two races for messages.
    pub names: [&'static str; 2],
    /// Material of the balls.
    pub ball: ContactMaterial,
    /// Material of the two races.
    pub races: [ContactMaterial; 2],
}

/// The two contacts of one ball: with the convex race (screw, inner ring) and with the concave one (nut,
/// outer ring).
///
/// ```text
///        4      1     2 cos β cos λ                          4      1     2 cos β cos λ
/// Σρ1 = ─── − ───── + ─────────────    (screw, inner) Σρ2 = ─── − ───── − ─────────────   (nut, outer)
///       d_b   f d_b   d − d_b cos β                         d_b   f d_b   d + d_b cos β
/// ```
///
/// # Units      d, d_b in m, Σρ in 1/m
/// # Source     Duan, Eq. 8; Harris, Eq. 2.28–2.30 with λ = 0. Deviation from Duan's print: 2/d_b instead of
///   2/d, and the plus sign of the
/// screw's term, since a screw is convex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaceContacts {
    /// With the screw or the inner ring.
    pub inner: PointContact,
    /// With the nut or the outer ring.
    pub outer: PointContact,
}

impl RaceContacts {
    /// Computes the contacts of a ball.
    pub(super) fn new(geometry: &RaceGeometry) -> Result<RaceContacts, ContactError> {
        let ball_diameter_m = positive("the ball diameter (m)", geometry.ball_diameter_m)?;
        let pitch_diameter_m = positive("the pitch diameter (m)", geometry.pitch_diameter_m)?;
        let angle = geometry.contact_angle_rad;
        if !(angle > 0.0 && angle < FRAC_PI_2) {
            return Err(ContactError::ContactAngle { angle_deg: angle.to_degrees() });
        }
        for (value, race) in geometry.conformity.into_iter().zip(geometry.names) {
            if !(value > 0.5 && value.is_finite()) {
                return Err(ContactError::Conformity { race, value });
            }
        }
        let reach_m = ball_diameter_m * angle.cos();
        if !(reach_m < pitch_diameter_m) {
            return Err(ContactError::BallTooLarge { ball_diameter_m, pitch_diameter_m });
        }
        let across = 2.0 * angle.cos() * geometry.helix_angle_rad.cos();
        let along = [across / (pitch_diameter_m - reach_m), -across / (pitch_diameter_m + reach_m)];
        let contact = |race: usize| {
            let curvatures = Curvatures {
                body_1_per_m: [2.0 / ball_diameter_m; 2],
                body_2_per_m: [-1.0 / (geometry.conformity[race] * ball_diameter_m), along[race]],
                angle_rad: 0.0,
            };
            PointContact::new(&curvatures, &geometry.ball, &geometry.races[race])
        };
        Ok(RaceContacts { inner: contact(0)?, outer: contact(1)? })
    }

    /// Returns δ_n/Q^(2/3) (m/N^(2/3)) of both contacts in series.
    pub fn approach_per_two_thirds(&self) -> f64 {
        self.inner.approach_per_two_thirds() + self.outer.approach_per_two_thirds()
    }

    /// Returns the larger p0/Q^(1/3) (Pa/N^(1/3)) of the two contacts.
    pub fn pressure_per_cube_root(&self) -> f64 {
        self.inner.pressure_per_cube_root().max(self.outer.pressure_per_cube_root())
    }
}

/// The balls of one nut, or of one angular contact bearing, under an axial load that all of them share
/// equally.
///
/// ```text
///            P                      δ_inner + δ_outer
/// Q = ────────────────     δ_axial = ─────────────────
///      N sin β cos λ                  sin β cos λ
/// ```
///
/// Assumptions: constant contact angle, rigid bodies and screw core. The elasticity of the core belongs to
/// the screw section of a model.
///
/// # Units      P in N, δ in m
/// # Limits     N times the balls carry N times the load at the same deflection
/// # Errors     [`ContactError::BeyondValidity`] above the pressure limit,
///   [`BALL_PRESSURE_LIMIT_PA`](super::BALL_PRESSURE_LIMIT_PA) unless changed
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedBalls {
    contacts: RaceContacts,
    count: f64,
    slope: f64,
    side: Side,
}

impl LoadedBalls {
    /// Combines `count` balls between two races.
    pub(super) fn new(
        geometry: &RaceGeometry,
        count: f64,
        pressure_limit_pa: f64,
    ) -> Result<LoadedBalls, ContactError> {
        let contacts = RaceContacts::new(geometry)?;
        let slope = geometry.contact_angle_rad.sin() * geometry.helix_angle_rad.cos();
        if pressure_limit_pa != f64::INFINITY {
            positive("the limit of the contact pressure (Pa)", pressure_limit_pa)?;
        }
        let load_per_ball = 1.0 / (count * slope);
        let compliance = contacts.approach_per_two_thirds() * load_per_ball.cbrt().powi(2) / slope;
        let side = Side::of_contacts(
            compliance,
            contacts.pressure_per_cube_root() * load_per_ball.cbrt(),
            pressure_limit_pa,
        );
        Ok(LoadedBalls { contacts, count, slope, side })
    }

    /// Returns the two contacts of a ball.
    pub fn contacts(&self) -> &RaceContacts {
        &self.contacts
    }

    /// Returns the number of loaded balls N, which may be fractional.
    pub fn ball_count(&self) -> f64 {
        self.count
    }

    /// Returns the nut or bearing as one side of a preloaded pair.
    pub fn side(&self) -> Side {
        self.side
    }

    /// Computes the normal load Q (N) of a ball.
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    pub fn ball_load_n(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.side.check_load_n(load_n)? / (self.count * self.slope))
    }

    /// Computes the axial deflection (m).
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    pub fn deflection_m(&self, load_n: f64) -> Result<f64, ContactError> {
        self.side.deflection_m(load_n)
    }

    /// Computes the axial stiffness (N/m).
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    pub fn stiffness_n_per_m(&self, load_n: f64, stiffness: Stiffness) -> Result<f64, ContactError> {
        self.side.stiffness_n_per_m(load_n, stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::STEEL;

    fn geometry() -> RaceGeometry {
        RaceGeometry {
            ball_diameter_m: 3.175e-3,
            pitch_diameter_m: 20e-3,
            contact_angle_rad: 0.25 * std::f64::consts::PI,
            helix_angle_rad: 0.08,
            conformity: [0.52, 0.53],
            names: ["screw", "nut"],
            ball: STEEL,
            races: [STEEL; 2],
        }
    }

    #[test]
    fn limit_curvature_sums_are_the_closed_form() {
        let geometry = geometry();
        let contacts = RaceContacts::new(&geometry).unwrap();
        let (ball, pitch, cos) = (3.175e-3, 20e-3, 0.5_f64.sqrt());
        let inner = 4.0 / ball - 1.0 / (0.52 * ball) + 2.0 * cos * 0.08_f64.cos() / (pitch - ball * cos);
        let outer = 4.0 / ball - 1.0 / (0.53 * ball) - 2.0 * cos * 0.08_f64.cos() / (pitch + ball * cos);
        assert!((contacts.inner.curvature_sum_per_m() / inner - 1.0).abs() < 1e-14);
        assert!((contacts.outer.curvature_sum_per_m() / outer - 1.0).abs() < 1e-14);
        assert!(contacts.inner.curvature_difference() > contacts.outer.curvature_difference());
    }

    #[test]
    fn bad_races_are_named() {
        let of = |change: fn(&mut RaceGeometry)| {
            let mut geometry = geometry();
            change(&mut geometry);
            RaceContacts::new(&geometry).unwrap_err()
        };
        assert!(matches!(of(|g| g.contact_angle_rad = 0.0), ContactError::ContactAngle { .. }));
        assert!(matches!(of(|g| g.contact_angle_rad = FRAC_PI_2), ContactError::ContactAngle { .. }));
        assert!(matches!(of(|g| g.contact_angle_rad = f64::NAN), ContactError::ContactAngle { .. }));
        assert!(matches!(of(|g| g.conformity[0] = 0.5), ContactError::Conformity { race: "screw", .. }));
        assert!(matches!(of(|g| g.conformity[1] = 0.4), ContactError::Conformity { race: "nut", .. }));
        assert!(matches!(of(|g| g.ball_diameter_m = -1.0), ContactError::NotPositive { .. }));
        assert!(matches!(of(|g| g.pitch_diameter_m = 0.0), ContactError::NotPositive { .. }));
        assert!(matches!(of(|g| g.pitch_diameter_m = 2e-3), ContactError::BallTooLarge { .. }));
    }
}
