//! Faults of the measuring chain are named with their number and record, and no effect of the structure with
//! them.

use std::f64::consts::TAU;

use assert_cmd::Command;
use jointid::{DiagnosisRequest, Study, read_machine};
use measurement::{FrfLine, MeasurementSet, read_set};
use num_complex::Complex64;
use numeric::distribution::clopper_pearson;
use numeric::random::normal;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use reference_simulator::{ChannelSet, Counts, Kind, Layout, Plan, generate_one, ordinary, write_case};
use serde_json::Value;
use test_data::draws;

/// Files spoilt in one way each, of two machines; nothing is wrong with the controls. Without a study every
/// other one: faults that `recover_faults_on_drawn_machines` then leaves out, and a control.
#[test]
#[ignore = "long"]
fn recover_faults_of_files() {
    let cases: [(&str, &str, &[&str]); 9] = [
        ("diagnose-polarity", "ok", &[]),
        ("diagnose-polarity", "neg", &["polarity"]),
        ("diagnose-polarity", "neg3", &["polarity@l3"]),
        ("diagnose-sensor-chain", "iepe05", &["high-pass"]),
        ("diagnose-conjugate", "conj", &["conjugate"]),
        ("unit-mistakes", "s_ok", &[]),
        ("unit-mistakes", "s_rad", &["frequency-scale"]),
        ("unit-mistakes", "s_mm", &["scale"]),
        ("diagnose-sensor-chain", "lp5k", &["low-pass"]),
    ];
    for (case, set, faults) in cases.into_iter().step_by(draws(2, 1) as usize) {
        let Some(folder) = test_data::shared(&format!("cases/{case}")) else { return };
        let machine = folder.join("machine.toml").display().to_string();
        let measurements = folder.join(set).display().to_string();
        let mut command = Command::cargo_bin("jointid").unwrap();
        command.args([
            "diagnose",
            "--json",
            "--quiet",
            "--no-cache",
            "--nulls",
            "20",
            "--measurements",
            &measurements,
        ]);
        command.args(if case == "unit-mistakes" {
            ["--config", &machine]
        } else {
            ["--positions", "l1,l3,l5"]
        });
        let found: Value = serde_json::from_slice(&command.output().unwrap().stdout).unwrap();
        let verdict = &found["verdict"];
        let named: Vec<&str> =
            verdict["faults"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        assert_eq!(
            (named.as_slice(), &verdict["effects"]),
            (faults, &serde_json::json!([])),
            "{case} {set}: {verdict:#}"
        );
        assert_eq!(
            verdict["kind"],
            if faults.is_empty() { "none" } else { "measurement" },
            "{case} {set}: {verdict:#}"
        );
    }
}

/// A fault: its id, with the record where it is one, and what it does to a line.
type Spoilt = (&'static str, fn(&FrfLine) -> FrfLine);

fn with_value(line: &FrfLine, factor: Complex64) -> FrfLine {
    FrfLine { value: line.value * factor, ..*line }
}

const SPOILT: [Spoilt; 17] = [
    ("polarity", |line| with_value(line, Complex64::new(-1.0, 0.0))),
    ("conjugate", |line| FrfLine { value: line.value.conj(), ..*line }),
    ("scale", |line| with_value(line, Complex64::new(1e3, 0.0))),
    ("scale", |line| with_value(line, Complex64::new(1.0 / 9.80665, 0.0))),
    ("frequency-scale", |line| FrfLine { frequency_hz: TAU * line.frequency_hz, ..*line }),
    ("low-pass", |line| with_value(line, Complex64::new(1.0, line.frequency_hz / 1500.0).inv())),
    ("high-pass", |line| with_value(line, Complex64::new(1.0, -8.0 / line.frequency_hz).inv())),
    ("polarity@l3", |line| with_value(line, Complex64::new(-1.0, 0.0))),
    ("conjugate@l3", |line| FrfLine { value: line.value.conj(), ..*line }),
    // A seismic sensor far below its resonance.
    ("mount-resonance", |line| {
        let along = line.frequency_hz / 3000.0;
        with_value(line, Complex64::new(1.0 - along * along, 2.0 * 0.03 * along).inv())
    }),
    ("polarity@l4", |line| with_value(line, Complex64::new(-1.0, 0.0))),
    ("frequency-scale@l3", |line| FrfLine { frequency_hz: 60.0 * line.frequency_hz, ..*line }),
    ("low-pass@l3", |line| with_value(line, Complex64::new(1.0, line.frequency_hz / 500.0).inv())),
    ("high-pass@l3", |line| with_value(line, Complex64::new(1.0, -8.0 / line.frequency_hz).inv())),
    ("frf-quantity@l5", |line| with_value(line, Complex64::new(0.0, TAU * line.frequency_hz))),
    ("mount-resonance@l4", |line| {
        let (along, ratio) = (line.frequency_hz / 300.0, 0.1);
        let damping = Complex64::new(0.0, 2.0 * ratio * along);
        with_value(line, (1.0 + damping) / (1.0 - along * along + damping))
    }),
    ("scale@l3", |line| with_value(line, Complex64::new(9.80665, 0.0))),
];

/// Returns kind, faults and effects of the verdict on a set.
pub fn verdict(machine: &str, set: MeasurementSet) -> (String, Vec<String>, Vec<String>) {
    let study = Study::new(read_machine(machine).unwrap(), set);
    let found = study.diagnose_with(&DiagnosisRequest { nulls: 20, ..DiagnosisRequest::default() }).unwrap();
    (found.verdict.kind.to_string(), found.verdict.faults, found.verdict.effects)
}

/// Drawn machines of finite elements, of which nothing is missing: each fault is named; where nothing is
/// wrong, none is.
///
/// Filters have their corner near the band; others differ from the model by less than tolerances and noise.
/// Of l1 to l6 every other one is fitted.
#[test]
#[ignore = "long"]
fn recover_faults_on_drawn_machines() {
    let (mut right, mut all, mut claimed, mut sound) = (0, 0, 0, 0);
    for number in 0..draws(1, 6) as usize {
        let simulated = ordinary(40_417, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        write_case(folder.path(), &simulated.case).unwrap();
        let machine = folder.path().join("machine.toml").display().to_string();
        let set = read_set(&folder.path().display().to_string()).unwrap();
        let (_, faults, _) = verdict(&machine, set.clone());
        (claimed, sound) = (claimed + usize::from(!faults.is_empty()), sound + 1);
        // Without a study four: a high pass and a mount on all records, a low pass and a mount on one.
        for (id, spoil) in SPOILT.into_iter().skip(draws(6, 0) as usize).step_by(draws(3, 1) as usize) {
            let mut other = set.clone();
            let record = id.split_once('@').map(|(_, record)| record);
            let concerns = |position: Option<usize>| {
                record.is_none_or(|name| position.is_some_and(|p| set.positions[p].name == name))
            };
            for frf in other.frfs.iter_mut().filter(|frf| concerns(frf.position)) {
                frf.lines.iter_mut().for_each(|line| *line = spoil(line));
            }
            let (kind, faults, effects) = verdict(&machine, other);
            // A factor is also the effect of a gain.
            let is_gain = id == "scale" && effects == ["frf-gain"];
            let is_right = (faults == [id] && kind == "measurement") || is_gain;
            (right, all) = (right + usize::from(is_right), all + 1);
            if !is_right {
                println!("machine {number}, {id}: {kind} {faults:?} {effects:?}");
            }
        }
    }
    recover_records_without_data_of_their_own();
    let interval = |part: usize, whole: usize| clopper_pearson(part, whole, 0.95).unwrap();
    println!(
        "{right} of {all} faults named ({:.2?}); claimed on {claimed} of {sound} sound sets",
        interval(right, all)
    );
    assert!(20 * (all - right) <= all && claimed == 0);
}

/// Faults of all records of the rotor, on a machine of which nothing is missing: each is named with its
/// channel.
#[test]
#[ignore = "long"]
fn recover_faults_of_one_channel() {
    let plan = Plan::on_layouts(&Counts::QUICK, 77, Some(Layout::Gantry));
    let index = plan
        .slots
        .iter()
        .position(|slot| slot.kind == Kind::Null && slot.channel_set == ChannelSet::Rotor)
        .unwrap();
    let (case, _) = generate_one(77, &plan, index).unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_case(folder.path(), &case).unwrap();
    let machine = folder.path().join("machine.toml").display().to_string();
    let set = read_set(&folder.path().display().to_string()).unwrap();
    assert_eq!(verdict(&machine, set.clone()).1, [""; 0]);
    let spoilt: [Spoilt; 4] = [
        SPOILT[0],
        SPOILT[1],
        ("low-pass", |line| with_value(line, Complex64::new(1.0, line.frequency_hz / 400.0).inv())),
        ("frf-quantity", |line| with_value(line, Complex64::new(0.0, TAU * line.frequency_hz))),
    ];
    for (id, spoil) in spoilt.into_iter().take(draws(1, 4) as usize) {
        let mut other = set.clone();
        for frf in other.frfs.iter_mut().filter(|frf| frf.response == "rotor") {
            frf.lines.iter_mut().for_each(|line| *line = spoil(line));
        }
        let (kind, faults, effects) = verdict(&machine, other);
        assert!(
            kind == "measurement" && faults == [format!("{id}@rotor")] && effects.is_empty(),
            "{id}: {kind} {faults:?} {effects:?}"
        );
    }
}

/// A record of noise, a copy of another record, and two of three held-out records at each other's positions are
/// named.
fn recover_records_without_data_of_their_own() {
    let simulated = ordinary(40_417, 0).unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_case(folder.path(), &simulated.case).unwrap();
    let machine = folder.path().join("machine.toml").display().to_string();
    let set = read_set(&folder.path().display().to_string()).unwrap();
    let at = |name: &str| {
        set.frfs.iter().position(|f| f.position.is_some_and(|p| set.positions[p].name == name)).unwrap()
    };
    let mut copied = set.clone();
    copied.frfs[at("l5")].lines = set.frfs[at("l1")].lines.clone();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut noise = set.clone();
    for line in &mut noise.frfs[at("l2")].lines {
        line.value = 1e-9 * Complex64::new(normal(&mut random), normal(&mut random));
    }
    let mut exchanged = set.clone();
    exchanged.frfs[at("l4")].lines.clone_from(&set.frfs[at("l6")].lines);
    exchanged.frfs[at("l6")].lines.clone_from(&set.frfs[at("l4")].lines);
    let cases = [
        (copied, &["copied-record@l5"][..]),
        (noise, &["noise@l2"]),
        (exchanged, &["swapped-records@l4", "swapped-records@l6"]),
    ];
    for (set, expected) in cases {
        let (kind, faults, effects) = verdict(&machine, set);
        assert!(
            kind == "measurement" && faults == expected && effects.is_empty(),
            "{kind} {faults:?} {effects:?}"
        );
    }
}
