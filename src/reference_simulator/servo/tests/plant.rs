//! Tests of motor, mechanics and friction.

use std::f64::consts::TAU;

use super::{ideal_run, largest, linear, ramp, with};
use crate::draw::Draw;
use crate::servo::contact::{energy_j, force_n};
use crate::servo::drive::POSITION_TICKS;
use crate::servo::friction::{Friction, FrictionElements};
use crate::servo::missing::Missing;
use crate::servo::motor::torque_nm;
use crate::servo::nominal::Axis;
use crate::servo::path::Feed;
use crate::servo::plant::Plant;
use crate::servo::run::{Machine, STEPS, run_in};
use crate::servo::sensor::Sensors;

/// A stiff axis is an oscillator of second order after a step of u_q, where u_d = −ω_e L_q i_q keeps i_d at
/// zero:
///
/// i_q = U/(L ω_d) e^{−σt} sin ω_d t with σ = R/2L and ω_n² = k_T p ψ/(J L).
#[test]
fn limit_motor_is_of_second_order() {
    let mut axis = linear();
    axis.nominal.torsion_nm_rad *= 1e4;
    axis.nominal.axial_n_m *= 1e4;
    let nominal = axis.nominal.clone();
    let (step, volts, inductance) = (1e-6, 10.0, 2.3e-3);
    let sigma = 0.184 / (2.0 * inductance);
    let natural = (1.018 * 4.0 * (1.018 / 6.0) / (nominal.inertia_kg_m2() * inductance)).sqrt();
    let damped = (natural * natural - sigma * sigma).sqrt();
    let mut plant = Plant::at_rest(&axis);
    let mut worst: f64 = 0.0;
    for k in 1..=40_000 {
        let speed = plant.motor_rad_s();
        plant.step(&axis, step, [-4.0 * speed * inductance * plant.current_a()[1], volts]);
        let time = f64::from(k) * step;
        let expected = volts / (inductance * damped) * (-sigma * time).exp() * (damped * time).sin();
        worst = worst.max((plant.current_a()[1] - expected).abs());
        assert!(plant.current_a()[0].abs() < 1e-3);
    }
    let peak = volts / (inductance * damped);
    assert!(worst < 2e-3 * peak, "{worst} of {peak}");
    assert!(
        (torque_nm(&nominal, [0.0, 12.5 * 2f64.sqrt()]) / 18.0 - 1.0).abs() < 2e-3,
        "torque at 12.5 A is not 18 N·m"
    );
}

/// A table on a screw that does not turn vibrates with sqrt(k/m) and decays with c/2m.
#[test]
fn limit_table_on_a_held_screw_is_an_oscillator() {
    let mut axis = linear();
    axis.nominal.screw_kg_m2 = 1e9;
    let mut plant = Plant::at_rest(&axis).displaced(1e-6);
    let (decay, natural) = (6000.0 / 300.0, (1.474e8f64 / 150.0).sqrt());
    let damped = (natural * natural - decay * decay).sqrt();
    for k in 1..=10_000 {
        plant.step(&axis, 5e-6, [0.0; 2]);
        let time = f64::from(k) * 5e-6;
        let expected =
            1e-6 * (-decay * time).exp() * ((damped * time).cos() + decay / damped * (damped * time).sin());
        assert!((plant.table_m() - expected).abs() < 1e-12, "{} for {expected} at {time}", plant.table_m());
    }
}

#[test]
fn electrical_energy_is_stored_or_dissipated() {
    let mut axis = with(Missing { growth_time_s: 0.5, ..Missing::default() });
    axis.nominal.inductance_h = [2.0e-3, 2.6e-3];
    axis.nominal.screw_friction =
        Friction { coulomb_n: 40.0, excess_n: 10.0, stribeck_m_s: 0.02, viscous_n_s_m: 100.0 };
    let command =
        Feed { amplitude_m: 0.01, ramp_s: 0.2, periods: 2, ..Feed::of(3000.0) }.commands_m().unwrap();
    let balance = |steps: usize| {
        let mut machine = Machine::at_rest(&axis, &Sensors::default());
        let before = machine.plant.stored_j(&axis);
        let mut worst: f64 = 0.0;
        for &command in &command {
            for _ in 0..POSITION_TICKS {
                machine.advance(command, steps);
            }
            let stored = machine.plant.stored_j(&axis) - before;
            worst = worst.max(
                (machine.plant.input_j() - stored - machine.plant.dissipated_j().iter().sum::<f64>()).abs(),
            );
        }
        (worst, machine.plant)
    };
    let (worst, plant) = balance(STEPS);
    let dissipated = plant.dissipated_j();
    assert!(dissipated.iter().all(|part| *part > 1e-4), "{dissipated:?}");
    assert!(plant.current_a()[0] != 0.0);
    assert!(worst < 1e-10 * plant.input_j(), "{worst} J of {} J", plant.input_j());
    assert!(balance(4 * STEPS).0 < 0.2 * worst, "the energy residual does not converge with the step");
}

