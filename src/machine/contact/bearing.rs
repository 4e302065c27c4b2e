//! A single angular contact ball bearing.

use super::error::positive;
use super::race::RaceGeometry;
use super::{BALL_PRESSURE_LIMIT_PA, ContactError, ContactMaterial, RaceContacts, STEEL, Side, Stiffness};

/// Catalogue quantities of one bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingData {
    /// Number of balls z.
    pub ball_count: usize,
    /// Ball diameter d_0 (m).
    pub ball_diameter_m: f64,
    /// Diameter of the ball centres (m).
    pub pitch_diameter_m: f64,
    /// Contact angle α (rad).
    pub contact_angle_rad: f64,
    /// Groove radius over ball diameter of the inner ring.
    pub inner_conformity: f64,
    /// Groove radius over ball diameter of the outer ring.
    pub outer_conformity: f64,
    /// Material of the balls.
    pub ball: ContactMaterial,
    /// Material of the rings.
    pub rings: ContactMaterial,
    /// Contact pressure limit (Pa); higher loads are rejected.
    pub pressure_limit_pa: f64,
}

impl BearingData {
    /// Returns a steel bearing with the same conformity on both rings and the default pressure limit.
    pub fn steel(ball_count: usize, ball_diameter_m: f64, pitch_diameter_m: f64, contact_angle_rad: f64, conformity: f64) -> BearingData {
        BearingData {
            ball_count,
            ball_diameter_m,
            pitch_diameter_m,
            contact_angle_rad,
            inner_conformity: conformity,
            outer_conformity: conformity,
            ball: STEEL,
            rings: STEEL,
            pressure_limit_pa: BALL_PRESSURE_LIMIT_PA,
        }
    }
}

/// One angular contact bearing under axial load at constant contact angle.
///
/// ```text
///         P                     δ_inner + δ_outer
/// Q = ─────────       δ_axial = ─────────────────
///      z sin α                        sin α
/// ```
///
/// # Units      P in N, δ in m
/// # Errors     [`ContactError::BeyondValidity`] above the pressure limit, [`BALL_PRESSURE_LIMIT_PA`] unless changed
/// # Source     Duan, Eq. 18–19; vertical, Eq. 12–14. Deviation: δ_n/sin α for the printed δ_n·sin α, which violates the equality of the
/// work of the axial load and the work of the contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngularContactBearing {
    contacts: RaceContacts,
    ball_count: f64,
    slope: f64,
    side: Side,
}

impl AngularContactBearing {
    /// Creates a bearing from its catalogue quantities.
    ///
    /// # Errors  a quantity outside its range, named.
    pub fn new(data: &BearingData) -> Result<AngularContactBearing, ContactError> {
        let ball_count = positive("the number of balls", data.ball_count as f64)?;
        let contacts = RaceContacts::new(&RaceGeometry {
            ball_diameter_m: data.ball_diameter_m,
            pitch_diameter_m: data.pitch_diameter_m,
            contact_angle_rad: data.contact_angle_rad,
            helix_angle_rad: 0.0,
            conformity: [data.inner_conformity, data.outer_conformity],
            names: ["inner", "outer"],
            ball: data.ball,
            races: [data.rings; 2],
        })?;
        let slope = data.contact_angle_rad.sin();
        let limit = positive("the limit of the contact pressure (Pa)", data.pressure_limit_pa);
        let limit = if data.pressure_limit_pa == f64::INFINITY { f64::INFINITY } else { limit? };
        Ok(AngularContactBearing { contacts, ball_count, slope, side: contacts.side(ball_count, slope, limit) })
    }

    /// Returns the two contacts of a ball.
    pub fn contacts(&self) -> &RaceContacts {
        &self.contacts
    }

    /// Returns the bearing as one side of a preloaded pair.
    pub fn side(&self) -> Side {
        self.side
    }

    /// Computes the normal load Q (N) of a ball.
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    pub fn ball_load_n(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.side.check_load_n(load_n)? / (self.ball_count * self.slope))
    }

    /// Computes the axial deflection (m).
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    pub fn deflection_m(&self, load_n: f64) -> Result<f64, ContactError> {
        self.side.deflection_m(load_n)
    }

    /// Computes the axial deflection (m) as Duan prints it, δ_n·sin α, for tables that compare the print with the physics.
    ///
    /// # Errors  a load that is not positive or beyond the pressure limit.
    /// # Source  Duan, Eq. 18, last line, as printed.
    pub fn deflection_as_printed_m(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.deflection_m(load_n)? * self.slope * self.slope)
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
    use crate::contact::published::{BEARING_PRELOAD_N, bearing};

    #[test]
    fn published_tab_3_secant_stiffness() {
        let bearing = AngularContactBearing::new(&bearing()).unwrap();
        let secant = bearing.stiffness_n_per_m(BEARING_PRELOAD_N, Stiffness::Secant).unwrap();
        assert!((secant / 9.3e7 - 1.0).abs() < 0.01, "{secant:e}");
        let printed = BEARING_PRELOAD_N / bearing.deflection_as_printed_m(BEARING_PRELOAD_N).unwrap();
        assert!((printed * 40.0_f64.to_radians().sin().powi(2) / secant - 1.0).abs() < 1e-12);
    }

    #[test]
    fn limit_axial_work_is_the_work_of_the_contacts() {
        let bearing = AngularContactBearing::new(&bearing()).unwrap();
        let ball = bearing.ball_load_n(800.0).unwrap();
        let normal = bearing.contacts().inner.approach_m(ball).unwrap() + bearing.contacts().outer.approach_m(ball).unwrap();
        assert!((10.0 * ball * normal / (800.0 * bearing.deflection_m(800.0).unwrap()) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn limit_catalogue_rule_of_thumb() {
        // δ_axial ≈ 0.00044/sin α·(Q²/D)^(1/3) mm with Q in N, D in mm: the manufacturers' rule for steel bearings.
        let bearing = AngularContactBearing::new(&bearing()).unwrap();
        let ball_n = bearing.ball_load_n(1000.0).unwrap();
        let rule_m = 0.44e-6 / 40.0_f64.to_radians().sin() * (ball_n * ball_n / 6.6).cbrt();
        assert!((bearing.deflection_m(1000.0).unwrap() / rule_m - 1.0).abs() < 0.05);
    }

    #[test]
    fn bad_catalogues_are_named() {
        let of = |change: fn(&mut BearingData)| {
            let mut data = bearing();
            change(&mut data);
            AngularContactBearing::new(&data).unwrap_err().to_string()
        };
        assert!(of(|d| d.ball_count = 0).contains("balls"));
        assert!(of(|d| d.contact_angle_rad = 0.0).contains("contact angle"));
        assert!(of(|d| d.inner_conformity = 0.49).contains("inner race"));
        assert!(of(|d| d.pitch_diameter_m = f64::NAN).contains("pitch"));
        assert!(of(|d| d.pressure_limit_pa = f64::NAN).contains("pressure"));
        let mut heavy = bearing();
        heavy.pressure_limit_pa = f64::INFINITY;
        assert!(AngularContactBearing::new(&heavy).unwrap().deflection_m(1e6).is_ok());
        let light = AngularContactBearing::new(&bearing()).unwrap();
        assert!(matches!(light.deflection_m(1e6), Err(ContactError::BeyondValidity { .. })));
    }
}
