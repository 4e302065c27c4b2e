//! A single ball nut on its screw.

use std::f64::consts::PI;

use super::error::positive;
use super::race::RaceGeometry;
use super::{BALL_PRESSURE_LIMIT_PA, ContactError, ContactMaterial, LoadedBalls, STEEL};

/// The number of loaded balls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Balls {
    /// This many.
    Count(f64),
    /// The balls of this many loaded turns: N = i·π·d/(d_b·cos λ), without gaps between balls, not rounded.
    ///
    /// # Source  Duan, below Eq. 9; vertical, Eq. 2.
    Turns(f64),
}

/// Catalogue quantities of one nut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NutData {
    /// Lead p (m per turn).
    pub lead_m: f64,
    /// Diameter of the ball centres d (m); Duan uses the nominal diameter.
    pub pitch_diameter_m: f64,
    /// Ball diameter d_b (m).
    pub ball_diameter_m: f64,
    /// Contact angle β (rad).
    pub contact_angle_rad: f64,
    /// Groove radius over ball diameter of the screw.
    pub screw_conformity: f64,
    /// Groove radius over ball diameter of the nut.
    pub nut_conformity: f64,
    /// Loaded balls.
    pub balls: Balls,
    /// Material of the balls.
    pub ball: ContactMaterial,
    /// Material of the screw.
    pub screw: ContactMaterial,
    /// Material of the nut.
    pub nut: ContactMaterial,
    /// Contact pressure limit (Pa); higher loads are rejected.
    pub pressure_limit_pa: f64,
}

impl NutData {
    /// Returns a steel nut with the same conformity on both races and the default pressure limit.
    pub fn steel(
        lead_m: f64,
        pitch_diameter_m: f64,
        ball_diameter_m: f64,
        contact_angle_rad: f64,
        conformity: f64,
        balls: Balls,
    ) -> NutData {
        NutData {
            lead_m,
            pitch_diameter_m,
            ball_diameter_m,
            contact_angle_rad,
            screw_conformity: conformity,
            nut_conformity: conformity,
            balls,
            ball: STEEL,
            screw: STEEL,
            nut: STEEL,
            pressure_limit_pa: BALL_PRESSURE_LIMIT_PA,
        }
    }
}

