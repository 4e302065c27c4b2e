//! Reads fields in the fixed columns of header lines.

use crate::error::UniversalError;
use crate::number::{self, Scan, is_overflown};
use crate::place::FilePlace;
use crate::source::SourceLine;
use crate::warning::{Warning, WarningKind};

/// A header line as text.
#[derive(Debug)]
pub(crate) struct HeaderLine {
    /// Characters, without trailing blanks.
    pub text: String,
    /// Place of the line.
    pub place: FilePlace,
    /// First numeric field that was blank.
    blank: Option<&'static str>,
}

impl HeaderLine {
    /// Decodes a line as UTF-8 if it is valid, else as Latin-1, so that no byte is lost and columns are
    /// preserved.
    pub fn new(line: &SourceLine<'_>, warnings: &mut Vec<Warning>) -> Self {
        let (text, read_as) = match str::from_utf8(line.text) {
            Ok(text) => (text.to_owned(), "UTF-8"),
            Err(_) => (line.text.iter().map(|&byte| char::from(byte)).collect(), "Latin-1"),
        };
        if !text.is_ascii() {
            warnings.push(WarningKind::NonAscii { read_as }.at(line.place));
        }
        let length = text.trim_end_matches([' ', '\t', '\r', '\0']).len();
        let mut text = text;
        text.truncate(length);
        text.shrink_to_fit();
        Self { text, place: line.place, blank: None }
    }

    /// Returns the characters from column `from` (counted from 0) to before column `to`, without surrounding
    /// blanks.
    pub fn columns(&self, from: usize, to: usize) -> &str {
        let offset = |column| {
            if self.text.is_ascii() {
                self.text.len().min(column)
            } else {
                self.text.char_indices().nth(column).map_or(self.text.len(), |(offset, _)| offset)
            }
        };
        self.text[offset(from)..offset(to)].trim_matches([' ', '\t', '\0'])
    }

    /// Reads an integer in columns; blank is 0, as in Fortran.
    pub fn integer(&mut self, from: usize, to: usize, field: &'static str) -> Result<i64, UniversalError> {
        let text = self.columns(from, to);
        if text.is_empty() {
            self.blank.get_or_insert(field);
            return Ok(0);
        }
        parse_integer(text).ok_or_else(|| self.fault(field, text, "write an integer in its columns"))
    }

    /// Reads an integer in columns, which may be asterisks: then it is unknown, and 0.
    pub fn integer_or_unknown(
        &mut self,
        (from, to): (usize, usize),
        field: &'static str,
        warnings: &mut Vec<Warning>,
    ) -> Result<i64, UniversalError> {
        if !is_overflown(self.columns(from, to).as_bytes()) {
            return self.integer(from, to, field);
        }
        warnings.push(WarningKind::Overflown { field, taken: "taken as 0" }.at(self.place));
        Ok(0)
    }

    /// Returns the first of some fields that is asterisks.
    pub fn overflown(&self, fields: &[(usize, usize, &'static str)]) -> Option<&'static str> {
        let at = |(from, to, _): &&(usize, usize, &str)| is_overflown(self.columns(*from, *to).as_bytes());
        fields.iter().find(at).map(|(_, _, field)| *field)
    }

    /// Reads a number in columns; blank is 0, as in Fortran.
    pub fn real(&mut self, from: usize, to: usize, field: &'static str) -> Result<f64, UniversalError> {
        let text = self.columns(from, to);
        if text.is_empty() {
            self.blank.get_or_insert(field);
            return Ok(0.0);
        }
        parse_real(text).ok_or_else(|| self.fault(field, text, "write a finite number in its columns"))
    }

    /// Creates the error of a field with unexpected content.
    pub fn fault(&self, field: &'static str, found: &str, expected: &'static str) -> UniversalError {
        UniversalError::Field { place: self.place, field, found: found.chars().take(80).collect(), expected }
    }

    /// Warns of blank numeric fields found so far.
    pub fn report_blanks(&self, warnings: &mut Vec<Warning>) {
        if let Some(field) = self.blank {
            warnings.push(WarningKind::BlankField { field }.at(self.place));
        }
    }

    /// Warns that the line is split at its blanks.
    pub fn report_columns(&self, warnings: &mut Vec<Warning>) {
        warnings.push(WarningKind::HeaderColumns.at(self.place));
    }
}

/// Parses the whole text as an integer.
pub(crate) fn parse_integer(text: &str) -> Option<i64> {
    text.parse().ok()
}

/// Parses the whole text as a finite number.
pub(crate) fn parse_real(text: &str) -> Option<f64> {
    match number::scan(text.as_bytes(), 0) {
        Scan::Number { value, end, .. } if end == text.len() && value.is_finite() => Some(value),
        _ => None,
    }
}

/// Whether a text field is unused: empty or `NONE`.
pub(crate) fn is_unused(text: &str) -> bool {
    text.is_empty() || text.eq_ignore_ascii_case("none")
}
