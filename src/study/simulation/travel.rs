//! A travel from rest to rest, as a setting of simulations.

use crate::StudyResult;
use dynamics::motion::{Course, SCurve};

/// Travel from rest to rest with limits on velocity, acceleration and jerk (an S-curve). For an axis whose
/// encoder reads an angle, rad replaces m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TravelProfile {
    /// Travel (m); backward where it is negative.
    pub travel_m: f64,
    /// Largest velocity (m/s).
    pub velocity_m_s: f64,
    /// Largest acceleration (m/s²).
    pub acceleration_m_s2: f64,
    /// Largest jerk (m/s³).
    pub jerk_m_s3: f64,
    /// Rest before and after (s).
    pub rest_s: f64,
}

impl Default for TravelProfile {
    fn default() -> Self {
        TravelProfile {
            travel_m: 0.1,
            velocity_m_s: 0.2,
            acceleration_m_s2: 2.0,
            jerk_m_s3: 50.0,
            rest_s: 0.2,
        }
    }
}

impl TravelProfile {
    /// Returns the command at samples of this period (s).
    ///
    /// # Errors  a limit that is not above 0; no travel.
    pub fn course(&self, period_s: f64, and_back: bool) -> StudyResult<Course> {
        let curve = SCurve {
            from: 0.0,
            to: self.travel_m,
            velocity: self.velocity_m_s,
            acceleration: self.acceleration_m_s2,
            jerk: self.jerk_m_s3,
        };
        Ok(curve.course(period_s, self.rest_s, and_back)?)
    }
}
