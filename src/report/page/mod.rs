//! One page that holds its charts' script, its style and all numbers: it opens without a network, and asks for nothing.

mod chart;
mod comparison;
mod curve;
mod frame;
mod loops;
mod motion;
mod parameter;
mod peak;
mod position;
mod shape;
mod text;
mod thin;
mod verdict;

pub use curve::{Curve, PeakMark};
pub use frame::{MOST_BYTES, html};
pub use shape::{Deflection, ModeShape, ShapeGroup};

use std::collections::BTreeMap;

use super::diagnosis::Diagnosis;
use super::document::{Comparison, Identification, Peaks, Validation};
use super::hybrid::Hybrid;
use super::loops::{Bode, Circles, GainStudy};

/// What a page says. What is absent is left out.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// What a person calls the machine, or the folder.
    pub title: String,
    /// `identification.json`.
    pub identification: Option<Identification>,
    /// `validation.json`.
    pub validation: Option<Validation>,
    /// `comparison.json`.
    pub comparison: Option<Comparison>,
    /// `peaks.json`.
    pub peaks: Option<Peaks>,
    /// `diagnosis.json`.
    pub diagnosis: Option<Diagnosis>,
    /// `bode.json`.
    pub bode: Option<Bode>,
    /// `gain.json`.
    pub gain: Option<GainStudy>,
    /// `circle.json`.
    pub circle: Option<Circles>,
    /// `hybrid.json`.
    pub hybrid: Option<Hybrid>,
    /// Measured and predicted FRFs.
    pub curves: Vec<Curve>,
    /// What a diagnosis was made on: measured, before and after.
    pub diagnosed: Vec<Curve>,
    /// Mode shapes along the shafts, by position.
    pub shapes: Vec<ShapeGroup>,
    /// Nut position (m) of each position, where known.
    pub nut_m: BTreeMap<String, f64>,
    /// What could not be shown, and why.
    pub notes: Vec<String>,
    /// Files the page was made of, with the SHA-256 of each.
    pub files: Vec<(String, String)>,
}

#[cfg(test)]
mod tests;
