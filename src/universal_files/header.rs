//! Reads the header of dataset 58: its first line and the eleven records that follow.

use std::io::{Read, Seek};
use std::sync::Arc;

use crate::check;
use crate::error::UniversalError;
use crate::evidence::AxisName;
use crate::field::{HeaderLine, parse_integer, parse_real};
use crate::frame::is_sentinel;
use crate::kind::{ByteOrder, Encoding, OrdinateType};
use crate::place::FilePlace;
use crate::record::{NodeLocation, RecordAxis, RecordHeader};
use crate::source::{ByteSource, LINE_LIMIT};
use crate::units::Units;
use crate::warning::{Warning, WarningKind};

/// Number of header lines after the first.
const LINES: usize = 11;

/// Reads the next line of a header with `missing` lines still to come.
///
/// A sentinel that closes the dataset ends the header too early; the source then stays before it.
pub(crate) fn header_line<R: Read + Seek>(
    source: &mut ByteSource<R>,
    dataset: u32,
    missing: usize,
    warnings: &mut Vec<Warning>,
) -> Result<HeaderLine, UniversalError> {
    let place = source.place();
    let Some(line) = source.line()? else { return Err(UniversalError::EndsInHeader { place, dataset }) };
    if !line.ended {
        let long = line.text.len() >= LINE_LIMIT;
        return Err(if long {
            UniversalError::LineTooLong { place, limit: LINE_LIMIT }
        } else {
            UniversalError::EndsInHeader { place, dataset }
        });
    }
    if !is_sentinel(line.text) {
        return Ok(HeaderLine::new(&line, warnings));
    }
    let header_line = HeaderLine::new(&line, warnings);
    if source.at_dataset_end(false)? {
        source.seek(place)?;
        return Err(UniversalError::ShortHeader { place, dataset, missing });
    }
    Ok(header_line)
}

/// Reads the header after its first line; also returns the byte count of a binary payload.
pub(crate) fn read_header<R: Read + Seek>(
    source: &mut ByteSource<R>,
    first: HeaderLine,
    (binary, accepts_missing): (bool, bool),
    units: Option<Arc<Units>>,
) -> Result<(RecordHeader, Option<u64>), UniversalError> {
    let mut header = RecordHeader { place: first.place, units, ..RecordHeader::default() };
    let mut warnings = Vec::new();
    let mut byte_count = None;
    if binary {
        let (order, count) = first_line(first, &mut warnings)?;
        header.encoding = Encoding::Binary(order);
        byte_count = count;
    }
    let mut missing = LINES;
    let mut next = |warnings: &mut Vec<Warning>| {
        let line = header_line(source, 58, missing, warnings);
        missing -= 1;
        line
    };
    for id_line in &mut header.id_lines {
        *id_line = next(&mut warnings)?.text;
    }
    let location_place =
        location_record(next(&mut warnings)?, &mut header, (&mut warnings, accepts_missing))?;
    data_form(next(&mut warnings)?, &mut header, &mut warnings)?;
    for name in [AxisName::Abscissa, AxisName::Ordinate, AxisName::Denominator, AxisName::Z] {
        let line = next(&mut warnings)?;
        let place = line.place;
        let axis = axis_record(line, &mut warnings)?;
        check::unit(&axis, name, place, &header, &mut warnings);
        match name {
            AxisName::Abscissa => header.abscissa = axis,
            AxisName::Ordinate => header.ordinate = axis,
            AxisName::Denominator => header.denominator = axis,
            AxisName::Z => header.z_axis = axis,
        }
    }
    check::location(&header.response, location_place, &mut warnings);
    check::location(&header.reference, location_place, &mut warnings);
    header.warnings = warnings;
    Ok((header, byte_count))
}

