//! A self-contained HTML page: it contains the charts' script, its style and all numbers, and opens without a
//! network.

mod chart;
mod comparison;
mod curve;
mod frame;
mod loops;
mod motion;
mod parameter;
mod peak;
mod position;
mod predicted;
mod shape;
mod sketch;
mod text;
mod thin;
mod verdict;

pub use curve::{PageCurve, PeakMark};
pub use frame::{MOST_BYTES, html};
pub use predicted::MeasuredMode;
pub use shape::{Deflection, ModeShape, ShapeGroup};
pub use sketch::Sketch;

use std::collections::BTreeMap;

use super::diagnosis::DiagnosisDocument;
use super::document::{ComparisonDocument, IdentificationDocument, PeaksDocument, ValidationDocument};
use super::hybrid::HybridDocument;
use super::loops::{BodeDocument, CirclesDocument, GainStudyDocument};
use super::prediction::PredictionDocument;

/// Contents of a page. Absent parts are left out.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Title of the machine, or name of the folder.
    pub title: String,
    /// `identification.json`.
    pub identification: Option<IdentificationDocument>,
    /// `validation.json`.
    pub validation: Option<ValidationDocument>,
    /// `prediction.json`.
    pub prediction: Option<PredictionDocument>,
    /// Measured natural frequencies, drawn over those of the prediction.
    pub measured_modes: Vec<MeasuredMode>,
    /// `comparison.json`.
    pub comparison: Option<ComparisonDocument>,
    /// `peaks.json`.
    pub peaks: Option<PeaksDocument>,
    /// `diagnosis.json`.
    pub diagnosis: Option<DiagnosisDocument>,
    /// `bode.json`.
    pub bode: Option<BodeDocument>,
    /// `gain.json`.
    pub gain: Option<GainStudyDocument>,
    /// `circle.json`.
    pub circle: Option<CirclesDocument>,
    /// `hybrid.json`.
    pub hybrid: Option<HybridDocument>,
    /// Measured and predicted FRFs.
    pub curves: Vec<PageCurve>,
    /// FRFs of a diagnosis: measured, and predicted before and after it.
    pub diagnosed: Vec<PageCurve>,
    /// The machine of the diagnosis.
    pub sketch: Sketch,
    /// Mode shapes along the shafts, by position.
    pub shapes: Vec<ShapeGroup>,
    /// Nut position (m) of each position, where known.
    pub nut_m: BTreeMap<String, f64>,
    /// Parts that cannot be shown, with the reasons.
    pub notes: Vec<String>,
    /// Files of the page's results, with their SHA-256.
    pub files: Vec<(String, String)>,
}

#[cfg(test)]
mod tests;
