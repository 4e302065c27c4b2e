//! Reads universal files dataset by dataset.

use std::io::{Read, Seek};
use std::sync::Arc;

use crate::abscissa::Abscissa;
use crate::ascii;
use crate::binary;
use crate::companion::{self, FileHeader, Node, Skipped, TraceLine};
use crate::error::UniversalError;
use crate::frame::Frame;
use crate::header::read_header;
use crate::kind::Encoding;
use crate::layout::find_extent;
use crate::place::FilePlace;
use crate::record::{RecordHeader, UniversalRecord};
use crate::source::ByteSource;
use crate::units::Units;
use crate::warning::{Warning, WarningKind};

/// Byte-order mark that some programs write before text in UTF-8.
const BYTE_ORDER_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];
/// Number of bytes whose line ends are examined in a file without datasets.
const LINE_END_SAMPLE: usize = 1 << 16;

/// A dataset; `F` is [`UniversalRecord`], or [`RecordHeader`] where only headers are read.
#[derive(Debug, Clone, PartialEq)]
pub enum Dataset<F = UniversalRecord> {
    /// Dataset 58.
    Function(Box<F>),
    /// Dataset 151.
    Header(FileHeader),
    /// Dataset 164; it is in force for all later datasets.
    Units(Units),
    /// Datasets 15 and 2411.
    Nodes(Vec<Node>),
    /// Dataset 82.
    TraceLines(Vec<TraceLine>),
    /// A dataset that is not read.
    Skipped(Skipped),
}

/// Reads a universal file dataset by dataset, with no more than one record in memory.
///
/// ```no_run
/// # use universal_files::{Dataset, UniversalReader};
/// let mut reader = UniversalReader::new(std::fs::File::open("beam.uff")?)?;
/// while let Some(dataset) = reader.next_header() {
///     if let Dataset::Function(header) = dataset? {
///         println!("{}: {} values", header.id_lines[0], header.count);
///     }
/// }
/// # Ok::<(), universal_files::UniversalError>(())
/// ```
///
/// After a refused record the next call continues with the next dataset; after a failure of the file itself
/// reading ends.
#[derive(Debug)]
pub struct UniversalReader<R> {
    pub(crate) source: ByteSource<R>,
    units: Option<Arc<Units>>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) further: u64,
    /// Whether a closing sentinel directly precedes.
    pub(crate) closed: bool,
    /// Whether the dataset being read is binary.
    pub(crate) binary: bool,
    ended: bool,
    /// Whether a missing value (NaN, infinite, asterisks) is read as NaN; otherwise it refuses the record.
    accepts_missing: bool,
}

impl<R: Read + Seek> UniversalReader<R> {
    /// Creates a reader at the start of a seekable input.
    pub fn new(inner: R) -> Result<Self, UniversalError> {
        let mut source = ByteSource::new(inner)?;
        if source.peek(BYTE_ORDER_MARK.len())? == BYTE_ORDER_MARK {
            source.seek(FilePlace { byte: BYTE_ORDER_MARK.len() as u64, line: Some(1) })?;
        }
        Ok(Self {
            source,
            units: None,
            warnings: Vec::new(),
            further: 0,
            closed: false,
            binary: false,
            ended: false,
            accepts_missing: false,
        })
    }

    /// Reads a missing value (NaN, infinite, or a field of asterisks) as NaN, instead of refusing its record.
    /// Asterisks in a counter of a header are 0, and cost a node only itself.
    pub fn accept_missing(mut self) -> Self {
        self.accepts_missing = true;
        self
    }

    /// Returns the next dataset, records with their data.
    pub fn next_dataset(&mut self) -> Option<Result<Dataset, UniversalError>> {
        self.step(Self::read_record)
    }

    /// Returns the next dataset, records as headers alone. Payloads are skipped, and faults in them are not
    /// detected.
    pub fn next_header(&mut self) -> Option<Result<Dataset<RecordHeader>, UniversalError>> {
        self.step(Self::read_record_header)
    }

    /// Reads the record of a header that this reader returned; the next call of the reader continues after
    /// it.
    pub fn record(&mut self, header: &RecordHeader) -> Result<UniversalRecord, UniversalError> {
        self.source.seek(header.place)?;
        self.ended = false;
        let units = std::mem::replace(&mut self.units, header.units.clone());
        let record = match self.open_line() {
            Ok(Some(frame)) if frame.number == 58 => self.read_record(frame),
            Ok(_) => Err(UniversalError::NoDataset),
            Err(fault) => Err(fault),
        };
        self.units = units;
        match &record {
            Ok(_) => {}
            Err(UniversalError::Io(_)) => self.ended = true,
            Err(_) => self.ended = self.find_next().is_err(),
        }
        record
    }

    /// Returns the tolerated faults outside records so far.
    pub fn warnings(&self) -> Vec<Warning> {
        let further = (self.further > 0)
            .then_some(Warning { place: None, kind: WarningKind::Further { count: self.further } });
        self.warnings.iter().cloned().chain(further).collect()
    }

