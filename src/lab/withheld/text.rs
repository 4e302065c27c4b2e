//! Scores as text, at most 80 columns wide.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use report::columns;

use super::document::WithheldDocument;
use super::proportion::Proportion;
use super::score::{Confusion, LocationScore, Scores, Spread};

const WIDTH: usize = 80;

/// Formats the document of a blind check.
pub fn withheld_text(document: &WithheldDocument) -> String {
    let mut text = scores_text(&document.scores);
    if !document.stamp.complete {
        text = format!(
            "\nStopped early: {} of {} case folders are diagnosed.\n{text}",
            document.cases.len(),
            document.sealed_cases
        );
    }
    if !document.not_made.is_empty() {
        text += &format!(
            "\n{} cases of the plan could not be made; the warnings state why.\n",
            document.not_made.len()
        );
    }
    if document.refused_machines > 0 {
        text += &format!(
            "\n{} machines were drawn and refused before those of the cases.\n",
            document.refused_machines
        );
    }
    text + &format!("\n{} diagnoses in parallel, on {} threads each\n", document.jobs, document.threads_each)
}

/// Formats the scores, the confusion matrix last.
pub fn scores_text(scores: &Scores) -> String {
    let mut text = String::new();
    section(&mut text, "No missing effect", &|text| {
        line(text, "false alarms, ordinary nulls", &scores.false_alarm_ordinary);
        line(text, "  an effect named", &scores.false_name_ordinary);
        line(text, "false alarms, hard nulls", &scores.false_alarm_hard);
        line(text, "wrong parameter: named, or none", &scores.wrong_parameter);
        line(text, "  frozen, and named", &scores.wrong_parameter_frozen);
        line(text, "bad channel: verdict measurement", &scores.bad_channel);
    });
    section(&mut text, "Detection: a discrepancy is reported", &|text| {
        // Single effects last, next to their rows by strength.
        let (single, others): (Vec<_>, Vec<_>) =
            scores.detection_by_kind.iter().partition(|(kind, _)| *kind == "single");
        for (kind, row) in others.into_iter().chain(single) {
            line(text, &format!("{kind} effects"), row);
        }
        for strength in ["faint", "weak", "clear", "strong"] {
            if let Some(row) = scores.detection_by_strength.get(strength) {
                line(text, &format!("  single, {strength}"), row);
            }
        }
        for (range, row) in &scores.detection_by_noncentrality {
            line(text, &format!("  single, non-centrality {range}"), row);
        }
    });
    section(&mut text, "Names of single effects (abstentions count as wrong)", &|text| {
        for (name, naming) in [("all", &scores.naming), ("from 25", &scores.naming_from_25)] {
            line(text, &format!("exact, {name}"), &naming.exact);
            line(text, &format!("a set that contains it, {name}"), &naming.class);
            line(text, &format!("among the first three, {name}"), &naming.top3);
            if let Some(mean) = naming.mean_set {
                let _ =
                    writeln!(text, "  {:<40} {mean:>9.2}", format!("effects named together, {name}, mean"));
            }
        }
        line(text, "correct where one effect is named", &scores.selective);
        line(text, "  one effect is named, from 25", &scores.selective_coverage);
    });
    section(&mut text, "Unknown, look-alike and double effects", &|text| {
        line(text, "unknown: verdict unknown", &scores.unknown);
        line(text, "unknown: named by the library", &scores.unknown_misnamed);
        line(text, "known: verdict unknown", &scores.known_called_unknown);
        line(text, "look-alikes: the set contains it", &scores.look_alike_class);
        line(text, "  exact by the first measurement", &scores.look_alike_exact);
        line(text, "  exact by the second measurement", &scores.look_alike_resolved);
        line(text, "doubles: both named", &scores.double_both);
        line(text, "  the dominant one named", &scores.double_dominant);
    });
    section(&mut text, "Single effects by fitted non-centrality (below 20 «none» is right, too)", &|text| {
        for (range, row) in &scores.by_size {
            line(text, &format!("{range}: exact"), &row.exact);
            line(text, "  a set that contains it", &row.class);
            line(text, "  only others named", &row.misnamed);
            line(text, "  right", &row.right);
        }
    });
    section(&mut text, "Layouts", &|text| {
        for (layout, row) in &scores.by_layout {
            line(text, &format!("{layout}: nulls, named"), &row.false_name);
            line(text, "  exact, from 20", &row.exact);
            line(text, "  a set that contains it, from 20", &row.class);
            line(text, "  correct where one effect is named", &row.selective);
            line(text, "  outside: named by the library", &row.outside_misnamed);
        }
    });
    section(&mut text, "Outside causes by kind", &|text| {
        line(text, "kinds never named by the library", &scores.outside.kinds_never_misnamed);
        for (kind, row) in &scores.outside.by_kind {
            line(text, &format!("{kind}: verdict unknown"), &row.unknown);
            line(text, "  named by the library", &row.misnamed);
            if row.imitated.count > 0 {
                line(text, "  imitated by the library", &row.imitated);
            }
        }
    });
    section(&mut text, "Location", &|text| {
        place(text, "known effects", &scores.location);
        place(text, "unknown effects", &scores.location_unknown);
    });
    section(&mut text, "Closed share of the held-out gap, correct verdicts", &|text| {
        spread(text, "closed", &scores.closing.closed, 3);
        spread(text, "error of the share", &scores.closing.error, 3);
        line(text, "interval contains the true share", &scores.closing.covered);
    });
    section(&mut text, "Runs", &|text| {
        line(text, "failed: no verdict", &scores.failed);
        spread(text, "seconds", &scores.seconds, 2);
    });
    text + "\n" + &confusion_text(&scores.confusion)
}

