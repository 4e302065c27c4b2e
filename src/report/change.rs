//! Changes of parameters between two identifications of one machine (`change.json`): document and text.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::provenance::Stamp;
use super::terminal::{columns, figure, probability, wrapped};

/// Change of one parameter from the first identification to the second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChangeRow {
    /// Estimate of the first identification (in `unit`).
    pub first: f64,
    /// Estimate of the second identification (in `unit`).
    pub second: f64,
    /// Unit of both.
    pub unit: String,
    /// Change with the tolerances of the machine common to both: relative to the first (1), or a difference
    /// (in `unit`) where `relative` is false.
    pub change: f64,
    /// 95 % interval of the change.
    pub change95: [f64; 2],
    /// Whether the change is relative.
    pub relative: bool,
    /// Probability of a change at least this large where nothing changed, for this parameter alone; absent
    /// where the change is not determined.
    pub p_value: Option<f64>,
    /// The same over all compared parameters (Holm).
    pub p_adjusted: Option<f64>,
    /// Whether the change is significant: `p_adjusted` is at most the level.
    pub changed: bool,
}

/// Changes between two identifications of one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChangeDocument {
    /// Schema, inputs and warnings of the document: the inputs are the two results.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Probability of claiming any change where nothing changed (1).
    pub level: f64,
    /// Number of parameters that are compared: their change is determined as narrowly as an identifiable
    /// value.
    pub compared: usize,
    /// Names of the tolerances of the machine that both identifications share.
    pub common: Vec<String>,
    /// Number of measured frequencies whose model error both identifications share: it cancels in changes.
    #[serde(default)]
    pub common_model_errors: usize,
    /// Changes by parameter id.
    pub parameters: BTreeMap<String, ChangeRow>,
}

/// Changes as text: the significant ones first.
pub fn change_text(title: &str, document: &ChangeDocument) -> String {
    let changed: Vec<String> = document
        .parameters
        .iter()
        .filter(|(_, row)| row.changed)
        .map(|(id, row)| format!("{id} by {}", amount(row.change, row)))
        .collect();
    // What only one of both results determines is not tested; a large change may be the reason.
    let open: Vec<String> = document
        .parameters
        .iter()
        .filter(|(_, row)| row.p_value.is_none() && row.change95[0] * row.change95[1] > 0.0)
        .map(|(id, row)| format!("{id} by {}", amount(row.change, row)))
        .collect();
    let verdict = match (changed.is_empty(), open.is_empty()) {
        _ if document.compared == 0 => {
            "no parameter could be compared: none is identifiable in both results".to_string()
        }
        (true, true) => "no significant change".to_string(),
        (true, false) => "no significant change among the parameters compared".to_string(),
        (false, _) => format!("significant change: {}", changed.join(", ")),
    };
    let mut text = format!("{title}\n");
    text += &wrapped(&format!(
        "{verdict} ({} parameters compared, level {:.0} % over all of them; {} tolerances of the machine and the model errors of {} frequencies are common to both)",
        document.compared,
        100.0 * document.level,
        document.common.len(),
        document.common_model_errors
    ));
    text.push('\n');
    let mut rows: Vec<(&String, &ChangeRow)> = document.parameters.iter().collect();
    rows.sort_by(|a, b| a.1.p_value.unwrap_or(2.0).total_cmp(&b.1.p_value.unwrap_or(2.0)).then(a.0.cmp(b.0)));
    let rows = rows.into_iter().map(|(id, row)| {
        vec![
            id.clone(),
            figure(row.first),
            figure(row.second),
            row.unit.clone(),
            amount(row.change, row),
            format!("{} … {}", amount(row.change95[0], row), amount(row.change95[1], row)),
            row.p_adjusted.map_or("–".into(), probability),
            if row.changed { "yes" } else { "" }.into(),
        ]
    });
    text += &columns(
        &["Parameter", "First", "Second", "Unit", "Change", "95 % interval", "p (Holm)", "Changed"]
            .map(String::from),
        rows,
    );
    let joint: Vec<&str> =
        document.parameters.iter().filter(|(_, row)| is_joint(row)).map(|(id, _)| id.as_str()).collect();
    if !joint.is_empty() {
        text += &wrapped(&format!(
            "first and second are separate fits, each with the machine's tolerances at its own values; the changes are with common ones, and so differ for {}",
            joint.join(", ")
        ));
    }
    if document.compared < document.parameters.len() {
        text += "p –: not compared, since one of both values is not identifiable\n";
    }
    if !open.is_empty() {
        text += &wrapped(&format!(
            "not compared, though its interval excludes 0: {}; it is a change, or another minimum of one fit",
            open.join(", ")
        ));
    }
    text
}

/// Whether a change differs from that of the two values beside it by more than rounding shows.
fn is_joint(row: &ChangeRow) -> bool {
    let apart = if row.relative { row.second / row.first - 1.0 } else { row.second - row.first };
    let half = 0.5 * (row.change95[1] - row.change95[0]);
    (apart - row.change).abs() > (0.1 * half).max(if row.relative { 5e-4 } else { 0.0 })
}

/// Writes a change: in per cent, as a factor from ten on, or in the unit of the parameter.
fn amount(change: f64, row: &ChangeRow) -> String {
    match row.relative {
        true if change >= 9.0 => format!("×{}", figure(1.0 + change)),
        true => format!("{:+.1} %", 100.0 * change),
        false => format!("{change:+.3e}"),
    }
}
