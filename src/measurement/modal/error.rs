//! Faults of a curve.

use thiserror::Error;

/// Reason why no modes can be estimated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModalError {
    /// Slices of different length.
    #[error("{what} holds {found} values for {lines} frequency lines; give one per line")]
    Length {
        /// Name of the slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of frequency lines.
        lines: usize,
    },
    /// A value that is not finite, or out of its range.
    #[error("line {line} (counted from 0): {what} is {value}; {remedy}")]
    Value {
        /// Index of the line.
        line: usize,
        /// Name of the quantity.
        what: &'static str,
        /// Value found.
        value: f64,
        /// Remedy.
        remedy: &'static str,
    },
    /// Frequencies that do not rise.
    #[error(
        "line {line} (counted from 0): frequency {frequency_hz} Hz does not follow {previous_hz} Hz; sort the lines, each frequency once"
    )]
    Order {
        /// Index of the line.
        line: usize,
        /// Its frequency (Hz).
        frequency_hz: f64,
        /// Frequency of the line before (Hz).
        previous_hz: f64,
    },
    /// Not enough lines to fit one mode and its background.
    #[error(
        "{found} usable lines in {from_hz}..{to_hz} Hz; a fit needs at least {needed}: widen the band or measure with a finer resolution"
    )]
    TooFewLines {
        /// Lines with H ≠ 0 inside the band.
        found: usize,
        /// Smallest number.
        needed: usize,
        /// Lower end of the band (Hz).
        from_hz: f64,
        /// Upper end of the band (Hz).
        to_hz: f64,
    },
    /// H is zero on all lines.
    #[error("H is zero on all {lines} lines; the channel recorded nothing")]
    AllZero {
        /// Number of lines.
        lines: usize,
    },
    /// A band that is empty or reversed.
    #[error("local fit from {from_hz} Hz to {to_hz} Hz; give 0 <= from < to")]
    Band {
        /// Lower end (Hz).
        from_hz: f64,
        /// Upper end (Hz).
        to_hz: f64,
    },
    /// The weighted normal equations cannot be solved.
    #[error(
        "the modal fit of {from_hz}..{to_hz} Hz is singular with {modes} modes; ask for fewer modes or a wider band"
    )]
    Singular {
        /// Poles in the model.
        modes: usize,
        /// Lower end of the band (Hz).
        from_hz: f64,
        /// Upper end of the band (Hz).
        to_hz: f64,
    },
}
