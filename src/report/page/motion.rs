//! Motion records: force and residual over time, distribution of the misfit, friction curve.

use serde_json::json;

use super::chart::{
    Chart, Switches, axis, bar_layout, colour, layout, line, name_axis, percent_axis, scatter,
};
use super::text::{TextTable, escape, rounded};
use crate::diagnosis::DiagnosisDocument;
use crate::document::IdentificationDocument;
use crate::record::{CurveRow, MotionRows, RECORD_HEADS, record_cells};
use crate::terminal::percent;
use crate::vocabulary::{Direction, MisfitBy};

/// Formats the part of a diagnosis on motion records.
pub fn content(of: &DiagnosisDocument) -> String {
    let Some(motion) = &of.motion else { return String::new() };
    let mut records = TextTable::new(
        "Records compared with the chosen model",
        2,
        [
            "Record",
            "",
            "Error before",
            "Error after",
            "With its own delay and factor",
            "Delay of position after force (ms)",
            "Force factor",
        ],
    );
    for r in &motion.records {
        let [low, high] = r.delay95_s;
        records.row([
            r.record.clone(),
            r.role.label(false).into(),
            percent(r.gap_before),
            percent(r.gap_after),
            percent(r.gap_own_chain),
            format!("{:.2} ({:.2} … {:.2})", 1e3 * r.delay_s, 1e3 * low, 1e3 * high),
            format!("{:.3}", r.factor),
        ]);
    }
    let contradictions: String = motion
        .contradictions
        .iter()
        .map(|c| format!("<p><strong>Measurement:</strong> {}</p>\n", escape(c)))
        .collect();
    let curve = friction_curve(&motion.friction_curve, &motion.unit);
    format!(
        "{contradictions}{}{}{}{curve}{}",
        records.html(),
        force(motion),
        phases(motion),
        misfit_table(motion)
    )
}

/// Formats the records of an identification.
pub fn identified(of: &IdentificationDocument) -> String {
    let mut table =
        TextTable::new("Records: force errors, relative to the force's root mean square", 2, RECORD_HEADS);
    of.records.iter().for_each(|row| table.row(record_cells(row)));
    format!("{}{}", table.html(), friction_curve(&of.friction_curve, "N or N·m"))
}

fn force(of: &MotionRows) -> String {
    let options: Vec<String> = of.traces.iter().map(|t| t.record.clone()).collect();
    let mut chart = Chart::new(
        "force",
        "Measured force and residual",
        "One period, where the command repeats. Residual: measured less predicted, with the machine as described and with the chosen model.",
        380,
        layout(true, axis("time (s)"), axis(&format!("force or torque ({})", of.unit))),
    )
    .switches(vec![Switches { label: "Record".into(), options, many: false, coloured: false }]);
    for (at, trace) in of.traces.iter().enumerate() {
        for (name, n, y) in [
            ("measured", 6, &trace.measured),
            ("residual, as described", 1, &trace.before),
            ("residual, chosen model", 0, &trace.after),
        ] {
            let hover = "%{x:.3~g} s: %{y:.4~g}";
            let look = json!({ "name": name, "line": line(colour(n), 1.2), "hovertemplate": hover });
            chart.trace_for(vec![Some(at)], scatter(&trace.time_s, y, "lines", look));
        }
    }
    chart.html()
}

fn phases(of: &MotionRows) -> String {
    let mut chart = Chart::new(
        "phases",
        "Share of the squared misfit by phase of the motion, machine as described",
        "",
        280,
        bar_layout(name_axis(""), percent_axis("share")),
    );
    for (n, trace) in of.traces.iter().enumerate() {
        let own = of.misfit_map.iter().filter(|c| {
            c.by == MisfitBy::Phase
                && c.direction == Direction::Both
                && c.record == trace.record
                && c.column.is_none()
        });
        let (x, y): (Vec<String>, Vec<f64>) =
            own.map(|c| (c.phase.clone().unwrap_or_default(), rounded(c.share, 4))).unzip();
        if !x.is_empty() {
            chart.trace(json!({
                "type": "bar", "x": x, "y": y, "name": escape(&trace.record), "marker": { "color": colour(n) },
                "hovertemplate": "%{x}: %{y:.1%}",
            }));
        }
    }
    chart.html()
}

fn misfit_table(of: &MotionRows) -> String {
    let mut table = TextTable::new(
        "Misfit of the machine as described, by speed and by position",
        3,
        ["Record", "Range", "Direction", "Error", "Share", "Mean residual"],
    );
    for c in of.misfit_map.iter().filter(|c| c.by != MisfitBy::Phase && c.column.is_none()) {
        let [from, to] = c.range.unwrap_or([f64::NAN; 2]);
        let place = if c.by == MisfitBy::SpeedMS {
            format!("{from:.3} … {to:.3} m/s")
        } else {
            format!("{from:.3} … {to:.3} m")
        };
        let mean = format!("{:+.2} {}", c.mean, of.unit);
        table.row([c.record.clone(), place, c.direction.to_string(), percent(c.gap), percent(c.share), mean]);
    }
    table.html()
}

fn friction_curve(of: &[CurveRow], unit: &str) -> String {
    let mut chart = Chart::new(
        "friction-curve",
        "Force at constant speed",
        "Points: means over intervals at constant speed of the fitted records, less the inertia force. Line: the model.",
        320,
        layout(true, axis("velocity (m/s)"), axis(&format!("force or torque ({unit})"))),
    );
    if !of.is_empty() {
        let x: Vec<f64> = of.iter().map(|p| rounded(p.velocity_m_s, 5)).collect();
        let y: Vec<f64> = of.iter().map(|p| rounded(p.load, 5)).collect();
        let spread: Vec<f64> = of.iter().map(|p| rounded(p.sd, 3)).collect();
        let hover = "%{x:.4~g} m/s: %{y:.4~g}";
        let look = json!({
            "name": "measured", "error_y": { "type": "data", "array": spread }, "marker": { "color": colour(1) },
            "hovertemplate": hover,
        });
        chart.trace(scatter(x, y, "markers", look));
        // One line per direction, because friction changes discontinuously with the sign of the velocity.
        for forward in [false, true] {
            let side = of
                .iter()
                .filter(|p| (p.velocity_m_s > 0.0) == forward)
                .filter_map(|p| Some((rounded(p.velocity_m_s, 5), rounded(p.predicted?, 5))));
            let (x, y): (Vec<f64>, Vec<f64>) = side.unzip();
            let look = json!({
                "name": "model", "showlegend": forward, "line": line(colour(0), 1.6), "hovertemplate": hover,
            });
            chart.trace(scatter(x, y, "lines", look));
        }
    }
    chart.html()
}
