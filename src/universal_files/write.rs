//! Writes universal files: datasets 58 and 58b, 151 and 164.

use std::io::Write;

use crate::abscissa::Abscissa;
use crate::companion::FileHeader;
use crate::kind::{ByteOrder, Encoding, OrdinateType};
use crate::record::{NodeLocation, Ordinate, RecordAxis, RecordHeader, UniversalRecord};
use crate::units::Units;
use crate::write_error::WriteError;
use crate::write_field::{abscissa_field, integer, scientific, text, text_line};
use crate::write_payload::{binary_payload, numbers_per_value, text_payload};

const SENTINEL: &[u8] = b"    -1\n";

/// Rounding error of a written record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Written {
    /// Largest shift of an abscissa value by rounding to 13 columns, or to 4 bytes if uneven and in single
    /// precision.
    pub abscissa_shift: f64,
}

/// Writes datasets one after the other.
///
/// Text fields are cut at their columns: identification lines at 80, labels and units at 20, entity names at
/// 10.
#[derive(Debug)]
pub struct UniversalWriter<W> {
    out: W,
}

impl<W: Write> UniversalWriter<W> {
    /// Creates a writer to an output.
    pub fn new(out: W) -> Self {
        Self { out }
    }

    /// Writes dataset 151, which belongs at the start.
    pub fn header(&mut self, header: &FileHeader) -> Result<(), WriteError> {
        let FileHeader { place: _, model_name, description, program, created, saved, writer, written } =
            header;
        let mut bytes = first_line("   151");
        for line in [model_name, description, program, created, saved, writer, written] {
            text_line(&mut bytes, line);
        }
        self.close(bytes)
    }

    /// Writes dataset 164, in force for all later records.
    pub fn units(&mut self, units: &Units) -> Result<(), WriteError> {
        let factors = [
            ("length", units.length_factor),
            ("force", units.force_factor),
            ("temperature", units.temperature_factor),
        ];
        if let Some(&(field, value)) = factors.iter().find(|(_, value)| !(*value > 0.0 && value.is_finite()))
        {
            return Err(WriteError::Factor { field, value });
        }
        if !units.temperature_offset.is_finite() {
            return Err(WriteError::Factor { field: "temperature offset", value: units.temperature_offset });
        }
        let mut bytes = first_line("   164");
        integer(&mut bytes, units.code, 10, "units code")?;
        text(&mut bytes, &units.description, 20);
        integer(&mut bytes, units.temperature_mode, 10, "temperature mode")?;
        bytes.push(b'\n');
        for (_, factor) in factors {
            scientific(&mut bytes, factor, 17, 25, 'D');
        }
        bytes.push(b'\n');
        scientific(&mut bytes, units.temperature_offset, 17, 25, 'D');
        bytes.push(b'\n');
        self.close(bytes)
    }

    /// Writes dataset 58 or 58b; type, count and spacing are those of the data, the precision is that of the
    /// header's ordinate type.
    ///
    /// An uneven abscissa in double precision takes 8 bytes in 58b, which preserves its digits. The format
    /// specifies 4 bytes. Programs that assume one number type for the whole payload read only 8; those that
    /// decide by size read both.
    pub fn record(&mut self, record: &UniversalRecord, encoding: Encoding) -> Result<Written, WriteError> {
        check(record)?;
        let UniversalRecord { header, abscissa, ordinate } = record;
        let kind =
            OrdinateType::new(matches!(ordinate, Ordinate::Complex(_)), header.ordinate_type.is_double());
        let mut bytes = match encoding {
            Encoding::Ascii => first_line("    58"),
            Encoding::Binary(order) => {
                let number = if kind.is_double() { 8 } else { 4 };
                let numbers = numbers_per_value(abscissa, kind);
                let order = if order == ByteOrder::Little { 1 } else { 2 };
                let size = number * numbers * ordinate.len();
                first_line(&format!(
                    "    58b{order:6}{:6}{:12}{size:12}{:6}{:6}{:12}{:12}",
                    2, 11, 0, 0, 0, 0
                ))
            }
        };
        let mut shift = head(&mut bytes, header, abscissa, kind, ordinate.len())?;
        match encoding {
            Encoding::Ascii => shift = shift.max(text_payload(&mut bytes, abscissa, ordinate, kind)),
            Encoding::Binary(order) => {
                shift = shift.max(binary_payload(&mut bytes, abscissa, ordinate, kind, order))
            }
        }
        self.close(bytes)?;
        Ok(Written { abscissa_shift: shift })
    }

