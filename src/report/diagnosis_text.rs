//! The text of a diagnosis on a terminal.

use super::diagnosis::{DiagnosisDocument, NAMED, RuleRow};
use super::table::moved_tolerances;
use super::terminal::{columns, figure, listed, percent, probability, range, share_closed, unit, wrapped};
use super::vocabulary::{EffectStatus, VerdictKind};

fn gap(x: Option<f64>) -> String {
    x.map_or("–".into(), percent)
}

/// Width of an interval of the closed share, in gaps, from which on it says nothing (1).
const UNDETERMINED: f64 = 2.0;

/// Whether an interval of the closed share is too wide to say anything.
pub(super) fn is_undetermined([low, high]: [f64; 2]) -> bool {
    high - low > UNDETERMINED
}

/// Returns the interval of the share that the chosen model closes, in brackets; empty where the verdict names
/// no effect.
pub(super) fn interval_text(document: &DiagnosisDocument) -> String {
    match document.chosen.closed95.filter(|interval| !is_undetermined(*interval)) {
        None if document.verdict.effects.is_empty() => String::new(),
        None => " (95 %: not determined by these data)".into(),
        Some([low, high]) => {
            let decimals = if high - low < 0.02 { 1 } else { 0 };
            format!(" (95 %: {:.decimals$} to {:.decimals$} %)", 100.0 * low, 100.0 * high)
        }
    }
}

/// Returns verdict, reason and next measurement as text.
pub(super) fn verdict_text(document: &DiagnosisDocument) -> String {
    let verdict = &document.verdict;
    let named =
        if verdict.effects.is_empty() { verdict.faults.join(", ") } else { listed(&verdict.effects, "or") };
    let head = if named.is_empty() {
        format!("verdict: {}", verdict.kind)
    } else {
        format!("verdict: {} — {named}", verdict.kind)
    };
    let described = document
        .named_effects()
        .filter_map(|row| Some(wrapped(&format!("  {}: {}", row.id, row.description.as_ref()?))));
    let next = verdict
        .next_measurement
        .as_ref()
        .map_or(String::new(), |next| wrapped(&format!("next measurement: {next}")));
    wrapped(&head) + &described.collect::<String>() + &wrapped(&verdict.reason) + &next
}

/// Returns the rules of the verdict as text: those that held, that did not with the figures that they
/// compared, and that were not asked.
pub fn why_text(document: &DiagnosisDocument) -> String {
    let Some(last) = &document.verdict.rule else {
        return wrapped("rules: there is no table of rules for this kind of data yet");
    };
    let row = |RuleRow { rule, when, held, figures }: &RuleRow| {
        let holds = held.map_or("not asked", |held| if held { "yes" } else { "no" });
        let figures = if figures.is_empty() { String::new() } else { format!(" ({figures})") };
        wrapped(&format!("  {holds}: {rule} – {when}{figures}"))
    };
    let head = format!("rules, read from the top; the verdict is that of «{last}»");
    wrapped(&head) + &document.rules.iter().map(row).collect::<String>()
}

/// Returns the held-out gap before and after, and the share that the chosen model closes. `name` is the name
/// of the gap.
pub(super) fn gap_text(document: &DiagnosisDocument, name: &str) -> String {
    let (chosen, before) = (&document.chosen, document.gap.held_out);
    let floor =
        document.noise_floor.map_or(String::new(), |floor| format!("; noise floor {}", percent(floor)));
    let ceiling = chosen.ceiling.map_or(String::new(), |c| {
        format!("; a generic impedance at one interface closes {} at most", share_closed(Some(c)))
    });
    if before.is_none() {
        return wrapped(&format!("{name}: nothing is held out{floor}"));
    }
    if chosen.is_nominal() {
        return wrapped(&format!("{name}: {}{floor}{ceiling}", gap(before)));
    }
    let interval = interval_text(document);
    let closed = match chosen.closed {
        Some(closed) if closed < 0.005 => format!("it closes none of it{interval}"),
        closed => format!("it closes {} of the squared gap{interval}", share_closed(closed)),
    };
    let text = format!(
        "{name}: {} as described, {} with {}{floor}; {closed}{ceiling}",
        gap(before),
        gap(chosen.gap_held_out),
        chosen.id
    );
    let is_open = chosen.closed95.is_some_and(|[low, _]| low <= 0.0);
    let remark = "  the effect is statistically significant, but does not clearly improve predictions: the model as described predicts about as well";
    wrapped(&text) + &if is_open { wrapped(remark) } else { String::new() }
}

