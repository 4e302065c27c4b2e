//! Parses decimal numbers in fixed or free columns, correctly rounded.

/// Next token of a line.
#[derive(Debug, PartialEq)]
pub(crate) enum Scan {
    /// Only blanks up to the end.
    End,
    /// A number.
    Number {
        /// Value; infinite where it exceeds the range.
        value: f64,
        /// Offset of its end.
        end: usize,
        /// Notation of its exponent.
        form: Form,
    },
    /// Not a number.
    Bad {
        /// Offset of its first byte.
        start: usize,
        /// Offset of its end.
        end: usize,
    },
}

/// Notation of an exponent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// With E, or no exponent.
    Usual,
    /// With a Fortran D.
    LetterD,
    /// Three digits without a letter.
    Bare,
}

/// Powers of ten that are exact in a double.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
/// Largest integer up to which all are exact in a double.
const EXACT_INTEGER: u64 = 1 << 53;

/// Whether a byte is a blank: space, tab, carriage return or NUL.
pub(crate) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0)
}

fn at(text: &[u8], offset: usize) -> u8 {
    text.get(offset).copied().unwrap_or(b' ')
}

/// Appends the digits from an offset on to `integer` (which may wrap) and returns the offset of their end.
#[inline]
fn digits(text: &[u8], mut offset: usize, integer: &mut u64) -> usize {
    while let Some(eight) = text[offset..].first_chunk::<8>().and_then(eight_digits) {
        *integer = integer.wrapping_mul(100_000_000).wrapping_add(eight);
        offset += 8;
    }
    while let Some(&byte) = text.get(offset)
        && byte.is_ascii_digit()
    {
        *integer = integer.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
        offset += 1;
    }
    offset
}

/// Returns the value of eight digits; `None` where one of the bytes is not a digit.
///
/// The bytes are lanes of one word. Three steps combine neighbours: 10·a + b, 100·a + b, 10⁴·a + b.
#[inline]
fn eight_digits(bytes: &[u8; 8]) -> Option<u64> {
    let word = u64::from_le_bytes(*bytes);
    let high = 0xF0F0_F0F0_F0F0_F0F0;
    let zeros = 0x3030_3030_3030_3030;
    if word & high != zeros || word.wrapping_add(0x0606_0606_0606_0606) & high != zeros {
        return None;
    }
    let units = word - zeros;
    let pairs = (units * 10 + (units >> 8)) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_FFFF_0000_FFFF;
    Some((fours * 10_000 + (fours >> 32)) & 0xFFFF_FFFF)
}

/// Scans the next number from an offset on.
///
/// A number ends at a blank, at the end of the text, or at a sign that starts the next one (full Fortran
/// columns touch). A sign right after the mantissa is an exponent without letter if exactly three digits and
/// no point follow: Fortran omits the letter in no other case.
///
/// With mantissa ≤ 2⁵³ and |power of ten| ≤ 22, both are exact in a double, so that one product or quotient
/// is correctly rounded. All other numbers go to the parser of the standard library, which rounds correctly,
/// too.
#[inline]
pub(crate) fn scan(text: &[u8], from: usize) -> Scan {
    let mut start = from;
    while start < text.len() && is_blank(text[start]) {
        start += 1;
    }
    if start >= text.len() {
        return Scan::End;
    }
    let negative = text[start] == b'-';
    let whole = start + usize::from(negative || text[start] == b'+');
    let mut mantissa = 0_u64;
    let mut end = digits(text, whole, &mut mantissa);
    let mut count = end - whole;
    let mut decimals = 0;
    let point = at(text, end) == b'.';
    if point {
        let first = end + 1;
        end = digits(text, first, &mut mantissa);
        decimals = end - first;
        count += decimals;
    }
    let mantissa_end = end;
    let mut power = 0_i32;
    let mut form = Form::Usual;
    if let Some((digits_from, found)) = exponent_start(text, end, point) {
        let mut integer = 0;
        let digits_end = digits(text, digits_from, &mut integer);
        let magnitude = if digits_end - digits_from > 9 {
            99_999
        } else {
            i32::try_from(integer).unwrap_or(99_999).min(99_999)
        };
        power = if text[digits_from - 1] == b'-' { -magnitude } else { magnitude };
        (end, form) = (digits_end, found);
    }
    if count == 0 || !matches!(at(text, end), b' ' | b'\t' | b'\r' | 0 | b'-' | b'+') {
        let length = text[start..].iter().position(|&byte| is_blank(byte)).unwrap_or(text.len() - start);
        return Scan::Bad { start, end: start + length };
    }
    let scale = i64::from(power) - decimals as i64;
    let value = if count <= 19 && mantissa <= EXACT_INTEGER && (-22..=22).contains(&scale) {
        let factor = EXACT_POWERS[scale.unsigned_abs() as usize];
        let magnitude = if scale < 0 { mantissa as f64 / factor } else { mantissa as f64 * factor };
        if negative { -magnitude } else { magnitude }
    } else {
        exact(&text[start..end], &text[start..mantissa_end], power, form)
    };
    Scan::Number { value, end, form }
}

