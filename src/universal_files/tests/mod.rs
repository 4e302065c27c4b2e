//! Tests of whole files: faults, round trips and garbage.

mod fault_binary;
mod fault_frame;
mod fault_header;
mod fault_text;
mod garbage;
mod round_trip;

use std::io::Cursor;

use num_complex::Complex64;

use super::*;

/// Reads a file in memory.
fn read(bytes: &[u8]) -> Result<UniversalFile, UniversalError> {
    super::read(Cursor::new(bytes))
}

/// Reads the headers of a file in memory.
fn read_headers(bytes: &[u8]) -> Result<UniversalFile<RecordHeader>, UniversalError> {
    super::read_headers(Cursor::new(bytes))
}

/// Reads the sound parts of a file in memory.
fn read_sound(bytes: &[u8]) -> Result<(UniversalFile, Vec<UniversalError>), UniversalError> {
    super::read_sound(Cursor::new(bytes), |_| true)
}

/// A text record that tests modify.
#[derive(Clone)]
struct Sample {
    first: String,
    ids: String,
    locations: String,
    form: String,
    abscissa: String,
    ordinate: String,
    denominator: String,
    z: String,
    data: Vec<u8>,
    closing: String,
}

impl Default for Sample {
    fn default() -> Self {
        Self {
            first: "    58\n".into(),
            ids: "frf\nNONE\n21-Nov-26 10:00:00\nNONE\nNONE\n".into(),
            locations: "    4         0    0         0 table             12   3 nut                3  -1\n"
                .into(),
            form: form(2, 4, 1),
            abscissa: "        18    0    0    0 Frequency            Hz\n".into(),
            ordinate: "        12    0    0    0 Acceleration         m/s^2\n".into(),
            denominator: "        13    0    0    0 Force                N\n".into(),
            z: "         0    0    0    0 NONE                 NONE\n".into(),
            data: b"  1.00000E+00  2.00000E+00  3.00000E+00\n  4.00000E+00\n".to_vec(),
            closing: "    -1\n".into(),
        }
    }
}

/// Record 7 with step 0.5.
fn form(kind: i64, count: usize, even: i64) -> String {
    format!("{kind:10}{count:10}{even:10}  0.00000E+00  5.00000E-01  0.00000E+00\n")
}

impl Sample {
    fn bytes(&self) -> Vec<u8> {
        let Self { first, ids, locations, form, abscissa, ordinate, denominator, z, data, closing } = self;
        let head = ["    -1\n", first, ids, locations, form, abscissa, ordinate, denominator, z].concat();
        [head.as_bytes(), data, closing.as_bytes()].concat()
    }

    /// Returns the sample with other text data.
    fn data(data: &str) -> Self {
        Self { data: data.into(), ..Self::default() }
    }

    /// Returns a little-endian 58b with the given payload.
    fn binary(kind: i64, count: usize, even: i64, byte_count: usize, data: Vec<u8>) -> Self {
        let first =
            format!("    58b     1     2          11{byte_count:12}     0     0           0           0\n");
        Self { first, form: form(kind, count, even), data, ..Self::default() }
    }

    /// Reads the only record.
    fn record(&self) -> UniversalRecord {
        only(&self.bytes())
    }

    /// Returns the error of a refused file.
    fn refusal(&self) -> UniversalError {
        read(&self.bytes()).unwrap_err()
    }
}

/// Reads the only record of a file.
fn only(bytes: &[u8]) -> UniversalRecord {
    let mut file = read(bytes).unwrap();
    assert_eq!(file.functions.len(), 1);
    file.functions.remove(0)
}

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

/// Encodes little-endian doubles.
fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Encodes little-endian singles.
fn singles(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Asserts that a warning of the record matches.
macro_rules! warned {
    ($record:expr, $kind:pat $(if $guard:expr)? $(, line $line:expr)?) => {
        assert!(
            $record.header.warnings.iter().any(|warning| {
                matches!(&warning.kind, $kind $(if $guard)?)
                    $(&& warning.place.is_some_and(|place| place.line == Some($line)))?
            }),
            "{:?}",
            $record.header.warnings
        )
    };
}
use warned;

/// Reproducible numbers.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, limit: usize) -> usize {
        self.next() as usize % limit.max(1)
    }

    fn unit(&mut self) -> f64 {
        self.next() as f64 / (1_u64 << 31) as f64
    }
}

#[test]
fn a_sound_record_is_read_without_warning() {
    let record = Sample::default().record();
    assert_eq!(record.header.warnings, []);
    assert_eq!(real(&record), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(record.abscissa.values(), [0.0, 0.5, 1.0, 1.5]);
    let header = &record.header;
    assert_eq!(header.id_lines[2], "21-Nov-26 10:00:00");
    assert_eq!(header.function_type, function_type::FREQUENCY_RESPONSE);
    assert_eq!(header.response, NodeLocation { entity: "table".into(), node: 12, direction: 3 });
    assert_eq!(header.reference, NodeLocation { entity: "nut".into(), node: 3, direction: -1 });
    assert_eq!(header.ordinate, RecordAxis::new(data_type::ACCELERATION, "Acceleration", "m/s^2"));
    assert_eq!(header.z_axis.unit(), None);
    assert_eq!(header.place, FilePlace { byte: 7, line: Some(2) });
}
