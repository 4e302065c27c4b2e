//! Reference motions of an axis.

use std::f64::consts::TAU;

use super::MotionError;

/// A commanded motion with a constant sampling step, linear between samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Time between samples (s).
    pub step_s: f64,
    /// Command (m or rad), starting at time 0.
    pub command: Vec<f64>,
    /// Voltage added to the velocity loop's output (V), held between samples; empty for none.
    pub added: Vec<f64>,
    /// Reading of the position loop's encoder at the start; `None` for the first command.
    pub start_position: Option<f64>,
    /// Rate of the reading at the start; `None` for 0.
    pub start_velocity: Option<f64>,
}

impl Course {
    /// Creates a course from a command alone, at rest at its first sample.
    pub fn new(step_s: f64, command: Vec<f64>) -> Self {
        Course { step_s, command, added: Vec::new(), start_position: None, start_velocity: None }
    }

    /// Creates a course of a duration (s) from the command at each sample, at rest at its first one. `name`
    /// is that of the command.
    ///
    /// # Errors  the duration has too many samples.
    pub fn sampled(
        name: &str,
        whole_s: f64,
        step_s: f64,
        command: impl Fn(usize) -> f64,
    ) -> Result<Self, MotionError> {
        let count = (whole_s / step_s).ceil() + 1.0;
        if count <= MOST_SAMPLES {
            return Ok(Course::new(step_s, (0..count as usize).map(command).collect()));
        }
        Err(MotionError::Input(format!(
            "{name}: takes {whole_s:.3e} s, more than {MOST_SAMPLES:e} samples of {step_s} s; increase the speed, or shorten the travel"
        )))
    }

    /// Duration (s).
    pub fn duration_s(&self) -> f64 {
        self.step_s * self.command.len().saturating_sub(1) as f64
    }

    /// Returns the sample at a time, and the share of the way to the next one. Tolerates times that were
    /// rounded for output.
    fn position(&self, time_s: f64) -> (usize, f64) {
        let at = (time_s / self.step_s).max(0.0);
        let near = at.round();
        if (at - near).abs() < 1e-6 { (near as usize, 0.0) } else { (at as usize, at.fract()) }
    }

    /// Returns the command at a time: extrapolated before its start, constant after its end.
    pub fn command(&self, time_s: f64) -> f64 {
        let Some(&last) = self.command.last() else { return 0.0 };
        if time_s < 0.0 {
            let second = self.command.get(1).copied().unwrap_or(last);
            return self.command[0] + (second - self.command[0]) * time_s / self.step_s;
        }
        let (at, share) = self.position(time_s);
        match self.command.get(at..at + 2) {
            Some(pair) if share > 0.0 => pair[0] + (pair[1] - pair[0]) * share,
            _ => self.command.get(at).copied().unwrap_or(last),
        }
    }

    /// Returns the voltage added to the drive's input at a time (V).
    pub fn added_voltage(&self, time_s: f64) -> f64 {
        self.added.get(self.position(time_s).0).copied().unwrap_or(0.0)
    }
}

/// A motion from rest to rest with limits on velocity, acceleration and jerk.
///
/// It has seven phases: the acceleration rises, is constant, and falls to zero; the velocity is constant;
/// then the same in reverse. A short travel omits phases.
///
/// # Units      m, m/s, m/s², m/s³ (or rad)
/// # Limits     infinite jerk is the trapezoid of velocity
/// # Source     Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008),
///   section 3.4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SCurve {
    /// Start position.
    pub from: f64,
    /// End position.
    pub to: f64,
    /// Largest velocity.
    pub velocity: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Largest jerk.
    pub jerk: f64,
}

impl SCurve {
    /// Computes the durations (s) of a jerk phase, of the velocity rise, and of the whole motion.
    ///
    /// # Errors  a limit that is not above 0; no travel.
    fn times_s(&self) -> Result<(f64, f64, f64), MotionError> {
        require_positive(
            "s-curve",
            &[("velocity", self.velocity), ("acceleration", self.acceleration), ("jerk", self.jerk)],
        )?;
        let travel = (self.to - self.from).abs();
        if !(travel > 0.0 && travel.is_finite()) {
            return Err(MotionError::Input(format!(
                "s-curve: from {} to {} is no travel; write two different positions",
                self.from, self.to
            )));
        }
        // Velocity that the travel allows without a phase of constant velocity: v·(rise time of v) = travel.
        let rise_s = |v: f64| {
            let jerk_s = (self.acceleration / self.jerk).min((v / self.jerk).sqrt());
            let steady_s = v / (self.jerk * jerk_s) - jerk_s;
            (jerk_s, 2.0 * jerk_s + steady_s.max(0.0))
        };
        let mut velocity = self.velocity;
        if velocity * rise_s(velocity).1 > travel {
            let (mut low, mut high) = (0.0, velocity);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if middle * rise_s(middle).1 > travel { high = middle } else { low = middle }
            }
            velocity = 0.5 * (low + high);
        }
        let (jerk_s, rise) = rise_s(velocity);
        Ok((jerk_s, rise, rise + travel / velocity))
    }

    /// Computes the share of the travel at a time: the integral of the jerk's seven phases.
    fn share(time_s: f64, (jerk_s, rise_s, whole_s): (f64, f64, f64)) -> f64 {
        // With unit velocity the jerk is 1/(jerk_s·(rise_s − jerk_s)).
        let jerk = 1.0 / (jerk_s * (rise_s - jerk_s));
        let cubed = |from: f64| (time_s - from).max(0.0).powi(3) / 6.0;
        let rise =
            |at: f64| cubed(at) - cubed(at + jerk_s) - cubed(at + rise_s - jerk_s) + cubed(at + rise_s);
        jerk * (rise(0.0) - rise(whole_s - rise_s)) / (whole_s - rise_s)
    }

    /// Computes the course, with rest (s) before its start and after its end.
    ///
    /// # Errors  a limit that is not above 0; no travel.
    pub fn course(&self, step_s: f64, rest_s: f64, and_back: bool) -> Result<Course, MotionError> {
        let times = self.times_s()?;
        let leg_s = times.2 + rest_s;
        let legs = if and_back { 2.0 } else { 1.0 };
        let command = |at: usize| {
            let time_s = at as f64 * step_s - rest_s;
            let mut share = Self::share(time_s.min(times.2), times);
            if and_back {
                share -= Self::share((time_s - leg_s).clamp(0.0, times.2), times);
            }
            self.from + (self.to - self.from) * share
        };
        Course::sampled("s-curve", rest_s + legs * leg_s, step_s, command)
    }
}

