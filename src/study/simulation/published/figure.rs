//! Published figures with ours, and the machines that ours are computed from.

use crate::{StudyError, StudyResult};
use config::{embedded_config, read_machine_text};
use machine::Machine;
use report::simulation::PublishedFigure;

/// The configurations that the figures are computed from.
pub const CONFIGS: [&str; 3] = ["configs/twin-ball-screw.toml", "configs/servo-axis.toml", "configs/vertical-axis.toml"];

/// Reads a configuration that comes with the program, with overrides.
pub fn read_published(path: &str, overrides: &[&str]) -> StudyResult<Machine> {
    let text = embedded_config(path).ok_or_else(|| StudyError::impossible(format!("{path}: does not come with the program")))?;
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_string()).collect();
    Ok(read_machine_text(path, text, &overrides, &[])?.machine)
}

/// Source of a published figure.
#[derive(Clone, Copy)]
pub struct FigureSource {
    /// The paper.
    pub paper: &'static str,
    /// Section, table, figure or equation of the paper.
    pub place: &'static str,
}

/// Compares a printed number with ours.
pub fn compared(
    source: FigureSource,
    quantity: &str,
    unit: &str,
    (published, ours): (f64, f64),
    tolerance: f64,
    remark: &str,
) -> PublishedFigure {
    let difference = ours / published - 1.0;
    PublishedFigure {
        paper: source.paper.into(),
        place: source.place.into(),
        quantity: quantity.into(),
        unit: unit.into(),
        published: Some(published),
        ours: Some(ours),
        relative_difference: Some(difference),
        verdict: if difference.abs() <= tolerance { "agrees" } else { "differs" }.into(),
        remark: remark.into(),
    }
}

/// Checks ours against a printed curve or statement without a number.
pub fn stated(source: FigureSource, quantity: &str, unit: &str, ours: f64, holds: bool, remark: &str) -> PublishedFigure {
    PublishedFigure {
        published: None,
        relative_difference: None,
        verdict: if holds { "agrees" } else { "differs" }.into(),
        ..compared(source, quantity, unit, (1.0, ours), 0.0, remark)
    }
}

/// Reports ours where the paper prints neither number nor statement.
pub fn ours_alone(source: FigureSource, quantity: &str, unit: &str, ours: f64, remark: &str) -> PublishedFigure {
    PublishedFigure { verdict: "not printed".into(), ..stated(source, quantity, unit, ours, true, remark) }
}

/// Reports a printed number that cannot be reproduced.
pub fn unreachable(source: FigureSource, quantity: &str, unit: &str, published: f64, remark: &str) -> PublishedFigure {
    PublishedFigure {
        ours: None,
        relative_difference: None,
        verdict: "not reproducible".into(),
        ..compared(source, quantity, unit, (published, 1.0), 0.0, remark)
    }
}
