//! Tests of the reference simulator: elements against closed forms, physics, the statistics of the hammer
//! test, cases.

mod case;
mod chain;
mod element;
mod hammer;
mod layout;
mod physics;

use std::collections::BTreeSet;
use std::path::Path;

use super::case::{Kind, Label, Subject, labels_json};
use super::draw::Draw;
use super::hammer::setting::Setting;
use super::machine::catalogue::{any_size, bench};
use super::machine::nuisance::Nuisance;

/// The published bench (even seeds) or a machine of any size, with nuisance parameters.
fn subject(seed: u64) -> Subject {
    let mut draw = Draw::new(seed);
    let drawn = if seed.is_multiple_of(2) { bench(true, &mut draw) } else { any_size(true, &mut draw) };
    let nuisance = Nuisance::random(drawn.nut_m.len(), &mut draw);
    Subject { drawn, nuisance, effects: Vec::new() }
}

/// Usual settings of a test for a band.
fn setting(band_hz: f64) -> Setting {
    Setting {
        rate_hz: Setting::rate_for(band_hz),
        samples: 16384,
        band_hz,
        averages: 8,
        width_s: 1.1 / band_hz,
        noise: 0.03,
        noise_corner_hz: 2.0,
    }
}

/// Checks properties of every label, by the kind of the case and the number of its effects.
pub(crate) fn check_label(label: &Label, kind: Kind, effects: usize, has_follow_up: bool) {
    assert_eq!(label.kind, kind);
    for count in [label.effects.len(), label.places.len(), label.noncentrality.len(), label.values.len()] {
        assert_eq!(count, effects);
    }
    assert_eq!(has_follow_up, kind == Kind::LookAlike);
    assert_eq!(label.fault.is_some(), kind == Kind::HardNullBadChannel);
    assert_eq!(label.faulty_records.is_empty(), kind != Kind::HardNullBadChannel);
    assert_eq!(label.wrong_parameter.is_some(), kind == Kind::HardNullWrongParameter);
}

/// Checks that a case's folder has the records' folder and two files without information from the label, and
/// returns the texts of manifest and machine file. The label must survive a round trip through JSON.
pub(crate) fn check_folder(place: &Path, records: &str, label: &Label) -> [String; 2] {
    let entries = std::fs::read_dir(place).unwrap();
    let names: BTreeSet<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(names, ["machine.toml", "manifest.toml", records].map(str::to_owned).into());
    let texts =
        ["manifest.toml", "machine.toml"].map(|name| std::fs::read_to_string(place.join(name)).unwrap());
    for text in &texts {
        for effect in &label.effects {
            assert!(!text.contains(effect.as_str()), "{effect} in {text}");
        }
        assert!(!text.contains("seed") && !text.replace("of this size", "").contains("size"));
    }
    let back: Vec<Label> = serde_json::from_str(&labels_json(std::slice::from_ref(label)).unwrap()).unwrap();
    assert_eq!(back[0], Label { exact: Vec::new(), ..label.clone() });
    texts
}
