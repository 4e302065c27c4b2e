//! Tests that each missing effect has its own signature and no other.

use std::f64::consts::TAU;

use super::{ideal_run, largest, linear, ramp, tone, with};
use crate::servo::missing::Missing;
use crate::servo::nominal::Axis;
use crate::servo::path::Feed;

fn linear_with(missing: Missing) -> Axis {
    Axis { missing, ..linear() }
}

#[test]
fn thermal_expansion_is_proportional_to_travel() {
    let command = Feed { amplitude_m: 0.03, ramp_s: 0.2, ..Feed::of(6000.0) }.commands_m().unwrap();
    let without = ideal_run(&linear(), &command);
    let expanded = ideal_run(&linear_with(Missing { growth: 5e-5, ..Missing::none() }), &command);
    for k in 0..command.len() {
        let expansion_m = expanded.table_m[k] - without.table_m[k];
        assert!((expansion_m - 5e-5 * without.position_m[k]).abs() < 5e-9, "{expansion_m} at {k}");
    }
    assert!(
        largest(expanded.position_m.iter().zip(&without.position_m).map(|(a, b)| a - b)) < 1e-8,
        "the encoder reading changes"
    );
}

/// A rising strain moves the table at a standing screw: γ (1 − e^{−t/τ}) · 0.3 m from the fixed bearing.
#[test]
fn thermal_expansion_rises_with_time_from_the_fixed_bearing() {
    let missing = Missing { growth: 5e-5, growth_time_s: 2.0, ..Missing::none() };
    let record = ideal_run(&linear_with(missing), &[0.0; 1500]);
    for k in [200, 500, 1400] {
        let expected = 5e-5 * 0.3 * (1.0 - (-record.time_s[k] / 2.0).exp());
        assert!((record.table_m[k] - expected).abs() < 1e-9, "{} for {expected}", record.table_m[k]);
    }
}

#[test]
fn lead_error_repeats_every_turn() {
    // One revolution, 16 mm, takes 800 ms.
    let record =
        ideal_run(&linear_with(Missing { lead_error_m: 0.8e-6, ..Missing::none() }), &ramp(0.02, 3.0));
    let error: Vec<f64> = record.table_m.iter().zip(&record.position_m).map(|(a, b)| a - b).collect();
    for k in 500..1300 {
        assert!((error[k] - error[k + 800]).abs() < 2e-9, "{k}");
    }
    let (re, im) = tone(&error[500..1300], TAU / 0.8, 1e-3);
    assert!((re.hypot(im) - 0.8e-6).abs() < 1e-8, "{}", re.hypot(im));
    assert!(
        error[500..1300].iter().sum::<f64>() / 800.0 + 0.8e-6 * 0.7f64.sin() < 1e-8,
        "the error is not zero at the start"
    );
    let without = ideal_run(&linear(), &ramp(0.02, 3.0));
    assert!(largest((500..2900).map(|k| without.table_m[k] - without.position_m[k])) < 1e-10);
}

/// The motor torque balances the cogging at 1 and 24 cycles per revolution; a revolution takes 8 s.
#[test]
fn ripple_shows_in_the_torque_once_and_24_times_per_turn() {
    let command = ramp(0.002, 9.5);
    let torque = |missing: Missing| ideal_run(&linear_with(missing), &command).torque_nm[1000..9000].to_vec();
    let rippled = torque(Missing { ripple_nm: [0.1, 0.15], ..Missing::none() });
    for (times, size) in [(1.0, 0.1), (24.0, 0.15), (5.0, 0.0), (23.0, 0.0)] {
        let (re, im) = tone(&rippled, times * TAU / 8.0, 1e-3);
        assert!((re.hypot(im) - size).abs() < 3e-3, "{times}: {}", re.hypot(im));
    }
    assert!(largest(torque(Missing::none())) < 1e-3);
}

/// Elastic friction differs from dry friction only near reversals.
#[test]
fn presliding_shows_at_reversals() {
    let feed = Feed { amplitude_m: 0.02, ramp_s: 0.2, ..Feed::of(2000.0) };
    let command = feed.commands_m().unwrap();
    let (elastic, dry) = (
        ideal_run(&with(Missing { presliding_m: 5e-6, ..Missing::none() }), &command),
        ideal_run(&with(Missing::none()), &command),
    );
    let period = TAU / feed.speed_rad_s();
    let (mut near, mut far) = (0.0f64, 0.0f64);
    for k in 0..command.len() {
        let phase = (feed.speed_rad_s() * (record_time(k) - 0.1)).cos();
        let off = (elastic.table_m[k] - dry.table_m[k]).abs();
        if phase.abs() < 0.15 {
            near = near.max(off);
        } else if phase.abs() > 0.6 && record_time(k) > 0.25 * period {
            far = far.max(off);
        }
    }
    assert!(near > 1e-6, "{near}");
    assert!(far < 1e-7, "{far}");
}

/// The torque of the extra mass is m·a·(lead/2π); the travel follows the same loops, and hardly changes.
#[test]
fn extra_mass_shows_in_the_torque() {
    let feed = Feed { amplitude_m: 0.02, ramp_s: 0.2, ..Feed::of(6000.0) };
    let command = feed.commands_m().unwrap();
    let (light, heavy) = (
        ideal_run(&linear(), &command),
        ideal_run(&linear_with(Missing { extra_kg: 60.0, ..Missing::none() }), &command),
    );
    let omega = feed.speed_rad_s();
    let period = (TAU / omega / 1e-3).round() as usize;
    let tail = command.len() - 1 - period..command.len() - 1;
    let amplitude = |values: &[f64]| tone(&values[tail.clone()], omega, 1e-3);
    let ((a, b), (c, d)) = (amplitude(&heavy.torque_nm), amplitude(&light.torque_nm));
    let expected = 60.0 * 0.02 * omega * omega * 0.016 / TAU;
    assert!(((a - c).hypot(b - d) / expected - 1.0).abs() < 0.05, "{} for {expected}", (a - c).hypot(b - d));
    assert!(largest(heavy.table_m.iter().zip(&light.table_m).map(|(a, b)| a - b)) < 2e-6);
}

/// A lag between the loops moves the table by a·t/k_v towards the command's past, t the mean age of the
/// demand: T/(e^{T/τ} − 1) for a lag τ in samples of T = 1 ms. At F6000 with 50 mm that is 0.2 m/s² · 4.2 ms
/// / 120 1/s = 7 µm.
#[test]
fn lag_delays_in_proportion_to_acceleration() {
    let lag_s: f64 = 4.7e-3;
    let age_s = 1e-3 / ((1e-3 / lag_s).exp() - 1.0);
    for feed_mm_min in [3000.0, 6000.0] {
        let feed = Feed { amplitude_m: 0.05, ramp_s: 0.5, ..Feed::of(feed_mm_min) };
        let command = feed.commands_m().unwrap();
        let (direct, late) = (
            ideal_run(&linear(), &command),
            ideal_run(&linear_with(Missing { lag_s, ..Missing::none() }), &command),
        );
        let omega = feed.speed_rad_s();
        let half = command.len() / 2..command.len();
        let off = half.map(|k| (late.table_m[k] - direct.table_m[k]).abs()).fold(0.0, f64::max);
        let expected = 0.05 * omega * omega * age_s / 120.0;
        assert!((off / expected - 1.0).abs() < 0.05, "{feed_mm_min}: {off} for {expected}");
    }
}

fn record_time(row: usize) -> f64 {
    row as f64 * 1e-3
}
