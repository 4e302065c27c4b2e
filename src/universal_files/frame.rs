//! Frame of a dataset: the lines `    -1` before and after it, and its number.

use std::io::{self, Read, Seek};

use crate::field::HeaderLine;
use crate::number::is_blank;
use crate::place::FilePlace;
use crate::source::ByteSource;

/// Number of bytes searched for the lines that follow a sentinel.
const LOOK_AHEAD: usize = 512;
/// Largest number of stray line-end bytes between a binary payload and its sentinel.
const STRAY_LIMIT: usize = 4;
const SENTINEL: &[u8; 6] = b"    -1";

/// A dataset's first line.
pub(crate) struct Frame {
    /// Dataset number.
    pub number: u32,
    /// Whether the dataset is binary.
    pub binary: bool,
    /// The line.
    pub line: HeaderLine,
}

/// Whether a line has -1 in columns 5 and 6, and nothing else.
pub(crate) fn is_sentinel(line: &[u8]) -> bool {
    line.strip_prefix(SENTINEL).is_some_and(all_blank)
}

/// Whether a line has -1 anywhere, and nothing else.
pub(crate) fn is_loose_sentinel(line: &[u8]) -> bool {
    let from = line.iter().position(|&byte| !is_blank(byte)).unwrap_or(line.len());
    line[from..].strip_prefix(b"-1").is_some_and(all_blank)
}

/// Whether a line has nothing but blanks.
pub(crate) fn all_blank(line: &[u8]) -> bool {
    line.iter().all(|&byte| is_blank(byte))
}

