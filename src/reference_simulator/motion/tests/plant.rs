//! Tests of the axis against closed forms.

use nalgebra::{Matrix3, Vector3};

use super::{ideal_axis, machine};
use crate::motion::plant::{Axis, Chain, Friction, FrictionElements, SHARES, Spring, UnlistedEffect};

fn moved(axis: &Axis, chain: &mut Chain, step_s: f64, duration_s: f64, force_n: impl Fn(f64) -> f64) {
    for k in 0..(duration_s / step_s).round() as usize {
        chain.step(axis, step_s, force_n((k as f64 + 0.5) * step_s));
    }
}

/// Computes the free response of the three bodies from their modes.
fn modal(axis: &Axis, position: [f64; 3], speed: [f64; 3], time_s: f64) -> Vector3<f64> {
    let root = Matrix3::from_diagonal(&Vector3::from(axis.masses_kg.map(|mass| 1.0 / mass.sqrt())));
    let (a, b) = (axis.coupling.stiffness_n_m, axis.nut.stiffness_n_m);
    let stiffness = Matrix3::new(a, -a, 0.0, -a, a + b, -b, 0.0, -b, b);
    let modes = (root * stiffness * root).symmetric_eigen();
    let back = root.try_inverse().unwrap();
    let (start, rate) = (
        modes.eigenvectors.transpose() * back * Vector3::from(position),
        modes.eigenvectors.transpose() * back * Vector3::from(speed),
    );
    let now = Vector3::from_fn(|k, _| {
        let square = modes.eigenvalues[k];
        if square < 1e-3 {
            start[k] + rate[k] * time_s
        } else {
            start[k] * (square.sqrt() * time_s).cos()
                + rate[k] * (square.sqrt() * time_s).sin() / square.sqrt()
        }
    });
    root * modes.eigenvectors * now
}

#[test]
fn free_response_matches_the_modes_and_converges_with_the_square_of_the_step() {
    let axis = ideal_axis();
    let (position, speed) = ([0.0, 2e-5, -1e-5], [0.01, 0.0, 0.03]);
    let error = |step_s: f64| {
        let mut chain = Chain::at_rest(&axis, 0.0);
        (chain.position_m, chain.speed_m_s) = (position, speed);
        moved(&axis, &mut chain, step_s, 0.05, |_| 0.0);
        (Vector3::from(chain.position_m) - modal(&axis, position, speed, 0.05)).norm()
    };
    let (coarse, fine) = (error(25e-6), error(12.5e-6));
    assert!(coarse < 2e-5 * 0.3, "{coarse}");
    assert!((coarse / fine - 4.0).abs() < 0.4, "{coarse} then {fine}");
}