/// Returns the estimated parameters of the named effects as a table.
pub(super) fn estimated_text(document: &DiagnosisDocument) -> String {
    let rows: Vec<Vec<String>> = document
        .effects
        .iter()
        .filter(|row| row.selected)
        .flat_map(|row| {
            row.parameters.iter().map(move |(id, value)| {
                let interval = row.parameters95.get(id).map_or(String::new(), |interval| range(*interval));
                let stated = row.parameter_units.get(id).map_or("", String::as_str);
                let remark =
                    if row.parameters_at_bound.contains(id) { "at the end of its range" } else { "" };
                vec![
                    format!("  {}", row.id),
                    id.clone(),
                    figure(*value),
                    interval,
                    unit(stated),
                    remark.into(),
                ]
            })
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    // Modes have no intervals.
    let has_intervals = rows.iter().any(|row| !row[3].is_empty());
    let kept = |row: Vec<String>| row.into_iter().enumerate().filter(|(at, _)| has_intervals || *at != 3);
    let cells = |row: Vec<String>| kept(row).map(|(_, cell)| cell).collect::<Vec<String>>();
    let heads =
        cells(["  effect", "parameter", "value", "95 % interval", "unit", ""].map(String::from).to_vec());
    format!("\nestimated parameters\n{}", columns(&heads, rows.into_iter().map(cells)))
}

/// Number of listed candidates that the verdict does not name.
const LISTED: usize = 8;

/// Returns the candidates as a table: those of the verdict, then the best others.
pub(super) fn candidates_text(document: &DiagnosisDocument, heads: [&str; 5]) -> String {
    let tried = || document.effects.iter().filter(|row| row.status == EffectStatus::Tried);
    let others = || tried().filter(|row| !row.selected).take(LISTED);
    let listed = || tried().filter(|row| row.selected).chain(others());
    let rows = listed().map(|row| {
        vec![
            format!("{} {}", if row.selected { "*" } else { " " }, row.id),
            percent(row.misfit_reduction),
            gap(row.gap_held_out_after),
            share_closed(row.closed),
            row.p_value.map_or("–".into(), probability),
        ]
    });
    let mut text =
        format!("\ncandidates, best first (* in the verdict)\n{}", columns(&heads.map(String::from), rows));
    let open: Vec<&str> = listed().filter(|row| row.open).map(|row| row.id.as_str()).collect();
    if !open.is_empty() {
        text += &wrapped(&format!("open, since their best fit was found once: {}", open.join(", ")));
    }
    let with_status = |status: EffectStatus| {
        document
            .effects
            .iter()
            .filter(|row| row.status == status)
            .map(|row| row.id.as_str())
            .collect::<Vec<_>>()
    };
    let failed = with_status(EffectStatus::Failed);
    if !failed.is_empty() {
        text += &wrapped(&format!("not decided, since their fit failed: {}", failed.join(", ")));
    }
    match with_status(EffectStatus::NotApplicable).len() {
        0 => {}
        1 => {
            text +=
                &wrapped("1 effect does not apply to this machine or these data (named with verbose output)")
        }
        count => {
            text += &wrapped(&format!(
                "{count} effects do not apply to this machine or these data (named with verbose output)"
            ))
        }
    }
    text
}

/// Returns from which size on effects that the verdict does not name would have been seen; empty where it is not
/// known.
fn seen_text(document: &DiagnosisDocument) -> String {
    let tried = || document.effects.iter().filter(|row| row.status == EffectStatus::Tried && !row.selected);
    let mut seen: Vec<(f64, &str)> =
        tried().filter_map(|row| Some((row.seen_from?, row.id.as_str()))).collect();
    if seen.is_empty() {
        return String::new();
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let from = seen.iter().map(|(from, id)| format!("{id} {}", percent(*from))).collect::<Vec<_>>();
    let hidden: Vec<&str> =
        tried().filter(|row| row.seen_from.is_none()).map(|row| row.id.as_str()).collect();
    let never = match hidden.is_empty() {
        true => String::new(),
        false => format!("; parameters of the machine take up {}", hidden.join(", ")),
    };
    wrapped(&format!(
        "nine of ten tests like this one would show an effect that changes the FRFs, as a gap, by: {}{never}",
        from.join(", ")
    ))
}

/// Returns the diagnosis of FRFs or modes as text, the verdict first.
pub fn diagnosis_text(document: &DiagnosisDocument) -> String {
    let mut text = verdict_text(document);
    text.push('\n');
    text += &gap_text(document, "gap at held-out positions");
    let named = if document.verdict.kind == VerdictKind::Ambiguous {
        "one of the named effects"
    } else {
        "the best effect"
    };
    let confirm = |does: bool| {
        if does { format!("confirm {named}") } else { format!("do not confirm {named} for certain") }
    };
    text += &document
        .verdict
        .confirmed
        .map_or(String::new(), |does| format!("  held-out data {}\n", confirm(does)));
    if let Some([before, after]) = document.chosen.gap_held_out_with_nuisances {
        text += &wrapped(&format!(
            "  with tolerances fitted as nuisance parameters: {} as described, {} with it",
            gap(before),
            gap(after)
        ));
    }
    for metric in &document.chosen.headline_metrics {
        text += &wrapped(&format!(
            "  {}: {} as described, {} with it",
            metric.figure,
            percent(metric.before),
            percent(metric.after)
        ));
    }
    text += &estimated_text(document);
    text += &candidates_text(document, ["effect", "χ² reduction", "held-out gap", "closed", "p"]);
    text += &seen_text(document);
    let first = if document.places.first().is_some_and(|place| place.shape == NAMED && place.over.is_none()) {
        "the named effect, then "
    } else {
        ""
    };
    text += &format!("\nlocation: {first}generic impedances at interfaces, best first\n");
    if !document.verdict.places.is_empty() {
        let places = listed(&document.verdict.places, "or");
        text +=
            &wrapped(&format!("with a probability of 90 % at {places}, by the evidence of all explanations"));
    }
    text += &document.verdict.band_text().map_or(String::new(), |band| wrapped(&band));
    let rows = document.places.iter().take(5);
    let rows = rows.map(|row| {
        vec![row.place_text(), row.shape_text().into(), percent(row.misfit_reduction), gap(row.gap_held_out)]
    });
    text += &columns(&["interface", "shape", "χ² reduction", "held-out gap"].map(String::from), rows);
    for ratio in &document.ratio {
        text += &wrapped(&format!("measured over predicted, {}: {}", ratio.channel, ratio.looks_like));
    }
    if let Some(moved) = moved_tolerances(&document.tolerances) {
        text += &format!("\n{moved}");
    }
    text
}
