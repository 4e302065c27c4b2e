//! Truncated, corrupted and random files: read or refused, without panic or endless loop.

use super::*;

/// Returns a file of text and binary records with companion datasets, and the values of the records.
fn small_file() -> (Vec<u8>, Vec<Vec<Complex64>>) {
    let mut draw = Draw(11);
    let mut writer = UniversalWriter::new(Vec::new());
    writer.header(&FileHeader::default()).unwrap();
    writer.units(&Units::si()).unwrap();
    let mut truth = Vec::new();
    for encoding in [Encoding::Ascii, Encoding::Binary(ByteOrder::Big), Encoding::Ascii] {
        let values: Vec<Complex64> = (0..7)
            .map(|_| Complex64::new(draw.below(1000) as f64 / 8.0, -(draw.below(1000) as f64) / 8.0))
            .collect();
        let abscissa = Abscissa::Even { first: 0.0, step: 1.0, count: values.len() };
        let axis = RecordAxis::new(data_type::DISPLACEMENT, "Displacement", "m");
        let record = UniversalRecord::frequency_response(
            NodeLocation::default(),
            NodeLocation::default(),
            axis,
            abscissa,
            values.clone(),
        );
        writer.record(&record, encoding).unwrap();
        truth.push(values);
    }
    (writer.finish().unwrap(), truth)
}

/// Reads in every way and counts datasets and headers.
fn exercise(bytes: &[u8]) -> (usize, usize) {
    let mut reader = UniversalReader::new(Cursor::new(bytes)).unwrap();
    let datasets = std::iter::from_fn(|| reader.next_dataset()).take(bytes.len() + 2).count();
    let mut reader = UniversalReader::new(Cursor::new(bytes)).unwrap();
    let headers = std::iter::from_fn(|| reader.next_header()).take(bytes.len() + 2).count();
    _ = (read(bytes), read_headers(bytes));
    (datasets, headers)
}

#[test]
fn every_truncated_file_gives_true_values_or_a_refusal() {
    let (bytes, truth) = small_file();
    for end in 0..bytes.len() {
        let (datasets, headers) = exercise(&bytes[..end]);
        assert!(datasets <= 6 && headers <= 6, "{end}");
        let Ok(file) = read(&bytes[..end]) else { continue };
        for (record, truth) in file.functions.iter().zip(&truth) {
            let values = complex(record);
            assert_eq!(values, &truth[..values.len()], "{end}");
            let reported = record.header.warnings.iter().any(|warning| {
                matches!(warning.kind, WarningKind::Truncated { .. } | WarningKind::ValueCount { .. })
            });
            assert_eq!(reported, values.len() < truth.len(), "{end}");
        }
    }
}

#[test]
fn corrupted_files_are_read_or_refused() {
    let (bytes, _) = small_file();
    let mut draw = Draw(3);
    for _ in 0..20_000 {
        let mut corrupted = bytes.clone();
        for _ in 0..=draw.below(4) {
            let at = draw.below(corrupted.len());
            match draw.below(5) {
                0 => corrupted[at] = draw.next() as u8,
                1 => corrupted[at] = b"0123456789-+.ED \n\r"[draw.below(18)],
                2 => _ = corrupted.remove(at),
                3 => corrupted.insert(at, b"0123456789-+.ED \n\r"[draw.below(18)]),
                _ => _ = corrupted.splice(at..at, *b"\n    -1\n"),
            }
        }
        let (datasets, headers) = exercise(&corrupted);
        assert!(datasets <= corrupted.len() && headers <= corrupted.len());
    }
}

#[test]
fn random_bytes_are_refused() {
    let mut draw = Draw(5);
    let alphabets: [&[u8]; 3] = [&(0..=255).collect::<Vec<u8>>(), b"    \n-1580b.E+", b" \n\r-1"];
    for round in 0..2000 {
        let alphabet = alphabets[round % 3];
        let length = draw.below(3000);
        let mut bytes: Vec<u8> = (0..length).map(|_| alphabet[draw.below(alphabet.len())]).collect();
        if round % 2 == 0 {
            bytes.splice(0..0, *b"    -1\n    58b     1     2          11         999\n\n\n\n\n\n");
        }
        let (datasets, headers) = exercise(&bytes);
        assert!(datasets <= bytes.len() && headers <= bytes.len());
    }
}

#[test]
fn huge_counts_reserve_nothing() {
    let text = Sample { form: form(6, 2_000_000_000, 0), ..Sample::default() }.record();
    assert_eq!(text.header.count, 1);
    let binary = Sample::binary(6, 2_000_000_000, 1, 2_000_000_000, doubles(&[1.0, 2.0]));
    assert_eq!(binary.record().header.count, 1);
    let trace = "    -1\n    82\n         1 999999999         8\nname\n         1\n    -1\n";
    assert!(matches!(read(trace.as_bytes()), Err(UniversalError::ShortHeader { dataset: 82, .. })));
}

#[test]
fn numbers_of_every_size_survive_in_text() {
    let mut draw = Draw(17);
    let values: Vec<f64> =
        (0..2000).map(|_| (draw.unit() - 0.5) * 10_f64.powi(draw.below(600) as i32 - 300)).collect();
    let lines: String = values
        .chunks(4)
        .map(|line| line.iter().map(|value| format!(" {value:.17e}")).collect::<String>() + "\n")
        .collect();
    let record = Sample { form: form(4, values.len(), 1), ..Sample::data(&lines) }.record();
    assert_eq!(real(&record), values);
}
