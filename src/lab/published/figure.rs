//! Published figures with ours, and the machines that ours are computed from.

use crate::document::published::{CLOSE, FigureVerdict, PublishedFigure};
use config::{embedded_config, read_machine_text};
use dynamics::model::elastic_frequencies_hz;
use machine::{LoadedPair, Machine, Operating};
use study::{StudyError, StudyResult};

/// Reads a configuration that comes with the program, with overrides.
pub fn read_published(path: &str, overrides: &[&str]) -> StudyResult<Machine> {
    let text = embedded_config(path)
        .ok_or_else(|| StudyError::impossible(format!("{path}: does not come with the program")))?;
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_string()).collect();
    Ok(read_machine_text(path, text, &overrides, &[])?.machine)
}

/// Returns the lowest natural frequency above 0 (Hz) at the start values.
///
/// # Errors  the machine has none.
pub fn first_hz(machine: &Machine, operating: &Operating) -> StudyResult<f64> {
    let hz = elastic_frequencies_hz(machine, 1, &machine.start(), operating);
    hz.first().copied().ok_or_else(|| StudyError::impossible("the machine has no natural frequency above 0"))
}

/// Returns the contact of that name.
///
/// # Errors  the machine has none.
pub fn contact<'m>(machine: &'m Machine, name: &str) -> StudyResult<&'m LoadedPair> {
    machine
        .contacts
        .iter()
        .map(std::sync::Arc::as_ref)
        .find(|c| c.name == name)
        .ok_or_else(|| StudyError::impossible(format!("no contact «{name}»")))
}

/// Source of a published figure.
#[derive(Clone, Copy)]
pub struct FigureSource {
    /// The paper.
    pub paper: &'static str,
    /// Section, table, figure or equation of the paper.
    pub place: &'static str,
}

impl FigureSource {
    /// Begins a figure of this source: a quantity with its unit.
    pub fn figure(self, quantity: impl Into<String>, unit: &str) -> Comparison {
        Comparison {
            source: self,
            quantity: quantity.into(),
            unit: unit.into(),
            published: None,
            as_printed: None,
            mended: None,
            holds: None,
        }
    }
}

/// A published figure while its values are collected; [`Comparison::because`] ends it.
pub struct Comparison {
    source: FigureSource,
    quantity: String,
    unit: String,
    /// Printed value and unit of its last digit.
    published: Option<(f64, f64)>,
    as_printed: Option<f64>,
    mended: Option<f64>,
    holds: Option<bool>,
}

impl Comparison {
    /// States the printed number and the unit of its last printed digit.
    pub fn printed(self, published: f64, resolution: f64) -> Self {
        Comparison { published: Some((published, resolution)), ..self }
    }

    /// States ours from the equations and numbers as printed.
    pub fn ours_as_printed(self, ours: f64) -> Self {
        Comparison { as_printed: Some(ours), ..self }
    }

    /// States ours from the equations and numbers as printed, where they give a value.
    pub fn maybe_as_printed(self, ours: Option<f64>) -> Self {
        Comparison { as_printed: ours, ..self }
    }

    /// States ours with the cause of the difference mended.
    pub fn mended(self, ours: f64) -> Self {
        Comparison { mended: Some(ours), ..self }
    }

    /// States whether a printed curve or statement without a number holds.
    pub fn holds(self, holds: bool) -> Self {
        Comparison { holds: Some(holds), ..self }
    }

    /// Ends the figure with the method, and the cause of a difference.
    pub fn because(self, remark: impl Into<String>) -> PublishedFigure {
        let ours = self.mended.or(self.as_printed);
        let relative_difference =
            self.published.zip(ours).map(|((published, _), ours)| ours / published - 1.0);
        let verdict = match (self.published, ours, self.holds) {
            (Some(_), None, _) => FigureVerdict::NotComputed,
            (Some((published, _)), Some(ours), _) if (ours / published - 1.0).abs() <= CLOSE => {
                FigureVerdict::Within2Percent
            }
            (Some((published, resolution)), Some(ours), _)
                if (ours - published).abs() <= 0.5 * resolution =>
            {
                FigureVerdict::WithinRounding
            }
            (Some(_), Some(_), _) => FigureVerdict::Differs,
            (None, _, Some(true)) => FigureVerdict::Holds,
            (None, _, Some(false)) => FigureVerdict::DoesNotHold,
            (None, _, None) => FigureVerdict::NotPrinted,
        };
        let coarse =
            self.published.filter(|(published, resolution)| 0.5 * resolution > CLOSE * published.abs());
        PublishedFigure {
            paper: self.source.paper.into(),
            place: self.source.place.into(),
            quantity: self.quantity,
            unit: self.unit,
            published: self.published.map(|(published, _)| published),
            resolution: coarse.map(|(_, resolution)| resolution),
            as_printed: self.as_printed,
            mended: self.mended,
            relative_difference,
            verdict,
            remark: remark.into(),
        }
    }
}
