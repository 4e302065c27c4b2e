//! Frequency and amplitude against position.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::Page;
use super::chart::{Chart, axis, colour, line, name_axis, panels, scatter, y_axis};
use super::text::{escape, rounded};
use crate::document::{OrderRow, PositionRow};
use crate::vocabulary::Role;

/// Formats the charts of frequency and amplitude against position.
pub fn charts(page: &Page) -> String {
    let Some(positions) = page.identification.as_ref().map(|i| &i.positions) else { return String::new() };
    let frequency = along(
        page,
        positions,
        ("frequency-position", "Natural frequencies against position", " (Hz)", "~g"),
        &|o| o.measured_hz,
        &|o| o.predicted_hz,
    );
    let amplitude = along(
        page,
        positions,
        ("amplitude-position", "Amplitudes against position, in the unit of the measurement", "", "~e"),
        &|o| o.measured_amplitude,
        &|o| o.predicted_amplitude,
    );
    format!("{frequency}{amplitude}")
}

/// Returns positions or records in the order of the nut position, or of their names where it is unknown.
pub fn ordered<'p, T>(page: &Page, of: &'p BTreeMap<String, T>) -> Vec<(&'p String, &'p T)> {
    let mut rows: Vec<_> = of.iter().collect();
    let at = |name: &String| page.nut_m.get(name).copied().unwrap_or(f64::INFINITY);
    rows.sort_by(|a, b| at(a.0).total_cmp(&at(b.0)).then(a.0.cmp(b.0)));
    rows
}

/// Returns the place of a position or record on the horizontal axis: its nut position where that is known,
/// else its name.
pub fn place(page: &Page, name: &String, known: bool) -> Value {
    page.nut_m.get(name).filter(|_| known).map_or_else(|| escape(name).into(), |nut_m| (*nut_m).into())
}

fn along(
    page: &Page,
    positions: &BTreeMap<String, PositionRow>,
    (id, label, unit, format): (&str, &str, &str, &str),
    measured: &dyn Fn(&OrderRow) -> Option<f64>,
    predicted: &dyn Fn(&OrderRow) -> Option<f64>,
) -> String {
    let rows = ordered(page, positions);
    let known = rows.iter().all(|(name, _)| page.nut_m.contains_key(*name));
    let x_axis = if known { axis("nut position (m)") } else { name_axis("position") };
    let value = |p: &PositionRow, order: u32, pick: &dyn Fn(&OrderRow) -> Option<f64>| {
        p.orders.iter().find(|o| o.order == order).and_then(pick)
    };
    let orders: std::collections::BTreeSet<u32> =
        positions.values().flat_map(|p| p.orders.iter().map(|o| o.order)).collect();
    let shown: Vec<u32> = orders
        .into_iter()
        .filter(|o| positions.values().any(|p| value(p, *o, measured).is_some()))
        .take(8)
        .collect();
    let titles: Vec<String> = shown.iter().map(|order| format!("order {order}{unit}")).collect();
    let layout = panels(x_axis, &titles, format);
    let caption = "Marks: measured, filled where fitted, open where held out. Lines: predicted.";
    let mut chart = Chart::new(id, label, caption, 90 + 130 * shown.len(), layout);
    for (n, order) in shown.into_iter().enumerate() {
        let y_axis = y_axis(n);
        let name = format!("order {order}");
        let points: Vec<_> = rows
            .iter()
            .filter_map(|(p, row)| Some((place(page, p, known), rounded(value(row, order, predicted)?, 6))))
            .collect();
        if !points.is_empty() {
            let (x, y): (Vec<Value>, Vec<f64>) = points.into_iter().unzip();
            let hover = format!("{name}, predicted<br>%{{y:.5~g}}<extra></extra>");
            let look = json!({ "line": line(colour(n), 1.6), "yaxis": y_axis, "hovertemplate": hover });
            chart.trace(scatter(x, y, "lines", look));
        }
        for (held_out, symbol) in [(false, "circle"), (true, "circle-open")] {
            let of_role = rows.iter().filter(|(_, row)| (row.role == Role::HeldOut) == held_out);
            let points: Vec<_> = of_role
                .filter_map(|(p, row)| Some((*p, place(page, p, known), value(row, order, measured)?)))
                .collect();
            if points.is_empty() {
                continue;
            }
            let names: Vec<String> = points.iter().map(|p| escape(p.0)).collect();
            let (x, y): (Vec<Value>, Vec<f64>) = points.into_iter().map(|(_, x, y)| (x, y)).unzip();
            let hover = format!("%{{text}}, {name}, measured<br>%{{y:.5~g}}<extra></extra>");
            let mark = json!({ "color": colour(n), "size": 9, "symbol": symbol });
            let look = json!({ "marker": mark, "text": names, "yaxis": y_axis, "hovertemplate": hover });
            chart.trace(scatter(x, y, "markers", look));
        }
    }
    chart.html()
}
