//! The sampled cascade of position, velocity and current loops.

use std::collections::VecDeque;

use super::nominal::{Loops, Nominal};

/// Period of the current loop, s.
pub const CURRENT_S: f64 = 31.25e-6;

/// Current periods in one period of the velocity loop: 125 µs.
pub const VELOCITY_TICKS: usize = 4;

/// Current periods in one period of the position loop: 1 ms.
pub const POSITION_TICKS: usize = 32;

/// A digital PI controller, u = k (e + T/T_i Σe).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Integral {
    sum: f64,
}

impl Integral {
    /// Returns the output for an error without any limit. `share` is T/T_i.
    ///
    /// # Source     Symmetry 11 (2019) 1156, section 2.3.
    fn output(&self, gain: f64, share: f64, error: f64) -> f64 {
        gain * (error + share * (self.sum + error))
    }

    /// Adds the error to the sum, unless the output is at its limit and the error would drive it further.
    fn accumulate(&mut self, output: f64, error: f64, limited: bool) {
        if !limited || output * error < 0.0 {
            self.sum += error;
        }
    }

    /// Returns the output for an error, within ± a limit; at the limit the sum does not grow.
    pub fn limited(&mut self, gain: f64, share: f64, error: f64, limit: f64) -> f64 {
        let unlimited = self.output(gain, share, error);
        self.accumulate(unlimited, error, unlimited.abs() > limit);
        unlimited.clamp(-limit, limit)
    }
}

/// State of the loops and their demands.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    ticks: usize,
    command_m: f64,
    readings_rad: VecDeque<f64>,
    speed_rad_s: f64,
    current_a: f64,
    velocity: Integral,
    currents: [Integral; 2],
}

impl Drive {
    /// Creates the state of a drive switched on at rest at zero.
    pub fn at_rest(loops: &Loops) -> Self {
        Self {
            ticks: 0,
            command_m: 0.0,
            readings_rad: VecDeque::from(vec![0.0; loops.speed_periods]),
            speed_rad_s: 0.0,
            current_a: 0.0,
            velocity: Integral::default(),
            currents: Default::default(),
        }
    }

    /// Samples one current period and returns the voltages of d and q, V.
    ///
    /// The inputs are the present command, the encoder's angle and both currents. Outer loops act at their
    /// own periods. The demand of i_d is zero. A voltage beyond link/√3 is shortened and keeps its direction.
    /// The demand of the position loop passes a first-order lag with the time constant `lag_s`, exact between
    /// its samples.
    pub fn sample(
        &mut self,
        nominal: &Nominal,
        lag_s: f64,
        command_m: f64,
        angle_rad: f64,
        current_a: [f64; 2],
    ) -> [f64; 2] {
        let (loops, ratio) = (&nominal.loops, nominal.ratio_m());
        if self.ticks.is_multiple_of(POSITION_TICKS) {
            let period = POSITION_TICKS as f64 * CURRENT_S;
            let ahead = loops.feed_forward * (command_m - self.command_m) / period;
            let demand = (loops.position_gain_1_s * (command_m - ratio * angle_rad) + ahead) / ratio;
            let share = if lag_s > 0.0 { 1.0 - (-period / lag_s).exp() } else { 1.0 };
            self.speed_rad_s += share * (demand - self.speed_rad_s);
            self.command_m = command_m;
        }
        if self.ticks.is_multiple_of(VELOCITY_TICKS) {
            let period = VELOCITY_TICKS as f64 * CURRENT_S;
            let before = self.readings_rad.pop_front().unwrap_or(angle_rad);
            self.readings_rad.push_back(angle_rad);
            let error = self.speed_rad_s - (angle_rad - before) / (loops.speed_periods as f64 * period);
            let share = period / loops.velocity_time_s;
            self.current_a =
                self.velocity.limited(loops.velocity_gain_a_s_rad, share, error, nominal.current_limit_a);
        }
        self.ticks += 1;
        let (gain, share, limit) =
            (loops.current_gain_v_a, CURRENT_S / loops.current_time_s, nominal.voltage_limit_v());
        let errors = [-current_a[0], self.current_a - current_a[1]];
        let unlimited: [f64; 2] = std::array::from_fn(|k| self.currents[k].output(gain, share, errors[k]));
        let length = unlimited[0].hypot(unlimited[1]);
        for (k, integral) in self.currents.iter_mut().enumerate() {
            integral.accumulate(unlimited[k], errors[k], length > limit);
        }
        unlimited.map(|volts| if length > limit { volts * limit / length } else { volts })
    }
}
