//! What is told of motion records on a terminal, and the rows that documents hold of them.

use std::collections::BTreeMap;

use super::diagnosis::{DiagnosisDocument, interval_text, verdict_text};
pub use super::motion_row::{
    ChainRow, ChannelRow, CurveRow, LearnableRow, MisfitRow, MotionRecordRow, MotionRows, PreprocessingRow, TraceRow, TransmissionRow,
};
use super::terminal::{columns, percent, wrapped};

/// Records of an identification for a person.
pub fn records_table(records: &BTreeMap<String, MotionRecordRow>) -> String {
    let header = ["record", "role", "force error", "simulated", "noise leaves", "samples"].map(String::from);
    let rows = records.iter().map(|(name, r)| {
        let optional = |x: Option<f64>| x.map_or("–".into(), percent);
        vec![
            name.clone(),
            r.role.replace('_', " "),
            percent(r.force_error),
            optional(r.simulated_force_error),
            optional(r.noise_floor),
            format!("{} of {}", r.compared, r.samples),
        ]
    });
    columns(&header, rows)
}

/// The diagnosis of motion records for a person: the verdict first.
pub fn motion_diagnosis_text(document: &DiagnosisDocument) -> String {
    let Some(motion) = &document.motion else { return String::new() };
    let optional = |x: Option<f64>| x.map_or("–".into(), percent);
    let mut text = verdict_text(&document.verdict);
    text += &motion.contradictions.iter().map(|c| wrapped(&format!("measurement: {c}"))).collect::<String>();
    if let Some(phase) = &document.verdict.phase {
        text += &wrapped(&format!("shows most in: {phase}"));
    }
    text.push('\n');
    text += &wrapped(&format!(
        "how far — {} of what was held out: {} before, {} after, noise leaves {}; closed {}{}",
        if motion.transmission.is_empty() { "force error" } else { "error of force and transmission, each in units of its noise," },
        optional(document.gap.held_out),
        optional(document.chosen.gap_held_out),
        optional(document.noise_floor),
        document.chosen.closed.map_or("–".into(), |c| format!("{:.0} %", 100.0 * c)),
        interval_text(document.chosen.closed95, ""),
    ));
    text += "\nwhich — candidates, best first; taken: of what is not foretold of parts left out\n";
    let tried = document.effects.iter().filter(|e| e.status == "tried").take(10).map(|e| {
        vec![
            if e.selected { format!("* {}", e.id) } else { format!("  {}", e.id) },
            format!("{:.1} %", 100.0 * e.misfit_reduction),
            optional(e.gap_held_out_after),
            e.closed.map_or("–".into(), |c| format!("{c:.2}")),
            e.p_value.map_or("–".into(), |p| format!("{p:.4}")),
        ]
    });
    text += &columns(&["effect", "taken", "held-out error", "closed", "p"].map(String::from), tried);
    for (status, words) in [("failed", "could not be fitted, so that nothing is said of: "), ("not-applicable", "do not apply: ")] {
        let ids: Vec<&str> = document.effects.iter().filter(|e| e.status == status).map(|e| e.id.as_str()).collect();
        if !ids.is_empty() {
            text += &wrapped(&format!("{words}{}", ids.join(", ")));
        }
    }
    if !motion.transmission.is_empty() {
        text += "\ntransmission — what is left at further points (µm or µrad), and of their tracking error\n";
        let rows = motion.transmission.iter().map(|c| {
            let left = |r: &TransmissionRow| format!("{:.2}", 1e6 * r.residual);
            let tracking = |r: &TransmissionRow| optional(r.tracking_gap);
            vec![c.record.clone(), c.column.clone(), left(&c.before), left(&c.after), tracking(&c.before), tracking(&c.after)]
        });
        text += &columns(&["record", "column", "before", "after", "tracking before", "after"].map(String::from), rows);
    }
    for l in &motion.learnable {
        let um = |x: f64| format!("{:.2}", 1e6 * x);
        let said = match l.after <= 1.2 * l.with_network {
            true => "physics leaves it nothing to win",
            false => "what it wins is an effect that is still missing",
        };
        text += &wrapped(&format!(
            "{}, held out: {} µm (µrad) with the machine as described, {} with a network that has learnt it, {} with the chosen model: {said}",
            l.column,
            um(l.before),
            um(l.with_network),
            um(l.after)
        ));
    }
    text += "\nwhere — share of the squared misfit of the machine as described, by phase\n";
    let phases = motion.misfit_map.iter().filter(|c| c.by == "phase" && c.direction == "both").map(|c| {
        let same = |d: &&MisfitRow| d.record == c.record && d.column == c.column && d.phase == c.phase && d.direction != "both";
        let (scale, unit) = if c.column.is_some() { (1e6, " µm (µrad)") } else { (1.0, "") };
        let mean = |d: &MisfitRow| format!("{:+.2}{unit} {}", scale * d.mean, d.direction);
        let sides: Vec<String> = motion.misfit_map.iter().filter(same).map(mean).collect();
        let name = c.phase.clone().unwrap_or_default();
        vec![
            c.column.as_ref().map_or(c.record.clone(), |column| format!("{} {column}", c.record)),
            name,
            format!("{:.0} %", 100.0 * c.share),
            percent(c.gap),
            sides.join(", "),
        ]
    });
    let left = format!("mean left ({})", motion.unit);
    text += &columns(&["record", "phase", "share", "error", left.as_str()].map(String::from), phases);
    let rows =
        document.places.iter().take(3).map(|p| vec![p.place_text(), p.shape.clone(), format!("{:.1} %", 100.0 * p.misfit_reduction)]);
    let of = if motion.transmission.is_empty() { "force" } else { "force or transmission error" };
    text += &format!("\na {of} that is any smooth function of one thing would take\n");
    text += &columns(&["of", "like", "taken"].map(String::from), rows);
    text
}
