//! The axis in motion: half a drift, a kick at the midpoint, half a drift.

use super::axis::Axis;
use super::friction::Film;
use super::outside::Outside;
use super::wave::along;

/// Sweeps of the midpoint speed in one step.
const SWEEPS: usize = 3;

/// Work since the start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Done by the motor, its cogging included.
    pub motor_j: f64,
    /// Done against friction and the constant pull.
    pub friction_j: f64,
    /// Lost in dashpots.
    pub dashpot_j: f64,
}

/// State of the axis.
///
/// A step of h: x_m = x + h v / 2; v′ = v + h a(x_m, (v + v′)/2) by a few sweeps; x′ = x_m + h v′ / 2. Second order, symplectic without
/// friction and dashpots. Friction elements follow the midpoints: their force depends on the way alone, however fast it was gone.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Time, s.
    pub time_s: f64,
    /// Positions of motor, screw and table, m.
    pub position_m: [f64; 3],
    /// Their speeds, m/s.
    pub speed_m_s: [f64; 3],
    /// Work since the start.
    pub work: Work,
    bearing: Film,
    guide: Film,
    /// Positions of motor and table at which the elements were last.
    dragged_m: [f64; 2],
    swing_m: f64,
    swing_m_s: f64,
    crept_m: f64,
    passages: Vec<f64>,
}

impl Chain {
    /// At rest at a position, with relaxed elements.
    pub fn at_rest(axis: &Axis, position_m: f64) -> Self {
        let lumps = axis.outside.iter().map(|outside| if let Outside::Grease { lumps, .. } = outside { lumps.len() } else { 0 }).sum();
        Self {
            time_s: 0.0,
            position_m: [position_m; 3],
            speed_m_s: [0.0; 3],
            work: Work::default(),
            bearing: Film::default(),
            guide: Film::default(),
            dragged_m: [position_m; 2],
            swing_m: position_m,
            swing_m_s: 0.0,
            crept_m: position_m,
            passages: vec![0.0; lumps],
        }
    }

    /// One step under a motor force.
    pub fn step(&mut self, axis: &Axis, step_s: f64, motor_n: f64) {
        let half = 0.5 * step_s;
        let middle: [f64; 3] = std::array::from_fn(|k| self.position_m[k] + half * self.speed_m_s[k]);
        axis.bearing.drag(&mut self.bearing, middle[0] - self.dragged_m[0]);
        axis.guide.drag(&mut self.guide, middle[2] - self.dragged_m[1]);
        self.dragged_m = [middle[0], middle[2]];
        let twist = axis.coupling.stiffness_n_m * (middle[0] - middle[1]);
        let (press, dashpot) = axis.nut.force(middle[1] - middle[2]);
        let pushed = motor_n * (1.0 + along(&axis.ripple, middle[0])) + along(&axis.cogging, middle[0]);
        let warmth = axis.warmth(self.time_s + half);
        let levels = [axis.bearing.level_n(middle[0], warmth), axis.guide.level_n(middle[2], warmth)];
        let (held, mut swing) = self.outside(axis, middle[2], step_s);
        let mut after = self.speed_m_s;
        let mut against = [0.0; 4];
        for _ in 0..SWEEPS {
            let speed: [f64; 3] = std::array::from_fn(|k| 0.5 * (self.speed_m_s[k] + after[k]));
            let damped = [axis.coupling.damping_n_s_m * (speed[0] - speed[1]), dashpot * (speed[1] - speed[2])];
            let through = press + damped[1];
            let bearing = axis.bearing.force(&self.bearing, levels[0], speed[0], through);
            let guide = axis.guide.force(&self.guide, levels[1], speed[2], through);
            let mut carried = held;
            if let Some(body) = &mut swing {
                carried += body.force(self.swing_m, self.swing_m_s, middle[2], speed[2], step_s);
            }
            let force = [pushed - twist - damped[0] - bearing, twist + damped[0] - through, through - guide - axis.pull_n - carried];
            after = std::array::from_fn(|k| self.speed_m_s[k] + step_s * force[k] / axis.masses_kg[k]);
            against = [bearing, guide + axis.pull_n, damped[0], damped[1]];
        }
        let speed: [f64; 3] = std::array::from_fn(|k| 0.5 * (self.speed_m_s[k] + after[k]));
        self.work.motor_j += step_s * pushed * speed[0];
        self.work.friction_j += step_s * (against[0] * speed[0] + against[1] * speed[2]);
        self.work.dashpot_j += step_s * (against[2] * (speed[0] - speed[1]) + against[3] * (speed[1] - speed[2]));
        if let Some(body) = swing {
            self.swing_m += half * (self.swing_m_s + body.after_m_s);
            self.swing_m_s = body.after_m_s;
        }
        self.position_m = std::array::from_fn(|k| middle[k] + half * after[k]);
        self.speed_m_s = after;
        self.time_s += step_s;
    }

