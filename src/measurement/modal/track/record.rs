//! What tracking is given.

use super::super::FittedMode;

/// The modes of one record.
#[derive(Debug, Clone, Copy)]
pub struct TrackRecord<'a> {
    /// Its name.
    pub name: &'a str,
    /// Nut position (m); records without one form a chain of their own, of modes that should not move.
    pub nut_m: Option<f64>,
    /// Records of the same response, excitation and quantity carry the same text: only their amplitudes are compared.
    pub series: &'a str,
    /// Band fitted (Hz).
    pub band_hz: (f64, f64),
    /// Its modes.
    pub modes: &'a [FittedMode],
}
