//! A single angular contact ball bearing.

use super::error::positive;
use super::race::RaceGeometry;
use super::{BALL_PRESSURE_LIMIT_PA, ContactError, ContactMaterial, LoadedBalls, STEEL};

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
    pub fn steel(
        ball_count: usize,
        ball_diameter_m: f64,
        pitch_diameter_m: f64,
        contact_angle_rad: f64,
        conformity: f64,
    ) -> BearingData {
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

impl LoadedBalls {
    /// Computes the balls of one angular contact bearing from its catalogue quantities; λ = 0.
    ///
    /// # Errors  a quantity outside its range, named.
    /// # Source  Duan, Eq. 18–19; vertical, Eq. 12–14. Deviation: δ_n/sin α for the printed δ_n·sin α, which
    ///   violates the equality of the
    /// work of the axial load and the work of the contacts.
    pub fn of_bearing(data: &BearingData) -> Result<LoadedBalls, ContactError> {
        let count = positive("the number of balls", data.ball_count as f64)?;
        let geometry = RaceGeometry {
            ball_diameter_m: data.ball_diameter_m,
            pitch_diameter_m: data.pitch_diameter_m,
            contact_angle_rad: data.contact_angle_rad,
            helix_angle_rad: 0.0,
            conformity: [data.inner_conformity, data.outer_conformity],
            names: ["inner", "outer"],
            ball: data.ball,
            races: [data.rings; 2],
        };
        LoadedBalls::new(&geometry, count, data.pressure_limit_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Stiffness;
    use crate::contact::published::{BEARING_PRELOAD_N, bearing};

    #[test]
    fn published_tab_3_secant_stiffness() {
        let bearing = LoadedBalls::of_bearing(&bearing()).unwrap();
        let secant = bearing.stiffness_n_per_m(BEARING_PRELOAD_N, Stiffness::Secant).unwrap();
        assert!((secant / 9.3e7 - 1.0).abs() < 0.01, "{secant:e}");
    }

    #[test]
    fn limit_axial_work_is_the_work_of_the_contacts() {
        let bearing = LoadedBalls::of_bearing(&bearing()).unwrap();
        let ball = bearing.ball_load_n(800.0).unwrap();
        let normal = bearing.contacts().inner.approach_m(ball).unwrap()
            + bearing.contacts().outer.approach_m(ball).unwrap();
        assert!((10.0 * ball * normal / (800.0 * bearing.deflection_m(800.0).unwrap()) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn limit_catalogue_rule_of_thumb() {
        // δ_axial ≈ 0.00044/sin α·(Q²/D)^(1/3) mm with Q in N, D in mm: the manufacturers' rule for steel
        // bearings.
        let bearing = LoadedBalls::of_bearing(&bearing()).unwrap();
        let ball_n = bearing.ball_load_n(1000.0).unwrap();
        let rule_m = 0.44e-6 / 40.0_f64.to_radians().sin() * (ball_n * ball_n / 6.6).cbrt();
        assert!((bearing.deflection_m(1000.0).unwrap() / rule_m - 1.0).abs() < 0.05);
    }

    #[test]
    fn bad_catalogues_are_named() {
        let of = |change: fn(&mut BearingData)| {
            let mut data = bearing();
            change(&mut data);
            LoadedBalls::of_bearing(&data).unwrap_err().to_string()
        };
        assert!(of(|d| d.ball_count = 0).contains("balls"));
        assert!(of(|d| d.contact_angle_rad = 0.0).contains("contact angle"));
        assert!(of(|d| d.inner_conformity = 0.49).contains("inner race"));
        assert!(of(|d| d.pitch_diameter_m = f64::NAN).contains("pitch"));
        assert!(of(|d| d.pressure_limit_pa = f64::NAN).contains("pressure"));
        let mut heavy = bearing();
        heavy.pressure_limit_pa = f64::INFINITY;
        assert!(LoadedBalls::of_bearing(&heavy).unwrap().deflection_m(1e6).is_ok());
        let light = LoadedBalls::of_bearing(&bearing()).unwrap();
        assert!(matches!(light.deflection_m(1e6), Err(ContactError::BeyondValidity { .. })));
    }
}
