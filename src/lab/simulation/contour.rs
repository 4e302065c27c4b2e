//! A circle as the command of two axes, and the deviation from it.

use std::f64::consts::TAU;

use dynamics::motion::{Course, MotionError, require_positive};

/// A circle of two axes through the origin, x = R·sin φ, y = R·(1 − cos φ). It starts from rest along x,
/// reaches full speed after `rise_s`, and ends at full speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Radius R (m).
    pub radius: f64,
    /// Angular speed (rad/s).
    pub speed_rad_s: f64,
    /// Revolutions at full speed.
    pub turns: f64,
    /// Rise time of the speed (s), as 3s² − 2s³.
    pub rise_s: f64,
}

impl Circle {
    /// Centre (m).
    pub fn centre(&self) -> [f64; 2] {
        [0.0, self.radius]
    }

    /// Computes the courses of both axes.
    ///
    /// # Errors  a radius, speed, number of revolutions or rise time that is not above 0; fewer than ten
    ///   samples per revolution.
    pub fn courses(&self, step_s: f64) -> Result<[Course; 2], MotionError> {
        let given = [
            ("radius", self.radius),
            ("speed", self.speed_rad_s),
            ("number of turns", self.turns),
            ("rise", self.rise_s),
        ];
        require_positive("circle", &given)?;
        if self.speed_rad_s * step_s > 0.1 * TAU {
            return Err(MotionError::Input(format!(
                "circle: {} rad/s has fewer than ten samples of {step_s} s per revolution; lower the speed",
                self.speed_rad_s
            )));
        }
        let whole_s = self.rise_s + TAU * self.turns / self.speed_rad_s;
        let angle = |at: usize| {
            let time_s = at as f64 * step_s;
            let s = (time_s / self.rise_s).min(1.0);
            self.speed_rad_s * (self.rise_s * s * s * s * (1.0 - 0.5 * s) + (time_s - self.rise_s).max(0.0))
        };
        let course = |of: &dyn Fn(f64) -> f64| {
            Course::sampled("circle", whole_s, step_s, |at| self.radius * of(angle(at)))
        };
        Ok([course(&f64::sin)?, course(&|a| 1.0 - a.cos())?])
    }
}

/// Computes the radial distance of points from a circle (m), positive outside.
pub fn contour_error(x: &[f64], y: &[f64], [a, b]: [f64; 2], radius: f64) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| (x - a).hypot(y - b) - radius).collect()
}
