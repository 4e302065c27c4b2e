//! A driven axis that shares no code with the models under test. A mass in its own closed loop is integrated
//! by the Runge–Kutta method at 50 µs. Its friction changes sign smoothly; its measurements have noise and
//! quantisation.

use rand::RngExt;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Parameters of the axis.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    pub mass_kg: f64,
    pub coulomb: f64,
    pub viscous: f64,
    /// Viscous friction in the backward direction (N·s/m).
    pub viscous_backward: f64,
    /// Static friction in excess of Coulomb friction (N), decreasing as 1/(1 + (v/v_s)²).
    pub stribeck: f64,
    /// Speed v_s (m/s).
    pub stribeck_velocity: f64,
    /// Travel l over which friction builds up after a reversal, as 1 − exp(−s/l).
    pub presliding_m: f64,
    /// Amplitude (N) of a force ripple along the travel, its wave number (rad/m) and phase (rad).
    pub ripple: f64,
    pub ripple_per_m: f64,
    pub ripple_phase: f64,
    /// Delay from command to force.
    pub delay_s: f64,
    pub spring_n_per_m: f64,
    /// Relative amplitude of the variation of friction along the travel, its wave number (rad/m) and phase
    /// (rad).
    pub friction_variation: f64,
    pub variation_per_m: f64,
    pub variation_phase: f64,
    /// Relative increase of friction over the record.
    pub friction_drift: f64,
}

/// Gain of the velocity loop over the mass (1/s).
const GAIN_PER_S: f64 = 87.5;

impl Axis {
    pub fn nominal() -> Self {
        Axis {
            mass_kg: 80.0,
            coulomb: 22.0,
            viscous: 200.0,
            viscous_backward: 200.0,
            stribeck: 0.0,
            stribeck_velocity: 0.012,
            presliding_m: 0.0,
            ripple: 0.0,
            ripple_per_m: 157.0,
            ripple_phase: 0.0,
            delay_s: 0.0,
            spring_n_per_m: 0.0,
            friction_variation: 0.0,
            variation_per_m: 11.0,
            variation_phase: 0.0,
            friction_drift: 0.0,
        }
    }

    /// Simulates the axis and returns command, position and force (m, m, N) at 1 kHz.
    pub fn run(&self, command: &[f64], seed: u64) -> Vec<(f64, f64, f64)> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (mut x, mut v) = (command[0], 0.0);
        let (mut since_reversal_m, mut coloured_noise) = (1.0, 0.0);
        let delay_samples = (self.delay_s * 1e3).round() as usize;
        let mut sent = vec![0.0; delay_samples];
        let total = command.len() as f64;
        let mut samples = Vec::new();
        for (i, &r) in command.iter().enumerate() {
            let read = (x / 5e-7).round() * 5e-7;
            let force = GAIN_PER_S * self.mass_kg * (120.0 * (r - x) - v);
            sent.push(force);
            let acting = sent[i];
            // Coloured noise of the recorded force.
            coloured_noise = 0.9 * coloured_noise + 0.15 * (random.random::<f64>() - 0.5);
            samples.push((r, read, force + coloured_noise + 0.3 * (random.random::<f64>() - 0.5)));
            let buildup = if self.presliding_m > 0.0 {
                1.0 - (-since_reversal_m / self.presliding_m).exp()
            } else {
                1.0
            };
            let level = |v: f64, x: f64| {
                let variation = 1.0
                    + self.friction_variation * (self.variation_per_m * x + self.variation_phase).sin()
                    + self.friction_drift * (i as f64 / total);
                buildup
                    * (self.coulomb * variation
                        + self.stribeck / (1.0 + (v / self.stribeck_velocity).powi(2)))
            };
            let acceleration = |x: f64, v: f64| {
                let viscous = if v > 0.0 { self.viscous } else { self.viscous_backward };
                let friction = level(v, x) * (v / 2e-5).tanh() + viscous * v;
                (acting
                    - friction
                    - self.spring_n_per_m * (x - 0.1)
                    - self.ripple * (self.ripple_per_m * x + self.ripple_phase).sin())
                    / self.mass_kg
            };
            for _ in 0..20 {
                let h = 5e-5;
                let (a1, v1) = (acceleration(x, v), v);
                let (a2, v2) = (acceleration(x + 0.5 * h * v1, v + 0.5 * h * a1), v + 0.5 * h * a1);
                let (a3, v3) = (acceleration(x + 0.5 * h * v2, v + 0.5 * h * a2), v + 0.5 * h * a2);
                let (a4, v4) = (acceleration(x + h * v3, v + h * a3), v + h * a3);
                let before = v;
                x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
                v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
                since_reversal_m = if before * v < 0.0 { 0.0 } else { since_reversal_m + h * v.abs() };
            }
        }
        samples
    }
}

/// Returns a position command (m, 1 kHz): motions back and forth over 0.2 m at various speeds, with
/// standstills between them.
///
/// Each motion has raised-cosine ramps and a section of constant speed. The command has two periods.
pub fn course(seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xA5A5);
    let mut command = vec![0.0];
    let mut x: f64 = 0.0;
    let mut forward = true;
    for speed in [0.12, 0.04, 0.09, 0.015, 0.15, 0.004, 0.06, 0.025] {
        let speed: f64 = speed * (0.85 + 0.3 * random.random::<f64>());
        let ramp = 0.08 + 0.08 * random.random::<f64>();
        let room: f64 = if forward { 0.2 - x } else { x };
        let steady = ((room * (0.6 + 0.4 * random.random::<f64>()) - speed * ramp) / speed).clamp(0.25, 1.2);
        let ramp_samples = (1e3 * ramp) as usize;
        let steady_samples = (1e3 * steady) as usize;
        for i in 0..2 * ramp_samples + steady_samples {
            let rise = |k: usize| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / ramp_samples as f64).cos();
            let share = if i < ramp_samples {
                rise(i)
            } else {
                rise((2 * ramp_samples + steady_samples - i).min(ramp_samples))
            };
            x += 1e-3 * speed * share * if forward { 1.0 } else { -1.0 };
            command.push(x);
        }
        command.extend(std::iter::repeat_n(x, 150));
        forward = !forward;
    }
    // Back to the start position, so that the command is periodic.
    let from = x;
    command.extend((0..600).map(|i| from * (0.5 + 0.5 * (std::f64::consts::PI * i as f64 / 600.0).cos())));
    command.extend(std::iter::repeat_n(0.0, 150));
    let length = command.len() - command.len() % 10;
    command.truncate(length);
    command.extend_from_within(..);
    command
}
