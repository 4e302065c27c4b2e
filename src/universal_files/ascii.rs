//! Reads the payload of a text record.

use std::io::{Read, Seek};

use crate::abscissa::Abscissa;
use crate::columns::{Field, data_columns, fields_of};
use crate::error::UniversalError;
use crate::evidence::SizeEvidence;
use crate::frame::{all_blank, is_loose_sentinel, is_sentinel};
use crate::number::is_overflown;
use crate::number::{Form, Scan, scan};
use crate::place::FilePlace;
use crate::point::{Points, numbers_per_value};
use crate::record::{Ordinate, RecordHeader};
use crate::source::{ByteSource, LINE_LIMIT, SourceLine};
use crate::warning::WarningKind;

/// End of the data.
enum NumberEnd {
    /// After the declared number of values.
    Full,
    /// At an earlier closing sentinel, which starts here.
    Sentinel(FilePlace),
    /// At the end of the file.
    File,
}

/// State of the reading of a payload.
struct ScanProgress {
    points: Points,
    letter_d: Option<FilePlace>,
    bare: Option<FilePlace>,
    /// Number of numbers in the first line.
    first_line: usize,
    /// A line that is shorter than the first, and its number of numbers.
    short_line: Option<(FilePlace, usize)>,
    /// The last line, if it is shorter.
    last_short: Option<(FilePlace, usize)>,
    /// Number of numbers in the last line beyond those declared.
    extra: Option<(FilePlace, usize)>,
    /// Whether missing values are read as NaN.
    accepts_missing: bool,
    /// Widths of the fields of a line, by the format.
    columns: &'static [usize],
}

impl ScanProgress {
    /// Whether the next number may be missing: an ordinate, where missing values are accepted.
    fn takes_missing(&self) -> bool {
        self.accepts_missing && !self.points.expects_abscissa()
    }

    /// Notes the notation of an exponent.
    fn note_form(&mut self, form: Form, place: FilePlace) {
        match form {
            Form::Usual => {}
            Form::LetterD => _ = self.letter_d.get_or_insert(place),
            Form::Bare => _ = self.bare.get_or_insert(place),
        }
    }

    /// Notes how many numbers a line holds.
    fn end_line(&mut self, place: FilePlace, count: usize) {
        if self.first_line == 0 {
            self.first_line = count;
        }
        self.short_line = self.short_line.or(self.last_short.take());
        self.last_short = (count < self.first_line).then_some((place, count));
    }

    /// Reads a line with overflown fields by the columns of the format, since these fields touch their
    /// neighbours. Returns whether it is written in them; otherwise it takes nothing.
    fn take_columns(&mut self, line: &SourceLine<'_>, bytes_left: u64) -> bool {
        if !(self.accepts_missing && line.ended && line.text.contains(&b'*')) {
            return false;
        }
        let Some(fields) = fields_of(line.text, self.columns) else { return false };
        let width = self.points.width();
        let is_abscissa =
            |at: usize| self.points.has_abscissa() && (self.points.filled() + at).is_multiple_of(width);
        let accepted = fields.iter().enumerate().all(|(at, field)| match field {
            Field::Number(value, _) => value.is_finite(),
            Field::Overflown => !is_abscissa(at),
        });
        if !accepted {
            return false;
        }
        for field in &fields {
            if self.points.is_full() {
                self.extra.get_or_insert((line.place, 0)).1 += 1;
                continue;
            }
            match *field {
                Field::Number(value, form) => {
                    self.note_form(form, line.place);
                    self.points.push(value, bytes_left);
                }
                Field::Overflown => self.points.push(f64::NAN, bytes_left),
            }
        }
        self.end_line(line.place, fields.len());
        true
    }
}

