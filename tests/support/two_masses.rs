//! A driven axis of two masses that shares nothing with the models under test: the motor and what turns with it, seen as travel, and a table on a
//! spring with play whose flanks are round, integrated by half-explicit Euler steps of 20 µs in its own loops, measured with noise and steps.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Travel per radian of the motor (m): a lead of 20 mm.
pub const TRAVEL_M: f64 = 0.02 / std::f64::consts::TAU;

/// The axis; all in units of the travel.
#[derive(Debug, Clone, Copy)]
pub struct TwoMasses {
    /// Motor, coupling and screw (kg of travel).
    pub motor_kg: f64,
    pub table_kg: f64,
    pub coulomb: f64,
    pub viscous: f64,
    /// All springs between motor and table in series.
    pub stiffness: f64,
    pub play_m: f64,
    /// Share by which the table goes further than the screw says.
    pub growth: f64,
    /// Amplitude and period of the lead's error (m).
    pub wave_m: (f64, f64),
    /// Standard deviations of force noise, coloured (N), and of the table's scale (m).
    pub noise: (f64, f64),
    /// Drift of the scale over a record (m), its late reading (s), and share by which friction varies along the travel.
    pub drift_m: f64,
    pub late_s: f64,
    pub uneven: f64,
}

/// Command, position, table (m) and torque (N·m).
pub type Sample = (f64, f64, f64, f64);

impl TwoMasses {
    pub fn usual() -> Self {
        TwoMasses {
            motor_kg: 400.0,
            table_kg: 150.0,
            coulomb: 80.0,
            viscous: 400.0,
            stiffness: 4e7,
            play_m: 0.0,
            growth: 0.0,
            wave_m: (0.0, 1.0),
            noise: (1.5, 1e-7),
            drift_m: 5e-7,
            late_s: 2e-5,
            uneven: 0.01,
        }
    }

    /// At 1 kHz.
    pub fn run(&self, command: &[f64], seed: u64) -> Vec<Sample> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || jointid::numeric::random::normal(&mut random);
        let h = 2e-5;
        let (mut x, mut v, mut y, mut w) = (command[0], 0.0, command[0], 0.0);
        let mut slow = 0.0;
        let mut samples = Vec::new();
        for (i, &r) in command.iter().enumerate() {
            let rate = 1e3 * (r - command[i.saturating_sub(1)]);
            let force = 25_000.0 * (20.0 * (r - x) + rate - v);
            slow = 0.9 * slow + 0.43 * self.noise.0 * normal();
            let drift = self.drift_m * (i as f64 / command.len() as f64);
            let table = y - self.late_s * w + drift + self.noise.1 * normal();
            let read = |x: f64, step: f64| (x / step).round() * step;
            samples.push((r, read(x, 2e-8), read(table, 1e-7), (force + slow) * TRAVEL_M));
            for _ in 0..50 {
                let lead = self.growth * y + self.wave_m.0 * (std::f64::consts::TAU * y / self.wave_m.1).sin();
                let stretch = y - lead - x;
                // Flanks round over 0.2 µm: the play opens as ln(1 + e^z).
                let soft = |z: f64| 2e-7 * (1.0 + (z / 2e-7).min(300.0).exp()).ln().max(if z > 6e-5 { z / 2e-7 } else { 0.0 });
                let half = 0.5 * self.play_m;
                let spring = if half > 0.0 { soft(stretch - half) - soft(-stretch - half) } else { stretch };
                let closed = if half > 0.0 { (spring / stretch.abs().max(1e-9)).abs().min(1.0) } else { 1.0 };
                let between = self.stiffness * spring + 6e3 * closed * (w - v);
                let level = self.coulomb * (1.0 + self.uneven * (13.0 * y).sin());
                let rub = level * (w / 1e-4).tanh() + self.viscous * w;
                v += h * (force + between) / self.motor_kg;
                w += h * (-between - rub) / self.table_kg;
                x += h * v;
                y += h * w;
            }
        }
        samples
    }
}
