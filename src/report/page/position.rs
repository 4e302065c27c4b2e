//! Frequency and amplitude against position, and errors in the layout of the published tables.

use std::collections::BTreeMap;

use plotly::Scatter;
use plotly::common::{Marker, MarkerSymbol, Mode};
use plotly::layout::{AxisType, HoverMode};

use super::Page;
use super::chart::{Chart, axis, colour, layout, line, with_y_axis};
use super::text::{TextTable, cell, escape, rounded};
use crate::document::{FrfRow, OrderRow, PositionRow};
use crate::table::role_text;
use crate::terminal::{figure, percent};

/// Formats the charts of frequency and amplitude against position.
pub fn charts(page: &Page) -> String {
    let Some(positions) = page.identification.as_ref().map(|i| &i.positions) else { return String::new() };
    let frequency =
        along(page, positions, ("frequency-position", "Natural frequencies against position", " (Hz)", "~g"), &|o| o.measured_hz, &|o| {
            o.predicted_hz
        });
    let amplitude = along(
        page,
        positions,
        ("amplitude-position", "Amplitudes against position, in the unit of the measurement", "", "~e"),
        &|o| o.measured_amplitude,
        &|o| o.predicted_amplitude,
    );
    format!("{frequency}{amplitude}")
}

/// Returns the positions in the order of the nut position, or of their names where it is unknown.
fn ordered<'p>(page: &Page, positions: &'p BTreeMap<String, PositionRow>) -> Vec<(&'p String, &'p PositionRow)> {
    let mut rows: Vec<_> = positions.iter().collect();
    let at = |name: &String| page.nut_m.get(name).copied().unwrap_or(f64::INFINITY);
    rows.sort_by(|a, b| at(a.0).total_cmp(&at(b.0)).then(a.0.cmp(b.0)));
    rows
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
    let x_axis = if known { axis("nut position (m)") } else { axis("position").type_(AxisType::Category) };
    let value =
        |p: &PositionRow, order: u32, pick: &dyn Fn(&OrderRow) -> Option<f64>| p.orders.iter().find(|o| o.order == order).and_then(pick);
    let orders: std::collections::BTreeSet<u32> = positions.values().flat_map(|p| p.orders.iter().map(|o| o.order)).collect();
    let shown: Vec<u32> = orders.into_iter().filter(|o| positions.values().any(|p| value(p, *o, measured).is_some())).take(8).collect();
    let count = shown.len().max(1) as f64;
    let bottom = if shown.len() > 1 { format!("y{}", shown.len()) } else { "y".into() };
    let mut layout = layout().show_legend(false).hover_mode(HoverMode::Closest).x_axis(x_axis.anchor(&bottom));
    for (n, order) in shown.iter().enumerate() {
        // One panel for each order.
        let (low, high) = ((shown.len() - 1 - n) as f64 / count, (shown.len() - n) as f64 / count);
        let panel = axis(&format!("order {order}{unit}")).domain(&[low + 0.03, high - 0.03]).tick_format(format).n_ticks(4);
        layout = with_y_axis(layout, n, panel);
    }
    let caption = "Marks: measured, filled where fitted, open where held out. Lines: predicted.";
    let mut chart = Chart::new(id, label, caption, 90 + 130 * shown.len(), layout);
    for (n, order) in shown.into_iter().enumerate() {
        let y_axis = if n == 0 { "y".to_string() } else { format!("y{}", n + 1) };
        // The nut position where it is known, else the name.
        let place = |name: &String| match page.nut_m.get(name).filter(|_| known) {
            Some(x) => serde_json::json!(x),
            None => serde_json::json!(escape(name)),
        };
        let name = format!("order {order}");
        let points: Vec<_> = rows.iter().filter_map(|(p, row)| Some((place(p), rounded(value(row, order, predicted)?, 6)))).collect();
        if !points.is_empty() {
            let (x, y): (Vec<_>, Vec<_>) = points.into_iter().unzip();
            let pen = line(colour(n), 1.6);
            let hover = format!("{name}, predicted<br>%{{y:.5~g}}<extra></extra>");
            chart.trace(Scatter::new(x, y).mode(Mode::Lines).line(pen).y_axis(&y_axis).hover_template(hover));
        }
        for (held_out, symbol) in [(false, MarkerSymbol::Circle), (true, MarkerSymbol::CircleOpen)] {
            let of_role = rows.iter().filter(|(_, row)| (row.role != "fit") == held_out);
            let points: Vec<_> = of_role.filter_map(|(p, row)| Some((*p, place(p), value(row, order, measured)?))).collect();
            if points.is_empty() {
                continue;
            }
            let names: Vec<String> = points.iter().map(|p| escape(p.0)).collect();
            let (x, y): (Vec<_>, Vec<_>) = points.into_iter().map(|(_, x, y)| (x, y)).unzip();
            let hover = format!("%{{text}}, {name}, measured<br>%{{y:.5~g}}<extra></extra>");
            let mark = Marker::new().color(colour(n)).size(9).symbol(symbol);
            let trace = Scatter::new(x, y).mode(Mode::Markers).marker(mark).text_array(names).hover_template(hover);
            chart.trace(trace.y_axis(&y_axis));
        }
    }
    chart.html()
}

