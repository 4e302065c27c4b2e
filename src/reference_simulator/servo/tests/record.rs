//! Tests of sensors, seeds and files.

use super::{ramp, with};
use crate::servo::missing::Missing;
use crate::servo::nominal::Axis;
use crate::servo::path::{Circle, Feed};
use crate::servo::run::run;
use crate::servo::sensor::Sensors;
use crate::servo::write::{write_circles, write_sines};

#[test]
fn seed_determines_the_record() {
    let command = ramp(0.05, 0.4);
    let record = |seed| run(&Axis::x(), &Sensors::default(), &command, seed).unwrap();
    assert_eq!(record(3), record(3));
    let (one, other) = (record(3), record(4));
    assert_ne!(one.table_m, other.table_m);
    assert_ne!(one.torque_nm, other.torque_nm);
    assert_eq!(one.position_m, other.position_m, "the noise of the scale reaches the loops");
}

#[test]
fn sensor_errors_have_their_stated_sizes() {
    let axis = with(Missing::none());
    let command = ramp(0.1, 1.0);
    let exact = run(&axis, &Sensors::perfect(), &command, 1).unwrap();
    let late = run(&axis, &Sensors { scale_delay_s: 1e-5, ..Sensors::perfect() }, &command, 1).unwrap();
    assert!((exact.table_m[900] - late.table_m[900] - 1e-6).abs() < 1e-9);
    let noisy = run(
        &axis,
        &Sensors { scale_noise_m: 1e-7, torque_noise_nm: 0.05, ..Sensors::perfect() },
        &command,
        1,
    )
    .unwrap();
    let sd = |a: &[f64], b: &[f64]| {
        (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
    };
    assert!((sd(&exact.table_m, &noisy.table_m) / 1e-7 - 1.0).abs() < 0.1);
    assert!((sd(&exact.torque_nm, &noisy.torque_nm) / 0.05 - 1.0).abs() < 0.1);
    let usual = run(&axis, &Sensors::default(), &command, 1).unwrap();
    let on_grid = |value: f64, step: f64| ((value / step).round() * step - value).abs() < 1e-6 * step;
    assert!(usual.table_m.iter().all(|value| on_grid(*value, 50e-9)));
    assert!(usual.position_m.iter().all(|value| on_grid(*value, 0.016 / 1_048_576.0)));
    assert!(!exact.position_m.iter().all(|value| on_grid(*value, 0.016 / 1_048_576.0)));
}

#[test]
fn sets_contain_their_records() {
    let folder = tempfile::tempdir().unwrap();
    let short = |feed: f64| Feed { amplitude_m: 0.002, ramp_s: 0.1, periods: 1, ..Feed::of(feed) };
    let feeds = [short(1000.0), short(2500.0), short(6000.0)];
    write_sines(folder.path(), &Axis::x(), &Sensors::default(), &feeds, 5).unwrap();
    let manifest = std::fs::read_to_string(folder.path().join("manifest.toml")).unwrap();
    let manifest: toml::Table = manifest.parse().unwrap();
    assert_eq!(manifest["split"]["fit"], toml::Value::from(vec!["F1000", "F6000"]));
    let motion = manifest["motion"].as_array().unwrap();
    assert_eq!(
        motion.iter().map(|record| record["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["F1000", "F2500", "F6000"]
    );
    for (feed, record) in feeds.iter().zip(motion) {
        let text = std::fs::read_to_string(folder.path().join(record["file"].as_str().unwrap())).unwrap();
        assert_eq!(text.lines().next(), Some("time_s,command_m,position_m,table_m,torque_nm"));
        let command = feed.commands_m().unwrap();
        assert_eq!(text.lines().count(), 1 + command.len());
        let last: Vec<f64> =
            text.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!((last[0] - (command.len() - 1) as f64 * 1e-3).abs() < 1e-9);
        assert!((last[1] - command[command.len() - 1]).abs() < 1e-12);
        assert!((last[2] - last[1]).abs() < 1e-3 && (last[3] - last[2]).abs() < 2e-5);
    }

    let circles = [Circle { radius_m: 0.005, ramp_s: 0.1, revolutions: 1, ..Circle::of(600.0) }];
    write_circles(&folder.path().join("circle"), [&Axis::x(), &Axis::y()], &Sensors::default(), &circles, 5)
        .unwrap();
    let rows = |axis: &str| {
        std::fs::read_to_string(folder.path().join(format!("circle/{axis}/motion/circle-600.csv"))).unwrap()
    };
    assert_eq!(rows("x").lines().count(), rows("y").lines().count());
    assert_ne!(rows("x"), rows("y"));
}
