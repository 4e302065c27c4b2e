//! Writes the data of a record as text or binary.

use crate::abscissa::Abscissa;
use crate::kind::{ByteOrder, OrdinateType};
use crate::record::Ordinate;
use crate::write_field::{abscissa_field, scientific};

/// Returns how many numbers make one value.
pub(crate) fn numbers_per_value(abscissa: &Abscissa, kind: OrdinateType) -> usize {
    1 + usize::from(kind.is_complex()) + usize::from(matches!(abscissa, Abscissa::Uneven(_)))
}

/// Calls `with` for each value: its abscissa if stored, its real part, and its imaginary part if complex.
fn each_value(abscissa: &Abscissa, ordinate: &Ordinate, mut with: impl FnMut(Option<f64>, f64, Option<f64>)) {
    let stored = |index: usize| {
        if let Abscissa::Uneven(values) = abscissa { values.get(index).copied() } else { None }
    };
    match ordinate {
        Ordinate::Real(values) => {
            values.iter().enumerate().for_each(|(index, &value)| with(stored(index), value, None))
        }
        Ordinate::Complex(values) => {
            values.iter().enumerate().for_each(|(index, value)| with(stored(index), value.re, Some(value.im)))
        }
    }
}

/// Writes 6E13.5; 4E20.12; 2(E13.5,E20.12); E13.5,2E20.12. Returns the largest rounding error of the
/// abscissa.
pub(crate) fn text_payload(
    bytes: &mut Vec<u8>,
    abscissa: &Abscissa,
    ordinate: &Ordinate,
    kind: OrdinateType,
) -> f64 {
    let (decimals, width) = if kind.is_double() { (12, 20) } else { (5, 13) };
    let per_line = match (kind.is_double(), numbers_per_value(abscissa, kind)) {
        (false, _) => 6,
        (true, 3) => 3,
        (true, _) => 4,
    };
    let (mut on_line, mut shift) = (0, 0.0_f64);
    let mut next = |bytes: &mut Vec<u8>| {
        if on_line == per_line {
            bytes.push(b'\n');
            on_line = 0;
        }
        on_line += 1;
    };
    each_value(abscissa, ordinate, |stored, re, im| {
        if let Some(value) = stored {
            next(bytes);
            shift = shift.max((abscissa_field(bytes, value) - value).abs());
        }
        for part in [Some(re), im].into_iter().flatten() {
            next(bytes);
            scientific(bytes, part, decimals, width, 'E');
        }
    });
    if !ordinate.is_empty() {
        bytes.push(b'\n');
    }
    shift
}

/// Writes abscissa if uneven, real part, imaginary part if complex, all in one precision. Returns the largest
/// rounding error of the abscissa.
pub(crate) fn binary_payload(
    bytes: &mut Vec<u8>,
    abscissa: &Abscissa,
    ordinate: &Ordinate,
    kind: OrdinateType,
    order: ByteOrder,
) -> f64 {
    let double = kind.is_double();
    let mut put = |number: f64| match (double, order) {
        (false, ByteOrder::Little) => bytes.extend((number as f32).to_le_bytes()),
        (false, ByteOrder::Big) => bytes.extend((number as f32).to_be_bytes()),
        (true, ByteOrder::Little) => bytes.extend(number.to_le_bytes()),
        (true, ByteOrder::Big) => bytes.extend(number.to_be_bytes()),
    };
    let mut shift = 0.0_f64;
    each_value(abscissa, ordinate, |stored, re, im| {
        if let Some(value) = stored {
            put(value);
            if !double {
                shift = shift.max((f64::from(value as f32) - value).abs());
            }
        }
        put(re);
        im.into_iter().for_each(&mut put);
    });
    shift
}