/// Reads the payload that starts here, and its closing sentinel. The source ends up after the sentinel, or
/// before it after a refusal.
pub(crate) fn read_values<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &mut RecordHeader,
    accepts_missing: bool,
) -> Result<(Abscissa, Ordinate), UniversalError> {
    let points = Points::new(header, source.remaining());
    let mut progress = ScanProgress {
        points,
        letter_d: None,
        bare: None,
        first_line: 0,
        short_line: None,
        last_short: None,
        extra: None,
        accepts_missing,
        columns: data_columns(header),
    };
    let end = read_lines(source, header, &mut progress)?;
    let ScanProgress { points, letter_d, bare, first_line, short_line, extra, .. } = progress;
    let place = header.place;
    let (declared, found) = (header.count as u64, points.taken() as u64);
    header.warnings.extend(letter_d.map(|place| WarningKind::ExponentLetter.at(place)));
    header.warnings.extend(bare.map(|place| WarningKind::ExponentBare.at(place)));
    match end {
        NumberEnd::Full => {
            if declared == 0 {
                header.warnings.push(WarningKind::NoValues.at(place));
            }
            header.warnings.extend(extra.map(|(place, extra)| WarningKind::PaddedLine { extra }.at(place)));
            read_closing(source, header, declared)?;
        }
        NumberEnd::File => header.warnings.push(WarningKind::Truncated { declared, found }.at(place)),
        NumberEnd::Sentinel(sentinel) => {
            let needed = numbers_per_value(header);
            let numbers = points.numbers();
            let fault = if numbers > 0 && numbers.is_multiple_of(declared) && needed > 1 {
                Some(UniversalError::NumbersPerValue { place, found: numbers, declared, needed })
            } else {
                short_line.map(|(place, found)| UniversalError::ShortLine {
                    place,
                    found,
                    expected: first_line,
                })
            };
            if let Some(fault) = fault {
                source.seek(sentinel)?;
                return Err(fault);
            }
            header.warnings.push(
                WarningKind::ValueCount { declared, found, evidence: SizeEvidence::NextSentinel }.at(place),
            );
        }
    }
    header.count = points.taken();
    Ok(points.into_values().finish(header))
}

/// Reads lines up to the end of the data.
fn read_lines<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &mut RecordHeader,
    progress: &mut ScanProgress,
) -> Result<NumberEnd, UniversalError> {
    let (mut blank_seen, mut sentinel_seen) = (false, false);
    while !progress.points.is_full() {
        let bytes_left = source.remaining();
        let Some(line) = source.line()? else { return Ok(NumberEnd::File) };
        let place = line.place;
        if is_sentinel(line.text) {
            if source.at_dataset_end(false)? {
                return Ok(NumberEnd::Sentinel(place));
            }
            if !std::mem::replace(&mut sentinel_seen, true) {
                header.warnings.push(WarningKind::SentinelInData.at(place));
            }
            progress.points.push(-1.0, bytes_left);
            continue;
        }
        if all_blank(line.text) {
            if !std::mem::replace(&mut blank_seen, true) {
                header.warnings.push(WarningKind::BlankLine.at(place));
            }
            continue;
        }
        if !line.ended && line.text.len() >= LINE_LIMIT {
            return Err(UniversalError::LineTooLong { place, limit: LINE_LIMIT });
        }
        read_numbers(&line, bytes_left, progress)?;
    }
    Ok(NumberEnd::Full)
}

/// Reads the numbers of a line. Where the file ends in the line, a number that touches the end may be cut and
/// is dropped.
fn read_numbers(
    line: &SourceLine<'_>,
    bytes_left: u64,
    progress: &mut ScanProgress,
) -> Result<(), UniversalError> {
    if progress.take_columns(line, bytes_left) {
        return Ok(());
    }
    let mut offset = 0;
    let mut count = 0;
    loop {
        match scan(line.text, offset) {
            Scan::End => break,
            Scan::Number { end, .. } | Scan::Bad { end, .. } if end == line.text.len() && !line.ended => {
                break;
            }
            Scan::Number { end, .. } | Scan::Bad { end, .. } if progress.points.is_full() => {
                progress.extra.get_or_insert((line.place, 0)).1 += 1;
                offset = end;
            }
            Scan::Number { value, end, form } => {
                if !value.is_finite() && !progress.takes_missing() {
                    return Err(not_finite(line, offset, end, progress));
                }
                progress.note_form(form, line.place);
                progress.points.push(value, bytes_left);
                count += 1;
                offset = end;
            }
            Scan::Bad { start, end } => {
                let found = excerpt(&line.text[start..end]);
                let lower = found.to_lowercase();
                let has_word = ["nan", "inf", "ind", "qnan", "snan"].iter().any(|word| lower.contains(word));
                // More asterisks than a field has are several fields.
                let widest = progress.columns.iter().copied().max().unwrap_or(0);
                let is_missing = has_word || (is_overflown(&line.text[start..end]) && end - start <= widest);
                if is_missing && progress.takes_missing() {
                    progress.points.push(f64::NAN, bytes_left);
                    count += 1;
                    offset = end;
                    continue;
                }
                if has_word {
                    return Err(not_finite(line, start, end, progress));
                }
                return Err(UniversalError::NotANumber { place: line.place, column: start + 1, found });
            }
        }
    }
    progress.end_line(line.place, count);
    Ok(())
}

