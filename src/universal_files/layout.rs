//! Layout and size of the payload of a binary record.

use std::io::{Read, Seek};

use crate::error::UniversalError;
use crate::evidence::SizeEvidence;
use crate::kind::OrdinateType;
use crate::place::FilePlace;
use crate::record::RecordHeader;
use crate::source::ByteSource;
use crate::warning::WarningKind;

/// Storage of one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Bytes of the abscissa: 0 if even, else 4 or 8.
    pub abscissa_bytes: u64,
    /// Type and precision of the ordinate.
    pub ordinate: OrdinateType,
}

/// The payload of a binary record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Extent {
    /// Layout of each value.
    pub layout: Layout,
    /// Whole values.
    pub count: u64,
}

/// End of an extent.
enum LayoutFit {
    /// A sentinel closes it, after this number of stray bytes.
    Closed(usize),
    /// The file ends before a sentinel.
    Open,
}

impl Layout {
    /// Returns the bytes of one value.
    pub fn stride(self) -> u64 {
        let number = if self.ordinate.is_double() { 8 } else { 4 };
        self.abscissa_bytes + if self.ordinate.is_complex() { 2 * number } else { number }
    }

    /// Returns the layouts a header may mean: first that of the format, then the abscissa in 8 bytes, then
    /// the other precision.
    fn candidates(header: &RecordHeader) -> Vec<Self> {
        let declared = header.ordinate_type;
        let other = OrdinateType::new(declared.is_complex(), !declared.is_double());
        let widths = |ordinate: OrdinateType| match (header.even, ordinate.is_double()) {
            (true, _) => &[0][..],
            (false, false) => &[4],
            (false, true) => &[4, 8],
        };
        let of =
            |ordinate| widths(ordinate).iter().map(move |&abscissa_bytes| Self { abscissa_bytes, ordinate });
        of(declared).chain(of(other)).collect()
    }
}

/// Finds the extent of the payload that starts here: a closing sentinel must follow it.
///
/// The first match decides:
/// 1. each layout × the number of values;
/// 2. the byte count of the first line, if it is a whole number of values;
/// 3. the distance to the next sentinel, if it is a whole number of values below the declared one;
/// 4. at the end of a file without sentinel, the layout that the byte count confirms or that ends with the
///    file.
///
/// Matches 2 and 3 exclude twice, three times, a half or a third of the declared values, which indicates
/// another type or spacing. Deviations from the header give warnings. Without a match the record is refused.
pub(crate) fn find_extent<R: Read + Seek>(
    source: &mut ByteSource<R>,
    header: &mut RecordHeader,
    byte_count: Option<u64>,
) -> Result<Extent, UniversalError> {
    let start = source.place();
    let declared = header.count as u64;
    let candidates = Layout::candidates(header);
    let size = |layout: Layout, count: u64| layout.stride().saturating_mul(count);
    let native = |layout: &&Layout| layout.ordinate == header.ordinate_type;

    for &layout in &candidates {
        if let Some(stray) = source.closes_at(start.byte.saturating_add(size(layout, declared)))? {
            source.seek(start)?;
            let extent = Extent { layout, count: declared };
            report(
                header,
                extent,
                byte_count,
                SizeEvidence::TypeAndCount,
                &LayoutFit::Closed(stray),
                start.byte,
            );
            return Ok(extent);
        }
    }
    if let Some(bytes) = byte_count.filter(|&bytes| bytes > 0)
        && let Some(stray) = source.closes_at(start.byte.saturating_add(bytes))?
    {
        source.seek(start)?;
        let mut whole = candidates.iter().filter(native).filter(|layout| bytes % layout.stride() == 0);
        if let (Some(&layout), None) = (whole.next(), whole.next())
            && !is_other_type(bytes / layout.stride(), declared)
        {
            let extent = Extent { layout, count: bytes / layout.stride() };
            report(
                header,
                extent,
                byte_count,
                SizeEvidence::HeaderBytes,
                &LayoutFit::Closed(stray),
                start.byte,
            );
            return Ok(extent);
        }
    }
    source.seek(start)?;
    let closing = source.distance_to_closing()?;
    let distance = closing.unwrap_or_else(|| source.remaining());
    let stray = source.stray_before(start.byte + distance)?;
    if closing.is_some() {
        let mut whole = candidates.iter().filter(native).flat_map(|&layout| {
            let lengths = (0..=stray).map(move |stray| (layout, distance - stray, stray));
            lengths.filter(|(layout, bytes, _)| {
                bytes % layout.stride() == 0 && bytes / layout.stride() < declared
            })
        });
        if let (Some((layout, bytes, stray)), None) = (whole.next(), whole.next())
            && !is_other_type(bytes / layout.stride(), declared)
        {
            let extent = Extent { layout, count: bytes / layout.stride() };
            report(
                header,
                extent,
                byte_count,
                SizeEvidence::NextSentinel,
                &LayoutFit::Closed(stray as usize),
                start.byte,
            );
            return Ok(extent);
        }
    } else {
        let confirmed =
            candidates.iter().filter(native).find(|&&layout| byte_count == Some(size(layout, declared)));
        let ending = || {
            candidates.iter().find(|&&layout| (distance - stray..=distance).contains(&size(layout, declared)))
        };
        if let Some(&layout) = confirmed.or_else(ending) {
            let extent = Extent { layout, count: declared.min(distance / layout.stride()) };
            let evidence =
                if confirmed.is_some() { SizeEvidence::TypeAndCount } else { SizeEvidence::EndOfFile };
            report(header, extent, byte_count, evidence, &LayoutFit::Open, start.byte);
            return Ok(extent);
        }
    }
    let expected = size(candidates[0], declared);
    Err(UniversalError::PayloadSize {
        place: header.place,
        count: declared,
        expected,
        header_bytes: byte_count,
        distance,
    })
}

