//! Round trips: written files are read back.

use super::*;

/// Returns a record with values that six digits and single precision hold exactly.
fn record(even: bool, double: bool, complex: bool, count: usize) -> UniversalRecord {
    let mut draw = Draw(7);
    let mut value = move || (draw.below(2001) as f64 - 1000.0) / 8.0;
    let abscissa = if even {
        Abscissa::Even { first: 2.0, step: 0.78125, count }
    } else {
        Abscissa::Uneven((0..count).map(|index| index as f64 + f64::from(index % 3 == 1) / 4.0).collect())
    };
    let values = if complex {
        Ordinate::Complex((0..count).map(|_| Complex64::new(value(), value())).collect())
    } else {
        Ordinate::Real((0..count).map(|_| value()).collect())
    };
    let response = NodeLocation { entity: "table".into(), node: 12, direction: -3 };
    let reference = NodeLocation { entity: "nut".into(), node: 3, direction: 1 };
    let numerator = RecordAxis::new(data_type::ACCELERATION, "Acceleration", "m/s²");
    let mut header =
        UniversalRecord::frequency_response(response, reference, numerator, abscissa.clone(), Vec::new())
            .header;
    header.id_lines =
        ["accelerance", "run 3", "21-Nov-26 10:00:00", "position 200 mm", "five hits"].map(str::to_owned);
    (header.function_id, header.version, header.load_case, header.z_value) = (4, 5, 6, 1.5);
    header.ordinate_type = OrdinateType::new(complex, double);
    UniversalRecord::new(header, abscissa, values)
}

fn written(record: &UniversalRecord, encoding: Encoding) -> Vec<u8> {
    let mut writer = UniversalWriter::new(Vec::new());
    writer.record(record, encoding).unwrap();
    writer.finish().unwrap()
}

#[test]
fn all_variants_are_read_back_unchanged() {
    for encoding in [Encoding::Ascii, Encoding::Binary(ByteOrder::Little), Encoding::Binary(ByteOrder::Big)] {
        for variant in 0..8 {
            let (even, double, complex) = (variant & 1 == 0, variant & 2 == 0, variant & 4 == 0);
            for count in [1, 2, 6, 101] {
                let record = record(even, double, complex, count);
                let back = only(&written(&record, encoding));
                let name =
                    format!("{encoding:?} even {even} double {double} complex {complex} count {count}");
                assert_eq!((&back.abscissa, &back.ordinate), (&record.abscissa, &record.ordinate), "{name}");
                let faults = back
                    .header
                    .warnings
                    .iter()
                    .filter(|warning| !matches!(warning.kind, WarningKind::NonAscii { .. }))
                    .count();
                assert_eq!(faults, 0, "{name}: {:?}", back.header.warnings);
                let bare = |header: &RecordHeader| RecordHeader {
                    warnings: Vec::new(),
                    place: FilePlace::default(),
                    encoding,
                    z_axis: RecordAxis::default(),
                    ..header.clone()
                };
                assert_eq!(bare(&back.header), bare(&record.header), "{name}");
            }
        }
    }
}

#[test]
fn text_in_double_precision_has_exact_columns_and_thirteen_digits() {
    let values = vec![
        Complex64::new(1.0 / 3.0, -2e-11 / 3.0),
        Complex64::new(0.0, 1e-300),
        Complex64::new(-1e200, 5e-324),
    ];
    let abscissa = Abscissa::Even { first: 0.0, step: 1.0, count: 3 };
    let record = UniversalRecord::frequency_response(
        NodeLocation::default(),
        NodeLocation::default(),
        RecordAxis::new(8, "", "m"),
        abscissa,
        values,
    );
    let text = String::from_utf8(written(&record, Encoding::Ascii)).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[13], "  3.333333333333E-01 -6.666666666667E-12  0.000000000000E+00 1.000000000000E-300");
    assert_eq!(lines[14], "-1.000000000000E+200 4.940656458412E-324");
    let back = only(text.as_bytes());
    for (back, value) in complex(&back).iter().zip(complex(&record)) {
        assert!(
            (back.re - value.re).abs() <= 5e-13 * value.re.abs()
                && (back.im - value.im).abs() <= 5e-13 * value.im.abs()
        );
    }
    assert_eq!(back.header.warnings, []);
}

