//! Convergence of the lumped model: document and text.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use report::document::Stamp;
use report::{columns, wrapped};

/// Identification with one discretisation of the rods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConvergenceRow {
    /// Number of masses per rod of the lumped model; absent for the exact rod.
    pub lumps: Option<usize>,
    /// First natural frequencies above 0 at the start values (Hz).
    pub frequencies_hz: Vec<f64>,
    /// Estimates by parameter id, each in its unit.
    pub parameters: BTreeMap<String, f64>,
    /// Ids of the fitted parameters.
    pub fitted: Vec<String>,
    /// Minimum of the objective: χ², or the value of `eq26` (1).
    pub cost: f64,
    /// Root sum of squares of the relative frequency errors (1), by held-out position.
    pub held_out_errors: BTreeMap<String, f64>,
}

/// Convergence of the lumped model with its number of masses (`convergence.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConvergenceDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Position of the nut for `frequencies_hz` (m).
    pub nut_m: Option<f64>,
    /// Names of the fitted positions.
    pub fit_positions: Vec<String>,
    /// Identifications in ascending number of masses, the exact rod last.
    pub rows: Vec<ConvergenceRow>,
}

/// Formats natural frequencies, parameters and errors by number of masses, for the machine of this title.
pub fn convergence_text(title: &str, document: &ConvergenceDocument) -> String {
    let exact = document.rows.iter().find(|row| row.lumps.is_none());
    let label = |row: &ConvergenceRow| row.lumps.map_or_else(|| "exact".to_string(), |n| n.to_string());
    let relative = |x: f64, reference: Option<&f64>| {
        reference.map_or_else(|| "–".into(), |r| format!("{:+.1e}", x / r - 1.0))
    };
    let frequencies = document.rows.iter().map(|row| {
        let cells = row.frequencies_hz.iter().enumerate().flat_map(|(at, f)| {
            let difference =
                exact.filter(|_| row.lumps.is_some()).map(|e| relative(*f, e.frequencies_hz.get(at)));
            [format!("{f:.3}"), difference.unwrap_or_default()]
        });
        std::iter::once(label(row)).chain(cells).collect()
    });
    let orders = exact.map_or(0, |e| e.frequencies_hz.len());
    let header = |cells: Vec<String>| [vec!["lumps".to_string()], cells].concat();
    let heads = header((1..=orders).flat_map(|k| [format!("order {k}"), "difference".into()]).collect());
    let mut text = format!("{title}\n\n");
    text += &wrapped(
        "natural frequencies at the start values (Hz), and their relative differences from the exact rod",
    );
    text += &columns(&heads, frequencies);
    let fitted: Vec<String> =
        exact.or(document.rows.last()).map(|row| row.fitted.clone()).unwrap_or_default();
    text += &format!(
        "\nparameters identified on {}: differences from the exact rod in %\n",
        document.fit_positions.join(", ")
    );
    let lumped = document.rows.iter().filter(|row| row.lumps.is_some());
    let values = lumped.map(|row| {
        let cell = |id: &String| match (row.parameters.get(id), exact.and_then(|e| e.parameters.get(id))) {
            (Some(x), Some(reference)) => format!("{:+.2}", 100.0 * (x / reference - 1.0)),
            _ => "–".into(),
        };
        std::iter::once(label(row)).chain(fitted.iter().map(cell)).collect()
    });
    let reference = exact.map(|row| {
        let cell = |id: &String| row.parameters.get(id).map_or_else(|| "–".into(), |x| format!("{x:.2e}"));
        std::iter::once("exact".to_string()).chain(fitted.iter().map(cell)).collect()
    });
    text += &columns(&header(fitted.clone()), values.chain(reference));
    let names: Vec<String> =
        exact.map(|row| row.held_out_errors.keys().cloned().collect()).unwrap_or_default();
    if !names.is_empty() {
        text += "\nheld-out errors (Tian et al., Eq. 27) in %\n";
        let errors = document.rows.iter().map(|row| {
            let cell = |name: &String| {
                row.held_out_errors.get(name).map_or_else(|| "–".into(), |e| format!("{:.2}", 100.0 * e))
            };
            std::iter::once(label(row)).chain(names.iter().map(cell)).collect()
        });
        text += &columns(&header(names.clone()), errors);
    }
    text
}