/// Reads the first line of a 58b, (I6,1A1,I6,I6,I12,I12,…): byte order and byte count.
fn first_line(
    mut line: HeaderLine,
    warnings: &mut Vec<Warning>,
) -> Result<(ByteOrder, Option<u64>), UniversalError> {
    let fields = [(7, 13), (13, 19), (19, 31)].map(|(from, to)| parse_integer(line.columns(from, to)));
    let (order, format, lines, bytes) = if let [Some(order), Some(format), Some(lines)] = fields {
        (order, format, lines, parse_integer(line.columns(31, 43)))
    } else {
        let rest = line.text.split_once(['b', 'B']).map_or("", |(_, rest)| rest);
        let numbers: Vec<i64> = rest.split_whitespace().map_while(parse_integer).take(4).collect();
        let &[order, format, lines, ref bytes @ ..] = numbers.as_slice() else {
            line.integer(7, 13, "byte order")?;
            line.integer(13, 19, "floating point format")?;
            line.integer(19, 31, "number of header lines")?;
            let expected =
                "write byte order (1 or 2), floating point format (2), 11 and the byte count after 58b";
            return Err(line.fault("first line of 58b", line.text.trim(), expected));
        };
        line.report_columns(warnings);
        (order, format, lines, bytes.first().copied())
    };
    match format {
        2 => {}
        1 => return Err(UniversalError::FloatFormat { place: line.place, format: "DEC VMS".to_owned() }),
        3 => return Err(UniversalError::FloatFormat { place: line.place, format: "IBM 5/370".to_owned() }),
        other => {
            return Err(UniversalError::FloatFormat {
                place: line.place,
                format: format!("unknown (code {other})"),
            });
        }
    }
    if lines != LINES as i64 {
        warnings.push(WarningKind::HeaderLines { found: lines }.at(line.place));
    }
    let order = match order {
        1 => ByteOrder::Little,
        2 => ByteOrder::Big,
        other => {
            return Err(line.fault(
                "byte order",
                &other.to_string(),
                "write 1 (little endian) or 2 (big endian)",
            ));
        }
    };
    Ok((order, bytes.and_then(|bytes| u64::try_from(bytes).ok())))
}

/// Reads record 6, 2(I5,I10),2(1X,10A1,I10,I4).
fn location_record(
    mut line: HeaderLine,
    header: &mut RecordHeader,
    (warnings, accepts_missing): (&mut Vec<Warning>, bool),
) -> Result<FilePlace, UniversalError> {
    let mut overflown = Vec::new();
    let mut read = |line: &mut HeaderLine, header: &mut RecordHeader| {
        header.function_type = line.integer(0, 5, "function type")?;
        let mut counter =
            |line: &mut HeaderLine, columns: (usize, usize), field: &'static str| match accepts_missing {
                true => line.integer_or_unknown(columns, field, &mut overflown),
                false => line.integer(columns.0, columns.1, field),
            };
        header.function_id = counter(line, (5, 15), "function identification number")?;
        header.version = counter(line, (15, 20), "version number")?;
        header.load_case = counter(line, (20, 30), "load case")?;
        header.response.entity = line.columns(30, 41).to_owned();
        header.response.node = line.integer(41, 51, "response node")?;
        header.response.direction = line.integer(51, 55, "response direction")?;
        header.reference.entity = line.columns(55, 66).to_owned();
        header.reference.node = line.integer(66, 76, "reference node")?;
        header.reference.direction = line.integer(76, 80, "reference direction")?;
        Ok(())
    };
    match read(&mut line, header) {
        Ok(()) => {
            warnings.append(&mut overflown);
            line.report_blanks(warnings);
        }
        Err(fault) => {
            let tokens: Vec<&str> = line.text.split_whitespace().collect();
            let numbers: Vec<i64> = tokens.iter().filter_map(|token| parse_integer(token)).collect();
            let (&[kind, id, version, load_case, node, direction, reference_node, reference_direction], 10) =
                (numbers.as_slice(), tokens.len())
            else {
                return Err(fault);
            };
            (header.function_type, header.function_id, header.version, header.load_case) =
                (kind, id, version, load_case);
            header.response = NodeLocation { entity: tokens[4].to_owned(), node, direction };
            header.reference = NodeLocation {
                entity: tokens[7].to_owned(),
                node: reference_node,
                direction: reference_direction,
            };
            line.report_columns(warnings);
        }
    }
    Ok(line.place)
}

