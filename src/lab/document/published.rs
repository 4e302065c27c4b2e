//! Result document of the published figures, compared with ours.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use report::document::Stamp;

/// Relative difference up to which ours counts as equal to a printed figure (1).
pub const CLOSE: f64 = 0.02;

/// A published figure with ours: from the equations and numbers as printed, and with the cause of the
/// difference mended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedFigure {
    /// Publication.
    pub paper: String,
    /// Section, table, figure or equation of the publication.
    pub place: String,
    /// Physical quantity.
    pub quantity: String,
    /// Unit of all values.
    pub unit: String,
    /// Printed value (in `unit`); absent for a curve or a statement without a number.
    pub published: Option<f64>,
    /// Unit of the last printed digit (in `unit`), or the width of the interval that the rounding of the
    /// printed numbers behind it allows, where half of it exceeds the limit of 2 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Computed by this program with the equations and numbers as printed (in `unit`); absent where they give
    /// no value.
    pub as_printed: Option<f64>,
    /// Computed by this program with the cause of the difference mended (in `unit`); absent where no cause is
    /// known, or none is needed.
    pub mended: Option<f64>,
    /// Relative difference of `mended`, else of `as_printed`, from the printed value (1).
    pub relative_difference: Option<f64>,
    /// Result of the comparison, from `mended`, else from `as_printed`.
    pub verdict: FigureVerdict,
    /// Method of computation, and cause of a difference; «cause unknown» with what was tried.
    pub remark: String,
}

/// Result of the comparison of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FigureVerdict {
    /// Within 2 % of the printed number.
    Within2Percent,
    /// Further off, but within half of [`PublishedFigure::resolution`].
    WithinRounding,
    /// Further off.
    Differs,
    /// The paper prints a number, ours does not exist.
    NotComputed,
    /// A printed curve or statement without a number holds.
    Holds,
    /// A printed curve or statement without a number does not hold.
    DoesNotHold,
    /// The paper prints neither number nor statement.
    NotPrinted,
}

impl FigureVerdict {
    /// Returns the verdict in words.
    pub fn word(self) -> &'static str {
        match self {
            FigureVerdict::Within2Percent => "within 2 %",
            FigureVerdict::WithinRounding => "within rounding",
            FigureVerdict::Differs => "differs",
            FigureVerdict::NotComputed => "not computed",
            FigureVerdict::Holds => "holds",
            FigureVerdict::DoesNotHold => "does not hold",
            FigureVerdict::NotPrinted => "not printed",
        }
    }
}

/// Numbers of figures of a paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct FigureCount {
    /// Figures with a printed number.
    pub printed: usize,
    /// Of these, within 2 % with the equations and numbers as printed.
    pub as_printed: usize,
    /// Of these, within 2 % once the cause is mended.
    pub mended: usize,
    /// Of these, further off, but within half a unit of the last printed digit.
    pub within_rounding: usize,
}

/// Published figures compared with results of this program (`published.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Comparisons, one for each published figure.
    pub figures: Vec<PublishedFigure>,
    /// Numbers of figures by paper; under `all` those of all papers.
    pub count: BTreeMap<String, FigureCount>,
}

/// Counts the figures by paper, and of all papers under `all`.
pub fn count(figures: &[PublishedFigure]) -> BTreeMap<String, FigureCount> {
    let mut count: BTreeMap<String, FigureCount> = BTreeMap::new();
    for figure in figures {
        let Some(published) = figure.published else { continue };
        let as_printed = figure.as_printed.is_some_and(|x| (x / published - 1.0).abs() <= CLOSE);
        for key in [figure.paper.as_str(), "all"] {
            let row = count.entry(key.into()).or_default();
            row.printed += 1;
            row.as_printed += usize::from(as_printed);
            row.mended += usize::from(figure.verdict == FigureVerdict::Within2Percent);
            row.within_rounding += usize::from(figure.verdict == FigureVerdict::WithinRounding);
        }
    }
    count
}