    /// Energy of motion and of the springs of the chain, J.
    pub fn energy_j(&self, axis: &Axis) -> f64 {
        let moving: f64 = axis.masses_kg.iter().zip(self.speed_m_s).map(|(mass, speed)| 0.5 * mass * speed * speed).sum();
        let twist = self.position_m[0] - self.position_m[1];
        moving + 0.5 * axis.coupling.stiffness_n_m * twist * twist + axis.nut.energy(self.position_m[1] - self.position_m[2])
    }

    /// Force on the table of what hangs on it, and the body that swings, which answers within the step.
    fn outside(&mut self, axis: &Axis, table_m: f64, step_s: f64) -> (f64, Option<Swing>) {
        let (mut force, mut swing, mut passed) = (0.0, None, 0);
        let speed = self.speed_m_s[2];
        for outside in &axis.outside {
            match outside {
                Outside::CableChain { force_n, at_m, width_m } => force += 0.5 * force_n * (1.0 + ((table_m - at_m) / width_m).tanh()),
                Outside::Pendulum { mass_kg, omega_rad_s, ratio } => {
                    swing = Some(Swing { mass_kg: *mass_kg, omega_rad_s: *omega_rad_s, ratio: *ratio, after_m_s: self.swing_m_s });
                }
                Outside::Grease { lumps, left } => {
                    for lump in lumps {
                        let inside = (1.0 - ((table_m - lump.at_m) / lump.width_m).powi(2)).max(0.0);
                        force += lump.force_n * inside * inside * left.powf(self.passages[passed]) * (speed / 0.002).tanh();
                        self.passages[passed] += if inside > 0.0 { speed.abs() * step_s / (2.0 * lump.width_m) } else { 0.0 };
                        passed += 1;
                    }
                }
                Outside::WiperCreep { stiffness_n_m, time_s } => {
                    force += stiffness_n_m * (table_m - self.crept_m);
                    self.crept_m += (table_m - self.crept_m) * (1.0 - (-step_s / time_s).exp());
                }
                Outside::ScaleCogging { .. } | Outside::DeadZone { .. } | Outside::RunningIn { .. } => {}
            }
        }
        (force, swing)
    }
}

/// A body on a spring at the table.
struct Swing {
    mass_kg: f64,
    omega_rad_s: f64,
    ratio: f64,
    after_m_s: f64,
}

impl Swing {
    /// Force on the table at the midpoint; moves the body on to the same midpoint.
    fn force(&mut self, position_m: f64, speed_m_s: f64, table_m: f64, table_m_s: f64, step_s: f64) -> f64 {
        let middle = position_m + 0.5 * step_s * speed_m_s;
        let relative = table_m_s - 0.5 * (speed_m_s + self.after_m_s);
        let pull = self.omega_rad_s * self.omega_rad_s * (table_m - middle) + 2.0 * self.ratio * self.omega_rad_s * relative;
        self.after_m_s = speed_m_s + step_s * pull;
        self.mass_kg * pull
    }
}
