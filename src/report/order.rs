//! Modes entered under a wrong order, and the result with the orders that they fit.

use std::collections::BTreeMap;

use super::document::{MisplacedModeRow, ParameterRow, RenumberedRow};
use super::table::parameter_cells;
use super::terminal::{figure, table, table_text, unit};
use super::text_table::cell;

impl RenumberedRow {
    /// Returns the misplaced modes as one warning. `cost`: that of the fit with the orders as entered.
    pub fn warning(&self, cost: f64) -> String {
        let one = |m: &MisplacedModeRow| {
            let fits = m.fits_order.map_or("no order".into(), |order| format!("order {order}"));
            format!(
                "{} Hz at {} fits {fits}, but is entered as order {}",
                figure(m.frequency_hz),
                m.position,
                m.order
            )
        };
        let named = self.modes.iter().map(one).collect::<Vec<_>>().join("; ");
        let there = match self.cost {
            Some(there) => {
                format!("with fitting orders the cost is {} instead of {}", figure(there), figure(cost))
            }
            None => "the fit does not depend on it".into(),
        };
        format!(
            "by the course of each order over the positions, {named}; {there}; check these orders in the table of modes"
        )
    }
}

/// Estimates with the orders as entered and with the fitting orders, as a table; empty without a second fit.
pub fn renumbered_table(entered: &BTreeMap<String, ParameterRow>, renumbered: &RenumberedRow) -> String {
    if renumbered.parameters.is_empty() {
        return String::new();
    }
    let mut out =
        table(["Parameter", "Unit", "As entered", "Fitting orders", "95 % interval", "Identifiable"]);
    for (id, there) in renumbered.parameters.iter().filter(|(_, row)| row.fitted) {
        let [value, interval, identifiable] = parameter_cells(there);
        let entered = cell(entered.get(id).map(|row| row.value), figure);
        out.add_row([id.clone(), unit(&there.unit), entered, value, interval, identifiable]);
    }
    table_text(&out)
}
