//! Each missing effect does what it should, and nothing else.

use std::f64::consts::TAU;

use super::{largest, linear, ramp, seen, tone, with};
use crate::servo::missing::Missing;
use crate::servo::nominal::Axis;
use crate::servo::path::Feed;

fn linear_with(missing: Missing) -> Axis {
    Axis { missing, ..linear() }
}

#[test]
fn growth_is_in_proportion_to_travel() {
    let command = Feed { amplitude_m: 0.03, ramp_s: 0.2, ..Feed::of(6000.0) }.commands_m().unwrap();
    let without = seen(&linear(), &command);
    let grown = seen(&linear_with(Missing { growth: 5e-5, ..Missing::none() }), &command);
    for k in 0..command.len() {
        let longer = grown.table_m[k] - without.table_m[k];
        assert!((longer - 5e-5 * without.position_m[k]).abs() < 5e-9, "{longer} at {k}");
    }
    assert!(largest(grown.position_m.iter().zip(&without.position_m).map(|(a, b)| a - b)) < 1e-8, "the encoder sees nothing");
}

/// A strain that rises moves the table though the screw stands still: γ (1 − e^{−t/τ}) · 0.3 m from the fixed bearing.
#[test]
fn growth_rises_with_time_from_the_fixed_bearing() {
    let missing = Missing { growth: 5e-5, growth_time_s: 2.0, ..Missing::none() };
    let record = seen(&linear_with(missing), &[0.0; 1500]);
    for k in [200, 500, 1400] {
        let expected = 5e-5 * 0.3 * (1.0 - (-record.time_s[k] / 2.0).exp());
        assert!((record.table_m[k] - expected).abs() < 1e-9, "{} for {expected}", record.table_m[k]);
    }
}

#[test]
fn lead_error_repeats_every_turn() {
    // 16 mm in 800 ms.
    let record = seen(&linear_with(Missing { lead_error_m: 0.8e-6, ..Missing::none() }), &ramp(0.02, 3.0));
    let error: Vec<f64> = record.table_m.iter().zip(&record.position_m).map(|(a, b)| a - b).collect();
    for k in 500..1300 {
        assert!((error[k] - error[k + 800]).abs() < 2e-9, "{k}");
    }
    let (re, im) = tone(&error[500..1300], TAU / 0.8, 1e-3);
    assert!((re.hypot(im) - 0.8e-6).abs() < 1e-8, "{}", re.hypot(im));
    assert!(error[500..1300].iter().sum::<f64>() / 800.0 + 0.8e-6 * 0.7f64.sin() < 1e-8, "read from the start");
    let without = seen(&linear(), &ramp(0.02, 3.0));
    assert!(largest((500..2900).map(|k| without.table_m[k] - without.position_m[k])) < 1e-10);
}

/// The motor's torque holds against the cogging, once and 24 times per turn; a turn takes 8 s.
#[test]
fn ripple_shows_in_the_torque_once_and_24_times_per_turn() {
    let command = ramp(0.002, 9.5);
    let torque = |missing: Missing| seen(&linear_with(missing), &command).torque_nm[1000..9000].to_vec();
    let rippled = torque(Missing { ripple_nm: [0.1, 0.15], ..Missing::none() });
    for (times, size) in [(1.0, 0.1), (24.0, 0.15), (5.0, 0.0), (23.0, 0.0)] {
        let (re, im) = tone(&rippled, times * TAU / 8.0, 1e-3);
        assert!((re.hypot(im) - size).abs() < 3e-3, "{times}: {}", re.hypot(im));
    }
    assert!(largest(torque(Missing::none())) < 1e-3);
}

/// Elastic friction differs from a dry one where the motion turns, and nowhere else.
#[test]
fn presliding_shows_at_reversals() {
    let feed = Feed { amplitude_m: 0.02, ramp_s: 0.2, ..Feed::of(2000.0) };
    let command = feed.commands_m().unwrap();
    let (elastic, dry) = (seen(&with(Missing { presliding_m: 5e-6, ..Missing::none() }), &command), seen(&with(Missing::none()), &command));
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

fn record_time(row: usize) -> f64 {
    row as f64 * 1e-3
}