/// Returns the number in a dataset's first line, and whether a `b` (binary) follows it.
pub(crate) fn dataset_number(line: &[u8]) -> Option<(u32, bool)> {
    let from = line.iter().position(|&byte| !is_blank(byte))?;
    let digits = line[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    if !(1..=6).contains(&digits) {
        return None;
    }
    let number =
        line[from..from + digits].iter().fold(0, |number, &byte| 10 * number + u32::from(byte - b'0'));
    match line.get(from + digits) {
        None => Some((number, false)),
        Some(b'b' | b'B') => Some((number, true)),
        Some(&byte) => is_blank(byte).then_some((number, false)),
    }
}

/// Whether the end of the file or another dataset follows a closing sentinel.
///
/// `bare` also accepts a dataset number without its opening sentinel; `whole` means that the window ends with
/// the file.
fn dataset_follows(window: &[u8], whole: bool, bare: bool) -> bool {
    let mut lines = window.split(|&byte| byte == b'\n').skip_while(|line| all_blank(line));
    match lines.next() {
        None => true,
        Some(line) if is_loose_sentinel(line) => lines
            .find(|line| !all_blank(line))
            .is_none_or(|line| dataset_number(line).is_some() || is_loose_sentinel(line)),
        Some(line) => {
            (bare && line.len() <= 80 && dataset_number(line).is_some())
                || (!whole && window.len() == line.len())
        }
    }
}

impl<R: Read + Seek> ByteSource<R> {
    /// Whether the sentinel just read closes a dataset: the file ends after it, or another dataset begins.
    pub fn at_dataset_end(&mut self, bare: bool) -> io::Result<bool> {
        let window = self.peek(LOOK_AHEAD)?;
        let whole = window.len() < LOOK_AHEAD;
        Ok(dataset_follows(window, whole, bare))
    }

    /// Moves after the next line that closes a dataset; returns false if the file ends before.
    pub fn skip_dataset(&mut self) -> io::Result<bool> {
        while let Some(line) = self.line()? {
            if is_sentinel(line.text) && self.at_dataset_end(true)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns the bytes from here to the next closing sentinel, wherever in a line it starts; `None` if the
    /// file ends before. Does not move.
    pub fn distance_to_closing(&mut self) -> io::Result<Option<u64>> {
        let begin = self.place();
        loop {
            let window = self.window(SENTINEL.len())?;
            if window.len() < SENTINEL.len() {
                self.seek(begin)?;
                return Ok(None);
            }
            let (offset, found) = find_sentinel(window);
            self.pass(offset);
            if found {
                let here = self.position();
                let line = first_line(self.peek(LOOK_AHEAD)?);
                let length = line.len();
                if is_sentinel(line) {
                    self.seek(FilePlace { byte: here + length as u64 + 1, line: None })?;
                    if self.at_dataset_end(true)? {
                        self.seek(begin)?;
                        return Ok(Some(here - begin.byte));
                    }
                }
                self.seek(FilePlace { byte: here + 1, line: None })?;
            }
        }
    }

    /// Moves to `byte` and counts the stray line-end bytes there before a closing sentinel; `None` if no
    /// sentinel follows.
    pub fn closes_at(&mut self, byte: u64) -> io::Result<Option<usize>> {
        if byte > self.length() {
            return Ok(None);
        }
        self.seek(FilePlace { byte, line: None })?;
        let window = self.peek(LOOK_AHEAD)?;
        let stray =
            window.iter().take(STRAY_LIMIT).take_while(|&&byte| matches!(byte, b'\r' | b'\n')).count();
        Ok(is_sentinel(first_line(&window[stray..])).then_some(stray))
    }

    /// Counts the line-end bytes directly before `end` and not before here, at most [`STRAY_LIMIT`]. Does not
    /// move.
    pub fn stray_before(&mut self, end: u64) -> io::Result<u64> {
        let begin = self.place();
        let from = begin.byte.max(end.saturating_sub(STRAY_LIMIT as u64));
        self.seek(FilePlace { byte: from, line: None })?;
        let window = self.peek((end - from) as usize)?;
        let stray = window.iter().rev().take_while(|&&byte| matches!(byte, b'\r' | b'\n')).count();
        self.seek(begin)?;
        Ok(stray as u64)
    }
}

/// Returns the bytes up to the first line feed.
fn first_line(window: &[u8]) -> &[u8] {
    window.split(|&byte| byte == b'\n').next().unwrap_or_default()
}

/// Returns the offset of the first sentinel in a window and true; else the offset before which none starts,
/// and false.
fn find_sentinel(window: &[u8]) -> (usize, bool) {
    let starts = window.len() + 1 - SENTINEL.len();
    match window.windows(SENTINEL.len()).position(|bytes| bytes == SENTINEL) {
        Some(offset) => (offset, true),
        None => (starts, false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentinel_is_a_whole_line() {
        assert!(is_sentinel(b"    -1") && is_sentinel(b"    -1      \r"));
        assert!(
            !is_sentinel(b"    -1.0")
                && !is_sentinel(b"    -1 2")
                && !is_sentinel(b"   -1")
                && !is_sentinel(b"     -1")
        );
        assert!(
            is_loose_sentinel(b"-1")
                && is_loose_sentinel(b"   -1\r")
                && !is_loose_sentinel(b"-12")
                && !is_loose_sentinel(b"")
        );
    }

    #[test]
    fn a_dataset_number_has_up_to_six_digits() {
        assert_eq!(dataset_number(b"    58"), Some((58, false)));
        assert_eq!(dataset_number(b"    58b     1     2"), Some((58, true)));
        assert_eq!(dataset_number(b"  2411   \r"), Some((2411, false)));
        for text in ["", "   ", "58.5", "58c", "1234567", "-1", "NONE"] {
            assert_eq!(dataset_number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_dataset_ends_where_another_or_nothing_follows() {
        for text in ["", "\n  \n", "    -1\n    58\n", "\n    -1\n  2411", "    -1\n"] {
            assert!(dataset_follows(text.as_bytes(), true, false), "{text:?}");
        }
        for text in ["  1.0\n", "    -1\n  1.0\n", "    58\n", "text"] {
            assert!(!dataset_follows(text.as_bytes(), true, false), "{text:?}");
        }
        assert!(dataset_follows(b"    58\n", true, true));
    }
}