/// Creates the error of a value that is not finite.
fn not_finite(line: &SourceLine<'_>, start: usize, end: usize, progress: &ScanProgress) -> UniversalError {
    UniversalError::NotFinite {
        place: line.place,
        index: progress.points.taken() as u64,
        found: excerpt(&line.text[start..end]),
    }
}

/// Reads the closing sentinel after the declared number of values.
fn read_closing<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &mut RecordHeader,
    declared: u64,
) -> Result<(), UniversalError> {
    let mut blank_seen = false;
    loop {
        let place = source.place();
        let Some(line) = source.line()? else {
            header.warnings.push(WarningKind::MissingClosing.at(place));
            return Ok(());
        };
        if is_sentinel(line.text) {
            return Ok(());
        }
        if is_loose_sentinel(line.text) {
            header.warnings.push(WarningKind::SentinelColumns.at(place));
            return Ok(());
        }
        if !all_blank(line.text) {
            if !line.ended {
                header.warnings.push(WarningKind::MissingClosing.at(place));
                return Ok(());
            }
            let found = excerpt(line.text);
            return Err(UniversalError::DataGoOn { place, declared, found });
        }
        if !std::mem::replace(&mut blank_seen, true) {
            header.warnings.push(WarningKind::BlankLine.at(place));
        }
    }
}

/// Returns the first characters of the text found.
fn excerpt(text: &[u8]) -> String {
    String::from_utf8_lossy(text).trim().chars().take(40).collect()
}

/// Moves after the payload that starts here and its closing sentinel, without reading the values.
///
/// Where all lines but the last are as long as the first, the position of the last is computed and checked;
/// otherwise all lines are read.
pub(crate) fn skip_values<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &mut RecordHeader,
) -> Result<(), UniversalError> {
    let start = source.place();
    if jump(source, header, start)? {
        return Ok(());
    }
    source.seek(start)?;
    if !source.skip_dataset()? {
        header.warnings.push(WarningKind::MissingClosing.at(source.place()));
    }
    Ok(())
}

/// Moves after the payload by the length of its first line; returns false where the lines differ in length.
fn jump<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &RecordHeader,
    start: FilePlace,
) -> Result<bool, UniversalError> {
    let numbers = (header.count as u64).saturating_mul(numbers_per_value(header) as u64);
    let Some(line) = source.line()? else { return Ok(false) };
    let (mut offset, mut per_line) = (0, 0);
    while let Scan::Number { end, .. } = scan(line.text, offset) {
        (offset, per_line) = (end, per_line + 1);
    }
    if per_line == 0 || numbers <= per_line {
        return Ok(false);
    }
    let length = source.position() - start.byte;
    let lines_before = numbers.div_ceil(per_line) - 1;
    let last = start.byte.saturating_add(lines_before.saturating_mul(length));
    if last >= source.length() {
        return Ok(false);
    }
    source.seek(FilePlace { byte: last - 1, line: start.line.map(|line| line + lines_before - 1) })?;
    for wanted in [all_blank as fn(&[u8]) -> bool, |_| true, is_sentinel] {
        if !source.line()?.is_some_and(|line| line.ended && wanted(line.text)) {
            return Ok(false);
        }
    }
    Ok(source.at_dataset_end(true)?)
}
