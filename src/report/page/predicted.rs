//! Predictions at positions that were not measured: natural frequency against position, and FRFs, with their
//! bands.

use serde_json::{Value, json};

use super::chart::{
    Chart, Switches, axis, colour, hover_layout, line, log_axis, panels, scatter, with, y_axis,
};
use super::text::{TextTable, escape, paragraph, rounded};
use crate::prediction::{
    HEADER, PredictedMode, PredictedPosition, PredictionDocument, mode_rows, stiffness_rows,
};

/// A measured natural frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredMode {
    /// Name of the position.
    pub position: String,
    /// Nut position (m).
    pub nut_m: f64,
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Whether it was held out of the fit.
    pub held_out: bool,
}

/// A predicted peak: nut position (m), frequency (Hz) and its interval.
type PeakRow = (f64, f64, [f64; 2]);

/// Number of orders in the chart of natural frequencies.
const ORDERS: usize = 7;
/// Largest distance ln(measured/predicted) of a mark from its order: beyond, the model lacks the mode.
const REACH: f64 = 0.2;

/// Returns the fill of a band, down to the trace before.
fn band() -> Value {
    json!({ "fill": "tonexty", "fillcolor": "rgba(0,114,178,0.22)" })
}

/// Formats the section of a prediction.
pub fn content(of: &PredictionDocument, measured: &[MeasuredMode]) -> String {
    let several =
        if of.minima > 1 { format!(" about each of {} minima of χ²", of.minima) } else { String::new() };
    let text = format!(
        "95 % intervals from {} machines{several} that data and tolerances leave possible.",
        of.draws
    );
    format!("{}{}{}{}", paragraph(&text), frequencies(of, measured), frfs(of), table(of))
}

/// Returns the predicted frequency (Hz) of an order at a nut position, linear between the predicted
/// positions.
fn interpolated(along: &[(f64, &PredictedPosition)], order: usize, nut_m: f64) -> Option<f64> {
    let of = |at: usize| along.get(at).and_then(|(x, p)| Some((*x, mode(p, order)?.mode.frequency_hz?)));
    let above = along.iter().position(|(x, _)| *x >= nut_m).unwrap_or(along.len());
    match (above.checked_sub(1).and_then(of), of(above)) {
        (Some((a, low)), Some((b, high))) if b > a => Some(low + (high - low) * (nut_m - a) / (b - a)),
        (Some((_, only)), _) | (None, Some((_, only))) => Some(only),
        (None, None) => None,
    }
}

fn mode(position: &PredictedPosition, order: usize) -> Option<&PredictedMode> {
    position.modes.iter().find(|m| m.mode.order == order)
}

