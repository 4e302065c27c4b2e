//! Buffered bytes of a file: lines, look-ahead and jumps.

use std::io::{self, Read, Seek, SeekFrom};

use crate::place::FilePlace;

/// Number of bytes read at a time.
const WINDOW: usize = 1 << 16;
/// Longest line returned in one piece (bytes).
pub(crate) const LINE_LIMIT: usize = 1 << 20;

/// A line, without its line feed.
#[derive(Debug)]
pub(crate) struct SourceLine<'a> {
    /// Its bytes; a carriage return may be among them.
    pub text: &'a [u8],
    /// Place of its first byte.
    pub place: FilePlace,
    /// Whether a line feed ends it; otherwise the file ends, or the line is longer than [`LINE_LIMIT`].
    pub ended: bool,
}

/// A seekable file with a window of it in memory.
#[derive(Debug)]
pub(crate) struct ByteSource<R> {
    inner: R,
    buffer: Vec<u8>,
    /// Number of valid bytes in `buffer`.
    filled: usize,
    /// Index of the next byte in `buffer`.
    at: usize,
    /// Offset of `buffer[0]` in the file.
    start: u64,
    length: u64,
    line: Option<u64>,
}

impl<R: Read + Seek> ByteSource<R> {
    /// Creates a source at the start of the file.
    pub fn new(mut inner: R) -> io::Result<Self> {
        let length = inner.seek(SeekFrom::End(0))?;
        inner.seek(SeekFrom::Start(0))?;
        Ok(Self { inner, buffer: Vec::new(), filled: 0, at: 0, start: 0, length, line: Some(1) })
    }

    /// Returns the place of the next byte.
    pub fn place(&self) -> FilePlace {
        FilePlace { byte: self.position(), line: self.line }
    }

    /// Returns the offset of the next byte.
    pub fn position(&self) -> u64 {
        self.start + self.at as u64
    }

    /// Returns the size of the file (bytes).
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Returns the number of bytes from the next one to the end.
    pub fn remaining(&self) -> u64 {
        self.length.saturating_sub(self.position())
    }

    /// Moves to a place; keeps the window where possible.
    pub fn seek(&mut self, place: FilePlace) -> io::Result<()> {
        self.line = place.line;
        match place.byte.checked_sub(self.start) {
            Some(offset) if offset <= self.filled as u64 => self.at = offset as usize,
            _ => {
                self.inner.seek(SeekFrom::Start(place.byte))?;
                (self.start, self.filled, self.at) = (place.byte, 0, 0);
            }
        }
        Ok(())
    }

    /// Fills the window with at least `wanted` bytes, unless the file ends before, and returns how many there
    /// are.
    fn fill(&mut self, wanted: usize) -> io::Result<usize> {
        while self.filled - self.at < wanted {
            if self.at + wanted > self.buffer.len() {
                self.buffer.copy_within(self.at..self.filled, 0);
                self.start += self.at as u64;
                self.filled -= self.at;
                self.at = 0;
                let window = WINDOW.min(usize::try_from(self.length).unwrap_or(WINDOW)) + 1;
                if self.buffer.len() < wanted.max(window) {
                    self.buffer.resize(wanted.max(window).max(2 * self.filled), 0);
                }
            }
            match self.inner.read(&mut self.buffer[self.filled..]) {
                Ok(0) => break,
                Ok(count) => self.filled += count,
                Err(fault) if fault.kind() == io::ErrorKind::Interrupted => {}
                Err(fault) => return Err(fault),
            }
        }
        Ok(self.filled - self.at)
    }

    /// Returns up to `wanted` bytes from here, without moving; fewer only at the end of the file.
    pub fn peek(&mut self, wanted: usize) -> io::Result<&[u8]> {
        let available = self.fill(wanted)?.min(wanted);
        Ok(&self.buffer[self.at..self.at + available])
    }

    /// Returns all bytes in the window from here, at least `least` unless the file ends, without moving.
    pub fn window(&mut self, least: usize) -> io::Result<&[u8]> {
        self.fill(least)?;
        Ok(&self.buffer[self.at..self.filled])
    }

    /// Skips bytes of the window that are not text.
    pub fn pass(&mut self, count: usize) {
        self.at = (self.at + count).min(self.filled);
        self.line = None;
    }

    /// Returns the next line; `None` at the end of the file.
    pub fn line(&mut self) -> io::Result<Option<SourceLine<'_>>> {
        let mut searched = 0;
        let (length, ended) = loop {
            let available = self.fill(searched + 1)?;
            if available == searched {
                break (searched, false);
            }
            match line_feed(&self.buffer[self.at + searched..self.filled]) {
                Some(offset) => break (searched + offset, true),
                None => searched = available,
            }
            if searched >= LINE_LIMIT {
                break (LINE_LIMIT, false);
            }
        };
        if length == 0 && !ended {
            return Ok(None);
        }
        let place = self.place();
        let from = self.at;
        self.at += length + usize::from(ended);
        if ended {
            self.line = self.line.map(|line| line + 1);
        }
        Ok(Some(SourceLine { text: &self.buffer[from..from + length], place, ended }))
    }
}

/// Returns the offset of the first line feed.
fn line_feed(bytes: &[u8]) -> Option<usize> {
    let (blocks, _) = bytes.as_chunks::<32>();
    let clean = blocks
        .iter()
        .position(|block| block.iter().fold(false, |found, &byte| found | (byte == b'\n')))
        .unwrap_or(blocks.len());
    bytes[32 * clean..].iter().position(|&byte| byte == b'\n').map(|offset| 32 * clean + offset)
}