/// Formats measured and predicted frequencies in the layout of Tab. 4 and 6–9 of Tian et al.; empty without orders.
pub fn errors(caption: &str, positions: &BTreeMap<String, PositionRow>) -> String {
    let orders: std::collections::BTreeSet<u32> = positions.values().flat_map(|p| p.orders.iter().map(|o| o.order)).collect();
    if orders.is_empty() {
        return String::new();
    }
    let header = ["Position".to_string(), String::new()].into_iter().chain(orders.iter().map(|o| format!("Order {o}")));
    let mut table = TextTable::new(caption, 2, header.chain(["Overall".to_string()]));
    for (name, p) in positions {
        let role = role_text(&p.role, false);
        let mut row = |class: &str, first: &str, what: &str, pick: &dyn Fn(&OrderRow) -> Option<String>, last: String| {
            let cells = orders.iter().map(|k| p.orders.iter().find(|o| o.order == *k).and_then(pick).unwrap_or_else(|| "–".into()));
            table.row_of(class, [first.to_string(), what.into()].into_iter().chain(cells).chain([last]).collect::<Vec<_>>());
        };
        row("first", name, "measured (Hz)", &|o| o.measured_hz.map(figure), String::new());
        row("", role, "predicted (Hz)", &|o| o.predicted_hz.map(figure), String::new());
        row("strong", "", "relative error", &|o| o.relative_error.map(percent), cell(p.overall_error, percent));
        if p.orders.iter().any(|o| o.published_hz.is_some()) {
            row("", "", "published (Hz)", &|o| o.published_hz.map(figure), cell(p.overall_error_published, percent));
        }
    }
    table.html()
}

/// Formats the gaps by position, where whole FRFs are compared.
pub fn gaps(caption: &str, positions: &BTreeMap<String, PositionRow>) -> String {
    let mut table = TextTable::new(caption, 2, ["Position", "", "Gap", "Noise alone"]);
    for (name, p) in positions.iter().filter(|(_, p)| p.gap.is_some()) {
        let role = role_text(&p.role, false);
        table.row([name.clone(), role.into(), cell(p.gap, figure), cell(p.noise_floor, figure)]);
    }
    table.html()
}

/// Formats the table of compared FRFs.
pub fn frfs(rows: &[FrfRow]) -> String {
    let header = ["FRF", "Response/excitation", "", "Lines", "Accepted", "Gap", "Noise alone", "Noise from"];
    let mut table = TextTable::new("FRFs, with their gap: the root mean square of ln(measured/predicted), per component", 3, header);
    for row in rows {
        let names: Vec<&str> = [&row.position, &row.record].into_iter().flatten().map(String::as_str).collect();
        table.row([
            names.join(" "),
            format!("{}/{}", row.response, row.excitation),
            role_text(&row.role, false).to_string(),
            row.lines.to_string(),
            percent(row.accepted_share),
            figure(row.gap),
            cell(row.noise_floor, figure),
            row.noise_source.clone(),
        ]);
    }
    table.html()
}
