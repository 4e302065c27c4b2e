//! Mode shapes along the shafts.

use serde_json::json;

use super::Page;
use super::chart::{Chart, Switches, axis, colour, dash, hover_layout, line, scatter, with};
use super::text::{escape, rounded};

/// Deflection of a shaft along its length.
#[derive(Debug, Clone, PartialEq)]
pub struct Deflection {
    /// Shaft.
    pub shaft: String,
    /// Torsional; otherwise axial.
    pub torsional: bool,
    /// Distance from the shaft's left end (m) and deflection: axial, or at the circumference.
    pub points: Vec<(f64, f64)>,
}

/// One mode.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeShape {
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Deflections of the shafts.
    pub deflections: Vec<Deflection>,
    /// Name and deflection of the response point of the set.
    pub observed: Option<(String, f64)>,
}

/// The modes at one position.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeGroup {
    /// Position.
    pub position: String,
    /// Nut position (m).
    pub nut_m: Option<f64>,
    /// Modes in ascending frequency.
    pub modes: Vec<ModeShape>,
}

/// Formats the section.
pub fn content(page: &Page) -> String {
    let groups = &page.shapes;
    let longest = groups.iter().map(|g| g.modes.len()).max().unwrap_or(0);
    if longest == 0 {
        return String::new();
    }
    let layout = hover_layout(
        with(axis("distance along the shaft (m)"), json!({ "anchor": "y2" })),
        with(axis("axial"), json!({ "domain": [0.54, 1.0] })),
    );
    let below = with(axis("torsional"), json!({ "domain": [0.0, 0.46] }));
    let layout = with(layout, json!({ "yaxis2": below }));
    let mut chart = Chart::new(
        "shapes-chart",
        "Axial and torsional deflection along the shafts for each undamped mode",
        "Undamped modes at the identified values. Axial deflection, and displacement of the circumference in torsion, \
         relative to the largest of the mode. Mark: nut position, at the deflection of the response point.",
        460,
        layout,
    )
    .switches(vec![
        Switches { label: "Position".into(), options: groups.iter().map(|g| g.position.clone()).collect(), many: false, coloured: false },
        Switches { label: "Modes".into(), options: (1..=longest).map(|n| format!("mode {n}")).collect(), many: true, coloured: true },
    ]);
    for (at, group) in groups.iter().enumerate() {
        for (n, mode) in group.modes.iter().enumerate() {
            let label = format!("mode {}, {:.1} Hz", n + 1, mode.frequency_hz);
            let all = mode.deflections.iter().flat_map(|d| d.points.iter().map(|p| p.1));
            let largest = all
                .chain(mode.observed.iter().map(|o| o.1))
                .fold(0.0, |m: f64, u| if u.abs() > m.abs() { u } else { m });
            let scale = if largest == 0.0 { 1.0 } else { 1.0 / largest };
            for deflection in &mode.deflections {
                let (x, y): (Vec<f64>, Vec<f64>) = deflection
                    .points
                    .iter()
                    .map(|(x, u)| (rounded(*x, 5), rounded((u * scale * 1e5).round() / 1e5, 4)))
                    .unzip();
                let hover = format!(
                    "{label}<br>{}, %{{x:.4~g}} m: %{{y:.3f}}<extra></extra>",
                    escape(&deflection.shaft)
                );
                let pen = with(line(colour(n), 1.8), json!({ "dash": dash(n) }));
                let y_axis = if deflection.torsional { "y2" } else { "y" };
                let look = json!({ "name": label, "line": pen, "yaxis": y_axis, "hovertemplate": hover });
                let trace = scatter(x, y, "lines", look);
                chart.trace_for(vec![Some(at), Some(n)], trace);
            }
            if let (Some((name, u)), Some(nut_m)) = (&mode.observed, group.nut_m) {
                let mark = json!({ "color": colour(n), "size": 9, "symbol": "diamond" });
                let hover = format!("{label}<br>{}: %{{y:.3f}}<extra></extra>", escape(name));
                let look = json!({ "name": label, "marker": mark, "hovertemplate": hover });
                let trace = scatter([nut_m], [rounded(u * scale, 4)], "markers", look);
                chart.trace_for(vec![Some(at), Some(n)], trace);
            }
        }
    }
    chart.html()
}
