//! Faults in binary payloads: sizes, precisions, line ends, sentinels.

use super::*;

const VALUES: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

#[test]
fn type_and_count_override_a_wrong_byte_count() {
    let record = Sample::binary(6, 4, 1, 32, doubles(&VALUES)).record();
    assert_eq!(complex(&record)[3], Complex64::new(7.0, 8.0));
    warned!(
        record,
        WarningKind::ByteCount { found: Some(32), used: 64, evidence: SizeEvidence::TypeAndCount }
    );
    assert_eq!(record.header.warnings.len(), 1);
}

#[test]
fn the_size_decides_the_precision() {
    let record = Sample::binary(5, 4, 1, 32, doubles(&VALUES)).record();
    assert_eq!(complex(&record)[3], Complex64::new(7.0, 8.0));
    assert_eq!(record.header.ordinate_type, OrdinateType::ComplexDouble);
    warned!(
        record,
        WarningKind::Precision {
            declared: OrdinateType::ComplexSingle,
            used: OrdinateType::ComplexDouble,
            ..
        }
    );
    let record = Sample::binary(4, 4, 1, 16, singles(&[1.0, 2.0, 3.0, 4.0])).record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, WarningKind::Precision { used: OrdinateType::RealSingle, .. });
}

#[test]
fn the_size_decides_the_width_of_an_uneven_abscissa() {
    let narrow: Vec<u8> = [(0.5_f32, 1.0_f64, 2.0_f64), (1.5, 3.0, 4.0)]
        .iter()
        .flat_map(|&(abscissa, re, im)| {
            [&abscissa.to_le_bytes()[..], &re.to_le_bytes(), &im.to_le_bytes()].concat()
        })
        .collect();
    let record = Sample::binary(6, 2, 0, 40, narrow).record();
    assert_eq!(record.abscissa, Abscissa::Uneven(vec![0.5, 1.5]));
    assert_eq!(complex(&record)[1], Complex64::new(3.0, 4.0));
    assert_eq!(record.header.warnings, []);
    let record = Sample::binary(6, 2, 0, 48, doubles(&[0.5, 1.0, 2.0, 1.5, 3.0, 4.0])).record();
    assert_eq!(record.abscissa, Abscissa::Uneven(vec![0.5, 1.5]));
    assert_eq!(complex(&record)[1], Complex64::new(3.0, 4.0));
    assert_eq!(record.header.warnings, []);
    let record = Sample::binary(6, 2, 0, 1234, doubles(&[0.5, 1.0, 2.0, 1.5, 3.0, 4.0])).record();
    assert_eq!(complex(&record)[1], Complex64::new(3.0, 4.0));
    warned!(record, WarningKind::WideAbscissa { .. });
}

#[test]
fn the_byte_count_overrides_a_wrong_count() {
    let record = Sample::binary(4, 99, 1, 64, doubles(&VALUES)).record();
    assert_eq!(real(&record), VALUES);
    warned!(record, WarningKind::ValueCount { declared: 99, found: 8, evidence: SizeEvidence::HeaderBytes });
}

#[test]
fn the_next_sentinel_decides_where_both_are_wrong() {
    let record = Sample::binary(4, 99, 1, 1234, doubles(&VALUES)).record();
    assert_eq!(real(&record), VALUES);
    warned!(record, WarningKind::ValueCount { declared: 99, found: 8, evidence: SizeEvidence::NextSentinel });
    warned!(
        record,
        WarningKind::ByteCount { found: Some(1234), used: 64, evidence: SizeEvidence::NextSentinel }
    );
}

#[test]
fn an_unexplained_size_is_refused() {
    let mut data = doubles(&VALUES);
    data.truncate(61);
    let refusal = Sample::binary(4, 8, 1, 64, data).refusal();
    assert!(
        matches!(
            refusal,
            UniversalError::PayloadSize { count: 8, expected: 64, header_bytes: Some(64), distance: 61, .. }
        ),
        "{refusal}"
    );
    let refusal = Sample::binary(4, 4, 1, 32, doubles(&VALUES[..7])).refusal();
    assert!(
        matches!(refusal, UniversalError::PayloadSize { distance: 56, .. }),
        "more values than declared: {refusal}"
    );
}

