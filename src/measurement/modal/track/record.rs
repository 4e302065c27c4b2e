//! Input of mode tracking.

use super::super::FittedMode;

/// The modes of one record.
#[derive(Debug, Clone, Copy)]
pub struct TrackRecord<'a> {
    /// Nut position (m), finite; records without one form a separate chain, in which modes should not move.
    pub nut_m: Option<f64>,
    /// Key shared by records of the same response, excitation, quantity and operating condition; amplitudes
    /// are compared only among them.
    pub series: &'a str,
    /// Fitted band (Hz).
    pub band_hz: (f64, f64),
    /// Modes.
    pub modes: &'a [FittedMode],
}
