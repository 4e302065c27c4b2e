//! Writes fields in fixed columns, as Fortran does.

use std::io::Write;

use crate::field::is_unused;
use crate::write_error::WriteError;

/// Largest number of characters that leaves a blank in 13 columns.
const ABSCISSA_CHARACTERS: usize = 12;

/// Writes an integer, right-justified.
pub(crate) fn integer(
    out: &mut Vec<u8>,
    value: i64,
    width: usize,
    field: &'static str,
) -> Result<(), WriteError> {
    let text = value.to_string();
    if text.len() > width {
        return Err(WriteError::TooWide { field, value, width });
    }
    right(out, &text, width);
    Ok(())
}

/// Writes text, left-justified and cut at its width: Latin-1, `?` for other characters, `NONE` for empty
/// text.
pub(crate) fn text(out: &mut Vec<u8>, text: &str, width: usize) {
    let text = if is_unused(text.trim()) { "NONE" } else { text };
    let byte = |character: char| match u8::try_from(character) {
        Ok(_) if character.is_control() => b' ',
        Ok(byte) => byte,
        Err(_) => b'?',
    };
    out.extend(text.chars().map(byte).chain(std::iter::repeat(b' ')).take(width));
}

/// Writes a line of text of up to 80 columns, without trailing blanks.
pub(crate) fn text_line(out: &mut Vec<u8>, line: &str) {
    text(out, line, 80);
    while out.last() == Some(&b' ') {
        out.pop();
    }
    out.push(b'\n');
}

/// Writes Ew.d with a digit before the point: at least two exponent digits, always signed.
pub(crate) fn scientific(out: &mut Vec<u8>, value: f64, decimals: usize, width: usize, letter: char) {
    right(out, &scientific_text(value, decimals, letter), width);
}

fn scientific_text(value: f64, decimals: usize, letter: char) -> String {
    let mut text = format!("{value:.decimals$e}");
    if let Some(at) = text.find('e') {
        let exponent: i32 = text[at + 1..].parse().unwrap_or(0);
        text.truncate(at);
        let sign = if exponent < 0 { '-' } else { '+' };
        text.push(letter);
        text.push(sign);
        let magnitude = exponent.unsigned_abs();
        if magnitude < 10 {
            text.push('0');
        }
        text.push_str(&magnitude.to_string());
    }
    text
}

/// Writes a number in 13 columns with a leading blank and returns the value written.
///
/// The form is E13.5 where that is exact, otherwise the one of up to 12 characters with the smallest error. A
/// step of 1/3 Hz in E13.5 deviates by 2 mHz after 6400 lines; as 0.3333333333 it deviates by 0.2 µHz.
pub(crate) fn abscissa_field(out: &mut Vec<u8>, value: f64) -> f64 {
    let decimals = |least: usize| {
        ABSCISSA_CHARACTERS.saturating_sub(format!("{:.0}", value.trunc()).len() + 1).max(least)
    };
    let forms =
        [scientific_text(value, 5, 'E'), scientific_text(value, 6, 'E'), format!("{value:.*}", decimals(1))];
    let shift = |text: &str| text.parse().map_or(f64::INFINITY, |written: f64| (written - value).abs());
    let [standard, others @ ..] = &forms;
    let mut best = standard;
    for form in others {
        if form.len() <= ABSCISSA_CHARACTERS && shift(form) < shift(best) {
            best = form;
        }
    }
    right(out, best, 13);
    best.parse().unwrap_or(value)
}

fn right(out: &mut Vec<u8>, text: &str, width: usize) {
    // Writing to memory does not fail.
    _ = write!(out, "{text:>width$}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(form: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        form(&mut out);
        String::from_utf8_lossy(&out).into_owned()
    }

    #[test]
    fn numbers_fill_their_columns() {
        assert_eq!(written(|out| scientific(out, -1.5e-3, 12, 20, 'E')), " -1.500000000000E-03");
        assert_eq!(written(|out| scientific(out, 0.0, 12, 20, 'E')), "  0.000000000000E+00");
        assert_eq!(written(|out| scientific(out, -1e-300, 12, 20, 'E')), "-1.000000000000E-300");
        assert_eq!(written(|out| scientific(out, 1.0, 17, 25, 'D')), "  1.00000000000000000D+00");
        assert_eq!(written(|out| integer(out, -7, 4, "x").unwrap()), "  -7");
        assert!(integer(&mut Vec::new(), 12345, 4, "x").is_err());
    }

    #[test]
    fn a_step_keeps_as_many_digits_as_fit() {
        for (value, text) in [
            (1.0, "  1.00000E+00"),
            (0.195313, "  1.95313E-01"),
            (1.0 / 3.0, " 0.3333333333"),
            (-0.1953125, "-0.195312500"),
        ] {
            assert_eq!(written(|out| _ = abscissa_field(out, value)).trim(), text.trim(), "{value}");
        }
        for value in [1.0 / 3.0, 1e-7 / 3.0, 12_345.678_9, 1e9 / 7.0, -2.0 / 3.0, 1e-30 / 7.0] {
            let text = written(|out| _ = abscissa_field(out, value));
            assert!(text.len() == 13 && text.starts_with(' '), "{text}");
            assert!((text.trim().parse::<f64>().unwrap() / value - 1.0).abs() < 5e-6, "{text}");
        }
    }

    #[test]
    fn text_is_cut_and_padded_and_never_blank() {
        assert_eq!(written(|out| text(out, "", 6)), "NONE  ");
        assert_eq!(written(|out| text(out, "Frequency", 4)), "Freq");
        let mut out = Vec::new();
        text(&mut out, "m/s²\n→", 6);
        assert_eq!(out, b"m/s\xB2 ?");
    }
}