/// Rejects parameters of a command, by their names, that are not above 0.
///
/// # Errors  the first of them.
pub fn require_positive(command: &str, given: &[(&str, f64)]) -> Result<(), MotionError> {
    match given.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        Some((what, x)) => {
            Err(MotionError::Input(format!("{command}: the {what} is {x}; write a number above 0")))
        }
        None => Ok(()),
    }
}

/// Largest number of samples of a command.
const MOST_SAMPLES: f64 = 2e7;

/// A sine about a centre. Its amplitude rises over the first period, so that it starts at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Centre (m or rad).
    pub centre: f64,
    /// Amplitude (m or rad).
    pub amplitude: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Number of periods.
    pub periods: f64,
}

impl Sine {
    /// Computes the course.
    ///
    /// # Errors  an amplitude, frequency or number of periods that is not above 0; fewer than ten samples per
    ///   period.
    pub fn course(&self, step_s: f64) -> Result<Course, MotionError> {
        require_positive(
            "sine",
            &[
                ("amplitude", self.amplitude),
                ("frequency", self.frequency_hz),
                ("number of periods", self.periods),
            ],
        )?;
        if self.frequency_hz * step_s > 0.1 {
            let fault = format!(
                "sine: {} Hz has fewer than ten samples of {step_s} s per period; lower the frequency, or shorten the position loop's period",
                self.frequency_hz
            );
            return Err(MotionError::Input(fault));
        }
        let command = |at: usize| {
            let periods = at as f64 * step_s * self.frequency_hz;
            // 3s² − 2s³ over the first period.
            let ramp = periods.min(1.0);
            self.centre + self.amplitude * ramp * ramp * (3.0 - 2.0 * ramp) * (TAU * periods).sin()
        };
        Course::sampled("sine", self.periods / self.frequency_hz, step_s, command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Travel, and velocity, acceleration and jerk by differences, keep their limits and reach them if the
    /// travel allows.
    #[test]
    fn limit_an_s_curve_keeps_its_limits() {
        for (travel, reached) in [(1.0, [true, true]), (0.02, [false, true]), (1e-4, [false, false])] {
            let curve = SCurve { from: 0.1, to: 0.1 + travel, velocity: 0.5, acceleration: 5.0, jerk: 200.0 };
            let step = 1e-4;
            let course = curve.course(step, 0.01, false).unwrap();
            assert!(
                (course.command[0] - 0.1).abs() < 1e-15
                    && (course.command.last().unwrap() - 0.1 - travel).abs() < 1e-12
            );
            let difference = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|w| (w[1] - w[0]) / step).collect() };
            let largest = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let velocity = difference(&course.command);
            let acceleration = difference(&velocity);
            let (v, a, j) = (largest(&velocity), largest(&acceleration), largest(&difference(&acceleration)));
            // Positions are rounded to about 1e-12 m; differences divide this by the step and its square.
            assert!(
                v < 0.5 + 1e-12 / step && a < 5.0 + 1e-12 / (step * step) && j < 200.0 * 1.01,
                "{v} {a} {j}"
            );
            assert_eq!([v > 0.499, a > 4.99], reached, "{travel}: {v} {a}");
            let back = curve.course(step, 0.01, true).unwrap();
            assert!((back.command.last().unwrap() - 0.1).abs() < 1e-12);
        }
        assert!(
            SCurve { from: 0.0, to: 0.0, velocity: 1.0, acceleration: 1.0, jerk: 1.0 }
                .course(1e-3, 0.0, false)
                .is_err()
        );
    }

    #[test]
    fn a_course_is_straight_between_samples() {
        let course = Course { added: vec![1.0, 2.0, 3.0], ..Course::new(1e-3, vec![0.0, 1.0, 3.0]) };
        assert_eq!(course.command(1e-3), 1.0);
        assert!((course.command(1.5e-3) - 2.0).abs() < 1e-12);
        assert_eq!((course.command(9.0), course.command(-1e-3)), (3.0, -1.0));
        assert_eq!((course.added_voltage(1.9e-3), course.added_voltage(2e-3)), (2.0, 3.0));
        assert!(
            Sine { centre: 0.0, amplitude: 1.0, frequency_hz: 200.0, periods: 3.0 }.course(1e-3).is_err()
        );
    }
}
