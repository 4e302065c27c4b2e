//! Faults between datasets, and reading after a refusal.

use super::*;

fn joined(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

#[test]
fn other_formats_are_refused() {
    for text in [
        "",
        "\n\n",
        "1.0 2.0\n3.0 4.0\n",
        "frequency_hz,re,im\n1,2,3\n",
        "    -1\n    -1\n",
        "    -1\nNONE\n",
    ] {
        assert!(matches!(read(text.as_bytes()), Err(UniversalError::NoDataset)), "{text:?}");
    }
}

#[test]
fn other_datasets_are_listed_with_place_and_number() {
    let other = b"    -1\n  2412\n         1        11\n    -1 2\n    -1\n      not a dataset\n    -1\n    -1\n  2412\n 1\n    -1\n";
    let file = read(&joined(&[&Sample::default().bytes(), other])).unwrap();
    assert_eq!(file.functions.len(), 1);
    assert!(
        matches!(
            file.skipped[..],
            [Skipped { number: 2412, times: 2, place: FilePlace { line: Some(18), .. } }]
        ),
        "{:?}",
        file.skipped
    );
    assert_eq!(file.warnings, []);
}

#[test]
fn text_between_datasets_gives_a_warning() {
    let sample = Sample::default().bytes();
    let file = read(&joined(&[b"made by hand\nyesterday\n", &sample, b"remark\n", &sample])).unwrap();
    assert_eq!(file.functions.len(), 2);
    let lines: Vec<u64> =
        file.warnings
            .iter()
            .filter_map(|warning| {
                if let WarningKind::StrayText { lines } = &warning.kind { Some(*lines) } else { None }
            })
            .collect();
    assert_eq!(lines, [2, 1]);
}

#[test]
fn a_single_sentinel_between_datasets_is_enough() {
    let sample = Sample::default().bytes();
    let file = read(&joined(&[&sample, &sample[7..]])).unwrap();
    assert_eq!(file.functions.len(), 2);
    assert!(matches!(file.warnings[..], [Warning { kind: WarningKind::MissingOpening, .. }]));
}

#[test]
fn a_byte_order_mark_is_skipped() {
    assert_eq!(only(&joined(&[b"\xEF\xBB\xBF", &Sample::default().bytes()])).header.count, 4);
}

#[test]
fn the_reader_continues_after_a_refused_record() {
    let good = Sample::default().bytes();
    let bad = [
        Sample { form: form(9, 4, 1), ..Sample::default() }.bytes(),
        Sample { form: form(2, 3, 1), ..Sample::default() }.bytes(),
        Sample { form: form(5, 4, 1), ..Sample::default() }.bytes(),
        Sample::data("  1.0 NaN 3.0 4.0\n").bytes(),
        Sample::binary(4, 2, 1, 16, doubles(&[1.0, f64::NAN])).bytes(),
        Sample::binary(4, 4, 1, 32, [&doubles(&[f64::NAN])[..], b"    -1\n    -1\n    58\n\0\0\0"].concat())
            .bytes(),
        Sample::binary(4, 2, 1, 16, vec![0; 13]).bytes(),
        b"    -1\n    58\nid\nid\n    -1\n".to_vec(),
        b"    -1\n   164\n         1SI\n  0.0 1.0 1.0\n 0.0\n    -1\n".to_vec(),
    ];
    for (index, bad) in bad.iter().enumerate() {
        let bytes = joined(&[&good, bad, &good]);
        assert!(read(&bytes).is_err(), "{index}");
        let mut reader = UniversalReader::new(Cursor::new(&bytes)).unwrap();
        let results: Vec<bool> = reader.by_ref().map(|dataset| dataset.is_ok()).collect();
        assert_eq!(results, [true, false, true], "{index}");
        assert_eq!(reader.warnings(), [], "{index}");
    }
}

#[test]
fn headers_match_those_of_the_records() {
    let units = b"    -1\n   164\n         1SI\n  1.0 1.0 1.0\n 0.0\n    -1\n";
    let long =
        Sample { form: form(5, 400, 1), ..Sample::data(&"  1.00000E+00  2.00000E+00\n".repeat(400)) }.bytes();
    let padded =
        Sample { form: form(2, 1001, 0), ..Sample::data(&"  1.0  2.0  3.0  4.0\n".repeat(501)) }.bytes();
    let binary = Sample::binary(5, 2, 1, 16, doubles(&[1.0, 2.0, 3.0, 4.0])).bytes();
    let bytes =
        joined(&[&long, units, &binary, &Sample::default().bytes(), &padded, &long, &long.replace_crlf()]);
    let full = read(&bytes).unwrap();
    let heads = read_headers(&bytes).unwrap();
    assert_eq!((full.functions.len(), heads.functions.len()), (6, 6));
    for (record, head) in full.functions.iter().zip(&heads.functions) {
        let without_warnings =
            |header: &RecordHeader| RecordHeader { warnings: Vec::new(), ..header.clone() };
        assert_eq!(without_warnings(&record.header), without_warnings(head));
        assert!(head.warnings.iter().all(|warning| record.header.warnings.contains(warning)));
    }
    let mut reader = UniversalReader::new(Cursor::new(&bytes)).unwrap();
    for (record, head) in full.functions.iter().zip(&heads.functions).rev() {
        assert_eq!(&reader.record(head).unwrap(), record);
    }
}

trait ReplaceLineEnds {
    fn replace_crlf(&self) -> Vec<u8>;
}

impl ReplaceLineEnds for Vec<u8> {
    fn replace_crlf(&self) -> Vec<u8> {
        String::from_utf8(self.clone()).unwrap().replace('\n', "\r\n").into_bytes()
    }
}

#[test]
fn every_message_names_a_place() {
    let place = FilePlace { byte: 80, line: Some(2) };
    let messages = [
        WarningKind::ByteCount { found: None, used: 16, evidence: SizeEvidence::TypeAndCount }
            .at(place)
            .to_string(),
        WarningKind::Truncated { declared: 4, found: 2 }.at(place).to_string(),
        WarningKind::BlankUnit { axis: AxisName::Denominator, units_in_force: false }.at(place).to_string(),
        UniversalError::PayloadSize { place, count: 1, expected: 8, header_bytes: None, distance: 7 }
            .to_string(),
    ];
    for message in messages {
        assert!(message.starts_with("line 2 (byte 80): "), "{message}");
    }
    assert_eq!(FilePlace { byte: 9, line: None }.to_string(), "byte 9");
}