#[test]
fn the_byte_count_of_a_binary_record_is_that_of_its_payload() {
    for (even, double, complex, bytes) in [
        (true, true, true, 160),
        (true, false, false, 40),
        (false, true, true, 240),
        (false, false, true, 120),
    ] {
        let file = written(&record(even, double, complex, 10), Encoding::Binary(ByteOrder::Little));
        let line = file.split(|&byte| byte == b'\n').nth(1).unwrap();
        let line = str::from_utf8(line).unwrap();
        assert_eq!(
            line,
            format!("    58b     1     2          11{bytes:12}     0     0           0           0")
        );
    }
}

#[test]
fn header_and_units_are_read_back_unchanged() {
    let header = FileHeader {
        model_name: "bench".into(),
        description: "hammer test".into(),
        program: "daq".into(),
        created: "21-Nov-26 10:00:00".into(),
        saved: "21-Nov-26 11:00:00".into(),
        writer: "writer".into(),
        written: "21-Nov-26 12:00:00".into(),
        place: FilePlace::default(),
    };
    let units = Units {
        code: 7,
        description: "Inch (pound f)".into(),
        length_factor: 1.0 / 0.0254,
        force_factor: 0.224_808_943_1,
        ..Units::si()
    };
    let mut writer = UniversalWriter::new(Vec::new());
    writer.header(&header).unwrap();
    writer.units(&units).unwrap();
    writer.record(&record(true, true, true, 5), Encoding::Ascii).unwrap();
    let file = read(&writer.finish().unwrap()).unwrap();
    assert_eq!(file.warnings, []);
    assert_eq!(FileHeader { place: FilePlace::default(), ..file.headers[0].clone() }, header);
    assert_eq!(Units { place: FilePlace::default(), ..file.units[0].clone() }, units);
    assert_eq!(file.functions[0].header.units.as_deref(), Some(&file.units[0]));
}

#[test]
fn the_rounding_error_of_the_abscissa_is_returned() {
    let mut record = record(true, true, true, 6401);
    let third = 1.0 / 3.0;
    record.abscissa = Abscissa::Even { first: 0.0, step: third, count: 6401 };
    let mut writer = UniversalWriter::new(Vec::new());
    let shift = writer.record(&record, Encoding::Binary(ByteOrder::Little)).unwrap().abscissa_shift;
    let back = only(&writer.finish().unwrap());
    let last = back.abscissa.at(6400).unwrap();
    assert!((last - 6400.0 * third).abs() <= shift * 1.000_001 && shift < 1e-6, "{shift}");
}

#[test]
fn values_that_the_format_cannot_hold_are_refused() {
    let refusal = |change: fn(&mut UniversalRecord)| {
        let mut record = record(false, false, true, 3);
        change(&mut record);
        let mut writer = UniversalWriter::new(Vec::new());
        let refusal = writer.record(&record, Encoding::Ascii).unwrap_err();
        assert!(writer.finish().unwrap().is_empty());
        refusal
    };
    assert!(matches!(
        refusal(|record| record.abscissa = Abscissa::Uneven(vec![1.0])),
        WriteError::Lengths { abscissa: 1, ordinate: 3 }
    ));
    assert!(matches!(
        refusal(|record| record.ordinate = Ordinate::Real(vec![0.0, f64::NAN, 0.0])),
        WriteError::NotFinite { what: "value", index: 1, .. }
    ));
    assert!(matches!(
        refusal(|record| record.ordinate = Ordinate::Real(vec![0.0, 0.0, 1e39])),
        WriteError::BeyondSingle { index: 2, .. }
    ));
    assert!(matches!(
        refusal(|record| record.header.response.direction = 12_345),
        WriteError::TooWide { width: 4, .. }
    ));
    let mut writer = UniversalWriter::new(Vec::new());
    assert!(matches!(
        writer.units(&Units { force_factor: 0.0, ..Units::si() }),
        Err(WriteError::Factor { field: "force", .. })
    ));
}
