//! The drive: position and velocity loop at one sampling rate, and a current that follows with dead time and
//! lag.

use std::collections::VecDeque;

/// Settings of a drive, which its engineer knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Gain of the position loop, 1/s.
    pub position_gain_1_s: f64,
    /// Gain of the velocity loop, N·s/m.
    pub velocity_gain_n_s_m: f64,
    /// Gain of the velocity feed-forward; 1 feeds the full reference speed forward.
    pub feed_forward: f64,
    /// Integral time of the velocity loop, s; infinite for a proportional loop.
    pub integral_time_s: f64,
    /// Whether a scale at the table closes the position loop; the motor's encoder always closes the velocity
    /// loop.
    pub is_direct: bool,
    /// Period of both loops, s.
    pub period_s: f64,
    /// Largest demanded force, N.
    pub limit_n: f64,
    /// Step of the motor encoder, m; 0 for a perfect one.
    pub quantum_m: f64,
}

/// Parameters of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Settings.
    pub set: Settings,
    /// Time from a demand to its effect on the current, s.
    pub dead_time_s: f64,
    /// Time constant of the current's lag, s.
    pub lag_s: f64,
    /// Actual force over demanded force.
    pub force_gain: f64,
}

/// Rounds a value to a grid; a step of 0 leaves it unchanged.
pub fn quantised(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (value / quantum).round() * quantum } else { value }
}

/// State of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Loops {
    reading_m: f64,
    reference_m: f64,
    integral_m: f64,
    pending: VecDeque<(f64, f64)>,
    applied_demand_n: f64,
    current_n: f64,
}

impl Loops {
    /// Creates the state at rest at a position.
    pub fn at_rest(drive: &Drive, position_m: f64) -> Self {
        let reading_m = quantised(position_m, drive.set.quantum_m);
        Self {
            reading_m,
            reference_m: position_m,
            integral_m: 0.0,
            pending: VecDeque::new(),
            applied_demand_n: 0.0,
            current_n: 0.0,
        }
    }

    /// Samples both loops and returns the demand u = k_v (e + ∫ e dt / T_i) with e = k_p (r − x_o) + f ṙ − ẋ,
    /// speeds as differences over one period. x is the motor's position and x_o that of the outer encoder.
    /// The integral stands still while the demand is limited.
    pub fn sample(
        &mut self,
        drive: &Drive,
        time_s: f64,
        reference_m: f64,
        position_m: f64,
        table_m: f64,
    ) -> f64 {
        let set = &drive.set;
        let reading_m = quantised(position_m, set.quantum_m);
        let speed = (reading_m - self.reading_m) / set.period_s;
        let ahead = set.feed_forward * (reference_m - self.reference_m) / set.period_s;
        (self.reading_m, self.reference_m) = (reading_m, reference_m);
        let outer_m = if set.is_direct { quantised(table_m, set.quantum_m) } else { reading_m };
        let error = set.position_gain_1_s * (reference_m - outer_m) + ahead - speed;
        let wanted = set.velocity_gain_n_s_m * (error + self.integral_m / set.integral_time_s);
        let demand = wanted.clamp(-set.limit_n, set.limit_n);
        if demand == wanted {
            self.integral_m += error * set.period_s;
        }
        self.pending.push_back((time_s + drive.dead_time_s, demand));
        demand
    }

    /// Returns the force in the middle of a step; the lag of the current is exact within the step.
    pub fn force(&mut self, drive: &Drive, middle_s: f64, step_s: f64) -> f64 {
        while let Some(&(due, demand)) = self.pending.front() {
            if due > middle_s {
                break;
            }
            self.applied_demand_n = demand;
            self.pending.pop_front();
        }
        let before = self.current_n;
        self.current_n = self.applied_demand_n
            + (before - self.applied_demand_n)
                * if drive.lag_s > 0.0 { (-step_s / drive.lag_s).exp() } else { 0.0 };
        0.5 * (before + self.current_n) * drive.force_gain
    }
}
