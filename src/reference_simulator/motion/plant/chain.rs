//! Integration of the axis: half a drift, a kick at the midpoint, half a drift.

use super::axis::Axis;
use super::friction::FrictionElements;
use super::outside::UnlistedEffect;
use super::wave::wave_sum;

/// Iterations of the midpoint speed in one step.
const SWEEPS: usize = 3;

/// Work since the start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Work done by the motor, including its cogging.
    pub motor_j: f64,
    /// Work done against friction and the constant pull.
    pub friction_j: f64,
    /// Work dissipated in dashpots.
    pub dashpot_j: f64,
}

/// State of the axis.
///
/// A step of h: x_m = x + h v / 2; v′ = v + h a(x_m, (v + v′)/2) by a few iterations; x′ = x_m + h v′ / 2.
/// The method has second order, and is symplectic without friction and dashpots. Friction elements follow the
/// midpoints: their force depends on the displacement alone, not on the speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Time, s.
    pub time_s: f64,
    /// Positions of motor, screw and table, m.
    pub position_m: [f64; 3],
    /// Speeds of motor, screw and table, m/s.
    pub speed_m_s: [f64; 3],
    /// Work since the start.
    pub work: Work,
    bearing: FrictionElements,
    guide: FrictionElements,
    /// Positions of motor and table at the last update of the friction elements.
    element_position_m: [f64; 2],
    pendulum_m: f64,
    pendulum_m_s: f64,
    creep_m: f64,
    passages: Vec<f64>,
}

impl Chain {
    /// Creates the state at rest at a position, with relaxed elements.
    pub fn at_rest(axis: &Axis, position_m: f64) -> Self {
        let lumps = axis
            .unlisted
            .iter()
            .map(|unlisted| if let UnlistedEffect::Grease { lumps, .. } = unlisted { lumps.len() } else { 0 })
            .sum();
        Self {
            time_s: 0.0,
            position_m: [position_m; 3],
            speed_m_s: [0.0; 3],
            work: Work::default(),
            bearing: FrictionElements::default(),
            guide: FrictionElements::default(),
            element_position_m: [position_m; 2],
            pendulum_m: position_m,
            pendulum_m_s: 0.0,
            creep_m: position_m,
            passages: vec![0.0; lumps],
        }
    }

    /// Advances the state by one step under a motor force.
    pub fn step(&mut self, axis: &Axis, step_s: f64, motor_n: f64) {
        let half = 0.5 * step_s;
        let middle: [f64; 3] = std::array::from_fn(|k| self.position_m[k] + half * self.speed_m_s[k]);
        axis.bearing.advance(&mut self.bearing, middle[0] - self.element_position_m[0]);
        axis.guide.advance(&mut self.guide, middle[2] - self.element_position_m[1]);
        self.element_position_m = [middle[0], middle[2]];
        let twist = axis.coupling.stiffness_n_m * (middle[0] - middle[1]);
        let (nut_elastic, dashpot) = axis.nut.force(middle[1] - middle[2]);
        let pushed = motor_n * (1.0 + wave_sum(&axis.ripple, middle[0])) + wave_sum(&axis.cogging, middle[0]);
        let oil_factor = axis.oil_factor(self.time_s + half);
        let levels = [axis.bearing.level_n(middle[0], oil_factor), axis.guide.level_n(middle[2], oil_factor)];
        let (unlisted_force, mut pendulum) = self.unlisted(axis, middle[2], step_s);
        let mut after = self.speed_m_s;
        let mut resisting = [0.0; 4];
        for _ in 0..SWEEPS {
            let speed: [f64; 3] = std::array::from_fn(|k| 0.5 * (self.speed_m_s[k] + after[k]));
            let damped =
                [axis.coupling.damping_n_s_m * (speed[0] - speed[1]), dashpot * (speed[1] - speed[2])];
            let nut_force = nut_elastic + damped[1];
            let bearing = axis.bearing.force(&self.bearing, levels[0], speed[0], nut_force);
            let guide = axis.guide.force(&self.guide, levels[1], speed[2], nut_force);
            let mut table_force = unlisted_force;
            if let Some(body) = &mut pendulum {
                table_force += body.force(self.pendulum_m, self.pendulum_m_s, middle[2], speed[2], step_s);
            }
            let force = [
                pushed - twist - damped[0] - bearing,
                twist + damped[0] - nut_force,
                nut_force - guide - axis.pull_n - table_force,
            ];
            after = std::array::from_fn(|k| self.speed_m_s[k] + step_s * force[k] / axis.masses_kg[k]);
            resisting = [bearing, guide + axis.pull_n, damped[0], damped[1]];
        }
        let speed: [f64; 3] = std::array::from_fn(|k| 0.5 * (self.speed_m_s[k] + after[k]));
        self.work.motor_j += step_s * pushed * speed[0];
        self.work.friction_j += step_s * (resisting[0] * speed[0] + resisting[1] * speed[2]);
        self.work.dashpot_j +=
            step_s * (resisting[2] * (speed[0] - speed[1]) + resisting[3] * (speed[1] - speed[2]));
        if let Some(body) = pendulum {
            self.pendulum_m += half * (self.pendulum_m_s + body.after_m_s);
            self.pendulum_m_s = body.after_m_s;
        }
        self.position_m = std::array::from_fn(|k| middle[k] + half * after[k]);
        self.speed_m_s = after;
        self.time_s += step_s;
    }

