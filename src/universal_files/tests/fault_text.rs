//! Faults in text payloads.

use super::*;

#[test]
fn the_padding_of_the_last_line_is_dropped() {
    let record =
        Sample::data("  1.00000E+00  2.00000E+00  3.00000E+00\n  4.00000E+00  0.00000E+00  0.00000E+00\n")
            .record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, WarningKind::PaddedLine { extra: 2 }, line 15);
}

#[test]
fn fortran_exponents_are_read() {
    let record = Sample::data("  1.00000D+00  2.00000d-01\n  3.0-105  -4.00000+100\n").record();
    assert_eq!(real(&record), [1.0, 0.2, 3e-105, -4e100]);
    warned!(record, WarningKind::ExponentLetter, line 14);
    warned!(record, WarningKind::ExponentBare, line 15);
}

#[test]
fn line_ends_of_every_kind_are_read() {
    for line_end in ["\r\n", "\r\r\n"] {
        let text = String::from_utf8(Sample::default().bytes()).unwrap().replace('\n', line_end);
        let record = only(text.as_bytes());
        assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(record.header.ordinate.unit, "m/s^2");
        assert_eq!(record.header.warnings, []);
    }
    let bare = String::from_utf8(Sample::default().bytes()).unwrap().replace('\n', "\r");
    assert!(matches!(read(bare.as_bytes()), Err(UniversalError::BareCarriageReturn)));
}

#[test]
fn blank_lines_among_the_data_are_skipped() {
    let record = Sample::data("\n  1.00000E+00  2.00000E+00\n\r\n  3.00000E+00  4.00000E+00\n").record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, WarningKind::BlankLine, line 14);
    let record = Sample::data("  1.0 2.0\n  3.0 4.0\n\n\n").record();
    assert_eq!(record.header.warnings.len(), 1);
}

#[test]
fn a_sentinel_among_the_data_is_a_value() {
    let record = Sample::data("  1.0\n    -1\n  3.0\n  4.0\n").record();
    assert_eq!(real(&record), [1.0, -1.0, 3.0, 4.0]);
    warned!(record, WarningKind::SentinelInData, line 15);
    let record = Sample::data("    -1.00000E+00\n    -1.00000E+00  2.0\n    -1 3.0\n").record();
    assert_eq!(real(&record), [-1.0, -1.0, 2.0, -1.0]);
}

#[test]
fn fewer_values_than_declared_give_a_warning() {
    let record = Sample { form: form(2, 2_508_876, 1), ..Sample::default() }.record();
    assert_eq!((record.header.count, record.abscissa.len()), (4, 4));
    warned!(
        record,
        WarningKind::ValueCount { declared: 2_508_876, found: 4, evidence: SizeEvidence::NextSentinel }
    );
}

#[test]
fn data_beyond_the_declared_count_are_refused() {
    let refusal = Sample { form: form(2, 3, 1), ..Sample::default() }.refusal();
    assert!(
        matches!(&refusal, UniversalError::DataGoOn { declared: 3, place, .. } if place.line == Some(15)),
        "{refusal}"
    );
    let text = refusal.to_string();
    assert!(text.contains("4.00000E+00") && text.contains("line 15"), "{text}");
}

#[test]
fn real_data_under_a_complex_type_are_refused() {
    let refusal = Sample { form: form(5, 4, 1), ..Sample::default() }.refusal();
    assert!(
        matches!(refusal, UniversalError::NumbersPerValue { found: 4, declared: 4, needed: 2, .. }),
        "{refusal}"
    );
    let refusal = Sample { form: form(2, 4, 0), ..Sample::default() }.refusal();
    assert!(
        matches!(refusal, UniversalError::NumbersPerValue { found: 4, declared: 4, needed: 2, .. }),
        "{refusal}"
    );
}

#[test]
fn a_blank_field_that_would_shift_the_data_is_refused() {
    let refusal =
        Sample::data("  1.00000E+00  2.00000E+00\n               3.00000E+00\n  4.0\n").data_refusal(5);
    assert!(
        matches!(&refusal, UniversalError::ShortLine { place, found: 1, expected: 2 } if place.line == Some(15)),
        "{refusal}"
    );
}

impl Sample {
    fn data_refusal(self, count: usize) -> UniversalError {
        Self { form: form(2, count, 1), ..self }.refusal()
    }
}

#[test]
fn text_that_is_not_a_number_is_refused_with_its_column() {
    let refusal = Sample::data("  1.00000E+00  2,00000E+00  3.0 4.0\n").refusal();
    assert!(
        matches!(&refusal, UniversalError::NotANumber { place, column: 16, found } if place.line == Some(14) && found == "2,00000E+00")
    );
    let refusal = Sample::data("  1.00000E+00*************  3.0 4.0\n").refusal();
    assert!(matches!(refusal, UniversalError::NotANumber { .. }), "{refusal}");
}

/// Reads the only record of a file, with missing values as NaN.
fn with_missing(bytes: &[u8]) -> UniversalRecord {
    let (mut file, refused) = read_sound(bytes).unwrap();
    assert!(refused.is_empty() && file.functions.len() == 1, "{refused:?}");
    file.functions.remove(0)
}