    /// Flushes and returns the output.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.out.flush()?;
        Ok(self.out)
    }

    /// Writes a dataset with its closing sentinel.
    fn close(&mut self, mut bytes: Vec<u8>) -> Result<(), WriteError> {
        bytes.extend(SENTINEL);
        Ok(self.out.write_all(&bytes)?)
    }
}

/// Returns opening sentinel and first line.
fn first_line(line: &str) -> Vec<u8> {
    [SENTINEL, line.as_bytes(), b"\n"].concat()
}

/// Refuses values that the format cannot hold.
fn check(record: &UniversalRecord) -> Result<(), WriteError> {
    let (abscissa, ordinate) = (record.abscissa.len(), record.ordinate.len());
    if abscissa != ordinate {
        return Err(WriteError::Lengths { abscissa, ordinate });
    }
    let single = !record.header.ordinate_type.is_double();
    let number = |what, index, value: f64| {
        if !value.is_finite() {
            return Err(WriteError::NotFinite { what, index, value });
        }
        if single && value.abs() > f64::from(f32::MAX) {
            return Err(WriteError::BeyondSingle { index, value });
        }
        Ok(())
    };
    match &record.abscissa {
        Abscissa::Even { first, step, .. } => {
            number("abscissa value", 0, *first)?;
            number("abscissa step", 0, *step)?;
        }
        Abscissa::Uneven(values) => values
            .iter()
            .enumerate()
            .try_for_each(|(index, &value)| number("abscissa value", index, value))?,
    }
    number("z axis value", 0, record.header.z_value)?;
    match &record.ordinate {
        Ordinate::Real(values) => {
            values.iter().enumerate().try_for_each(|(index, &value)| number("value", index, value))
        }
        Ordinate::Complex(values) => {
            let mut parts =
                values.iter().enumerate().flat_map(|(index, value)| [(index, value.re), (index, value.im)]);
            parts.try_for_each(|(index, part)| number("value", index, part))
        }
    }
}

/// Writes the eleven header records; returns the largest shift of an even abscissa.
fn head(
    bytes: &mut Vec<u8>,
    header: &RecordHeader,
    abscissa: &Abscissa,
    kind: OrdinateType,
    count: usize,
) -> Result<f64, WriteError> {
    for line in &header.id_lines {
        text_line(bytes, line);
    }
    integer(bytes, header.function_type, 5, "function type")?;
    integer(bytes, header.function_id, 10, "function identification number")?;
    integer(bytes, header.version, 5, "version number")?;
    integer(bytes, header.load_case, 10, "load case")?;
    for (NodeLocation { entity, node, direction }, nodes, directions) in [
        (&header.response, "response node", "response direction"),
        (&header.reference, "reference node", "reference direction"),
    ] {
        bytes.push(b' ');
        text(bytes, entity, 10);
        integer(bytes, *node, 10, nodes)?;
        integer(bytes, *direction, 4, directions)?;
    }
    bytes.push(b'\n');
    integer(bytes, kind.code(), 10, "ordinate data type")?;
    integer(bytes, i64::try_from(count).unwrap_or(i64::MAX), 10, "number of values")?;
    let (even, first, step) = match *abscissa {
        Abscissa::Even { first, step, .. } => (1, first, step),
        Abscissa::Uneven(_) => (0, 0.0, 0.0),
    };
    integer(bytes, even, 10, "abscissa spacing")?;
    let first_shift = abscissa_field(bytes, first) - first;
    let step_shift = abscissa_field(bytes, step) - step;
    abscissa_field(bytes, header.z_value);
    bytes.push(b'\n');
    for axis in [&header.abscissa, &header.ordinate, &header.denominator, &header.z_axis] {
        axis_record(bytes, axis)?;
    }
    Ok(first_shift.abs().max((first_shift + step_shift * count.saturating_sub(1) as f64).abs()))
}

/// Writes one of records 8 to 11.
fn axis_record(bytes: &mut Vec<u8>, axis: &RecordAxis) -> Result<(), WriteError> {
    integer(bytes, axis.data_type, 10, "specific data type")?;
    integer(bytes, axis.length_exponent, 5, "length units exponent")?;
    integer(bytes, axis.force_exponent, 5, "force units exponent")?;
    integer(bytes, axis.temperature_exponent, 5, "temperature units exponent")?;
    for field in [&axis.label, &axis.unit] {
        bytes.push(b' ');
        text(bytes, field, 20);
    }
    bytes.push(b'\n');
    Ok(())
}
