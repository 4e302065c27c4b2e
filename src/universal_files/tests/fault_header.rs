//! Faults in headers and in the companion datasets.

use super::*;

#[test]
fn blank_fields_are_zero() {
    let sample = Sample {
        locations: "    4         0    0         0 NONE               1   3\n".into(),
        form: "         2         4         1  0.00000E+00  5.00000E-01\n".into(),
        z: "\n".into(),
        ..Sample::default()
    };
    let record = sample.record();
    assert_eq!(record.header.reference, NodeLocation::default());
    warned!(record, WarningKind::BlankField { field: "reference node" });
    warned!(record, WarningKind::BlankField { field: "z axis value" });
    warned!(record, WarningKind::BlankField { field: "specific data type" }, line 13);
}

#[test]
fn headers_out_of_columns_are_split_at_blanks() {
    let sample = Sample {
        locations: "4 0 0 0 table 12 3 nut 3 -1\n".into(),
        form: "2 4 1 0.0 0.5 0.0\n".into(),
        abscissa: "18 0 0 0 Frequency  Hz\n".into(),
        ..Sample::default()
    };
    let record = sample.record();
    assert_eq!(
        record
            .header
            .warnings
            .iter()
            .filter(|warning| matches!(warning.kind, WarningKind::HeaderColumns))
            .count(),
        3
    );
    let header = &record.header;
    let sound = Sample::default().record().header;
    assert_eq!(
        (&header.response, &header.reference, &header.abscissa),
        (&sound.response, &sound.reference, &sound.abscissa)
    );
    assert_eq!(record.abscissa.values(), [0.0, 0.5, 1.0, 1.5]);
    let wide = Sample {
        form: "         2         4         1   0.0000000E+00   5.0000000E-01   0.0000000E+00\n".into(),
        ..Sample::default()
    };
    assert_eq!(wide.record().abscissa.values(), [0.0, 0.5, 1.0, 1.5]);
}

#[test]
fn invalid_headers_are_refused_with_field_and_line() {
    let refusals = [
        (Sample { form: form(7, 4, 1), ..Sample::default() }, "ordinate data type", 9),
        (Sample { form: form(2, 4, 2), ..Sample::default() }, "abscissa spacing", 9),
        (
            Sample { form: form(2, 4, 1).replace("         4", "        -4"), ..Sample::default() },
            "number of values",
            9,
        ),
        (
            Sample { form: form(2, 4, 1).replace("         4", "       4.5"), ..Sample::default() },
            "number of values",
            9,
        ),
        (Sample { locations: "FRF\n".into(), ..Sample::default() }, "function type", 8),
        (Sample { ordinate: "acceleration\n".into(), ..Sample::default() }, "specific data type", 11),
    ];
    for (sample, named, line) in refusals {
        let refusal = sample.refusal();
        assert!(
            matches!(&refusal, UniversalError::Field { field, place, .. } if *field == named && place.line == Some(line)),
            "{named}: {refusal}"
        );
    }
}

#[test]
fn characters_beyond_ascii_keep_their_columns() {
    let latin = "        12    0    0    0 Schwingstärke        m/s²\n"
        .chars()
        .map(|character| character as u8)
        .collect::<Vec<u8>>();
    let text = String::from_utf8(Sample::default().bytes()).unwrap();
    let (before, after) = text.split_once("        12    0    0    0 Acceleration         m/s^2\n").unwrap();
    let record = only(&[before.as_bytes(), &latin, after.as_bytes()].concat());
    assert_eq!(record.header.ordinate, RecordAxis::new(12, "Schwingstärke", "m/s²"));
    warned!(record, WarningKind::NonAscii { read_as: "Latin-1" }, line 11);
    let record = Sample {
        ordinate: "        12    0    0    0 Schwingstärke        m/s²\n".into(),
        ..Sample::default()
    }
    .record();
    assert_eq!(record.header.ordinate, RecordAxis::new(12, "Schwingstärke", "m/s²"));
    warned!(record, WarningKind::NonAscii { read_as: "UTF-8" });
}

#[test]
fn contradicting_entity_names_give_a_warning_and_are_kept() {
    let locations = "    4         0    0         0 1+Z                1   3 2:-X               2   1\n";
    let record = Sample { locations: locations.into(), ..Sample::default() }.record();
    assert_eq!(record.header.reference, NodeLocation { entity: "2:-X".into(), node: 2, direction: 1 });
    assert_eq!(record.header.warnings.len(), 1);
    warned!(record, WarningKind::EntityConflict { entity, node: 2, direction: 1 } if entity == "2:-X");
    let record =
        Sample { locations: locations.replace("1   3 2:-X", "1   9 NONE"), ..Sample::default() }.record();
    warned!(record, WarningKind::UnknownDirection { direction: 9 });
}

