//! Modes entered under a wrong order, and the result with the orders that they fit.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::ParameterRow;
use super::terminal::{figure, range, table, table_text, unit};

/// A mode whose order does not fit its course over the positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MisplacedModeRow {
    /// Name of the position.
    pub position: String,
    /// Order under which the mode is entered.
    pub order: u32,
    /// Measured natural frequency (Hz).
    pub frequency_hz: f64,
    /// Order whose course over the other positions the mode continues; absent for a mode that continues none.
    pub fits_order: Option<u32>,
}

/// Misplaced modes, and the fit with the orders that they fit. Modes that fit none are left out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RenumberedRow {
    /// The misplaced modes.
    pub modes: Vec<MisplacedModeRow>,
    /// Minimum of the objective with the fitting orders, to compare with `cost` of the document (1); absent where no fitted position is concerned.
    pub cost: Option<f64>,
    /// Estimates with the fitting orders, by parameter id.
    pub parameters: BTreeMap<String, ParameterRow>,
}

impl RenumberedRow {
    /// Returns the misplaced modes as one warning. `cost`: that of the fit with the orders as entered.
    pub fn warning(&self, cost: f64) -> String {
        let one = |m: &MisplacedModeRow| {
            let fits = m.fits_order.map_or("no order".into(), |order| format!("order {order}"));
            format!("{} Hz at {} fits {fits}, but is entered as order {}", figure(m.frequency_hz), m.position, m.order)
        };
        let named = self.modes.iter().map(one).collect::<Vec<_>>().join("; ");
        let there = match self.cost {
            Some(there) => format!("with fitting orders the cost is {} instead of {}", figure(there), figure(cost)),
            None => "the fit does not depend on it".into(),
        };
        format!("by the course of each order over the positions, {named}; {there}; check these orders in the table of modes")
    }
}

/// Estimates with the orders as entered and with the fitting orders, as a table; empty without a second fit.
pub fn renumbered_table(entered: &BTreeMap<String, ParameterRow>, renumbered: &RenumberedRow) -> String {
    if renumbered.parameters.is_empty() {
        return String::new();
    }
    let mut out = table(["Parameter", "Unit", "As entered", "Fitting orders", "95 % interval", "Identifiable"]);
    for (id, there) in renumbered.parameters.iter().filter(|(_, row)| row.fitted) {
        out.add_row([
            id.clone(),
            unit(&there.unit),
            entered.get(id).map_or_else(|| "–".into(), |row| figure(row.value)),
            figure(there.value),
            there.interval95.map_or_else(|| "–".into(), range),
            match there.identifiable {
                Some(true) => "yes".into(),
                Some(false) => "no".into(),
                None => "–".into(),
            },
        ]);
    }
    table_text(&out)
}
