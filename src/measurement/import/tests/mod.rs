//! Inputs with right values from `../shared/cases`, read by the library alone.

mod real_files;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::ErrorKind;

use num_complex::Complex64;

use super::*;
use crate::{Quantity, read_set_with};
use universal_files::read_sound;

/// Accelerance of 10 kg on 100 Hz with 2 % damping, the truth of all cases.
fn truth(frequency_hz: f64) -> Complex64 {
    let (omega, natural) = (std::f64::consts::TAU * frequency_hz, std::f64::consts::TAU * 100.0);
    -omega * omega / (10.0 * Complex64::new(natural * natural - omega * omega, 0.04 * natural * omega))
}

/// Returns the line of the cases, 0.5 Hz apart, that a frequency stands for.
fn nearest_line(frequency_hz: f64) -> f64 {
    let line = (2.0 * frequency_hz).round() / 2.0;
    assert!((frequency_hz - line).abs() < 2e-6 * line, "{frequency_hz}");
    line
}

/// Reads a case: FRFs and all that is said, or the refusal.
fn read(case: &str) -> Option<Result<(Vec<ImportedFrf>, String), String>> {
    let path = test_data::shared(&format!("cases/{case}"))?;
    if path.extension().is_some_and(|e| e == "csv") {
        let quantity = if case.contains("mixed") { Quantity::Receptance } else { Quantity::Accelerance };
        let request = TableRequest { quantity: Some(quantity), ..TableRequest::default() };
        let frfs = frfs_from_table(case, "a", &decoded(std::fs::read(path).unwrap()), &request)
            .map_err(|e| e.to_string());
        return Some(frfs.map(|frfs| {
            let said = frfs.iter().flat_map(|f| f.warnings.clone()).collect::<Vec<_>>().join("\n");
            (frfs, said)
        }));
    }
    let (file, refused) = read_sound(File::open(path).unwrap(), is_of_frf).unwrap();
    let of_file = frfs_from_universal(case, "a", file, None, false).map_err(|e| e.to_string());
    Some(of_file.map(|(frfs, notes)| {
        let left_out = refused.iter().map(ToString::to_string);
        let said = left_out
            .chain(notes)
            .chain(frfs.iter().flat_map(|f| f.warnings.clone()))
            .collect::<Vec<_>>()
            .join("\n");
        (frfs, said)
    }))
}

#[test]
fn limit_cases_give_their_right_values() {
    for (case, factor, word) in [
        ("uff-negative-direction-mapped/tap.uff", -1.0, ""),
        ("uff-abscissa-unit/rad.uff", 1.0, ""),
        ("uff-abscissa-unit/rpm.uff", 1.0, ""),
        ("uff-unit-not-understood/gs.uff", 1.0, ""),
        ("uff-unit-not-understood/g-per-n.uff", 1.0, "«g/N» contains the denominator"),
        ("uff-unit-not-understood/meganewton.uff", 1.0, ""),
        ("uff-164-against-label/mm-164-label-m.uff", 1e-3, "dataset 164 is used"),
        ("uff-force-over-response/apparent-mass.uff", 1.0, "reciprocal"),
        ("uff-broken-neighbour-blocks-import/nodes-2411-one-line.uff", 1.0, "dataset 2411"),
        ("uff-broken-neighbour-blocks-import/time-record-of-type-0.uff", 1.0, "ordinate data type"),
        ("uff-broken-neighbour-blocks-import/units-164-blank.uff", 1.0, "unit factors is `blank`"),
        ("uff-coherence-of-another-record/node0.uff", 1.0, "paired in spite of"),
        ("uff-coherence-of-another-record/repeats.uff", 1.0, ""),
        ("nan-at-0-hz/frf.uff", 1.0, ""),
        ("nan-at-0-hz/frf.csv", 1.0, ""),
        // The excess is at 0 Hz, a line that is dropped.
        ("nan-at-0-hz/coherence-1.00001.uff", 1.0, ""),
        ("csv-unit-in-column-name/rad.csv", 1.0, ""),
        ("csv-units-of-real-and-imag-differ/mixed.csv", 1.0, ""),
        ("csv-several-frfs-in-one-table/two.csv", 1.0, ""),
    ] {
        let Some(found) = read(case) else { return };
        let (frfs, said) = found.unwrap_or_else(|fault| panic!("{case}: {fault}"));
        assert!(said.contains(word), "{case}: {said}");
        for (at, frf) in frfs.iter().enumerate() {
            assert_eq!(frf.frequency_hz.len(), 400, "{case}");
            for (f, value) in frf.frequency_hz.iter().zip(&frf.values) {
                // Headers state steps with six digits.
                let f = &nearest_line(*f);
                let omega = std::f64::consts::TAU * f;
                let of_quantity = if frf.quantity == Quantity::Receptance { -omega * omega } else { 1.0 };
                // The second FRF of these files is a multiple of the first.
                let multiple = if case.contains("two.csv") {
                    2.0
                } else if case.contains("repeats") {
                    1.1
                } else {
                    1.0
                };
                let several = if at == 1 { multiple } else { 1.0 };
                let expected = truth(*f) * factor * several / of_quantity;
                assert!(
                    (value - expected).norm() < 2e-5 * expected.norm(),
                    "{case}, {f} Hz: {value} for {expected}; {said}"
                );
            }
        }
    }
}

