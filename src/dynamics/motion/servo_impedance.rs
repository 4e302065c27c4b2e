//! The drive in the frequency domain: a dynamic stiffness between its encoders and the driven point.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::MotionError;
use machine::{Drive, Machine, Operating, Tachometry, Value};

/// The effect of a position-controlled drive on the machine: a force −Σ Z·q on the driven point, each Z from
/// the coordinate q of one point.
///
/// ```text
/// F = −S(ω)·k_v·(1 + I)·( k_p·x_p·s_p + D·x_v·s_v )                      k_s = Re Z,  c_s = Im Z/ω
/// I = T/(T_i·(e^{iωT} − 1)), the sum of the samples before the present one; 1/(T_i·iω) for T → 0
/// D  = (1 − e^{−iωPT})/(P·T) for differences over P periods, iω for a tachometer
/// s  = e^{−iωT/2}·sin(ωT/2)/(ωT/2), the mean delay of a value held over a period T
/// S  = G·e^{−iωτ}; with a winding G·e^{−iωτ}/(R + iωL); with a current loop, whose voltage is late, G·C·e^{−iωτ}/(R + iωL + C·e^{−iωτ}·s_c)
/// ```
///
/// A winding adds the induced voltage, G·k·iω over the same denominator. At low frequency and without
/// integral: k_s = G·k_v·k_p·i, c_s = G·k_v·i with i = lead/2π.
///
/// # Units      N/m or N·m/rad (force of the driven point per coordinate of the other)
/// # Limits     below half the loops' sampling rates; aliasing from above is neglected (poles of
///   [`super::LinearLoops`] include it)
/// # Source     Franklin, Powell and Workman, Digital Control of Dynamic Systems (1998), section 6.1 (held
///   samples)
#[derive(Debug, Clone)]
pub struct ServoImpedance {
    /// Index of the driven point.
    pub on: usize,
    points: [usize; 3],
    numbers: ImpedanceNumbers,
}

#[derive(Debug, Clone, Copy)]
struct ImpedanceNumbers {
    constant: f64,
    position_gain: f64,
    velocity_gain: f64,
    integral_time_s: f64,
    /// Velocity feed-forward (1), and acceleration feed-forward (output per m/s²).
    feed_forward: (f64, f64),
    delay_s: f64,
    periods_s: (f64, f64),
    differenced: Option<f64>,
    travel: (f64, f64),
    winding: Option<(f64, f64, f64)>,
    current: Option<(f64, f64, f64)>,
}

/// Computes the sum of the samples before the present one, times period over integral time, per present
/// sample.
///
/// # Source  Σ z^{−k} from k = 1 on is 1/(z − 1), z = e^{sT}
fn integral(s: Complex64, time_s: f64, period_s: f64) -> Complex64 {
    period_s / time_s / ((s * period_s).exp() - 1.0)
}

/// Computes the mean delay of a value held over a period.
fn hold_delay(omega: f64, period_s: f64) -> Complex64 {
    let half = 0.5 * omega * period_s;
    Complex64::from_polar(if half == 0.0 { 1.0 } else { half.sin() / half }, -half)
}

