//! Parameters: values and intervals, correlations, and how the searches converged.

use serde_json::{Value, json};

use super::chart::{Chart, axis, colour, dash, layout, line, log_axis, name_axis, scatter, with};
use super::text::{TextTable, escape, paragraph, rounded};
use std::collections::BTreeMap;

use crate::certainty::ToleranceRow;
use crate::document::IdentificationDocument;
use crate::identification::found_text;
use crate::table::{TOLERANCE_HEADS, dependence, parameter_cells, tolerance_cells};
use crate::terminal::{figure, range, unit, with_interval};

/// Draws values with their intervals, and a chart of intervals and plausible ranges.
pub fn values(of: &IdentificationDocument) -> String {
    let heads =
        ["Parameter", "Description", "Value", "Unit", "95 % interval", "Plausible range", "Identifiable"];
    let mut table = TextTable::new("Parameters", 2, heads);
    for (id, p) in &of.parameters {
        let [value, interval, identifiable] = parameter_cells(p);
        table.row([
            id.clone(),
            p.description.clone(),
            value,
            unit(&p.unit),
            interval,
            range([p.lower, p.upper]),
            identifiable,
        ]);
    }
    let mut derived = TextTable::new("Derived quantities", 1, ["Quantity", "Value", "95 % interval"]);
    for (name, x) in &of.derived {
        let (value, interval) = match of.derived_interval95.get(name) {
            Some(ends) => with_interval(*x, *ends),
            None => (figure(*x), "–".into()),
        };
        derived.row([name.replace('_', " "), value, interval]);
    }
    let combinations: String = of.combinations.iter().map(|c| paragraph(&c.description)).collect();
    let note = dependence(&of.parameters).map_or(String::new(), |text| paragraph(&text));
    format!("{}{note}{}{}{combinations}", table.html(), intervals(of), derived.html())
}

/// Draws the tolerances that were fitted as nuisance parameters, the farthest moved first.
pub fn tolerances(of: &BTreeMap<String, ToleranceRow>) -> String {
    if of.is_empty() {
        return String::new();
    }
    let mut rows: Vec<(&String, &ToleranceRow)> = of.iter().collect();
    rows.sort_by(|a, b| b.1.deviation().abs().total_cmp(&a.1.deviation().abs()));
    let mut table = TextTable::new("Tolerances fitted as nuisance parameters", 1, TOLERANCE_HEADS);
    rows.into_iter().for_each(|row| table.row(tolerance_cells(row)));
    let explanation = "Machine and measurement state these numbers within tolerances; they are fitted together with the parameters, each with its prior. One that moved \
                       far may be misstated, or make up for an effect that the description lacks.";
    format!("{}{}", paragraph(explanation), table.html())
}

/// Draws plausible range (pale) and interval (dark) of each parameter, over its value.
fn intervals(of: &IdentificationDocument) -> String {
    // The gain has no plausible range: its bounds are numerical.
    let positive =
        of.parameters.iter().filter(|(id, p)| *id != "gain" && p.fitted && p.lower > 0.0 && p.value > 0.0);
    let rows: Vec<_> = positive.collect();
    let names: Vec<String> = rows.iter().map(|(id, _)| escape(id)).collect();
    let mut chart = Chart::new(
        "intervals",
        "Plausible range and 95 % interval of each parameter, relative to its value",
        "Pale: plausible range before the measurement. Dark: 95 % interval after it. Where only the pale bar stands, the data do not determine the parameter.",
        90 + 30 * rows.len(),
        layout(false, log_axis("times the value"), name_axis("")),
    );
    for (name, (id, p)) in names.iter().zip(&rows) {
        let bar = |ends: [f64; 2], line: Value, opacity: f64, what: &str| {
            let hover =
                format!("{}, {what}<br>{} {}<extra></extra>", escape(id), range(ends), escape(&p.unit));
            let look = json!({ "line": line, "opacity": opacity, "hovertemplate": hover });
            scatter(ends.map(|x| rounded(x / p.value, 5)), [name, name], "lines", look)
        };
        chart.trace(bar([p.lower, p.upper], line("#8A8A8A", 12.0), 0.35, "plausible range"));
        for ends in p.parts().into_iter().filter(|i| i.iter().all(|x| x.is_finite() && *x > 0.0)) {
            chart.trace(bar(ends, line(colour(0), 7.0), 1.0, "95 % interval"));
        }
        let hover = format!("{}<br>{} {}<extra></extra>", escape(id), figure(p.value), escape(&p.unit));
        let look = json!({ "marker": { "color": colour(1), "size": 8 }, "hovertemplate": hover });
        chart.trace(scatter([1.0], [name], "markers", look));
    }
    chart.html()
}

