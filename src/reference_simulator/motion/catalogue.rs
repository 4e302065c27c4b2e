//! Random axes with nuisance parameters that no description contains.

use super::drive::{Drive, Settings};
use super::plant::{Axis, Contact, Friction, Spring, ThermalExpansion, Wave};
use super::run::Machine;
use crate::draw::Draw;
use crate::machine::catalogue::round_to;

/// Limits of the motions of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Length available for strokes, m.
    pub stroke_m: f64,
    /// Rapid traverse speed, m/s.
    pub speed_m_s: f64,
    /// Largest acceleration, m/s².
    pub acceleration_m_s2: f64,
}

/// A drawn axis and the limits of its motions.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAxis {
    /// Axis and drive, including nuisance parameters.
    pub machine: Machine,
    /// Limits of its motions.
    pub limits: MotionLimits,
}

/// Returns the stiffness of one spring for a given natural frequency of motor against screw and table, N/m.
pub fn stiffness_for(masses_kg: [f64; 3], frequency_hz: f64) -> f64 {
    let (motor, rest) = (masses_kg[0], masses_kg[1] + masses_kg[2]);
    (std::f64::consts::TAU * frequency_hz).powi(2) * motor * rest / (motor + rest)
}

/// Draws an axis of 40 to 500 kg; `viscous` limits the ratio of viscous to dry friction at rapid speed.
pub fn random_axis(viscous: [f64; 2], draw: &mut Draw) -> DrawnAxis {
    let mass = draw.log_between(40.0, 500.0);
    let (motor, screw) = (draw.between(0.25, 0.5), draw.between(0.03, 0.08));
    let masses_kg = [motor * mass, screw * mass, (1.0 - motor - screw) * mass];
    let acceleration_m_s2 = draw.log_between(1.0, 5.0);
    let stroke_m = (draw.log_between(0.2, 0.6) * 100.0).round() / 100.0;
    let speed_m_s = draw.between(0.6, 0.95) * (0.3 * stroke_m * acceleration_m_s2).sqrt().min(0.5);
    let dry = draw.between(0.1, 0.35) * mass * acceleration_m_s2;
    let film = draw.between(viscous[0], viscous[1]) * dry / speed_m_s;
    let guide_share = draw.between(0.55, 0.75);
    let frequency_hz = draw.between(250.0, 450.0);
    let stiffness = stiffness_for(masses_kg, frequency_hz);
    let loss = 2.0 * draw.between(0.06, 0.12) / (std::f64::consts::TAU * frequency_hz);
    let presliding_m = draw.between(5e-7, 1.5e-6);
    let surface = |share: f64, film_share: f64| Friction {
        coulomb_n: share * dry,
        viscous_n_s_m: film_share * film,
        reference_speed_m_s: speed_m_s,
        presliding_m,
        ..Friction::none()
    };
    let (mut bearing, mut guide) = (surface(1.0 - guide_share, 0.4), surface(guide_share, 0.6));
    (bearing.thinning, guide.thinning) = (draw.between(0.0, 0.08), draw.between(0.0, 0.08));
    guide.position_waves = waves(0.012, stroke_m, 3, draw);
    let velocity = draw.between(60.0, 110.0);
    let set = Settings {
        position_gain_1_s: round_to(draw.between(0.4, 0.8) * velocity, 3),
        velocity_gain_n_s_m: round_to(velocity * mass, 3),
        feed_forward: 0.0,
        integral_time_s: f64::INFINITY,
        is_direct: false,
        period_s: [2.5e-4, 5e-4][draw.index(2)],
        limit_n: round_to(6.0 * (mass * acceleration_m_s2 + dry + film * speed_m_s), 2),
        quantum_m: round_to(draw.log_between(8e-9, 3e-8), 2),
    };
    let drive =
        Drive { set, dead_time_s: draw.between(0.0, 8e-6), lag_s: draw.between(1e-5, 4e-5), force_gain: 1.0 };
    let axis = Axis {
        masses_kg,
        coupling: Spring { stiffness_n_m: 1.3 * stiffness, damping_n_s_m: 1.3 * stiffness * loss },
        nut: Contact {
            stiffness_n_m: 4.3 * stiffness,
            damping_n_s_m: 4.3 * stiffness * loss,
            backlash_m: 0.0,
            edge_m: 5e-7,
        },
        bearing,
        guide,
        pull_n: draw.within(0.3) * dry,
        cogging: Vec::new(),
        ripple: Vec::new(),
        pitch: Vec::new(),
        thermal_expansion: ThermalExpansion { strain: 0.0, time_s: 600.0, elapsed_s: 0.0, fixed_m: 0.0 },
        scale_delay_s: 0.0,
        unlisted: Vec::new(),
    };
    DrawnAxis {
        machine: Machine { axis, drive },
        limits: MotionLimits { stroke_m, speed_m_s, acceleration_m_s2 },
    }
}

/// Draws a smooth random curve along a stroke: waves of decreasing amplitude with a given rms.
pub fn waves(rms: f64, stroke_m: f64, count: usize, draw: &mut Draw) -> Vec<Wave> {
    let mut out: Vec<Wave> = (0..count)
        .map(|k| Wave {
            amplitude: draw.between(0.5, 1.0) / (1.0 + k as f64),
            per_m: (0.6 + k as f64 + draw.unit()) / stroke_m,
            phase_rad: draw.within(std::f64::consts::PI),
        })
        .collect();
    let power: f64 = out.iter().map(|wave| 0.5 * wave.amplitude * wave.amplitude).sum();
    out.iter_mut().for_each(|wave| wave.amplitude *= rms / power.sqrt());
    out
}

/// Returns one copy of a machine for each nuisance parameter, changed by one standard deviation of its prior.
pub fn directions(machine: &Machine, stroke_m: f64) -> Vec<Machine> {
    let mut out = Vec::new();
    let mut moved = |change: &dyn Fn(&mut Machine)| {
        let mut copy = machine.clone();
        change(&mut copy);
        out.push(copy);
    };
    moved(&|m| m.axis.guide.thinning += 0.03);
    moved(&|m| [&mut m.axis.bearing, &mut m.axis.guide].iter_mut().for_each(|f| f.presliding_m *= 1.4));
    moved(&|m| {
        m.axis.guide.position_waves.push(Wave { amplitude: 0.012, per_m: 1.0 / stroke_m, phase_rad: 0.0 })
    });
    moved(&|m| {
        m.axis.guide.position_waves.push(Wave { amplitude: 0.012, per_m: 1.0 / stroke_m, phase_rad: 1.571 })
    });
    moved(&|m| {
        m.axis.guide.position_waves.push(Wave { amplitude: 0.008, per_m: 2.0 / stroke_m, phase_rad: 0.0 })
    });
    moved(&|m| m.drive.dead_time_s += 1e-5);
    moved(&|m| m.axis.coupling.stiffness_n_m *= 0.8);
    out
}