/// Writes a heading with its lines; nothing without lines.
fn section(text: &mut String, title: &str, lines: &dyn Fn(&mut String)) {
    let mut body = String::new();
    lines(&mut body);
    if !body.is_empty() {
        let _ = write!(text, "\n{title}\n{body}");
    }
}

fn line(text: &mut String, what: &str, row: &Proportion) {
    // Omit the line without cases of this kind.
    if let (Some(share), Some([low, high])) = (row.share, row.interval95) {
        let (share, low, high) = (100.0 * share, 100.0 * low, 100.0 * high);
        let _ = writeln!(
            text,
            "  {what:<36} {:>4} of {:<4} {share:>6.1} %   {low:.1} … {high:.1} %",
            row.count, row.of
        );
    }
}

fn place(text: &mut String, what: &str, location: &LocationScore) {
    line(text, &format!("interface, {what}"), &location.interface);
    line(text, &format!("sets of places, {what}"), &location.places_hold);
    spread(text, "  places of a set", &location.places, 0);
    line(text, &format!("phase, {what}"), &location.phase);
    line(text, &format!("bands overlap, {what}"), &location.band_touches);
    spread(text, "  overlap over union", &location.band_overlap, 2);
}

fn spread(text: &mut String, what: &str, of: &Spread, digits: usize) {
    if let (Some(low), Some(median), Some(max)) = (of.low10, of.median, of.max) {
        let _ =
            writeln!(text, "  {what:<36} median {median:.digits$}, 10 % {low:.digits$}, max {max:.digits$}");
    }
}

/// Formats the confusion matrix: a row per truth, a column per answer that occurs, in as many blocks as 80
/// columns need.
pub fn confusion_text(confusion: &Confusion) -> String {
    const KINDS: [(&str, &str); 6] = [
        ("none", "none"),
        ("unknown", "unkn"),
        ("wrong-parameter", "par"),
        ("measurement", "meas"),
        ("insufficient", "few"),
        ("failed", "fail"),
    ];
    let short =
        |answer: &str| KINDS.iter().find(|(kind, _)| *kind == answer).map(|(_, short)| (*short).to_string());
    let is_effect = |name: &str| !name.starts_with('(') && short(name).is_none();
    // Effects are numbered to save width; named effects that are no case's truth follow the others.
    let mut effects: Vec<&str> =
        confusion.rows.keys().map(String::as_str).filter(|name| is_effect(name)).collect();
    let answers: Vec<&str> = confusion.rows.values().flat_map(BTreeMap::keys).map(String::as_str).collect();
    let mut never_true: Vec<&str> =
        answers.iter().copied().filter(|name| is_effect(name) && !effects.contains(name)).collect();
    never_true.sort_unstable();
    never_true.dedup();
    effects.extend(&never_true);
    let number = |name: &str| effects.iter().position(|e| *e == name).map(|at| (at + 1).to_string());
    let heads: Vec<(&str, String)> = effects
        .iter()
        .copied()
        .chain(KINDS.iter().map(|(kind, _)| *kind))
        .filter(|name| answers.contains(name))
        .filter_map(|name| Some((name, number(name).or_else(|| short(name))?)))
        .collect();
    let labels: Vec<(&str, String)> = effects
        .iter()
        .copied()
        .filter(|name| confusion.rows.contains_key(*name))
        .chain(confusion.rows.keys().map(String::as_str).filter(|name| name.starts_with('(')))
        .map(|name| (name, number(name).map_or_else(|| name.to_string(), |n| format!("{name} {n:>2}"))))
        .collect();
    let count = |truth: &str, answer: &str| {
        confusion.rows.get(truth).and_then(|row| row.get(answer)).copied().unwrap_or(0)
    };
    let label_width = labels.iter().map(|(_, label)| label.chars().count()).chain([5]).max().unwrap_or(5);
    let mut text = String::from("Truth by row, the first effect named or the kind of verdict by column\n");
    let mut rest = &heads[..];
    while !rest.is_empty() {
        let mut width = label_width + 1;
        let fitting = rest.iter().take_while(|(name, head)| {
            let cells = labels.iter().map(|(truth, _)| count(truth, name).to_string().len());
            width += cells.chain([head.len()]).max().unwrap_or(1) + 1;
            width <= WIDTH
        });
        let (block, after) = rest.split_at(fitting.count().max(1));
        rest = after;
        let header: Vec<String> =
            std::iter::once("truth".to_string()).chain(block.iter().map(|(_, head)| head.clone())).collect();
        let rows = labels.iter().map(|(truth, label)| {
            let cells = block.iter().map(|(answer, _)| match count(truth, answer) {
                0 => "·".to_string(),
                n => n.to_string(),
            });
            std::iter::once(label.clone()).chain(cells).collect()
        });
        text += &columns(&header, rows);
        if !rest.is_empty() {
            text.push('\n');
        }
    }
    for name in never_true {
        let _ = writeln!(text, "{} {name}", number(name).unwrap_or_default());
    }
    text
}