/// Formats natural frequency against position, one panel for each order.
fn frequencies(of: &PredictionDocument, measured: &[MeasuredMode]) -> String {
    let along: Vec<(f64, &PredictedPosition)> =
        of.ordered().into_iter().filter_map(|(_, p)| Some((p.nut_m?, p))).collect();
    let most =
        along.iter().flat_map(|(_, p)| p.modes.iter().map(|m| m.mode.order)).max().unwrap_or(0).min(ORDERS);
    if along.len() < 2 || most == 0 {
        return String::new();
    }
    let nearest = |mark: &MeasuredMode| {
        let distance = |order: &usize| {
            let hz = interpolated(&along, *order, mark.nut_m)?;
            Some((*order, (hz / mark.frequency_hz).ln().abs()))
        };
        let all = (1..=most).filter_map(|order| distance(&order));
        all.min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, distance)| *distance < REACH)
            .map(|(order, _)| order)
    };
    let marks: Vec<(usize, &MeasuredMode)> =
        measured.iter().filter_map(|mark| Some((nearest(mark)?, mark))).collect();
    let titles: Vec<String> = (1..=most).map(|order| format!("order {order} (Hz)")).collect();
    let layout = panels(axis("nut position (m)"), &titles, "~g");
    let caption = "Line and band: prediction with its 95 % interval. Marks: measured, filled where fitted, open where held out.";
    let mut chart = Chart::new(
        "prediction-frequency",
        "Predicted natural frequencies against position",
        caption,
        90 + 140 * most,
        layout,
    );
    for order in 1..=most {
        let y_axis = y_axis(order - 1);
        let row = |(x, p): &(f64, &PredictedPosition)| {
            let PredictedMode { mode, frequency95, .. } = mode(p, order)?;
            Some((*x, mode.frequency_hz?, (*frequency95)?))
        };
        let rows: Vec<PeakRow> = along.iter().filter_map(row).collect();
        let x: Vec<f64> = rows.iter().map(|r| r.0).collect();
        let hover = format!("order {order}, %{{x:.4~g}} m<br>%{{y:.5~g}} Hz<extra></extra>");
        let curve = |pick: &dyn Fn(&PeakRow) -> f64, width: f64| {
            let y: Vec<f64> = rows.iter().map(|row| rounded(pick(row), 6)).collect();
            let look = json!({ "line": line(colour(0), width), "yaxis": y_axis, "hovertemplate": hover });
            scatter(&x, y, "lines", look)
        };
        chart.trace(curve(&|row| row.2[0], 0.6));
        chart.trace(with(curve(&|row| row.2[1], 0.6), band()));
        chart.trace(curve(&|row| row.1, 1.8));
        for (held_out, symbol) in [(false, "circle"), (true, "circle-open")] {
            let own: Vec<&MeasuredMode> = marks
                .iter()
                .filter(|(of, mark)| *of == order && mark.held_out == held_out)
                .map(|(_, mark)| *mark)
                .collect();
            if own.is_empty() {
                continue;
            }
            let (x, y): (Vec<f64>, Vec<f64>) = own.iter().map(|mark| (mark.nut_m, mark.frequency_hz)).unzip();
            let names: Vec<String> = own.iter().map(|mark| escape(&mark.position)).collect();
            let hover = "%{text}, measured<br>%{y:.5~g} Hz<extra></extra>";
            let mark = json!({ "color": colour(1), "size": 9, "symbol": symbol });
            let look = json!({ "marker": mark, "text": names, "yaxis": y_axis, "hovertemplate": hover });
            chart.trace(scatter(x, y, "markers", look));
        }
    }
    chart.html()
}

/// Formats the predicted FRFs with their bands, one position at a time.
fn frfs(of: &PredictionDocument) -> String {
    let positions: Vec<_> =
        of.ordered().into_iter().filter_map(|(name, p)| Some((name, p.frf.as_ref()?))).collect();
    let title = format!("|{}| (SI units)", of.quantity);
    let layout =
        hover_layout(log_axis("frequency (Hz)"), with(log_axis(&title), json!({ "tickformat": "~e" })));
    let caption = format!(
        "{}/{}. Line and band: prediction with its pointwise 95 % band, without noise.",
        of.response, of.excitation
    );
    let options = positions.iter().map(|(name, _)| (*name).clone()).collect();
    let switches = Switches { label: "Position".into(), options, many: false, coloured: false };
    let mut chart = Chart::new("prediction-frf", "Predicted FRFs", &caption, 420, layout)
        .switches(vec![switches])
        .log_switch();
    for (at, (_, frf)) in positions.iter().enumerate() {
        let hz: Vec<f64> = frf.frequency_hz.iter().map(|hz| rounded(*hz, 7)).collect();
        let curve = |y: Vec<f64>, width: f64| {
            let hover = "%{x:.5~g} Hz: %{y:.3~e}<extra></extra>";
            scatter(&hz, y, "lines", json!({ "line": line(colour(0), width), "hovertemplate": hover }))
        };
        let end =
            |which: usize| frf.magnitude95.iter().map(|ends| rounded(ends[which], 5)).collect::<Vec<f64>>();
        let value = frf.value.iter().map(|[re, im]| rounded(re.hypot(*im), 5)).collect::<Vec<f64>>();
        for trace in [curve(end(0), 0.5), with(curve(end(1), 0.5), band()), curve(value, 1.6)] {
            chart.trace_for(vec![Some(at)], trace);
        }
    }
    chart.html()
}

/// Formats the predicted modes and static stiffnesses as tables.
fn table(of: &PredictionDocument) -> String {
    let (place, modes) = mode_rows(of);
    let heads = HEADER.map(|name| if name == "Nut m" { place } else { name });
    let mut table =
        TextTable::new("Predicted natural frequencies, damping ratios and amplitudes (SI units)", 2, heads);
    modes.into_iter().for_each(|row| table.row(row));
    let mut stiffness =
        TextTable::new("Predicted static stiffness (SI units)", 1, [place, "Stiffness", "95 % interval"]);
    stiffness_rows(of).into_iter().for_each(|row| stiffness.row(row));
    table.html() + &stiffness.html()
}
