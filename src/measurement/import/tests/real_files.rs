//! Files of real instruments, which are not part of the project.

use std::fs::File;
use std::path::PathBuf;

use num_complex::Complex64;
use universal_files::{
    Ordinate, Skipped, UniversalFile, UniversalReader, UniversalRecord, Warning, WarningKind, data_type,
    function_type, read, read_headers,
};

/// Returns real ordinate values.
fn real(record: &UniversalRecord) -> &[f64] {
    match &record.ordinate {
        Ordinate::Real(values) => values,
        Ordinate::Complex(_) => panic!("complex"),
    }
}

/// Returns complex ordinate values.
fn complex(record: &UniversalRecord) -> &[Complex64] {
    match &record.ordinate {
        Ordinate::Complex(values) => values,
        Ordinate::Real(_) => panic!("real"),
    }
}

/// Returns the folder of real files, if it exists.
fn folder() -> Option<PathBuf> {
    test_data::shared("realdata/uff")
}

#[test]
fn published_beam_measurement_is_three_accelerances() {
    let Some(folder) = folder() else { return };
    let file = read(File::open(folder.join("measurement.uff")).unwrap()).unwrap();
    assert_eq!(file.functions.len(), 3);
    for (index, record) in file.functions.iter().enumerate() {
        let header = &record.header;
        assert_eq!(header.function_type, function_type::FREQUENCY_RESPONSE);
        assert_eq!(
            (header.ordinate.data_type, header.denominator.data_type),
            (data_type::ACCELERATION, data_type::EXCITATION_FORCE)
        );
        assert_eq!((header.response.node, header.reference.node), (1, index as i64 + 1));
        assert_eq!(
            (record.abscissa.at(0), record.abscissa.at(1000), record.abscissa.at(1001)),
            (Some(0.0), Some(1000.0), None)
        );
        assert!(
            header
                .warnings
                .iter()
                .all(|warning| matches!(warning.kind, WarningKind::BlankUnit { units_in_force: false, .. }))
        );
        let values = complex(record);
        assert_eq!(values.len(), 1001);
        let peak_hz = (40..100).max_by(|&a, &b| values[a].norm().total_cmp(&values[b].norm())).unwrap();
        assert!((50..=53).contains(&peak_hz), "first mode 51.5 Hz, peak at {peak_hz} Hz");
        let text = std::fs::read_to_string(folder.join(format!("meas_point_{}.txt", index + 1))).unwrap();
        for (line, value) in text.lines().zip(values).skip(1) {
            let line = line.trim_matches(['(', ')', 'j']);
            let split = line
                .rfind(['+', '-'])
                .map(|at| if line[..at].ends_with('e') { line[..at].rfind(['+', '-']).unwrap() } else { at });
            let (re, im) = line.split_at(split.unwrap());
            let published = Complex64::new(re.parse().unwrap(), im.parse().unwrap());
            assert!((value - published).norm() < 1e-11 * published.norm(), "{line} {value}");
        }
    }
}

#[test]
fn all_real_files_are_read_and_their_faults_reported() {
    let Some(folder) = folder() else { return };
    let file = |name: &str| read(File::open(folder.join(name)).unwrap()).unwrap();
    let counts =
        |file: &UniversalFile| file.functions.iter().map(|record| record.header.count).collect::<Vec<_>>();

    let vibration = file("MPSTD#Set001_2024_10_08_10_27_07.uff");
    assert_eq!(counts(&vibration), [222_400; 4]);
    assert!(vibration.functions.iter().all(|record| matches!(
        record.header.warnings[..],
        [Warning { kind: WarningKind::StrayLineEnd { bytes: 2 }, .. }]
    )));

    let (text, binary) = (file("Sample_UFF58_ascii.uff"), file("Sample_UFF58b_bin.uff"));
    for (text, binary) in real(&text.functions[0]).iter().zip(real(&binary.functions[0])) {
        assert!((text - binary).abs() <= 5.1e-6 * binary.abs(), "{text} {binary}");
    }
    assert_eq!((counts(&text), counts(&binary)), (vec![79_292], vec![79_292]));
    assert_eq!(counts(&file("binary8byte.uff")), [250]);

    let truncated = &file("dataset_milestone_in_header.uff").functions[0];
    let is_cut = |warning: &Warning| {
        matches!(warning.kind, WarningKind::ValueCount { declared: 2_508_876, found: 42, .. })
    };
    assert!(truncated.header.warnings.iter().any(is_cut), "{:?}", truncated.header.warnings);
    let latin = &file("non_ascii_header.uff").functions[0];
    assert_eq!(latin.header.ordinate.unit(), Some("(1/N)*(m/s²)"));
    let spectrum = &file("sample_dataset58_psd.uff").functions[0];
    assert_eq!(
        (spectrum.header.count, spectrum.header.even, spectrum.abscissa.at(3200)),
        (3201, false, Some(3200.0))
    );
    assert_eq!(real(&file("time-history-not-all-columns-filled.uff").functions[0])[12], -5.84096);

    let model = file("TestLab 161 164 18 15 82.uff");
    assert_eq!(
        (model.nodes.len(), model.trace_lines.len(), model.headers.len(), model.units.len()),
        (36, 3, 1, 1)
    );
    assert_eq!(model.trace_lines.iter().map(|line| line.nodes.len()).collect::<Vec<_>>(), [9, 32, 11]);
    assert!(matches!(model.skipped[..], [Skipped { number: 18, times: 1, .. }]));
    let engine = file("heat_engine_housing.uff");
    assert_eq!((engine.units[0].code, engine.units[0].length_factor, engine.nodes.len()), (5, 1000.0, 10));
    assert!((engine.nodes[0].position_m().unwrap()[0] + 0.171_175_567_6).abs() < 1e-9);
    assert_eq!(file("groups_test.uff").nodes.len(), 74);
    assert_eq!(file("mesh_Oros-modal_uff15_uff2412.uff").nodes.len(), 96);
}

#[test]
fn headers_of_all_real_files_match_their_records() {
    let Some(folder) = folder() else { return };
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let open = || File::open(&path).unwrap();
        let (Ok(full), Ok(heads)) = (read(open()), read_headers(open())) else {
            assert!(path.extension().is_some_and(|extension| extension == "txt"), "{}", path.display());
            continue;
        };
        assert_eq!(full.functions.len(), heads.functions.len());
        let mut reader = UniversalReader::new(open()).unwrap();
        for (record, head) in full.functions.iter().zip(&heads.functions) {
            assert_eq!(&reader.record(head).unwrap(), record, "{}", path.display());
        }
    }
}