    /// Returns the size of the file (bytes).
    pub(crate) fn length(&self) -> u64 {
        self.source.length()
    }

    /// Creates the error of a file with thousands of tiny datasets.
    pub(crate) fn too_many_small(&self) -> UniversalError {
        UniversalError::TooManySmall { place: self.source.place(), what: "datasets" }
    }

    /// Creates the error of a file without any dataset.
    pub(crate) fn nothing_found(mut self) -> UniversalError {
        let wanted = LINE_END_SAMPLE.min(usize::try_from(self.source.length()).unwrap_or(LINE_END_SAMPLE));
        let sample = self.source.seek(FilePlace::default()).and_then(|()| self.source.peek(wanted));
        match sample {
            Ok(sample) if sample.contains(&b'\r') && !sample.contains(&b'\n') => {
                UniversalError::BareCarriageReturn
            }
            Ok(_) => UniversalError::NoDataset,
            Err(fault) => fault.into(),
        }
    }

    fn step<F>(
        &mut self,
        function: fn(&mut Self, Frame) -> Result<F, UniversalError>,
    ) -> Option<Result<Dataset<F>, UniversalError>> {
        if self.ended {
            return None;
        }
        let dataset = self.dataset(function);
        let lost = match &dataset {
            Ok(found) => found.is_none(),
            Err(UniversalError::Io(_)) => true,
            Err(_) => self.find_next().is_err(),
        };
        self.ended = lost;
        dataset.transpose()
    }

    fn dataset<F>(
        &mut self,
        function: fn(&mut Self, Frame) -> Result<F, UniversalError>,
    ) -> Result<Option<Dataset<F>>, UniversalError> {
        let Some(frame) = self.open_frame()? else { return Ok(None) };
        let place = frame.line.place;
        let mut warnings = Vec::new();
        let length_factor = self.units.as_ref().map(|units| units.length_factor);
        let found = match (frame.number, frame.binary) {
            (58, _) => return function(self, frame).map(|record| Some(Dataset::Function(Box::new(record)))),
            (151, false) => {
                companion::read_file_header(&mut self.source, place, &mut warnings).map(Dataset::Header)
            }
            (164, false) => companion::read_units(&mut self.source, place, &mut warnings).map(Dataset::Units),
            (15 | 2411, false) => {
                let how = (length_factor, self.accepts_missing);
                companion::read_nodes(&mut self.source, frame.number, how, &mut warnings).map(Dataset::Nodes)
            }
            (82, false) => {
                companion::read_trace_lines(&mut self.source, &mut warnings).map(Dataset::TraceLines)
            }
            (number, _) => {
                self.find_next()?;
                return Ok(Some(Dataset::Skipped(Skipped { number, place, times: 1 })));
            }
        };
        self.warn(warnings);
        if frame.number == 164 {
            // Units before it are no longer in force, even where it cannot be read.
            self.units = None;
        }
        let found = found?;
        if let Dataset::Units(units) = &found {
            self.units = Some(Arc::new(units.clone()));
        }
        self.close()?;
        Ok(Some(found))
    }

    fn read_record(&mut self, frame: Frame) -> Result<UniversalRecord, UniversalError> {
        let (mut header, byte_count) = read_header(
            &mut self.source,
            frame.line,
            (frame.binary, self.accepts_missing),
            self.units.clone(),
        )?;
        let (abscissa, ordinate) = match header.encoding {
            Encoding::Ascii => ascii::read_values(&mut self.source, &mut header, self.accepts_missing)?,
            Encoding::Binary(order) => {
                let extent = find_extent(&mut self.source, &mut header, byte_count)?;
                let values =
                    binary::read_values(&mut self.source, &header, (order, self.accepts_missing), extent)?;
                self.close_payload(&mut header)?;
                values
            }
        };
        self.closed = true;
        abscissa.check(header.place, &mut header.warnings);
        header.warnings.shrink_to_fit();
        Ok(UniversalRecord { header, abscissa, ordinate })
    }

    fn read_record_header(&mut self, frame: Frame) -> Result<RecordHeader, UniversalError> {
        let (mut header, byte_count) = read_header(
            &mut self.source,
            frame.line,
            (frame.binary, self.accepts_missing),
            self.units.clone(),
        )?;
        match header.encoding {
            Encoding::Ascii => ascii::skip_values(&mut self.source, &mut header)?,
            Encoding::Binary(_) => {
                let extent = find_extent(&mut self.source, &mut header, byte_count)?;
                let byte = self.source.position() + extent.layout.stride() * extent.count;
                self.source.seek(FilePlace { byte, line: None })?;
                self.close_payload(&mut header)?;
            }
        }
        self.closed = true;
        if header.even {
            let (first, step, count) = (header.abscissa_first, header.abscissa_step, header.count);
            Abscissa::Even { first, step, count }.check(header.place, &mut header.warnings);
        }
        header.warnings.shrink_to_fit();
        Ok(header)
    }
}

impl<R: Read + Seek> Iterator for UniversalReader<R> {
    type Item = Result<Dataset, UniversalError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_dataset()
    }
}
