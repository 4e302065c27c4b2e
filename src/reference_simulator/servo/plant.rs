//! Motor, torsional spring, screw, nut, table, and their integration step.

use super::contact;
use super::friction::FrictionElements;
use super::motor;
use super::nominal::Axis;

/// Number of components of a state, and of its rates.
const SIZE: usize = 13;
const D: usize = 0;
const Q: usize = 1;
const MOTOR: usize = 2;
const MOTOR_SPEED: usize = 3;
const SCREW: usize = 4;
const SCREW_SPEED: usize = 5;
const TABLE: usize = 6;
const TABLE_SPEED: usize = 7;
const ELECTRIC: usize = 8;
const EXPANSION: usize = 9;
const COPPER: usize = 10;
const DASHPOT: usize = 11;
const FRICTION: usize = 12;

/// State of an axis: two currents, three bodies, friction, and the energy balance.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    time_s: f64,
    state: [f64; SIZE],
    guide: FrictionElements,
    bearing: FrictionElements,
}

impl Plant {
    /// Creates the state at rest at zero, without currents, with the nut in the middle of its backlash.
    pub fn at_rest(axis: &Axis) -> Self {
        let elements = FrictionElements::relaxed(axis.missing.presliding_m);
        Self { time_s: 0.0, state: [0.0; SIZE], guide: elements.clone(), bearing: elements }
    }

    /// Advances by one step of the classical Runge–Kutta rule under held voltages of d and q. Within each
    /// stage the friction elements slip from their positions at the start of the step.
    pub fn step(&mut self, axis: &Axis, step_s: f64, voltage_v: [f64; 2]) {
        let half = 0.5 * step_s;
        let moved = |rates: &[f64; SIZE], by: f64| -> [f64; SIZE] {
            std::array::from_fn(|k| self.state[k] + by * rates[k])
        };
        let first = self.rates(axis, self.time_s, &self.state, voltage_v);
        let second = self.rates(axis, self.time_s + half, &moved(&first, half), voltage_v);
        let third = self.rates(axis, self.time_s + half, &moved(&second, half), voltage_v);
        let fourth = self.rates(axis, self.time_s + step_s, &moved(&third, step_s), voltage_v);
        let mean: [f64; SIZE] =
            std::array::from_fn(|k| (first[k] + 2.0 * (second[k] + third[k]) + fourth[k]) / 6.0);
        self.state = moved(&mean, step_s);
        self.time_s += step_s;
        let (nominal, ratio) = (&axis.nominal, axis.nominal.ratio_m());
        self.guide.advance(&nominal.table_friction, self.state[TABLE], self.state[TABLE_SPEED]);
        self.bearing.advance(
            &nominal.screw_friction,
            ratio * self.state[SCREW],
            ratio * self.state[SCREW_SPEED],
        );
    }

    fn rates(&self, axis: &Axis, time_s: f64, state: &[f64; SIZE], voltage_v: [f64; 2]) -> [f64; SIZE] {
        let (nominal, ratio) = (&axis.nominal, axis.nominal.ratio_m());
        let [rotor, screw] = nominal.shafts_kg_m2();
        let current = [state[D], state[Q]];
        let currents = motor::rates_a_s(nominal, current, state[MOTOR_SPEED], voltage_v);

        let twist_rate = state[MOTOR_SPEED] - state[SCREW_SPEED];
        let shaft =
            nominal.torsion_nm_rad * (state[MOTOR] - state[SCREW]) + nominal.torsion_nm_s_rad * twist_rate;
        let thread = axis.missing.thread(ratio, time_s, state[SCREW]);
        let shift_rate = thread.per_rad_m * state[SCREW_SPEED] + thread.expansion_m_s - state[TABLE_SPEED];
        let (push, elastic) = contact::force_n(nominal, thread.position_m - state[TABLE], shift_rate);
        let guide = self.guide.force_n(&nominal.table_friction, state[TABLE], state[TABLE_SPEED]);
        let bearing = ratio
            * self.bearing.force_n(&nominal.screw_friction, ratio * state[SCREW], ratio * state[SCREW_SPEED]);
        let torque = motor::torque_nm(nominal, current) + axis.missing.cogging_nm(state[MOTOR]);

        let mut rates = [0.0; SIZE];
        [rates[D], rates[Q]] = currents;
        rates[MOTOR] = state[MOTOR_SPEED];
        rates[MOTOR_SPEED] = (torque - shaft) / rotor;
        rates[SCREW] = state[SCREW_SPEED];
        rates[SCREW_SPEED] = (shaft - thread.per_rad_m * push - bearing) / screw;
        rates[TABLE] = state[TABLE_SPEED];
        rates[TABLE_SPEED] = (push - guide) / axis.table_kg();
        rates[ELECTRIC] = 1.5 * (voltage_v[0] * current[0] + voltage_v[1] * current[1]);
        rates[EXPANSION] = push * thread.expansion_m_s;
        rates[COPPER] = 1.5 * nominal.resistance_ohm * (current[0] * current[0] + current[1] * current[1]);
        rates[DASHPOT] = nominal.torsion_nm_s_rad * twist_rate * twist_rate + (push - elastic) * shift_rate;
        rates[FRICTION] = guide * state[TABLE_SPEED] + bearing * state[SCREW_SPEED];
        rates
    }

    /// Returns the currents of d and q, A.
    pub fn current_a(&self) -> [f64; 2] {
        [self.state[D], self.state[Q]]
    }

    /// Returns the angle of the motor, rad.
    pub fn motor_rad(&self) -> f64 {
        self.state[MOTOR]
    }

    /// Returns the position of the table, m.
    pub fn table_m(&self) -> f64 {
        self.state[TABLE]
    }

    /// Returns the speed of the table, m/s.
    pub fn table_m_s(&self) -> f64 {
        self.state[TABLE_SPEED]
    }

    /// Returns the energy put in by voltages and by thermal expansion against the nut, J.
    #[cfg(test)]
    pub fn input_j(&self) -> f64 {
        self.state[ELECTRIC] + self.state[EXPANSION]
    }

    /// Returns the energy dissipated in copper, in dashpots and by friction, J.
    #[cfg(test)]
    pub fn dissipated_j(&self) -> [f64; 3] {
        [self.state[COPPER], self.state[DASHPOT], self.state[FRICTION]]
    }

    /// Returns the energy of field, motion, springs and cogging, J.
    #[cfg(test)]
    pub fn stored_j(&self, axis: &Axis) -> f64 {
        let (nominal, state) = (&axis.nominal, &self.state);
        let [rotor, screw] = nominal.shafts_kg_m2();
        let motion = 0.5
            * (rotor * state[MOTOR_SPEED].powi(2)
                + screw * state[SCREW_SPEED].powi(2)
                + axis.table_kg() * state[TABLE_SPEED].powi(2));
        let twist = 0.5 * nominal.torsion_nm_rad * (state[MOTOR] - state[SCREW]).powi(2);
        let shift =
            axis.missing.thread(nominal.ratio_m(), self.time_s, state[SCREW]).position_m - state[TABLE];
        motor::field_j(nominal, self.current_a())
            + motion
            + twist
            + contact::energy_j(nominal, shift)
            + axis.missing.cogging_j(state[MOTOR])
    }

    /// Returns the same state with another table position.
    #[cfg(test)]
    pub fn displaced(mut self, table_m: f64) -> Self {
        self.state[TABLE] = table_m;
        self
    }

    /// Returns the speed of the motor, rad/s.
    #[cfg(test)]
    pub fn motor_rad_s(&self) -> f64 {
        self.state[MOTOR_SPEED]
    }
}
