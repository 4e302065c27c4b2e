//! Single- against multi-position identification.

use plotly::Bar;
use plotly::common::Marker;
use plotly::layout::{AxisType, BarMode};

use super::chart::{Chart, axis, colour, layout};
use super::text::escape;
use crate::document::ComparisonDocument;
use crate::table::summary;

/// Formats the section.
pub fn content(of: &ComparisonDocument) -> String {
    let gaps = of.runs.values().any(|r| r.common_gap.is_some());
    let table = summary(of);
    let mut chart = Chart::new(
        "comparison-chart",
        &table.caption,
        "",
        280,
        layout()
            .show_legend(true)
            .bar_mode(BarMode::Group)
            .x_axis(axis("fitted on").type_(AxisType::Category))
            .y_axis(axis(if gaps { "gap, together" } else { "error, together" }).tick_format(if gaps {
                ""
            } else {
                ".0%"
            })),
    );
    let mut bars = |name: &str, n: usize, pick: &dyn Fn(&crate::document::ComparisonRun) -> Option<f64>| {
        let points = of.runs.values().filter_map(|r| Some((escape(&r.fit_positions.join(",")), pick(r)?)));
        let (x, y): (Vec<String>, Vec<f64>) = points.unzip();
        if !x.is_empty() {
            chart.trace(Bar::new(x, y).name(name).marker(Marker::new().color(colour(n))));
        }
    };
    bars("ours", 0, &|r| r.common_gap.or(r.common_error));
    bars("published", 4, &|r| r.common_error_published);
    format!("{}{}", table.html(), chart.html())
}