#[test]
fn friction_elements_follow_masings_rule() {
    let friction = Friction { coulomb_n: 20.0, presliding_m: 1e-5, ..Friction::none() };
    let mut elements = FrictionElements::default();
    let (mut way, mut first) = (0.0, Vec::new());
    while way < 4e-5 {
        first.push((way, friction.force(&elements, 20.0, 0.0, 0.0)));
        friction.advance(&mut elements, 1e-7);
        way += 1e-7;
    }
    let virgin = |way: f64| {
        let at = way / 1e-7;
        let k = at as usize;
        first[k].1 + (at - k as f64) * (first[k + 1].1 - first[k].1)
    };
    assert!((first.last().unwrap().1 - 20.0).abs() < 1e-9, "all elements slip after four mean distances");
    assert!((SHARES.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    // After a reversal the curve is the initial one, twice as large.
    for k in 0..700 {
        let (gone, force) = (k as f64 * 1e-7, friction.force(&elements, 20.0, 0.0, 0.0));
        assert!((force - (20.0 - 2.0 * virgin(0.5 * gone))).abs() < 1e-9, "{gone}: {force}");
        friction.advance(&mut elements, -1e-7);
    }
    // A closed loop returns to the same force.
    let before = friction.force(&elements, 20.0, 0.0, 0.0);
    friction.advance(&mut elements, 5e-6);
    friction.advance(&mut elements, -5e-6);
    assert!((friction.force(&elements, 20.0, 0.0, 0.0) - before).abs() < 1e-12);
}

#[test]
fn backlash_is_crossed_in_its_time_and_an_impact_conserves_momentum() {
    let mut axis = ideal_axis();
    axis.coupling = Spring { stiffness_n_m: 1e9, damping_n_s_m: 0.0 };
    (axis.nut.backlash_m, axis.nut.edge_m) = (2e-4, 1e-6);
    let mut chain = Chain::at_rest(&axis, 0.0);
    chain.speed_m_s = [0.05, 0.05, 0.0];
    // From the middle of the backlash, half of it is crossed in 2 ms.
    moved(&axis, &mut chain, 5e-6, 1.8e-3, |_| 0.0);
    assert!(chain.speed_m_s[2] < 1e-6, "{}", chain.speed_m_s[2]);
    moved(&axis, &mut chain, 5e-6, 0.3e-3, |_| 0.0);
    assert!(chain.speed_m_s[2] > 1e-4, "{}", chain.speed_m_s[2]);
    // After the impact: momentum and energy are conserved, the flank is open again.
    moved(&axis, &mut chain, 5e-6, 2.4e-3, |_| 0.0);
    let momentum: f64 = axis.masses_kg.iter().zip(chain.speed_m_s).map(|(mass, speed)| mass * speed).sum();
    assert!((momentum - 40.0 * 0.05).abs() < 1e-9);
    assert!((chain.energy_j(&axis) / (0.5 * 40.0 * 0.05f64.powi(2)) - 1.0).abs() < 1e-4);
    // Two bodies: 2 m₁ / (m₁ + m₃) v; a small part stays in the vibration of the coupling.
    assert!((chain.speed_m_s[2] / (2.0 * 40.0 / 100.0 * 0.05) - 1.0).abs() < 0.03, "{:?}", chain.speed_m_s);
}

#[test]
fn energy_is_balanced() {
    let machine = machine();
    for backlash_m in [0.0, 2e-5] {
        let mut axis = machine.axis.clone();
        axis.nut.backlash_m = backlash_m;
        let mut chain = Chain::at_rest(&axis, 0.0);
        moved(&axis, &mut chain, 12.5e-6, 0.6, |time| 120.0 * (std::f64::consts::TAU * 3.0 * time).sin());
        let work = chain.work;
        let rest = work.motor_j - work.friction_j - work.dashpot_j - chain.energy_j(&axis);
        assert!(work.motor_j > 0.5 && work.dashpot_j > 0.0, "{work:?}");
        assert!(rest.abs() < 1e-6 * work.motor_j, "backlash {backlash_m}: {rest} of {} J", work.motor_j);
    }
}

#[test]
fn pendulum_has_its_frequency_and_wiper_its_time_constant() {
    let mut axis = ideal_axis();
    axis.masses_kg = [1e6, 1e3, 1e6];
    axis.unlisted = vec![UnlistedEffect::Pendulum { mass_kg: 5.0, omega_rad_s: 60.0, ratio: 0.0 }];
    let mut chain = Chain::at_rest(&axis, 0.0);
    chain.speed_m_s = [0.01; 3];
    // The table keeps its speed and the body swings about it. The momentum given to the body is m v (1 − cos
    // ωt).
    let mut momenta = Vec::new();
    for _ in 0..4000 {
        chain.step(&axis, 25e-6, 0.0);
        momenta.push(
            0.01 * 2.001e6 - axis.masses_kg.iter().zip(chain.speed_m_s).map(|(m, v)| m * v).sum::<f64>(),
        );
    }
    for (k, given) in momenta.iter().enumerate() {
        let time = 25e-6 * (k + 1) as f64;
        let expected = 5.0 * 0.01 * (1.0 - (60.0 * time).cos());
        assert!((given - expected).abs() < 1e-4, "{time}: {given} for {expected}");
    }
    axis.unlisted = vec![UnlistedEffect::WiperCreep { stiffness_n_m: 1e4, time_s: 0.05 }];
    let mut chain = Chain::at_rest(&axis, 0.0);
    chain.speed_m_s = [0.01; 3];
    moved(&axis, &mut chain, 25e-6, 0.5, |_| 0.0);
    let before: f64 = axis.masses_kg.iter().zip(chain.speed_m_s).map(|(m, v)| m * v).sum();
    moved(&axis, &mut chain, 25e-6, 0.1, |_| 0.0);
    let after: f64 = axis.masses_kg.iter().zip(chain.speed_m_s).map(|(m, v)| m * v).sum();
    // A Maxwell element at constant speed: k T v.
    let force = (before - after) / 0.1;
    assert!((force / (1e4 * 0.05 * 0.01) - 1.0).abs() < 2e-3, "{force}");
}

#[test]
fn halving_the_step_quarters_the_error_of_a_motion_with_friction_and_backlash() {
    let mut axis = machine().axis;
    axis.nut.backlash_m = 1e-5;
    axis.guide.load_coefficient = 0.02;
    let end = |step_s: f64| {
        let mut chain = Chain::at_rest(&axis, 0.0);
        moved(&axis, &mut chain, step_s, 0.5, |time| 150.0 * (std::f64::consts::TAU * 4.0 * time).sin());
        chain.position_m[2]
    };
    let (a, b, c) = (end(50e-6), end(25e-6), end(12.5e-6));
    let ratio = (a - b) / (b - c);
    assert!((2.5..6.0).contains(&ratio) && (b - c).abs() < 1e-6, "{a} {b} {c}");
}
