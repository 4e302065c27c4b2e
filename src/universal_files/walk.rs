//! Moves from dataset to dataset: sentinels, stray text and skipped datasets.

use std::io::{Read, Seek};

use crate::error::UniversalError;
use crate::field::HeaderLine;
use crate::frame::{Frame, all_blank, dataset_number, is_loose_sentinel, is_sentinel};
use crate::place::FilePlace;
use crate::reader::UniversalReader;
use crate::record::RecordHeader;
use crate::warning::{Warning, WarningKind};

/// Largest number of faults between datasets that are listed one by one.
const WARNING_LIMIT: usize = 100;

impl<R: Read + Seek> UniversalReader<R> {
    /// Adds faults outside records; those beyond [`WARNING_LIMIT`] are only counted.
    pub(crate) fn warn(&mut self, warnings: impl IntoIterator<Item = Warning>) {
        for warning in warnings {
            if self.warnings.len() < WARNING_LIMIT {
                self.warnings.push(warning);
            } else {
                self.further += 1;
            }
        }
    }

    /// Reads the sentinel after a binary payload, and stray bytes before it.
    pub(crate) fn close_payload(&mut self, header: &mut RecordHeader) -> Result<(), UniversalError> {
        let place = self.source.place();
        match self.source.closes_at(place.byte)? {
            Some(stray) => {
                self.source.pass(stray);
                self.source.line()?;
            }
            None => header.warnings.push(WarningKind::MissingClosing.at(place)),
        }
        Ok(())
    }

    /// Reads the sentinel that closes a text dataset; text before it is skipped with a warning.
    pub(crate) fn close(&mut self) -> Result<(), UniversalError> {
        let mut stray: Option<(FilePlace, u64)> = None;
        loop {
            let place = self.source.place();
            let Some(line) = self.source.line()? else {
                self.warn([WarningKind::MissingClosing.at(place)]);
                break;
            };
            if is_sentinel(line.text) {
                break;
            }
            if is_loose_sentinel(line.text) {
                self.warn([WarningKind::SentinelColumns.at(place)]);
                break;
            }
            if !all_blank(line.text) {
                stray.get_or_insert((place, 0)).1 += 1;
            }
        }
        self.warn(stray.map(|(place, lines)| WarningKind::StrayText { lines }.at(place)));
        self.closed = true;
        Ok(())
    }

    /// Moves after the next closing sentinel: past a dataset that is not read, or the rest of a refused one.
    pub(crate) fn find_next(&mut self) -> Result<(), UniversalError> {
        let place = self.source.place();
        let found = if self.binary {
            let distance = self.source.distance_to_closing()?;
            let byte = place.byte + distance.unwrap_or_else(|| self.source.remaining());
            self.source.seek(FilePlace { byte, line: None })?;
            self.source.line()?.is_some()
        } else {
            self.source.skip_dataset()?
        };
        if !found {
            self.warn([WarningKind::MissingClosing.at(self.source.place())]);
        }
        self.closed = true;
        Ok(())
    }

    /// Reads the first line of the next dataset; `None` at the end of the file.
    pub(crate) fn open_frame(&mut self) -> Result<Option<Frame>, UniversalError> {
        let mut opened = false;
        let mut stray: Option<(FilePlace, u64)> = None;
        let frame = loop {
            let place = self.source.place();
            let Some(line) = self.source.line()? else { break None };
            if all_blank(line.text) {
                continue;
            }
            if is_sentinel(line.text) || (self.closed && is_loose_sentinel(line.text)) {
                opened = true;
                continue;
            }
            if (opened || self.closed) && dataset_number(line.text).is_some() {
                self.source.seek(place)?;
                break self.open_line()?;
            }
            stray.get_or_insert((place, 0)).1 += 1;
            (opened, self.closed) = (false, false);
        };
        self.warn(stray.map(|(place, lines)| WarningKind::StrayText { lines }.at(place)));
        if let (Some(frame), false) = (&frame, opened) {
            let place = frame.line.place;
            self.warn([WarningKind::MissingOpening.at(place)]);
        }
        self.closed = false;
        Ok(frame)
    }

    /// Reads the first line of a dataset, which starts here.
    pub(crate) fn open_line(&mut self) -> Result<Option<Frame>, UniversalError> {
        let Some(line) = self.source.line()? else { return Ok(None) };
        let Some((number, binary)) = dataset_number(line.text) else { return Ok(None) };
        self.binary = binary;
        Ok(Some(Frame { number, binary, line: HeaderLine::new(&line, &mut Vec::new()) }))
    }
}
