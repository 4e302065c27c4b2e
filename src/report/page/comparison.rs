//! Single- against multi-position identification.

use plotly::Bar;
use plotly::common::Marker;
use plotly::layout::{AxisType, BarMode};

use super::chart::{Chart, axis, colour, layout};
use super::text::{TextTable, cell, escape};
use crate::document::ComparisonDocument;
use crate::terminal::{figure, percent};

/// Formats the section.
pub fn content(of: &ComparisonDocument) -> String {
    let gaps = of.runs.values().any(|r| r.common_gap.is_some());
    let header = ["Fitted on".to_string(), String::new()].into_iter().chain(of.common_positions.iter().cloned());
    let caption = if gaps { "Gaps at the positions held out" } else { "Overall frequency errors at the positions held out" };
    let mut table = TextTable::new(caption, 2, header.chain(["together".to_string()]));
    for run in of.runs.values() {
        let line = |pick: &dyn Fn(&crate::document::PositionRow) -> String| -> Vec<String> {
            of.common_positions.iter().map(|p| run.positions.get(p).map_or_else(|| "–".into(), pick)).collect()
        };
        let mut row = |first: String, what: &str, middle: Vec<String>, last: String| {
            table.row([first, what.to_string()].into_iter().chain(middle).chain([last]).collect::<Vec<_>>());
        };
        let on = run.fit_positions.join(", ");
        if gaps {
            row(on, "", line(&|p| cell(p.gap, figure)), cell(run.common_gap, figure));
        } else {
            row(on, "ours", line(&|p| cell(p.overall_error, percent)), cell(run.common_error, percent));
            if run.common_error_published.is_some() {
                let published = cell(run.common_error_published, percent);
                row(String::new(), "published", line(&|p| cell(p.overall_error_published, percent)), published);
            }
        }
    }
    let mut chart = Chart::new(
        "comparison-chart",
        caption,
        "",
        280,
        layout()
            .show_legend(true)
            .bar_mode(BarMode::Group)
            .x_axis(axis("fitted on").type_(AxisType::Category))
            .y_axis(axis(if gaps { "gap, together" } else { "error, together" }).tick_format(if gaps { "" } else { ".0%" })),
    );
    let mut bars = |name: &str, n: usize, pick: &dyn Fn(&crate::document::ComparisonRun) -> Option<f64>| {
        let points = of.runs.values().filter_map(|r| Some((escape(&r.fit_positions.join(", ")), pick(r)?)));
        let (x, y): (Vec<String>, Vec<f64>) = points.unzip();
        if !x.is_empty() {
            chart.trace(Bar::new(x, y).name(name).marker(Marker::new().color(colour(n))));
        }
    };
    bars("ours", 0, &|r| r.common_gap.or(r.common_error));
    bars("published", 4, &|r| r.common_error_published);
    format!("{}{}", table.html(), chart.html())
}