    /// Returns the kinetic energy and the energy of the chain's springs, J.
    #[cfg(test)]
    pub fn energy_j(&self, axis: &Axis) -> f64 {
        let moving: f64 =
            axis.masses_kg.iter().zip(self.speed_m_s).map(|(mass, speed)| 0.5 * mass * speed * speed).sum();
        let twist = self.position_m[0] - self.position_m[1];
        moving
            + 0.5 * axis.coupling.stiffness_n_m * twist * twist
            + axis.nut.energy(self.position_m[1] - self.position_m[2])
    }

    /// Returns the force of unlisted effects on the table, and the body of a pendulum, which is solved within
    /// the step.
    fn unlisted(&mut self, axis: &Axis, table_m: f64, step_s: f64) -> (f64, Option<PendulumBody>) {
        let (mut force, mut pendulum, mut passed) = (0.0, None, 0);
        let speed = self.speed_m_s[2];
        for unlisted in &axis.unlisted {
            match unlisted {
                UnlistedEffect::CableChain { force_n, at_m, width_m } => {
                    force += 0.5 * force_n * (1.0 + ((table_m - at_m) / width_m).tanh())
                }
                UnlistedEffect::Pendulum { mass_kg, omega_rad_s, ratio } => {
                    pendulum = Some(PendulumBody {
                        mass_kg: *mass_kg,
                        omega_rad_s: *omega_rad_s,
                        ratio: *ratio,
                        after_m_s: self.pendulum_m_s,
                    });
                }
                UnlistedEffect::Grease { lumps, left } => {
                    for lump in lumps {
                        let inside = (1.0 - ((table_m - lump.at_m) / lump.width_m).powi(2)).max(0.0);
                        force += lump.force_n
                            * inside
                            * inside
                            * left.powf(self.passages[passed])
                            * (speed / 0.002).tanh();
                        self.passages[passed] +=
                            if inside > 0.0 { speed.abs() * step_s / (2.0 * lump.width_m) } else { 0.0 };
                        passed += 1;
                    }
                }
                UnlistedEffect::WiperCreep { stiffness_n_m, time_s } => {
                    force += stiffness_n_m * (table_m - self.creep_m);
                    self.creep_m += (table_m - self.creep_m) * (1.0 - (-step_s / time_s).exp());
                }
                UnlistedEffect::ScaleCogging { .. }
                | UnlistedEffect::DeadZone { .. }
                | UnlistedEffect::RunningIn { .. } => {}
            }
        }
        (force, pendulum)
    }
}

/// A body on a spring at the table, within one step.
struct PendulumBody {
    mass_kg: f64,
    omega_rad_s: f64,
    ratio: f64,
    after_m_s: f64,
}

impl PendulumBody {
    /// Returns the force on the table at the midpoint and updates the body's speed at the end of the step.
    fn force(&mut self, position_m: f64, speed_m_s: f64, table_m: f64, table_m_s: f64, step_s: f64) -> f64 {
        let middle = position_m + 0.5 * step_s * speed_m_s;
        let relative = table_m_s - 0.5 * (speed_m_s + self.after_m_s);
        let pull = self.omega_rad_s * self.omega_rad_s * (table_m - middle)
            + 2.0 * self.ratio * self.omega_rad_s * relative;
        self.after_m_s = speed_m_s + step_s * pull;
        self.mass_kg * pull
    }
}
