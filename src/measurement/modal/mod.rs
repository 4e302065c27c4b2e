//! Natural frequencies, damping ratios and amplitudes from measured curves, tracked over positions.
//!
//! ```text
//! curve ─ lscf (polynomial) ─ stabilisation ─ selection ─┬─ fit ─── Mode ─── track
//! (lines)  (poles per order)   (candidates)   (modes)    │  (± sd)          (sighting, process, search, evidence)
//!           model, least_squares, noise ─────────────────┘
//! ```
//!
//! [`fit_curve`] finds the modes of one curve; [`track`](track()) follows them over records and reports which are regular, with
//! reasons. The result is deterministic: nothing is drawn at random.

mod curve;
mod error;
mod fit;
mod least_squares;
mod lscf;
mod model;
mod noise;
mod peak;
mod polynomial;
mod selection;
mod stabilisation;
mod track;

pub use curve::{CurveFit, CurveOptions, FrfCurve, LEAST_LINES};
pub use error::ModalError;
pub use fit::{Amplitude, AmplitudeKind, FittedMode, ModalFit, fit_curve, with_curve_of};
pub use stabilisation::{DiagramPole, Stability, stabilisation_diagram};
pub use track::{TrackEvidence, TrackRecord, TrackedMode, track};

#[cfg(test)]
mod tests;
