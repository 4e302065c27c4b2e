//! Results of identification, validation and comparison as text on a terminal.

use super::certainty::SearchRow;
use super::document::{ComparisonDocument, IdentificationDocument, ValidationDocument};
use super::order::renumbered_table;
use super::prediction::natural_frequencies_text;
use super::record::records_table;
use super::table::{
    bootstrap, derived_table, frfs, gaps, moved_tolerances, parameters_table, positions,
    run_frequencies_table, run_parameters_table, summary,
};
use super::terminal::wrapped;

/// An identification as text. `title` is that of the machine; `derived` names the derived quantities of its
/// description, in their order.
pub fn identification_text(title: &str, document: &IdentificationDocument, derived: &[String]) -> String {
    if document.records.is_empty() {
        of_responses(title, document, derived)
    } else {
        of_records(title, document)
    }
}

const STOPPED: &str = "stopped early: the result so far\n";

fn of_responses(title: &str, document: &IdentificationDocument, derived: &[String]) -> String {
    let heading = format!(
        "fitted on {}, held out {}",
        document.fit_positions.join(", "),
        match (document.held_out_positions.is_empty(), document.leave_one_out) {
            (false, _) => document.held_out_positions.join(", "),
            (true, false) => "nothing".into(),
            (true, true) => "nothing; each position is predicted by a fit without it".into(),
        }
    );
    let mut text = format!("{title}\n{}\n", wrapped(&heading));
    text += &parameters_table(&document.parameters);
    text.push('\n');
    if let Some(renumbered) = document.renumbered.as_ref().filter(|r| r.cost.is_some()) {
        text += &wrapped("with misplaced modes at the orders they fit:");
        text += &renumbered_table(&document.parameters, renumbered);
        text.push('\n');
    }
    if let Some(moved) = moved_tolerances(&document.tolerances) {
        text += &moved;
        text.push('\n');
    }
    text += &if document.frfs.is_empty() {
        positions("", &document.positions, document.leave_one_out).text()
    } else {
        format!(
            "{}\n{}",
            frfs(&document.frfs, document.leave_one_out).text(),
            natural_frequencies_text(&document.modes)
        )
    };
    text.push('\n');
    if !derived.is_empty() {
        text += &derived_table(&document.derived, &document.derived_interval95, derived);
        text.push('\n');
    }
    if !document.bootstrap.is_empty() {
        text += &bootstrap(&document.bootstrap).text();
        text.push('\n');
    }
    let percent = |key: &str| document.derived.get(key).map(|x| format!("{:.2} %", 100.0 * x));
    for (key, which) in
        [("largest_frequency_error_held_out", "held out"), ("largest_frequency_error_left_out", "left out")]
    {
        if let Some(largest) = percent(key) {
            text += &format!("largest frequency error, {which}: {largest}\n");
        }
    }
    if let Some(rms) = document.derived.get("ln_amplitude_rms_fit") {
        text += &format!("amplitude error at fitted positions: {rms:.3} rms of ln(amplitude)\n");
    }
    let found = document.search.as_ref().map_or_else(String::new, found_text);
    text += &wrapped(&format!("cost {:.6} after {} evaluations{found}", document.cost, document.evaluations));
    if !document.stamp.complete {
        text += STOPPED;
    }
    text
}

/// How often the best minimum was found.
pub(super) fn found_text(SearchRow { starts, found, required }: &SearchRow) -> String {
    match (*starts, found < required) {
        (1, false) => String::new(),
        (_, false) => format!("; {found} of {starts} starts ended in the best minimum"),
        (_, true) => {
            format!("; only {found} of {starts} starts ended in the best minimum, {required} were required")
        }
    }
}

fn of_records(title: &str, document: &IdentificationDocument) -> String {
    let held_out = if document.held_out_positions.is_empty() {
        "nothing".into()
    } else {
        document.held_out_positions.join(", ")
    };
    let mut text = format!(
        "{title}\n{}\n{}\n{}",
        wrapped(&format!(
            "fitted on {} by {}, held out {held_out}",
            document.fit_positions.join(", "),
            document.settings.objective
        )),
        parameters_table(&document.parameters),
        records_table(&document.records)
    );
    if !document.stamp.complete {
        text += STOPPED;
    }
    text
}

/// A validation as text.
pub fn validation_text(document: &ValidationDocument) -> String {
    if !document.records.is_empty() {
        return records_table(&document.records);
    }
    let whole_frfs = document.positions.values().any(|p| p.gap.is_some());
    let mut text = if whole_frfs {
        gaps("", &document.positions).text()
    } else {
        positions("", &document.positions, false).text()
    };
    if let Some(largest) = document.largest_error {
        text += &format!("\nlargest frequency error: {:.2} %\n", 100.0 * largest);
    }
    text
}

/// A comparison of a multi-position identification with single-position ones as text.
pub fn comparison_text(document: &ComparisonDocument) -> String {
    if document.runs.values().any(|r| r.common_gap.is_some()) {
        return String::from(
            "Gap of whole FRFs at the positions and records that no run has fitted, and over all of them\n\n",
        ) + &summary(document).text()
            + "\n"
            + &run_parameters_table(document);
    }
    String::from(
        "Frequency errors at the positions that no run has fitted, and over all of them\n(root of the summed squares)\n\n",
    ) + &summary(document).text()
        + "\nNatural frequencies by order, along the stroke\n\n"
        + &run_frequencies_table(document)
        + "\n"
        + &run_parameters_table(document)
}