#[test]
fn half_the_step_moves_the_table_by_less_than_a_tenth_of_a_nanometre() {
    for axis in [Axis::x(), Axis::y(), with(Missing::none())] {
        let command = Feed { amplitude_m: 0.02, ramp_s: 0.2, ..Feed::of(6000.0) }.commands_m().unwrap();
        let table_m =
            |steps| run_in(&axis, &Sensors::perfect(), &command, &mut Draw::new(0), steps).unwrap().table_m;
        let off = largest(table_m(STEPS).iter().zip(&table_m(2 * STEPS)).map(|(a, b)| a - b));
        assert!(off > 0.0 && off < 1e-10, "{off}");
    }
}

/// At constant speed the motor torque is the friction, stated here independently. The table lags the motor by
/// half the backlash and by the compliance of nut and shaft; after the reversal the lag has the other sign.
#[test]
fn limit_constant_speed_shows_friction_backlash_and_stiffness() {
    let axis = with(Missing { presliding_m: 5e-6, ..Missing::none() });
    for speed in [0.002, 0.02, 0.1] {
        let mut command = ramp(speed, 0.1 + 0.03 / speed + 0.3);
        let back: Vec<f64> = command.iter().rev().copied().collect();
        let there = command.len() - 1;
        command.extend(back);
        let record = ideal_run(&axis, &command);
        let ratio = 0.016 / TAU;
        let force = 150.0 + 60.0 * (-speed / 0.01).exp() + 800.0 * speed;
        let behind = 8.5e-6 + force * (1.0 / 1.474e8 + ratio * ratio / 1.54e4);
        let home = there + there / 2;
        for (at, sign) in [(there, 1.0), (home, -1.0)] {
            let torque: f64 = record.torque_nm[at - 100..at].iter().sum::<f64>() / 100.0;
            assert!(
                (torque * sign / (force * ratio) - 1.0).abs() < 2e-3,
                "{torque} for {} at {speed}",
                force * ratio
            );
            let lag = (record.position_m[at] - record.table_m[at]) * sign;
            assert!((lag - behind).abs() < 1e-8, "{lag} for {behind} at {speed}");
        }
    }
}

/// Inside the backlash the nut has no force. Outside it is a spring that never pulls; its force is the
/// gradient of its energy.
#[test]
fn limit_nut_only_pushes() {
    let nominal = Axis::x().nominal;
    assert_eq!(force_n(&nominal, 8.2e-6, 0.1), (0.0, 0.0));
    for side in [1.0, -1.0] {
        let (_, elastic) = force_n(&nominal, side * 10.5e-6, 0.0);
        assert!((elastic / (side * 1.474e8 * 2e-6) - 1.0).abs() < 1e-12);
        let (pressed, _) = force_n(&nominal, side * 10.5e-6, side * 0.01);
        assert!((pressed * side - 1.474e8 * 2e-6 - 6000.0 * 0.01 * 2.0 / 2.1).abs() < 1e-6, "{pressed}");
        assert_eq!(force_n(&nominal, side * 8.6e-6, side * -0.5).0, 0.0, "a parting flank pulls");
    }
    for k in -200..200 {
        let (shift, d) = (f64::from(k) * 0.1e-6, 1e-10);
        let slope = (energy_j(&nominal, shift + d) - energy_j(&nominal, shift - d)) / (2.0 * d);
        let elastic = force_n(&nominal, shift, 0.0).1;
        assert!((slope - elastic).abs() < 0.01 + 1e-3 * elastic.abs(), "{slope} for {elastic} at {shift}");
    }
}

/// Slipping elements obey Masing's rule: the curve after a reversal from full slip is the initial curve,
/// twice as long and twice as high.
#[test]
fn limit_friction_reverses_by_masings_rule() {
    let law = Friction { coulomb_n: 150.0, excess_n: 0.0, stribeck_m_s: 0.01, viscous_n_s_m: 0.0 };
    let first = |x: f64| FrictionElements::relaxed(5e-6).force_n(&law, x, 0.0);
    let mut elements = FrictionElements::relaxed(5e-6);
    for k in 1..=300 {
        elements.advance(&law, f64::from(k) * 1e-7, 0.0);
    }
    let slip = elements.force_n(&law, 3e-5, 0.0);
    assert!((slip - 150.0).abs() < 1e-9);
    for k in 1..=100 {
        let x = f64::from(k) * 1e-7;
        let back = elements.force_n(&law, 3e-5 - 2.0 * x, 0.0);
        assert!((back - (slip - 2.0 * first(x))).abs() < 1e-9);
    }
    // The last element slips at −ln(1/16) = 2.77 of the mean distance.
    assert!(first(13.8e-6) < 150.0 * (1.0 - 1e-6) && first(13.9e-6) > 150.0 * (1.0 - 1e-9));
}
