//! A driven axis of two masses that shares no code with the models under test. The motor with its rotating
//! parts, expressed as travel, drives a table through a spring with smoothed backlash. Semi-implicit Euler
//! steps of 20 µs integrate it in its own loops; its measurements have noise and quantisation.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Travel per radian of the motor (m): a lead of 20 mm.
pub const TRAVEL_M: f64 = 0.02 / std::f64::consts::TAU;

/// Parameters of the axis, referred to the travel of the table.
#[derive(Debug, Clone, Copy)]
pub struct TwoMasses {
    /// Inertia of motor, coupling and screw, reflected to the travel (kg).
    pub motor_kg: f64,
    pub table_kg: f64,
    pub coulomb: f64,
    pub viscous: f64,
    /// Stiffness of all springs between motor and table in series (N/m).
    pub stiffness: f64,
    pub backlash_m: f64,
    /// Relative thermal expansion of the lead.
    pub lead_expansion: f64,
    /// Amplitude and period of the periodic lead error (m).
    pub lead_error_m: (f64, f64),
    /// Standard deviations of the coloured force noise (N) and of the linear scale at the table (m).
    pub noise: (f64, f64),
    /// Drift of the scale over a record.
    pub scale_drift_m: f64,
    /// Delay of the scale's reading.
    pub scale_delay_s: f64,
    /// Relative amplitude of the variation of friction along the travel.
    pub friction_variation: f64,
}

/// Command, position, table (m) and torque (N·m).
pub type Sample = (f64, f64, f64, f64);

impl TwoMasses {
    pub fn nominal() -> Self {
        TwoMasses {
            motor_kg: 400.0,
            table_kg: 150.0,
            coulomb: 80.0,
            viscous: 400.0,
            stiffness: 4e7,
            backlash_m: 0.0,
            lead_expansion: 0.0,
            lead_error_m: (0.0, 1.0),
            noise: (1.5, 1e-7),
            scale_drift_m: 5e-7,
            scale_delay_s: 2e-5,
            friction_variation: 0.01,
        }
    }

    /// Simulates the axis and returns its samples at 1 kHz.
    pub fn run(&self, command: &[f64], seed: u64) -> Vec<Sample> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || numeric::random::normal(&mut random);
        let h = 2e-5;
        let (mut x, mut v, mut y, mut w) = (command[0], 0.0, command[0], 0.0);
        let mut coloured_noise = 0.0;
        let mut samples = Vec::new();
        for (i, &r) in command.iter().enumerate() {
            let rate = 1e3 * (r - command[i.saturating_sub(1)]);
            let force = 25_000.0 * (20.0 * (r - x) + rate - v);
            coloured_noise = 0.9 * coloured_noise + 0.43 * self.noise.0 * normal();
            let drift = self.scale_drift_m * (i as f64 / command.len() as f64);
            let table = y - self.scale_delay_s * w + drift + self.noise.1 * normal();
            let read = |x: f64, step: f64| (x / step).round() * step;
            samples.push((r, read(x, 2e-8), read(table, 1e-7), (force + coloured_noise) * TRAVEL_M));
            for _ in 0..50 {
                let lead = self.lead_expansion * y
                    + self.lead_error_m.0 * (std::f64::consts::TAU * y / self.lead_error_m.1).sin();
                let stretch = y - lead - x;
                // Contact is smoothed over 0.2 µm: the spring force sets in as ln(1 + e^z).
                let smoothed = |z: f64| {
                    2e-7 * (1.0 + (z / 2e-7).min(300.0).exp()).ln().max(if z > 6e-5 { z / 2e-7 } else { 0.0 })
                };
                let half = 0.5 * self.backlash_m;
                let spring =
                    if half > 0.0 { smoothed(stretch - half) - smoothed(-stretch - half) } else { stretch };
                let contact =
                    if half > 0.0 { (spring / stretch.abs().max(1e-9)).abs().min(1.0) } else { 1.0 };
                let transmitted = self.stiffness * spring + 6e3 * contact * (w - v);
                let level = self.coulomb * (1.0 + self.friction_variation * (13.0 * y).sin());
                let friction = level * (w / 1e-4).tanh() + self.viscous * w;
                v += h * (force + transmitted) / self.motor_kg;
                w += h * (-transmitted - friction) / self.table_kg;
                x += h * v;
                y += h * w;
            }
        }
        samples
    }
}
