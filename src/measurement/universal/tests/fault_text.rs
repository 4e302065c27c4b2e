//! Faults in text payloads.

use super::*;

#[test]
fn the_padding_of_the_last_line_is_dropped() {
    let record = Sample::data("  1.00000E+00  2.00000E+00  3.00000E+00\n  4.00000E+00  0.00000E+00  0.00000E+00\n").record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, Warning::PaddedLine { extra: 2, place } if place.line == Some(15));
}

#[test]
fn fortran_exponents_are_read() {
    let record = Sample::data("  1.00000D+00  2.00000d-01\n  3.0-105  -4.00000+100\n").record();
    assert_eq!(real(&record), [1.0, 0.2, 3e-105, -4e100]);
    warned!(record, Warning::ExponentLetter { place } if place.line == Some(14));
    warned!(record, Warning::ExponentBare { place } if place.line == Some(15));
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
    warned!(record, Warning::BlankLine { place } if place.line == Some(14));
    let record = Sample::data("  1.0 2.0\n  3.0 4.0\n\n\n").record();
    assert_eq!(record.header.warnings.len(), 1);
}

#[test]
fn a_sentinel_among_the_data_is_a_value() {
    let record = Sample::data("  1.0\n    -1\n  3.0\n  4.0\n").record();
    assert_eq!(real(&record), [1.0, -1.0, 3.0, 4.0]);
    warned!(record, Warning::SentinelInData { place } if place.line == Some(15));
    let record = Sample::data("    -1.00000E+00\n    -1.00000E+00  2.0\n    -1 3.0\n").record();
    assert_eq!(real(&record), [-1.0, -1.0, 2.0, -1.0]);
}

#[test]
fn fewer_values_than_declared_give_a_warning() {
    let record = Sample { form: form(2, 2_508_876, 1), ..Sample::default() }.record();
    assert_eq!((record.header.count, record.abscissa.len()), (4, 4));
    warned!(record, Warning::ValueCount { declared: 2_508_876, found: 4, evidence: SizeEvidence::NextSentinel, .. });
}

#[test]
fn data_beyond_the_declared_count_are_refused() {
    let refusal = Sample { form: form(2, 3, 1), ..Sample::default() }.refusal();
    assert!(matches!(&refusal, UniversalError::DataGoOn { declared: 3, place, .. } if place.line == Some(15)), "{refusal}");
    let text = refusal.to_string();
    assert!(text.contains("4.00000E+00") && text.contains("line 15"), "{text}");
}

#[test]
fn real_data_under_a_complex_type_are_refused() {
    let refusal = Sample { form: form(5, 4, 1), ..Sample::default() }.refusal();
    assert!(matches!(refusal, UniversalError::NumbersPerValue { found: 4, declared: 4, needed: 2, .. }), "{refusal}");
    let refusal = Sample { form: form(2, 4, 0), ..Sample::default() }.refusal();
    assert!(matches!(refusal, UniversalError::NumbersPerValue { found: 4, declared: 4, needed: 2, .. }), "{refusal}");
}

#[test]
fn a_blank_field_that_would_shift_the_data_is_refused() {
    let refusal = Sample::data("  1.00000E+00  2.00000E+00\n               3.00000E+00\n  4.0\n").data_refusal(5);
    assert!(matches!(&refusal, UniversalError::ShortLine { place, found: 1, expected: 2 } if place.line == Some(15)), "{refusal}");
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

#[test]
fn values_that_are_not_finite_are_refused_by_name() {
    for (text, found) in [("NaN", "NaN"), ("-Infinity", "-Infinity"), ("1.#QNAN", "1.#QNAN"), ("1.0E+400", "1.0E+400")] {
        let refusal = Sample::data(&format!("  1.0 2.0\n  {text} 4.0\n")).refusal();
        assert!(
            matches!(&refusal, UniversalError::NotFinite { place, index: 2, found: text_found } if place.line == Some(15) && text_found == found),
            "{text}: {refusal}"
        );
    }
}

#[test]
fn a_file_truncated_in_the_data_keeps_whole_values() {
    let sample = Sample { closing: String::new(), ..Sample::data("  1.00000E+00  2.00000E+00\n  3.00000E+0") };
    let record = sample.record();
    assert_eq!(real(&record), [1.0, 2.0]);
    warned!(record, Warning::Truncated { declared: 4, found: 2, .. });
    let record = Sample { closing: String::new(), ..Sample::default() }.record();
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    warned!(record, Warning::MissingClosing { .. });
}

#[test]
fn a_record_without_values_gives_a_warning() {
    let record = Sample { form: form(2, 0, 1), ..Sample::data("") }.record();
    assert!(record.ordinate.is_empty());
    warned!(record, Warning::NoValues { .. });
}

#[test]
fn unusual_abscissas_give_warnings() {
    let sample = |data: &str| Sample { form: form(2, 4, 0), ..Sample::data(data) }.record();
    let record = sample("  -1.0 1 -0.5 2 -0.5 3 -0.75 4\n");
    assert_eq!(record.abscissa.values(), [-1.0, -0.5, -0.5, -0.75]);
    warned!(record, Warning::NegativeAbscissa { count: 4, index: 0, .. });
    warned!(record, Warning::RepeatedAbscissa { count: 1, index: 2, .. });
    warned!(record, Warning::FallingAbscissa { count: 1, index: 3, .. });
    let record = Sample { form: form(2, 4, 1).replace("5.00000E-01", "0.00000E+00"), ..Sample::default() }.record();
    warned!(record, Warning::RepeatedAbscissa { count: 3, index: 1, .. });
}

#[test]
fn an_endless_line_is_refused() {
    let refusal = Sample::data(&"1.0 ".repeat(400_000)).refusal();
    assert!(matches!(refusal, UniversalError::LineTooLong { .. }), "{refusal}");
}

#[test]
fn a_sentinel_in_other_columns_ends_the_data() {
    let record = Sample { closing: "-1\n".into(), ..Sample::default() }.record();
    warned!(record, Warning::SentinelColumns { place } if place.line == Some(16));
}
