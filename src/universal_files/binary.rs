//! Reads the payload of a binary record.

use std::io::{self, Read, Seek};

use num_complex::Complex64;

use crate::abscissa::Abscissa;
use crate::error::UniversalError;
use crate::kind::ByteOrder;
use crate::layout::{Extent, Layout};
use crate::place::FilePlace;
use crate::point::Values;
use crate::record::{Ordinate, RecordHeader};
use crate::source::ByteSource;

/// Reads the payload that starts here. The source ends up after it, also after a refusal.
pub(crate) fn read_values<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &RecordHeader,
    (order, accepts_missing): (ByteOrder, bool),
    extent: Extent,
) -> Result<(Abscissa, Ordinate), UniversalError> {
    let Extent { layout, count } = extent;
    let stride = layout.stride();
    let start = source.position();
    let end = FilePlace { byte: start + stride * count, line: None };
    // The extent ends inside the file, so that the bytes of the file bound the count.
    let count = count as usize;
    let complex = layout.ordinate.is_complex();
    let mut values = Values::default();
    values.reserve(count, complex, header.even);
    let mut left = count;
    while left > 0 {
        let window = source.window(stride as usize)?;
        let whole = (window.len() / stride as usize).min(left);
        if whole == 0 {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
        }
        let done = count - left;
        decode(&window[..whole * stride as usize], layout, order, &mut values);
        if let Some((index, found)) = values.first_not_finite(done, complex, accepts_missing) {
            source.seek(end)?;
            let place = FilePlace { byte: start + stride * index as u64, line: None };
            return Err(UniversalError::NotFinite { place, index: index as u64, found });
        }
        source.pass(whole * stride as usize);
        left -= whole;
    }
    source.seek(end)?;
    Ok(values.finish(header))
}

impl Values {
    /// Returns the first value from an index on that is NaN or infinite; on the abscissa alone where missing
    /// values are accepted.
    fn first_not_finite(&self, from: usize, complex: bool, accepts_missing: bool) -> Option<(usize, String)> {
        let abscissa = self.abscissa.get(from..).unwrap_or_default();
        let bad = |value: f64| !value.is_finite();
        if let Some(offset) = abscissa.iter().position(|&value| bad(value)) {
            return Some((from + offset, format!("{} on the abscissa", abscissa[offset])));
        }
        if accepts_missing {
            return None;
        }
        if complex {
            let values = &self.complex[from..];
            let offset = values.iter().position(|value| bad(value.re) || bad(value.im))?;
            return Some((from + offset, values[offset].to_string()));
        }
        let values = &self.real[from..];
        let offset = values.iter().position(|&value| bad(value))?;
        Some((from + offset, values[offset].to_string()))
    }
}

/// Appends whole values.
fn decode(bytes: &[u8], layout: Layout, order: ByteOrder, values: &mut Values) {
    match (layout.ordinate.is_double(), order) {
        (false, ByteOrder::Little) => {
            append(bytes, layout, order, values, |bytes: [u8; 4]| f64::from(f32::from_le_bytes(bytes)))
        }
        (false, ByteOrder::Big) => {
            append(bytes, layout, order, values, |bytes: [u8; 4]| f64::from(f32::from_be_bytes(bytes)))
        }
        (true, ByteOrder::Little) => append(bytes, layout, order, values, f64::from_le_bytes),
        (true, ByteOrder::Big) => append(bytes, layout, order, values, f64::from_be_bytes),
    }
}

/// Appends whole values of numbers of `B` bytes.
fn append<const B: usize>(
    bytes: &[u8],
    layout: Layout,
    order: ByteOrder,
    values: &mut Values,
    number: impl Fn([u8; B]) -> f64,
) {
    if layout.abscissa_bytes == 0 {
        let (numbers, _) = bytes.as_chunks::<B>();
        if layout.ordinate.is_complex() {
            let (pairs, _) = numbers.as_chunks::<2>();
            values.complex.extend(pairs.iter().map(|&[re, im]| Complex64::new(number(re), number(im))));
        } else {
            values.real.extend(numbers.iter().map(|&bytes| number(bytes)));
        }
        return;
    }
    for value in bytes.chunks_exact(layout.stride() as usize) {
        let (first, rest) = value.split_at(layout.abscissa_bytes as usize);
        values.abscissa.push(abscissa(first, order));
        match *rest.as_chunks::<B>().0 {
            [re, im] => values.complex.push(Complex64::new(number(re), number(im))),
            [re] => values.real.push(number(re)),
            _ => {}
        }
    }
}

/// Decodes an abscissa of 4 or 8 bytes.
fn abscissa(bytes: &[u8], order: ByteOrder) -> f64 {
    if let &[a, b, c, d] = bytes {
        let bytes = [a, b, c, d];
        return f64::from(if order == ByteOrder::Little {
            f32::from_le_bytes(bytes)
        } else {
            f32::from_be_bytes(bytes)
        });
    }
    let bytes = bytes.first_chunk::<8>().copied().unwrap_or_default();
    if order == ByteOrder::Little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) }
}
