//! Natural frequencies from FRFs, tracked over the records.

use serde_json::json;

use super::Page;
use super::chart::{Chart, axis, colour, layout, line, log_axis, name_axis, scatter, symbol};
use super::position::{ordered, place};
use super::text::{TextTable, cell, rounded};
use crate::document::PeaksDocument;
use crate::terminal::{figure, percent};

/// Formats the section.
pub fn content(page: &Page, of: &PeaksDocument) -> String {
    let known = of.modes.iter().flat_map(|m| m.records.keys()).all(|name| page.nut_m.contains_key(name));
    let x_axis = if known { axis("nut position (m)") } else { name_axis("record") };
    let mut chart = Chart::new(
        "peaks-chart",
        "Natural frequencies from the FRFs, against position",
        "Error bars: 95 % intervals. Grey: spurious peaks.",
        340,
        layout(true, x_axis, log_axis("Hz")),
    );
    let header = ["Mode", "Record", "Hz", "±", "Damping", "±", "Amplitude"];
    let mut table = TextTable::new("Regular modes by record; ± is half a 95 % interval", 2, header);
    for mode in &of.modes {
        let n = if mode.regular { mode.order.saturating_sub(1) } else { 6 };
        let rows = ordered(page, &mode.records);
        let x: Vec<serde_json::Value> = rows.iter().map(|(name, _)| place(page, name, known)).collect();
        let y: Vec<f64> = rows.iter().map(|(_, r)| rounded(r.frequency_hz, 7)).collect();
        let spread: Vec<f64> = rows.iter().map(|(_, r)| 1.96 * r.frequency_sd_hz.unwrap_or(0.0)).collect();
        let name = format!(
            "mode {} at {} Hz{}",
            mode.order,
            figure(mode.frequency_hz),
            if mode.regular { "" } else { ", no regularity" }
        );
        let mode_of_points = if mode.regular { "lines+markers" } else { "markers" };
        let look = json!({
            "name": name, "showlegend": mode.regular, "line": line(colour(n), 1.0),
            "marker": { "color": colour(n), "size": 8, "symbol": symbol(n) },
            "error_y": { "type": "data", "array": spread }, "hovertemplate": "%{y:.6~g} Hz",
        });
        chart.trace(scatter(x, y, mode_of_points, look));
        for (name, row) in rows.iter().filter(|_| mode.regular) {
            table.row([
                mode.order.to_string(),
                (*name).clone(),
                figure(row.frequency_hz),
                cell(row.frequency_sd_hz.map(|s| 1.96 * s), figure),
                percent(row.damping_ratio),
                cell(row.damping_sd.map(|s| 1.96 * s), percent),
                figure(row.amplitude),
            ]);
        }
    }
    format!("{}{}", chart.html(), table.html())
}