impl ServoImpedance {
    /// Creates the impedance of a machine's drive.
    ///
    /// # Errors  the machine has no drive.
    pub fn new(machine: &Machine, values: &[f64], operating: &Operating) -> Result<Self, MotionError> {
        let drive: &Drive = machine.drive.as_ref().ok_or(MotionError::NoDrive)?;
        let at = |value: &Value| value.at(values, operating);
        let constant = at(&drive.constant) * at(&drive.force_factor);
        let phases = |m: &machine::Motor| if m.pole_pairs.is_some() { 1.5 } else { 1.0 };
        Ok(ServoImpedance {
            on: drive.on,
            points: [drive.position.encoder.at, drive.velocity.encoder.at, drive.on],
            numbers: ImpedanceNumbers {
                constant,
                position_gain: at(&drive.position.gain_per_s),
                velocity_gain: at(&drive.velocity.gain),
                integral_time_s: at(&drive.velocity.integral_time_s),
                feed_forward: (
                    at(&drive.position.feed_forward),
                    at(&drive.velocity.acceleration_feed_forward),
                ),
                delay_s: at(&drive.delay_s),
                periods_s: (drive.position.period_s, drive.velocity.period_s),
                differenced: match drive.velocity.tachometry {
                    Tachometry::Difference(periods) => Some(periods as f64 * drive.velocity.period_s),
                    Tachometry::Direct => None,
                },
                travel: (drive.position.encoder.travel, drive.velocity.encoder.travel),
                winding: drive
                    .motor
                    .as_ref()
                    .map(|m| (at(&m.resistance_ohm), at(&m.inductance_h), constant / phases(m))),
                current: drive.current.as_ref().map(|c| (at(&c.gain), at(&c.integral_time_s), c.period_s)),
            },
        })
    }

    /// Computes force per output of the velocity loop, and induced force per rate of the driven point.
    fn actuator(&self, s: Complex64) -> (Complex64, Complex64) {
        let n = &self.numbers;
        let late = (-s * n.delay_s).exp();
        match (n.winding, n.current) {
            (None, _) => (n.constant * late, Complex64::ZERO),
            (Some((r, l, k)), None) => (n.constant * late / (r + s * l), n.constant * k / (r + s * l)),
            (Some((r, l, k)), Some((gain, time_s, period_s))) => {
                // In the forward path the hold of the velocity loop includes that of the current loop; in the
                // current loop's feedback it does not.
                let loops = gain * (1.0 + integral(s, time_s, period_s)) * late;
                let whole = r + s * l + loops * hold_delay(s.im, period_s);
                (n.constant * loops / whole, n.constant * k / whole)
            }
        }
    }

    /// Computes each Z, with the index of the point whose coordinate it multiplies.
    pub fn stiffness(&self, omega_rad_s: f64) -> [(usize, Complex64); 3] {
        let n = &self.numbers;
        let s = Complex64::new(0.0, omega_rad_s);
        let rate = n.differenced.map_or(s, |over_s| (1.0 - (-s * over_s).exp()) / over_s);
        let speed = n.velocity_gain
            * (1.0 + integral(s, n.integral_time_s, n.periods_s.1))
            * hold_delay(omega_rad_s, n.periods_s.1);
        let (share, induced) = self.actuator(s);
        // `speed` includes the hold of the velocity loop; the position path has the longer hold of the
        // position loop in its place.
        let slower = hold_delay(omega_rad_s, n.periods_s.0) / hold_delay(omega_rad_s, n.periods_s.1);
        let position = share * speed * n.position_gain * slower * n.travel.0;
        let velocity = share * speed * rate * n.travel.1;
        [(self.points[0], position), (self.points[1], velocity), (self.points[2], induced * s)]
    }

    /// Computes the force on the driven point per command of the position loop.
    ///
    /// ```text
    /// W = S(ω)·s·[ k_v·(1 + I)·(k_p + f·D) + a·D² ],   D = (1 − e^{−iωT})/T, T and s of the position loop
    /// ```
    ///
    /// # Units      N or N·m per unit of the command (m or rad)
    /// # Source     the loops of [`machine::PositionLoop`] and [`machine::VelocityLoop`]: the rate of the
    ///   command is the difference of its samples
    pub fn force_per_command(&self, omega_rad_s: f64) -> Complex64 {
        let n = &self.numbers;
        let s = Complex64::new(0.0, omega_rad_s);
        let rate = (1.0 - (-s * n.periods_s.0).exp()) / n.periods_s.0;
        let speed = n.velocity_gain
            * (1.0 + integral(s, n.integral_time_s, n.periods_s.1))
            * (n.position_gain + n.feed_forward.0 * rate);
        self.actuator(s).0 * hold_delay(omega_rad_s, n.periods_s.0) * (speed + n.feed_forward.1 * rate * rate)
    }