/// Reads record 7, 3I10,3E13.5.
fn data_form(
    mut line: HeaderLine,
    header: &mut RecordHeader,
    warnings: &mut Vec<Warning>,
) -> Result<(), UniversalError> {
    let read = |line: &mut HeaderLine| {
        let integers = [
            line.integer(0, 10, "ordinate data type")?,
            line.integer(10, 20, "number of values")?,
            line.integer(20, 30, "abscissa spacing")?,
        ];
        let reals = [
            line.real(30, 43, "abscissa minimum")?,
            line.real(43, 56, "abscissa increment")?,
            line.real(56, 69, "z axis value")?,
        ];
        if line.columns(69, usize::MAX).is_empty() {
            return Ok((integers, reals));
        }
        Err(line.fault("data form", line.text.trim(), "write 3I10,3E13.5 and nothing after"))
    };
    let (integers, reals) = match read(&mut line) {
        Ok(fields) => {
            line.report_blanks(warnings);
            fields
        }
        Err(fault) => {
            let tokens: Vec<&str> = line.text.split_whitespace().collect();
            let integers: Vec<i64> = tokens.iter().take(3).filter_map(|token| parse_integer(token)).collect();
            let reals: Vec<f64> = tokens.iter().skip(3).filter_map(|token| parse_real(token)).collect();
            let (&[kind, count, spacing], &[first, step, z], 6) =
                (integers.as_slice(), reals.as_slice(), tokens.len())
            else {
                return Err(fault);
            };
            line.report_columns(warnings);
            ([kind, count, spacing], [first, step, z])
        }
    };
    let [kind, count, spacing] = integers;
    header.ordinate_type = OrdinateType::from_code(kind).ok_or_else(|| {
        line.fault(
            "ordinate data type",
            &kind.to_string(),
            "write 2 real single, 4 real double, 5 complex single or 6 complex double",
        )
    })?;
    header.count = usize::try_from(count)
        .map_err(|_| line.fault("number of values", &count.to_string(), "write how many values follow"))?;
    header.even = match spacing {
        0 => false,
        1 => true,
        other => {
            return Err(line.fault("abscissa spacing", &other.to_string(), "write 0 (uneven) or 1 (even)"));
        }
    };
    [header.abscissa_first, header.abscissa_step, header.z_value] = reals;
    Ok(())
}

/// Reads one of records 8 to 11, I10,3I5,2(1X,20A1).
fn axis_record(mut line: HeaderLine, warnings: &mut Vec<Warning>) -> Result<RecordAxis, UniversalError> {
    let read = |line: &mut HeaderLine| {
        Ok(RecordAxis {
            data_type: line.integer(0, 10, "specific data type")?,
            length_exponent: line.integer(10, 15, "length units exponent")?,
            force_exponent: line.integer(15, 20, "force units exponent")?,
            temperature_exponent: line.integer(20, 25, "temperature units exponent")?,
            label: line.columns(25, 46).to_owned(),
            unit: line.columns(46, 67).to_owned(),
        })
    };
    match read(&mut line) {
        Ok(axis) => {
            line.report_blanks(warnings);
            Ok(axis)
        }
        Err(fault) => {
            let numbers: Vec<i64> = line.text.split_whitespace().map_while(parse_integer).take(4).collect();
            let &[data_type, length_exponent, force_exponent, temperature_exponent] = numbers.as_slice()
            else {
                return Err(fault);
            };
            let words = after_words(&line.text, 4);
            let (label, unit) = words.split_once("  ").unwrap_or((words, ""));
            line.report_columns(warnings);
            let (label, unit) = (label.trim().to_owned(), unit.trim().to_owned());
            Ok(RecordAxis { data_type, length_exponent, force_exponent, temperature_exponent, label, unit })
        }
    }
}

/// Returns the text after the first `count` words.
fn after_words(text: &str, count: usize) -> &str {
    let mut rest = text.trim_start();
    for _ in 0..count {
        rest = rest.trim_start_matches(|character: char| !character.is_whitespace()).trim_start();
    }
    rest
}