#[test]
fn overflown_fields_that_touch_cost_their_values_alone() {
    let stars = "*".repeat(13);
    let sample =
        |data: String, count: usize| Sample { form: form(2, count, 1), ..Sample::data(&data) }.bytes();
    for (line, missing) in [
        (format!("  1.00000E+00{stars}  3.00000E+00\n"), vec![1]),
        (format!("{stars}  2.00000E+00{stars}\n"), vec![0, 2]),
        (format!("  1.00000E+00{stars}{stars}\n"), vec![1, 2]),
        (format!("{stars}{stars}{stars}  \r\n"), vec![0, 1, 2]),
    ] {
        let record = with_missing(&sample(line.clone(), 3));
        for (at, value) in real(&record).iter().enumerate() {
            let expected = if missing.contains(&at) { f64::NAN } else { 1.0 + at as f64 };
            assert!(
                *value == expected || (value.is_nan() && expected.is_nan()),
                "{line}: {:?}",
                real(&record)
            );
        }
        assert!(read(&sample(line, 3)).is_err(), "without missing values");
    }
    // 26 asterisks outside the columns may be one field or two.
    let (file, refused) = read_sound(&sample(format!("1.0 {}{} 3.0\n", stars, stars), 4)).unwrap();
    assert!(file.functions.is_empty() && refused[0].to_string().contains("is not a number"), "{refused:?}");
    // Double precision: fields of 20.
    let double = format!("  1.000000000000E+00{}  3.000000000000E+00\n", "*".repeat(20));
    let record = with_missing(&Sample { form: form(4, 3, 1), ..Sample::data(&double) }.bytes());
    assert!(real(&record)[1].is_nan() && real(&record)[2] == 3.0, "{:?}", real(&record));
    // Uneven: an abscissa of 13 before each value of 20.
    let uneven = format!("  1.00000E+00{}  2.00000E+00  4.000000000000E+00\n", "*".repeat(20));
    let record = with_missing(&Sample { form: form(4, 2, 0), ..Sample::data(&uneven) }.bytes());
    assert!(real(&record)[0].is_nan() && real(&record)[1] == 4.0, "{:?}", real(&record));
}

#[test]
fn asterisks_in_a_header_cost_their_field_alone() {
    let locations = format!("    4{} table             12   3 nut                3  -1\n", "*".repeat(25));
    let sample = Sample { locations, ..Sample::default() };
    let record = with_missing(&sample.bytes());
    assert_eq!(
        (record.header.version, record.header.response.node, record.header.response.direction),
        (0, 12, 3)
    );
    let said: Vec<String> = record.header.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(said.iter().filter(|text| text.contains("is asterisks")).count(), 3, "{said:?}");
    assert!(read(&sample.bytes()).is_err());
    // A node without a position leaves the others.
    let node = |label: &str, x: &str| {
        format!("{label:>10}         0         0        11{x:>13}  0.00000E+00  0.00000E+00\n")
    };
    let nodes = format!("    -1\n    15\n{}{}    -1\n", node("1", &"*".repeat(13)), node("2", "5.00000E-01"));
    let (file, refused) = read_sound(nodes.as_bytes()).unwrap();
    assert!(refused.is_empty() && file.nodes.len() == 1 && file.nodes[0].label == 2, "{file:?}");
    assert!(
        file.warnings.iter().any(|w| w.to_string().contains("the node is left out")),
        "{:?}",
        file.warnings
    );
}

#[test]
fn values_that_are_not_finite_are_refused_by_name() {
    for (text, found) in
        [("NaN", "NaN"), ("-Infinity", "-Infinity"), ("1.#QNAN", "1.#QNAN"), ("1.0E+400", "1.0E+400")]
    {
        let refusal = Sample::data(&format!("  1.0 2.0\n  {text} 4.0\n")).refusal();
        assert!(
            matches!(&refusal, UniversalError::NotFinite { place, index: 2, found: text_found } if place.line == Some(15) && text_found == found),
            "{text}: {refusal}"
        );
    }
}

#[test]
fn a_file_truncated_in_the_data_keeps_whole_values() {
    let sample =
        Sample { closing: String::new(), ..Sample::data("  1.00000E+00  2.00000E+00\n  3.00000E+0") };
    let record = sample.record();
    assert_eq!(real(&record), [1.0, 2.0]);
    warned!(record, WarningKind::Truncated { declared: 4, found: 2 });
    let record = Sample { closing: String::new(), ..Sample::default() }.record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, WarningKind::MissingClosing);
}

#[test]
fn a_record_without_values_gives_a_warning() {
    let record = Sample { form: form(2, 0, 1), ..Sample::data("") }.record();
    assert!(record.ordinate.is_empty());
    warned!(record, WarningKind::NoValues);
}

#[test]
fn unusual_abscissas_give_warnings() {
    let sample = |data: &str| Sample { form: form(2, 4, 0), ..Sample::data(data) }.record();
    let record = sample("  -1.0 1 -0.5 2 -0.5 3 -0.75 4\n");
    assert_eq!(record.abscissa.values(), [-1.0, -0.5, -0.5, -0.75]);
    warned!(record, WarningKind::NegativeAbscissa { count: 4, index: 0, .. });
    warned!(record, WarningKind::RepeatedAbscissa { count: 1, index: 2, .. });
    warned!(record, WarningKind::FallingAbscissa { count: 1, index: 3, .. });
    let record =
        Sample { form: form(2, 4, 1).replace("5.00000E-01", "0.00000E+00"), ..Sample::default() }.record();
    warned!(record, WarningKind::RepeatedAbscissa { count: 3, index: 1, .. });
}

#[test]
fn an_endless_line_is_refused() {
    let refusal = Sample::data(&"1.0 ".repeat(400_000)).refusal();
    assert!(matches!(refusal, UniversalError::LineTooLong { .. }), "{refusal}");
}

#[test]
fn a_sentinel_in_other_columns_ends_the_data() {
    let record = Sample { closing: "-1\n".into(), ..Sample::default() }.record();
    warned!(record, WarningKind::SentinelColumns, line 16);
}