    /// Computes the displacement of a point per command from open-loop receptances under a force on the
    /// driven point: that of the point, and `open(a)` of point a.
    ///
    /// ```text
    /// x/r = H_x,on·W/(1 + Σ Z_a·H_a,on)
    /// ```
    ///
    /// # Limits     below half the loops' sampling rates it is [`super::LinearLoops::response`]
    pub fn follow(
        &self,
        omega_rad_s: f64,
        response: Complex64,
        open: impl Fn(usize) -> Complex64,
    ) -> Complex64 {
        let by: Complex64 = self.stiffness(omega_rad_s).iter().map(|&(point, z)| z * open(point)).sum();
        response * self.force_per_command(omega_rad_s) / (1.0 + by)
    }

    /// Returns the stiffness at the driven point if both encoders sit there.
    ///
    /// # Errors  an encoder sits at another point: the drive is then no spring to the ground.
    pub fn at_driven_point(&self, omega_rad_s: f64) -> Result<Complex64, MotionError> {
        if self.points.iter().any(|p| *p != self.on) {
            let fault = "the drive's encoders do not sit at the driven point, so that the drive is no spring to the ground there; \
                         compute closed-loop FRFs instead";
            return Err(MotionError::Input(fault.into()));
        }
        Ok(self.stiffness(omega_rad_s).iter().map(|(_, z)| z).sum())
    }

    /// Computes a closed-loop receptance from open-loop ones; `open(a, b)` is that of point a per force on
    /// point b.
    ///
    /// ```text
    /// H = H_re − H_r,on·w/(1 + Σ Z_a·H_a,on),     w = Σ Z_a·H_a,e
    /// ```
    ///
    /// # Source  Sherman and Morrison: one force proportional to displacements
    pub fn close(
        &self,
        omega_rad_s: f64,
        response: usize,
        excitation: usize,
        open: impl Fn(usize, usize) -> Complex64,
    ) -> Complex64 {
        let stiffness = self.stiffness(omega_rad_s);
        let by = |force: usize| stiffness.iter().map(|&(point, z)| z * open(point, force)).sum::<Complex64>();
        open(response, excitation) - open(response, self.on) * by(excitation) / (1.0 + by(self.on))
    }

    /// Returns half the lowest sampling rate (Hz); above it a held sample is no mean delay.
    pub fn highest_hz(&self) -> f64 {
        0.5 / self.numbers.periods_s.0.max(self.numbers.periods_s.1)
    }

    /// Returns the points (index) whose receptances [`ServoImpedance::close`] needs in addition to the
    /// response: encoders and driven point.
    pub fn points(&self) -> Vec<usize> {
        let mut points = self.points.to_vec();
        points.sort_unstable();
        points.dedup();
        points
    }
}

/// Computes the gains of a position and a velocity loop that act like a spring and a damper: k_p = k_s/c_s
/// (1/s), and k_v = c_s/(G·i) (output per m/s).
///
/// # Units      k_s N·m/rad, c_s N·m·s/rad, constant G in N·m per output, lead in m per turn
pub fn gains_of(stiffness: f64, damping: f64, constant: f64, lead_m: f64) -> (f64, f64) {
    (stiffness / damping, damping * 2.0 * PI / (constant * lead_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_gains_there_and_back() {
        let (constant, lead_m, position, velocity) = (1.3, 0.02, 60.0, 200.0);
        let i = lead_m / (2.0 * PI);
        let (stiffness, damping) = (constant * velocity * position * i, constant * velocity * i);
        let (p, v) = gains_of(stiffness, damping, constant, lead_m);
        assert!((p / position - 1.0).abs() < 1e-12 && (v / velocity - 1.0).abs() < 1e-12);
    }
}