/// Returns the offset of the exponent's digits and its notation, if an exponent starts here.
#[inline]
fn exponent_start(text: &[u8], end: usize, point: bool) -> Option<(usize, Form)> {
    let form = match at(text, end) {
        b'E' | b'e' => Form::Usual,
        b'D' | b'd' => Form::LetterD,
        b'+' | b'-' if point => {
            let three = (1..=3).all(|offset| at(text, end + offset).is_ascii_digit());
            let next = at(text, end + 4);
            return (three && !next.is_ascii_digit() && next != b'.').then_some((end + 1, Form::Bare));
        }
        _ => return None,
    };
    let digits_from = end + 1 + usize::from(matches!(at(text, end + 1), b'+' | b'-'));
    at(text, digits_from).is_ascii_digit().then_some((digits_from, form))
}

/// Parses a number with the standard library: as written, or composed of mantissa and power of ten where
/// Rust's notation differs.
#[cold]
fn exact(number: &[u8], mantissa: &[u8], power: i32, form: Form) -> f64 {
    let text = match (form, str::from_utf8(number)) {
        (Form::Usual, Ok(text)) => return text.parse().unwrap_or(f64::NAN),
        _ => format!("{}e{power}", String::from_utf8_lossy(mantissa)),
    };
    text.parse().unwrap_or(f64::NAN)
}

/// Whether a field holds asterisks alone: Fortran fills a field with them that is too narrow for its number.
pub(crate) fn is_overflown(field: &[u8]) -> bool {
    !field.is_empty() && field.iter().all(|&byte| byte == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        match scan(text.as_bytes(), 0) {
            Scan::Number { value, .. } => value,
            other => panic!("{text}: {other:?}"),
        }
    }

    fn all(text: &str) -> Vec<f64> {
        let (mut values, mut offset) = (Vec::new(), 0);
        while let Scan::Number { value, end, .. } = scan(text.as_bytes(), offset) {
            values.push(value);
            offset = end;
        }
        values
    }

    #[test]
    fn a_million_numbers_match_the_standard_library_bit_for_bit() {
        let mut state = 7_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 11
        };
        for round in 0..1_000_000 {
            let decimals = (draw() % 20) as usize;
            let range = [5, 12, 25, 290][round % 4];
            let magnitude = draw() as f64 / 9e14 * 10_f64.powi((draw() % (2 * range)) as i32 - range as i32);
            let number = if draw() % 2 == 0 { -magnitude } else { magnitude };
            for text in [format!("{number:.decimals$e}"), format!("{number:.decimals$E}")] {
                let expected: f64 = text.parse().unwrap();
                assert_eq!(value(&text).to_bits(), expected.to_bits(), "{text}");
            }
        }
    }

    #[test]
    fn fortran_notations_are_parsed() {
        assert_eq!(value("1.5D-03"), 1.5e-3);
        assert_eq!(value("-1.5d+3"), -1.5e3);
        assert_eq!(value("1.0-105"), 1e-105);
        assert_eq!(value("-1.234567890123D-300"), -1.234_567_890_123e-300);
        assert_eq!(value("+5.E-300"), 5e-300);
        assert_eq!(value(" .5"), 0.5);
        assert_eq!(value("5."), 5.0);
        assert_eq!(value("0.00000E+000"), 0.0);
        assert_eq!(value("-0.0").to_bits(), (-0.0_f64).to_bits());
        assert_eq!(value("+12"), 12.0);
        assert_eq!(value("1e400"), f64::INFINITY);
        assert_eq!(value("123456789012345678901234567890"), 1.234_567_890_123_456_8e29);
    }

    #[test]
    fn touching_columns_are_separated() {
        assert_eq!(all("-1.00000E+00-2.00000E+00 3.0-105-4.0-105"), [-1.0, -2.0, 3e-105, -4e-105]);
        assert_eq!(all("-12.34567-123.4567-1234.567"), [-12.34567, -123.4567, -1234.567]);
    }

    #[test]
    fn invalid_numbers_are_refused() {
        for text in [
            "NaN",
            "*************",
            "1,5",
            "1.5.5",
            "-",
            ".",
            "E5",
            "1.0E",
            "1.0E+",
            "0x10",
            "1_0",
            "inf",
            "1.#QNAN",
        ] {
            assert!(matches!(scan(text.as_bytes(), 0), Scan::Bad { .. }), "{text}");
        }
        assert_eq!(scan(b"  \r", 0), Scan::End);
        assert_eq!(scan(b"", 0), Scan::End);
    }
}