/// Whether a count is twice, three times, a half or a third of the declared one: another type or spacing is
/// more likely than another count.
fn is_other_type(found: u64, declared: u64) -> bool {
    [2, 3].iter().any(|&factor| {
        found.checked_mul(factor) == Some(declared) || declared.checked_mul(factor) == Some(found)
    })
}

/// Writes type and count as found into the header, and warns of deviations.
fn report(
    header: &mut RecordHeader,
    extent: Extent,
    byte_count: Option<u64>,
    evidence: SizeEvidence,
    fit: &LayoutFit,
    start: u64,
) {
    let place = header.place;
    let declared = header.count as u64;
    let bytes = extent.layout.stride() * extent.count;
    let cut = matches!(fit, LayoutFit::Open) && extent.count < declared;
    if byte_count != Some(bytes) && !cut {
        header.warnings.push(WarningKind::ByteCount { found: byte_count, used: bytes, evidence }.at(place));
    }
    if extent.layout.ordinate != header.ordinate_type {
        header.warnings.push(
            WarningKind::Precision { declared: header.ordinate_type, used: extent.layout.ordinate, evidence }
                .at(place),
        );
        header.ordinate_type = extent.layout.ordinate;
    }
    // A byte count that states 8 bytes leaves nothing to decide: several programs, this one among them, write them.
    if extent.layout.abscissa_bytes == 8 && byte_count != Some(bytes) {
        header.warnings.push(WarningKind::WideAbscissa { evidence }.at(place));
    }
    if cut {
        header.warnings.push(WarningKind::Truncated { declared, found: extent.count }.at(place));
    } else if extent.count != declared {
        header.warnings.push(WarningKind::ValueCount { declared, found: extent.count, evidence }.at(place));
    }
    if extent.count == 0 {
        header.warnings.push(WarningKind::NoValues.at(place));
    }
    if let LayoutFit::Closed(stray @ 1..) = *fit {
        let place = FilePlace { byte: start + bytes, line: None };
        header.warnings.push(WarningKind::StrayLineEnd { bytes: stray as u64 }.at(place));
    }
    header.count = extent.count as usize;
}
