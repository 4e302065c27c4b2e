//! A simulated motion as text: its signals as a table, and a summary.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::csv_cell::csv_cell;
use super::motion::MotionDocument;

/// Returns the names of the signals in the order of a table: those of the axis, then those of its points.
fn signals(document: &MotionDocument) -> Vec<&str> {
    let has = |name: &str| document.columns.contains_key(name);
    let axis = if has("velocity_rad_s") {
        ["time_s", "command_rad", "position_rad", "force_n", "torque_nm", "velocity_rad_s"]
    } else {
        ["time_s", "command_m", "position_m", "force_n", "torque_nm", "velocity_m_s"]
    };
    let points = document.columns.keys().map(String::as_str).filter(|name| !axis.contains(name));
    axis.into_iter().filter(|name| has(name)).chain(points).collect()
}

/// Returns the signals of a motion as a CSV table.
pub fn motion_csv(document: &MotionDocument) -> String {
    let names = signals(document);
    let columns: Vec<&Vec<f64>> = names.iter().filter_map(|name| document.columns.get(*name)).collect();
    let mut text = names.iter().map(|name| csv_cell(name)).collect::<Vec<_>>().join(",") + "\n";
    for row in 0..columns.first().map_or(0, |c| c.len()) {
        for (at, column) in columns.iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            // Rounds off the accumulated error of the times.
            let _ = if at == 0 {
                write!(text, "{:.9}", column[row])
            } else {
                write!(text, "{comma}{:e}", column[row])
            };
        }
        text.push('\n');
    }
    text
}

/// Summarises a simulation in a few lines.
pub fn motion_summary(document: &MotionDocument) -> String {
    let mut text = String::new();
    let e = &document.energy;
    let _ = writeln!(
        text,
        "energy: {:.6} J supplied, {:.6} J stored, {:.6} J lost; relative imbalance {:.1e}",
        e.supplied_j, e.stored_j, e.lost_j, e.imbalance
    );
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    document.events.iter().for_each(|e| *counts.entry((&e.joint, &e.kind)).or_default() += 1);
    let counts: Vec<String> =
        counts.iter().map(|((joint, kind), count)| format!("{joint} {kind} {count} times")).collect();
    let _ =
        writeln!(text, "events: {}", if counts.is_empty() { "none".to_string() } else { counts.join(", ") });
    if let Some(record) = &document.record {
        let _ = writeln!(
            text,
            "record {}: rms prediction error {:.2} % of the force, {:.2} % of the tracking error",
            record.name,
            100.0 * record.force_gap,
            100.0 * record.tracking_gap
        );
    }
    if let Some(unstable) = &document.unstable {
        let _ = writeln!(
            text,
            "the loop diverges at {} s, with a tracking error of {:.3e} m or rad: it is unstable; lower its gains, its delay or its periods",
            unstable.time_s, unstable.error
        );
    }
    text
}
