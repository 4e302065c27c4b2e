//! Fixed columns of the data lines of a text record, for lines with overflown fields.

use crate::number::{Form, Scan, is_blank, is_overflown, scan};
use crate::record::RecordHeader;

/// Widths of the fields of a data line.
///
/// ```text
///            even      uneven
/// real       6E13.5    3(2E13.5)             single precision
/// complex    6E13.5    2(3E13.5)
/// real       4E20.12   2(E13.5,E20.12)       double precision
/// complex    4E20.12   E13.5,2E20.12
/// ```
///
/// # Source  dataset 58 of the Structural Dynamics Research Laboratory, University of Cincinnati
pub(crate) fn data_columns(header: &RecordHeader) -> &'static [usize] {
    match (header.ordinate_type.is_double(), header.even, header.ordinate_type.is_complex()) {
        (false, _, _) => &[13; 6],
        (true, true, _) => &[20; 4],
        (true, false, false) => &[13, 20, 13, 20],
        (true, false, true) => &[13, 20, 20],
    }
}

/// A field of a data line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Field {
    /// A number, and the notation of its exponent.
    Number(f64, Form),
    /// Asterisks.
    Overflown,
}

/// Splits a line into the fields of its columns; `None` if it is not written in them.
pub(crate) fn fields_of(line: &[u8], widths: &[usize]) -> Option<Vec<Field>> {
    let length = line.iter().rposition(|&byte| !is_blank(byte)).map_or(0, |last| last + 1);
    let mut fields = Vec::with_capacity(widths.len());
    let mut from = 0;
    for width in widths {
        if from >= length {
            break;
        }
        let field = &line[from..length.min(from + width)];
        from += width;
        if is_overflown(field) {
            // The asterisks of a field fill it.
            (field.len() == *width).then(|| fields.push(Field::Overflown))?;
            continue;
        }
        let Scan::Number { value, end, form } = scan(field, 0) else { return None };
        if !field[end..].iter().all(|&byte| is_blank(byte)) {
            return None;
        }
        fields.push(Field::Number(value, form));
    }
    (from >= length).then_some(fields)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(line: &str, widths: &[usize]) -> Option<Vec<f64>> {
        let value = |field| match field {
            Field::Number(value, _) => value,
            Field::Overflown => f64::NAN,
        };
        Some(fields_of(line.as_bytes(), widths)?.into_iter().map(value).collect())
    }

    #[test]
    fn touching_fields_are_split_at_their_columns() {
        let stars = "*************";
        let line = format!("  1.00000E+00{stars}{stars} -4.00000E+00{stars}-6.00000-105");
        let found = values(&line, &[13; 6]).unwrap();
        assert_eq!([0, 3, 5].map(|at| found[at]), [1.0, -4.0, -6e-105]);
        assert!([1, 2, 4].iter().all(|at| found[*at].is_nan()), "{found:?}");
        assert_eq!(values(&format!("  1.00000E+00{stars}  \r"), &[13; 6]).unwrap().len(), 2);
        assert_eq!(
            values("  1.00000E+00  1.000000000000E+00********************", &[13, 20, 20]).unwrap()[..2],
            [1.0, 1.0]
        );
    }

    #[test]
    fn lines_outside_the_columns_are_not_split() {
        for line in [
            "1.0 ************* 2.0",
            "  1.00000E+00************",
            "  1.00000E+00",
            "  1.00000E+00   text",
            &" ".repeat(13),
        ] {
            let found = values(line, &[13; 6]);
            assert!(
                found.is_none() || found.as_deref() == Some(&[1.0]) || found.as_deref() == Some(&[]),
                "{line}: {found:?}"
            );
        }
        let seven = "  1.00000E+00".repeat(7);
        assert_eq!(values(&seven, &[13; 6]), None);
    }
}
