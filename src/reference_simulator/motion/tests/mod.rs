//! Tests of the axis in motion: closed forms, energy, convergence, cases.

mod case;
mod plant;
mod servo;

use super::drive::{Drive, Settings};
use super::plant::{Axis, Contact, Friction, Spring, ThermalExpansion};
use super::run::Machine;

/// An ideal axis of 100 kg: no friction, no backlash, no dashpots.
fn ideal_axis() -> Axis {
    Axis {
        masses_kg: [35.0, 5.0, 60.0],
        coupling: Spring { stiffness_n_m: 3e7, damping_n_s_m: 0.0 },
        nut: Contact { stiffness_n_m: 1e8, damping_n_s_m: 0.0, backlash_m: 0.0, edge_m: 5e-7 },
        bearing: Friction::none(),
        guide: Friction::none(),
        pull_n: 0.0,
        cogging: Vec::new(),
        ripple: Vec::new(),
        pitch: Vec::new(),
        thermal_expansion: ThermalExpansion { strain: 0.0, time_s: 100.0, elapsed_s: 0.0, fixed_m: 0.0 },
        scale_delay_s: 0.0,
        unlisted: Vec::new(),
    }
}

/// A drive of 1 kHz without errors.
fn drive() -> Drive {
    let set = Settings {
        position_gain_1_s: 60.0,
        velocity_gain_n_s_m: 12_000.0,
        feed_forward: 0.0,
        integral_time_s: f64::INFINITY,
        is_direct: false,
        period_s: 1e-3,
        limit_n: 1e6,
        quantum_m: 0.0,
    };
    Drive { set, dead_time_s: 0.0, lag_s: 0.0, force_gain: 1.0 }
}

/// The ideal axis with friction and dashpots.
fn machine() -> Machine {
    let mut axis = ideal_axis();
    axis.coupling.damping_n_s_m = 200.0;
    axis.nut.damping_n_s_m = 500.0;
    axis.bearing = Friction { coulomb_n: 8.0, viscous_n_s_m: 60.0, ..Friction::none() };
    axis.guide = Friction {
        coulomb_n: 15.0,
        viscous_n_s_m: 120.0,
        excess: 0.3,
        stribeck_m_s: 0.01,
        thinning: 0.05,
        presliding_m: 5e-6,
        ..Friction::none()
    };
    axis.pull_n = 3.0;
    Machine { axis, drive: drive() }
}