#[test]
fn line_ends_after_the_payload_are_skipped() {
    let mut data = doubles(&VALUES);
    data.extend(b"\r\n");
    let record = Sample::binary(4, 8, 1, 64, data.clone()).record();
    assert_eq!(real(&record), VALUES);
    warned!(record, WarningKind::StrayLineEnd { bytes: 2 });
    let record = Sample::binary(4, 8, 1, 66, data).record();
    warned!(record, WarningKind::ByteCount { found: Some(66), used: 64, .. });
}

#[test]
fn sentinels_and_line_ends_in_the_payload_are_data() {
    let data = b"    -1\n    -1\n    58\n\r\n\n\n\n".to_vec();
    assert_eq!(data.len(), 26);
    let data = [&data[..24], &8.0_f64.to_le_bytes()[..]].concat();
    let record = Sample::binary(4, 4, 1, 32, data).record();
    assert_eq!((real(&record).len(), real(&record)[3]), (4, 8.0));
    assert_eq!(record.header.warnings, []);
}

#[test]
fn a_file_truncated_in_the_payload_keeps_whole_values_if_the_header_is_consistent() {
    let truncated = |byte_count| Sample {
        closing: String::new(),
        ..Sample::binary(4, 8, 1, byte_count, doubles(&VALUES)[..45].to_vec())
    };
    let record = truncated(64).record();
    assert_eq!(real(&record), &VALUES[..5]);
    warned!(record, WarningKind::Truncated { declared: 8, found: 5 });
    assert!(matches!(truncated(32).refusal(), UniversalError::PayloadSize { .. }));
    let record = Sample { closing: String::new(), ..Sample::binary(4, 8, 1, 32, doubles(&VALUES)) }.record();
    assert_eq!(real(&record), VALUES);
    warned!(record, WarningKind::ByteCount { evidence: SizeEvidence::EndOfFile, .. });
    warned!(record, WarningKind::MissingClosing);
}

#[test]
fn foreign_floating_point_is_refused_by_name() {
    for (code, name) in [(1, "VMS"), (3, "IBM"), (7, "code 7")] {
        let mut sample = Sample::binary(4, 8, 1, 64, doubles(&VALUES));
        sample.first = sample.first.replacen("     2", &format!("{code:6}"), 1);
        let refusal = sample.refusal();
        assert!(
            matches!(refusal, UniversalError::FloatFormat { .. }) && refusal.to_string().contains(name),
            "{refusal}"
        );
    }
    let mut sample = Sample::binary(4, 8, 1, 64, doubles(&VALUES));
    sample.first = sample.first.replacen("     1", "     5", 1);
    assert!(matches!(sample.refusal(), UniversalError::Field { field: "byte order", .. }));
}

#[test]
fn values_that_are_not_finite_are_refused_with_their_offset() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut values = VALUES;
        values[5] = bad;
        let sample = Sample::binary(6, 4, 1, 64, doubles(&values));
        let payload = sample.bytes().len() - 7 - 64;
        let refusal = sample.refusal();
        assert!(
            matches!(&refusal, UniversalError::NotFinite { place, index: 2, .. } if place.byte == payload as u64 + 32),
            "{refusal}"
        );
    }
    let refusal = Sample::binary(4, 2, 0, 32, doubles(&[0.0, 1.0, f64::NAN, 2.0])).refusal();
    assert!(refusal.to_string().contains("on the abscissa"), "{refusal}");
}

#[test]
fn a_first_line_out_of_columns_is_split_at_blanks() {
    let mut sample = Sample::binary(4, 8, 1, 64, doubles(&VALUES));
    sample.first = "58b 1 2 11 64 0 0 0 0\n".into();
    let record = sample.record();
    assert_eq!(real(&record), VALUES);
    warned!(record, WarningKind::HeaderColumns);
    sample.first = "    58b     1     2          12\n".into();
    let record = sample.record();
    warned!(record, WarningKind::HeaderLines { found: 12 });
    warned!(record, WarningKind::ByteCount { found: None, used: 64, .. });
    sample.first = "    58b\n".into();
    assert!(matches!(sample.refusal(), UniversalError::Field { .. }));
}

#[test]
fn twice_the_values_are_another_type_and_refused() {
    let refusal = Sample::binary(4, 4, 1, 64, doubles(&VALUES)).refusal();
    assert!(
        matches!(refusal, UniversalError::PayloadSize { expected: 32, header_bytes: Some(64), .. }),
        "{refusal}"
    );
}