impl LoadedBalls {
    /// Computes the balls of one nut from its catalogue quantities; λ = arctan(p/(π·d)).
    ///
    /// # Errors  a quantity outside its range, named.
    /// # Source  Duan, Eq. 7–9; vertical, Eq. 2–5. Deviation: see [`RaceContacts`](super::RaceContacts) for
    ///   the curvatures.
    pub fn of_nut(data: &NutData) -> Result<LoadedBalls, ContactError> {
        positive("the lead (m)", data.lead_m)?;
        positive("the pitch diameter (m)", data.pitch_diameter_m)?;
        let helix_angle_rad = (data.lead_m / (PI * data.pitch_diameter_m)).atan();
        let count = match data.balls {
            Balls::Count(count) => positive("the number of loaded balls", count)?,
            Balls::Turns(turns) => {
                positive("the number of loaded turns", turns)? * PI * data.pitch_diameter_m
                    / (data.ball_diameter_m * helix_angle_rad.cos())
            }
        };
        let geometry = RaceGeometry {
            ball_diameter_m: data.ball_diameter_m,
            pitch_diameter_m: data.pitch_diameter_m,
            contact_angle_rad: data.contact_angle_rad,
            helix_angle_rad,
            conformity: [data.screw_conformity, data.nut_conformity],
            names: ["screw", "nut"],
            ball: data.ball,
            races: [data.screw, data.nut],
        };
        LoadedBalls::new(&geometry, count, data.pressure_limit_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Stiffness;
    use crate::contact::published::{NUT_PRELOAD_N, nut};

    #[test]
    fn published_tab_1_secant_stiffness() {
        let stiffness = |balls| {
            LoadedBalls::of_nut(&nut(balls))
                .unwrap()
                .stiffness_n_per_m(NUT_PRELOAD_N, Stiffness::Secant)
                .unwrap()
        };
        assert!(
            (stiffness(Balls::Count(98.0)) / 4.04e8 - 1.0).abs() < 0.01,
            "{:e}",
            stiffness(Balls::Count(98.0))
        );
        assert!(
            (stiffness(Balls::Count(19.9)) / 1.39e8 - 1.0).abs() < 0.01,
            "{:e}",
            stiffness(Balls::Count(19.9))
        );
        assert!(
            (stiffness(Balls::Turns(1.0)) / 1.39e8 - 1.0).abs() < 0.01,
            "{:e}",
            stiffness(Balls::Turns(1.0))
        );
        // The printed stiffness is a third of that from the paper's own formula and number of balls.
        assert!(stiffness(Balls::Count(98.0)) > 3.0 * 1.28e8);
    }

    #[test]
    fn published_helix_angle_and_ball_count() {
        let data = nut(Balls::Turns(1.0));
        assert!(((data.lead_m / (PI * data.pitch_diameter_m)).atan().to_degrees() - 4.5499).abs() < 1e-4);
        assert!((LoadedBalls::of_nut(&data).unwrap().ball_count() - 19.852).abs() < 1e-3);
        // FDW20-5B2: 2.5 turns twice give 99.3, printed 98.
        assert!((LoadedBalls::of_nut(&nut(Balls::Turns(5.0))).unwrap().ball_count() - 99.26).abs() < 0.01);
    }

    #[test]
    fn limit_axial_work_is_the_work_of_the_contacts() {
        let nut = LoadedBalls::of_nut(&nut(Balls::Count(98.0))).unwrap();
        for load in [10.0, 1115.0, 5000.0] {
            let ball = nut.ball_load_n(load).unwrap();
            let normal = nut.contacts().inner.approach_m(ball).unwrap()
                + nut.contacts().outer.approach_m(ball).unwrap();
            let work = nut.ball_count() * ball * normal;
            assert!((work / (load * nut.deflection_m(load).unwrap()) - 1.0).abs() < 1e-13);
            let tangent = nut.stiffness_n_per_m(load, Stiffness::Tangent).unwrap();
            assert!((tangent / nut.stiffness_n_per_m(load, Stiffness::Secant).unwrap() - 1.5).abs() < 1e-13);
        }
    }

    #[test]
    fn limit_pressure_is_checked_by_default() {
        let nut = LoadedBalls::of_nut(&nut(Balls::Count(98.0))).unwrap();
        let limit = nut.side().load_limit_n();
        let ball = nut.ball_load_n(limit * (1.0 - 1e-12)).unwrap();
        let pressures = [nut.contacts().inner, nut.contacts().outer]
            .map(|contact| contact.max_pressure_pa(ball).unwrap());
        assert!((pressures[0].max(pressures[1]) / BALL_PRESSURE_LIMIT_PA - 1.0).abs() < 1e-9);
        assert!(matches!(nut.deflection_m(1.001 * limit), Err(ContactError::BeyondValidity { .. })));
        assert!(matches!(nut.deflection_m(0.0), Err(ContactError::NotPositive { .. })));
    }

    #[test]
    fn bad_catalogues_are_named() {
        let of = |change: fn(&mut NutData)| {
            let mut data = nut(Balls::Count(98.0));
            change(&mut data);
            LoadedBalls::of_nut(&data).unwrap_err().to_string()
        };
        assert!(of(|d| d.lead_m = 0.0).contains("lead"));
        assert!(of(|d| d.balls = Balls::Count(0.0)).contains("balls"));
        assert!(of(|d| d.balls = Balls::Turns(-1.0)).contains("turns"));
        assert!(of(|d| d.contact_angle_rad = 2.0).contains("contact angle"));
        assert!(of(|d| d.nut_conformity = 0.5).contains("nut race"));
        assert!(of(|d| d.pressure_limit_pa = 0.0).contains("pressure"));
        assert!(of(|d| d.ball.youngs_modulus_pa = -1.0).contains("Young"));
    }
}
