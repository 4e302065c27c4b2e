//! Sensitivity of a natural frequency to the joints: document and text.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use report::document::Stamp;

/// Sensitivity of a natural frequency to the stiffness of one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensitivityRow {
    /// Name of the joint.
    pub joint: String,
    /// Stiffness k of the joint (N/m or N·m/rad).
    pub stiffness: f64,
    /// Deformation of the joint for the mode shape, the largest deflection 1 (m or rad).
    pub deformation: f64,
    /// Share of the joint in the strain energy of the mode (1).
    pub strain_energy_share: f64,
    /// Relative sensitivity d ln f/d ln k (1), half of `strain_energy_share`.
    pub elasticity: f64,
    /// Natural frequency at each factor on the stiffness (Hz).
    pub frequencies_hz: Vec<f64>,
}

/// Sensitivity of a natural frequency to the joints (`sensitivity.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensitivityDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Position of the nut (m).
    pub nut_m: Option<f64>,
    /// Mode number among the natural frequencies above 0, from 1.
    pub order: usize,
    /// Natural frequency of this mode (Hz).
    pub frequency_hz: f64,
    /// Factors on the stiffness of a joint (1).
    pub factors: Vec<f64>,
    /// Sensitivities in descending share of the strain energy.
    pub joints: Vec<SensitivityRow>,
}

/// Returns sensitivities as a table, under the title of the machine.
pub fn sensitivity_text(document: &SensitivityDocument, title: &str) -> String {
    let mut text =
        format!("{title}\nnatural frequency {}: {:.4} Hz\n\n", document.order, document.frequency_hz);
    let at = |factor: Option<&f64>| factor.map_or_else(String::new, |factor| format!("f at {factor}"));
    let (low, high) = (at(document.factors.first()), at(document.factors.last()));
    let _ = writeln!(
        text,
        "{:<20} {:>11} {:>9} {:>10} {low:>10} {high:>10}",
        "joint", "stiffness", "energy %", "dlnf/dlnk"
    );
    for row in &document.joints {
        let (energy, elasticity) = (100.0 * row.strain_energy_share, row.elasticity);
        let _ = write!(text, "{:<20} {:>11.4e} {energy:>9.2} {elasticity:>10.4}", row.joint, row.stiffness);
        for hz in row.frequencies_hz.first().into_iter().chain(row.frequencies_hz.last()) {
            let _ = write!(text, " {hz:>10.3}");
        }
        text.push('\n');
    }
    text
}