/// Correlations of the fitted parameters as a heat map.
pub fn correlations(of: &IdentificationDocument) -> String {
    let names: Vec<String> = of.fitted_parameters.iter().map(|n| escape(n)).collect();
    if names.len() < 2 || of.correlation.len() != names.len() {
        return String::new();
    }
    let z: Vec<Vec<f64>> = of
        .correlation
        .iter()
        .map(|row| row.iter().map(|x| (x * 1000.0).round() / 1000.0).collect())
        .collect();
    let rows = json!({ "autorange": true, "range": [names.len() as f64 - 0.5, -0.5] });
    let mut chart = Chart::new(
        "correlations",
        "Correlations of the fitted parameters",
        "Near +1 or −1 the data determine only a combination of two parameters.",
        160 + 30 * names.len(),
        layout(false, name_axis(""), with(name_axis(""), rows)),
    );
    chart.trace(json!({
        "type": "heatmap", "x": names, "y": names, "z": z, "zmin": -1.0, "zmax": 1.0,
        "colorscale": [[0.0, "#0072B2"], [0.5, "#F7F7F7"], [1.0, "#D55E00"]],
        "hovertemplate": "%{y} and %{x}: %{z:.2f}<extra></extra>",
    }));
    chart.html()
}

/// Least cost after each generation or start of each round of searches.
pub fn convergence(of: &IdentificationDocument) -> String {
    let mut chart = Chart::new(
        "convergence",
        "Least cost after each generation or start of each round of searches",
        "",
        300,
        layout(of.searches.len() > 1, axis("generation or start"), log_axis("cost")),
    );
    let mut table =
        TextTable::new("Rounds of searches, best first", 1, ["Seed", "Least cost", "Evaluations"]);
    for (n, search) in of.searches.iter().enumerate() {
        table.row([search.seed.to_string(), figure(search.cost), search.evaluations.to_string()]);
        // A stair: only where the cost falls.
        let falls =
            |i: &usize| *i == 0 || *i + 1 == search.trace.len() || search.trace[*i] < search.trace[*i - 1];
        let kept: Vec<usize> = (0..search.trace.len()).filter(falls).collect();
        if kept.is_empty() {
            continue;
        }
        let y: Vec<f64> = kept.iter().map(|i| rounded(search.trace[*i], 5)).collect();
        let pen = with(line(colour(n), 1.6), json!({ "dash": dash(n), "shape": "hv" }));
        let name = format!("seed {}", search.seed);
        let look = json!({ "name": name, "line": pen, "hovertemplate": "%{x}<br>%{y:.5~g}" });
        chart.trace(scatter(kept, y, "lines", look));
    }
    let effort = of.search.as_ref().map(found_text).unwrap_or_default();
    let agreement = match effort.strip_prefix("; ") {
        Some(effort) if of.searches_agree == Some(false) => {
            paragraph(&format!("{effort}: a better minimum may exist."))
        }
        Some(effort) => paragraph(&format!("{effort}.")),
        None => String::new(),
    };
    format!("{agreement}{}{}", chart.html(), table.html())
}
