//! Table of an imported FRF, as lines and as text.

use std::borrow::Borrow;
use std::fmt::Write;

use num_complex::Complex64;

use super::ImportedFrf;
use crate::frf::{Fault, ReadLines, SortedLines};

/// Table of an imported FRF. Lines without coherence are left out where the others have one.
pub(crate) struct ImportedTable<F = ImportedFrf> {
    pub frf: F,
    /// Whether the number of averages is known, which a coherence needs.
    pub averaged: bool,
}

/// A line of a table: frequency (Hz), value, coherence, relative standard deviation.
type Line = (f64, Complex64, Option<f64>, Option<f64>);

impl<F: Borrow<ImportedFrf>> ImportedTable<F> {
    fn coherence(&self) -> Option<&[f64]> {
        let coherence = self.frf.borrow().coherence.as_deref();
        coherence.filter(|c| self.averaged && c.iter().any(|c| c.is_finite()))
    }

    fn rows(&self) -> impl Iterator<Item = Line> {
        let frf = self.frf.borrow();
        let coherence = self.coherence();
        let relative_sd = |at: usize| frf.relative_sd.as_ref().map(|sd| sd[at]).filter(|sd| sd.is_finite());
        let lines = frf.frequency_hz.iter().zip(&frf.values).enumerate();
        lines
            .map(move |(at, (f, h))| (*f, *h, coherence.map(|c| c[at]), relative_sd(at)))
            .filter(|(_, _, coherence, _)| coherence.is_none_or(f64::is_finite))
    }

    /// Returns its lines, checked as those of a file.
    ///
    /// # Errors  as those of a file.
    pub(crate) fn lines(&self) -> Result<ReadLines, Fault> {
        let mut sorted = SortedLines::default();
        for (frequency_hz, value, coherence, relative_sd) in self.rows() {
            sorted.add(frequency_hz, value, coherence, relative_sd)?;
        }
        sorted.finish(self.coherence().is_some())
    }

    /// Formats it.
    pub(crate) fn text(&self) -> String {
        /// Usual length of a line (bytes).
        const LINE: usize = 80;
        let has_sd = self.frf.borrow().relative_sd.is_some();
        let mut text = String::with_capacity(LINE * (self.frf.borrow().values.len() + 1));
        text += "frequency_hz,real,imag";
        text += if self.coherence().is_some() { ",coherence" } else { "" };
        text += if has_sd { ",relative_sd\n" } else { "\n" };
        for (f, h, coherence, relative_sd) in self.rows() {
            let _ = write!(text, "{f:?},{:e},{:e}", h.re, h.im);
            if let Some(coherence) = coherence {
                let _ = write!(text, ",{coherence}");
            }
            match relative_sd {
                Some(sd) => _ = write!(text, ",{sd}"),
                None if has_sd => text.push(','),
                None => {}
            }
            text.push('\n');
        }
        text
    }
}
