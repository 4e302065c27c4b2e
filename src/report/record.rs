//! Motion records: their text on a terminal, and their rows in documents.

use std::collections::BTreeMap;

use super::diagnosis::DiagnosisDocument;
use super::diagnosis_text::{candidates_text, estimated_text, gap_text, verdict_text};
pub use super::motion_row::{
    ChannelRow, CurveRow, LearnableRow, MeasuringChainRow, MisfitRow, MotionRecordRow, MotionRows,
    PreprocessingRow, TraceRow, TransmissionRow,
};
use super::terminal::{columns, percent, signed, unit, wrapped};
use super::text_table::cell;
use super::vocabulary::{Direction, MisfitBy};

/// Heads of the table of motion records.
pub(super) const RECORD_HEADS: [&str; 6] =
    ["record", "role", "force error", "simulated", "noise floor", "samples"];

/// Returns a motion record as the cells of its row.
pub(super) fn record_cells((name, r): (&String, &MotionRecordRow)) -> [String; 6] {
    [
        name.clone(),
        r.role.label(false).into(),
        percent(r.force_error),
        cell(r.simulated_force_error, percent),
        cell(r.noise_floor, percent),
        format!("{} of {}", r.compared, r.samples),
    ]
}

/// Returns motion records with their errors as a table.
pub fn records_table(records: &BTreeMap<String, MotionRecordRow>) -> String {
    columns(&RECORD_HEADS.map(String::from), records.iter().map(|row| record_cells(row).to_vec()))
}

/// The diagnosis of motion records as text: the verdict first.
pub fn motion_diagnosis_text(document: &DiagnosisDocument) -> String {
    let Some(motion) = &document.motion else { return String::new() };
    let mut text = verdict_text(document);
    text += &motion.contradictions.iter().map(|c| wrapped(&format!("measurement: {c}"))).collect::<String>();
    if let Some(phase) = &document.verdict.phase {
        text += &wrapped(&format!("largest residual in phase: {phase}"));
    }
    text.push('\n');
    let gap = if motion.transmission.is_empty() {
        "force error of held-out records"
    } else {
        "error of force and transmission at held-out records (each weighted by its noise)"
    };
    text += &gap_text(document, gap);
    text += &estimated_text(document);
    text += &candidates_text(
        document,
        ["effect", "reduction of prediction error", "held-out error", "closed", "p"],
    );
    if !motion.transmission.is_empty() {
        text += "\ntransmission error at extra measuring points (µm or µrad, rms residual) and their tracking error\n";
        let rows = motion.transmission.iter().map(|c| {
            let left = |r: &TransmissionRow| format!("{:.2}", 1e6 * r.residual);
            let tracking = |r: &TransmissionRow| cell(r.tracking_gap, percent);
            vec![
                c.record.clone(),
                c.column.clone(),
                left(&c.before),
                left(&c.after),
                tracking(&c.before),
                tracking(&c.after),
            ]
        });
        text += &columns(
            &["record", "column", "before", "after", "tracking before", "after"].map(String::from),
            rows,
        );
    }
    for l in &motion.learnable {
        let um = |x: f64| format!("{:.2}", 1e6 * x);
        let conclusion = match l.after <= 1.2 * l.with_network {
            true => "the chosen model predicts as well as the network",
            false => "the network predicts better: an effect is still missing",
        };
        text += &wrapped(&format!(
            "{}, held out: {} µm (µrad) as described, {} with a network trained on the residual, {} with the chosen model; {conclusion}",
            l.column,
            um(l.before),
            um(l.with_network),
            um(l.after)
        ));
    }
    text += &phases_text(motion);
    let rows = document
        .places
        .iter()
        .filter(|p| p.over.is_some())
        .take(3)
        .map(|p| vec![p.place_text(), p.shape.clone(), format!("{:.1} %", 100.0 * p.misfit_reduction)]);
    let of = if motion.transmission.is_empty() { "force" } else { "force or transmission error" };
    text += &format!("\nreduction by a {of} that is a free smooth function of one quantity\n");
    text += &columns(&["function of", "resembles", "reduction"].map(String::from), rows);
    text
}

/// Share of the squared residual of the machine as described by record, channel and phase of motion, with its
/// mean in both directions.
fn phases_text(motion: &MotionRows) -> String {
    let unit_of = |cell: &MisfitRow| {
        let channel = motion.transmission.iter().find(|c| Some(&c.column) == cell.column.as_ref());
        match channel.map(|c| c.before.unit.as_str()) {
            Some("rad") => (1e6, "µrad".to_string()),
            Some(_) => (1e6, "µm".to_string()),
            None => (1.0, unit(&motion.unit)),
        }
    };
    let whole =
        motion.misfit_map.iter().filter(|c| c.by == MisfitBy::Phase && c.direction == Direction::Both);
    let rows = whole.map(|c| {
        let (scale, unit) = unit_of(c);
        let mean = |direction: Direction| {
            let same = |d: &&MisfitRow| {
                (&d.record, &d.column, &d.phase, d.direction) == (&c.record, &c.column, &c.phase, direction)
            };
            motion.misfit_map.iter().find(same).map_or("–".into(), |d| signed(scale * d.mean))
        };
        vec![
            c.column.as_ref().map_or(c.record.clone(), |column| format!("{} {column}", c.record)),
            c.phase.clone().unwrap_or_default(),
            format!("{:.0} %", 100.0 * c.share),
            percent(c.gap),
            mean(Direction::Forward),
            mean(Direction::Backward),
            unit,
        ]
    });
    let heads = ["record", "phase", "share", "error", "mean forward", "backward", "unit"];
    let table = columns(&heads.map(String::from), rows);
    format!("\nlocation: share of the squared residual of the machine as described, by phase\n{table}")
}
