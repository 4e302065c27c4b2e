//! Single- against multi-position identification.

use serde_json::json;

use super::chart::{Chart, axis, bar_layout, colour, name_axis, percent_axis};
use super::text::escape;
use crate::document::ComparisonDocument;
use crate::table::summary;

/// Formats the section.
pub fn content(of: &ComparisonDocument) -> String {
    let gaps = of.runs.values().any(|r| r.common_gap.is_some());
    let table = summary(of);
    let together = if gaps { axis("gap, together") } else { percent_axis("error, together") };
    let layout = bar_layout(name_axis("fitted on"), together);
    let mut chart = Chart::new("comparison-chart", &table.caption, "", 280, layout);
    let mut bars = |name: &str, n: usize, pick: &dyn Fn(&crate::document::ComparisonRun) -> Option<f64>| {
        let points = of.runs.values().filter_map(|r| Some((escape(&r.fit_positions.join(",")), pick(r)?)));
        let (x, y): (Vec<String>, Vec<f64>) = points.unzip();
        if !x.is_empty() {
            let marker = json!({ "color": colour(n) });
            chart.trace(json!({ "type": "bar", "x": x, "y": y, "name": name, "marker": marker }));
        }
    };
    bars("ours", 0, &|r| r.common_gap.or(r.common_error));
    bars("published", 4, &|r| r.common_error_published);
    format!("{}{}", table.html(), chart.html())
}