#[test]
fn blank_units_give_a_warning_with_the_units_in_force() {
    let blank = Sample {
        ordinate: "        12    0    0    0 NONE                 NONE\n".into(),
        ..Sample::default()
    };
    warned!(blank.record(), WarningKind::BlankUnit { axis: AxisName::Ordinate, units_in_force: false }, line 11);
    let units = b"    -1\n   164\n         5mm (milli newton)            2\n  1.0D+03  1.0D+03  1.0D+00\n  2.7315D+02\n    -1\n";
    let record = only(&[units, blank.bytes().as_slice()].concat());
    warned!(record, WarningKind::BlankUnit { axis: AxisName::Ordinate, units_in_force: true });
    let units = record.header.units.as_ref().unwrap();
    assert_eq!(
        (units.code, units.length_m(1500.0), units.force_n(500.0), units.temperature_offset),
        (5, 1.5, 0.5, 273.15)
    );
    assert_eq!(units.description, "mm (milli newton)");
}

#[test]
fn each_record_keeps_the_units_before_it() {
    let units = |factor: &str| {
        format!("    -1\n   164\n         9USER\n  {factor}  1.0D+00  1.0D+00\n  0.0D+00\n    -1\n")
    };
    let sample = Sample::default().bytes();
    let bytes =
        [&sample, units("1.0D+03").as_bytes(), &sample, units("1.0D+00").as_bytes(), &sample].concat();
    let file = read(&bytes).unwrap();
    let factors: Vec<_> = file
        .functions
        .iter()
        .map(|record| record.header.units.as_ref().map(|units| units.length_factor))
        .collect();
    assert_eq!(factors, [None, Some(1000.0), Some(1.0)]);
    assert_eq!(file.units.len(), 2);
}

#[test]
fn factors_that_contradict_their_code_give_a_warning_and_invalid_ones_are_refused() {
    let units = |length: &str| {
        format!("    -1\n   164\n         1SI\n  {length}  1.0D+00  1.0D+00\n  0.0D+00\n    -1\n")
    };
    let file = read(units("1.0D+03").as_bytes()).unwrap();
    assert!(
        matches!(
            file.warnings[..],
            [Warning { kind: WarningKind::UnitsConflict { code: 1, factor: "length", .. }, .. }]
        ),
        "{:?}",
        file.warnings
    );
    for length in ["0.0D+00", "-1.0", "1.0D+999", "metre"] {
        assert!(matches!(read(units(length).as_bytes()), Err(UniversalError::Field { .. })), "{length}");
    }
}

#[test]
fn nodes_and_trace_lines_are_read_by_count() {
    let text = "    -1\n    15\n         7         1         0         1    -1.00000    -1.00000    -1.00000\n    -1\n\
                    -1\n  2411\n         8         1         0         1\n    -1.0D+00  2.0D+00  -1\n    -1\n\
                    -1\n    82\n         1         9         8\nMassif\n         2         5         6         3         4         1         2         3\n         0         0\n    -1\n";
    let text = text.replace("\n                -1", "\n    -1").replace("\n-1", "\n    -1");
    let file = read(text.as_bytes()).unwrap();
    assert_eq!(file.warnings, []);
    assert_eq!(file.nodes.iter().map(|node| node.label).collect::<Vec<_>>(), [7, 8]);
    assert_eq!(file.nodes[0].position, [-1.0; 3]);
    assert_eq!((file.nodes[1].position, file.nodes[1].position_m()), ([-1.0, 2.0, -1.0], None));
    assert_eq!(file.trace_lines[0].name, "Massif");
    assert_eq!(file.trace_lines[0].nodes, [2, 5, 6, 3, 4, 1, 2, 3, 0]);
}

#[test]
fn thousands_of_tiny_datasets_are_refused() {
    let tiny = "    -1\n    58\n\n\n\n\n\n\n         2         1         1\n\n\n\n\n1\n    -1\n".repeat(3000);
    assert!(matches!(read(tiny.as_bytes()), Err(UniversalError::TooManySmall { .. })));
}

#[test]
fn a_file_header_with_missing_lines_is_tolerated() {
    let bytes =
        [b"    -1\n   151\nbench\nhammer test\n    -1\n", Sample::default().bytes().as_slice()].concat();
    let file = read(&bytes).unwrap();
    assert_eq!((file.headers[0].description.as_str(), file.headers[0].written.as_str()), ("hammer test", ""));
    assert!(
        matches!(
            file.warnings[..],
            [Warning { kind: WarningKind::ShortDataset { dataset: 151, missing: 5 }, .. }]
        ),
        "{:?}",
        file.warnings
    );
    assert_eq!(file.functions.len(), 1);
}