#[test]
fn limit_repeats_have_their_own_coherences() {
    let Some(found) = read("uff-coherence-of-another-record/repeats.uff") else { return };
    let (frfs, _) = found.unwrap();
    let first: Vec<f64> = frfs.iter().map(|f| f.coherence.as_ref().unwrap()[0]).collect();
    assert_eq!(first, [0.97, 0.485]);
}

#[test]
fn cases_without_force_or_frequency_are_refused() {
    for (case, word) in [
        ("uff-abscissa-unit/time.uff", "not a frequency"),
        ("uff-force-over-response/transmissibility.uff", "transmissibility"),
    ] {
        let Some(found) = read(case) else { return };
        let fault = found.unwrap_err();
        assert!(fault.contains(word), "{case}: {fault}");
    }
}

/// A set in memory is the set that its files give, with the same contents of files.
#[test]
fn imported_frfs_are_read_as_their_files_are() {
    let frf =
        |name: &str, quantity, coherence: Option<Vec<f64>>, relative_sd: Option<Vec<f64>>| ImportedFrf {
            name: name.into(),
            source: "tap.uff".into(),
            texts: Vec::new(),
            response: "7:+Z".into(),
            excitation: "table".into(),
            response_direction: 3,
            excitation_direction: 0,
            by_torque: false,
            quantity,
            frequency_hz: vec![0.1, 1.0 / 3.0, 2e2],
            values: vec![
                Complex64::new(1.0 / 3.0, -0.0),
                Complex64::new(-1e-300, 2e-9),
                Complex64::new(3.0, 4.0),
            ],
            coherence,
            relative_sd,
            dropped: 0,
            warnings: Vec::new(),
        };
    let placed = vec![
        (frf("a b", Quantity::Receptance, Some(vec![0.9, f64::NAN, 0.7]), None), Placement::default()),
        (
            frf("A-b", Quantity::Mobility, None, Some(vec![1e-3, f64::NAN, 0.1])),
            Placement { position: Some("p «1»".into()), response: Some("nut".into()), excitation: None },
        ),
        (frf("c", Quantity::Accelerance, None, None), Placement::default()),
    ];
    let nuts_m = BTreeMap::from([("p «1»".to_string(), 0.1 + 0.2)]);
    for averages in [None, Some(4)] {
        let files: BTreeMap<String, String> = set_files("a\ttitle", &placed, &nuts_m, averages).collect();
        let read =
            |name: &str| files.get(name).map(|t| t.clone().into_bytes()).ok_or(ErrorKind::NotFound.into());
        let from_files = read_set_with("tap.uff", read).unwrap();
        let in_memory =
            set_of("tap.uff", "a\ttitle", placed.clone(), &nuts_m, averages).unwrap().with_noise();
        assert_eq!(in_memory, from_files);
        assert_eq!(in_memory.files.len(), 4);
    }
    let low = vec![(frf("a", Quantity::Receptance, Some(vec![0.1; 3]), None), Placement::default())];
    let refused = set_of("tap.uff", "title", low, &nuts_m, Some(4)).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "tap.uff/frf/a.csv: no line has a coherence of 0.8 or more; measure again"
    );
}
