//! The whole page: head, sections in reading order, provenance.

use super::chart::LIBRARY;
use super::text::{TextTable, escape, paragraph, section};
use super::{Page, comparison, curve, loops, motion, parameter, peak, position, predicted, shape, verdict};
use crate::document::{IdentificationDocument, Stamp};
use crate::table;
use crate::terminal::percent;
use crate::vocabulary::VerdictKind;

/// Largest size of a page in bytes, so that it can be sent by mail and opened on a laptop.
pub const MOST_BYTES: usize = 8 << 20;

/// Begins every page, so that a later one replaces it.
const BEGIN: &str = "<!doctype html><!-- jointid -->";

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("page.js");

/// Content security policy: the browser fetches nothing, because the page contains all that it needs.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'";

/// Formats the page as HTML.
pub fn html(page: &Page) -> String {
    let sections = sections(page);
    let contents: String = sections
        .iter()
        .filter(|s| !s.2.is_empty())
        .map(|(id, heading, _)| format!("<li><a href=\"#{id}\">{}</a></li>", escape(heading)))
        .collect();
    let body: String = sections.iter().map(|(id, heading, content)| section(id, heading, content)).collect();
    let lead = page
        .diagnosis
        .as_ref()
        .map(verdict::sentence)
        .or_else(|| page.identification.as_ref().map(sentence))
        .unwrap_or_default();
    let lead = if lead.is_empty() { lead } else { format!("<p class=\"verdict\">{}</p>\n", escape(&lead)) };
    let under = page.diagnosis.as_ref().map(|of| verdict::summary(of, &page.sketch)).unwrap_or_default();
    let mut notes: String = page.notes.iter().map(|n| format!("<li>{}</li>", escape(n))).collect();
    if !notes.is_empty() {
        notes = format!("<ul class=\"notes\">{notes}</ul>\n");
    }
    format!(
        "{BEGIN}\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title} – jointid</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">Skip to content</a>\n<header>\n<h1>{title}</h1>\n{lead}{under}{notes}</header>\n\
         <nav aria-label=\"Contents\"><ul>{contents}</ul></nav>\n<main id=\"main\">\n{body}</main>\n<script type=\"text/javascript\">{LIBRARY}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        title = escape(&page.title),
    )
}

fn sections(page: &Page) -> Vec<(&'static str, &'static str, String)> {
    let mut out: Vec<(&'static str, &'static str, String)> = Vec::new();
    let parameters = page.identification.as_ref().map(|of| {
        let content = format!("{}{}", parameter::values(of), table::bootstrap(&of.bootstrap).html());
        ("parameters", "Parameters", content)
    });
    // Where nothing is missing, the values are the result.
    let is_complete = page.diagnosis.as_ref().is_some_and(|of| of.verdict.kind == VerdictKind::None);
    out.extend(parameters.clone().filter(|_| is_complete));
    if let Some(of) = &page.diagnosis {
        out.push(("diagnosis", "Diagnosis", verdict::content(of, &page.diagnosed)));
    }
    out.push((
        "frf",
        "Measured and predicted",
        format!("{}{}", other_description(page), curve::chart("curves", &page.curves, "")),
    ));
    if let Some(of) = &page.identification {
        let caption = "Natural frequencies, with the relative error of the prediction";
        let errors = table::positions(caption, &of.positions, of.leave_one_out).html();
        let mut frfs = table::frfs(&of.frfs, of.leave_one_out);
        frfs.insert(4, "Accepted", of.frfs.iter().map(|row| percent(row.accepted_share)));
        out.push((
            "positions",
            "Results by position",
            format!("{}{errors}{}", position::charts(page), frfs.html()),
        ));
        if !of.records.is_empty() {
            out.push(("records", "Results by record", motion::identified(of)));
        }
    }
    if let Some(of) = &page.validation {
        let largest = of
            .largest_error
            .map(|x| paragraph(&format!("Largest relative frequency error: {}.", percent(x))))
            .unwrap_or_default();
        let errors = table::positions("Validation: natural frequencies", &of.positions, false).html();
        out.push((
            "validation",
            "Validation",
            format!("{largest}{errors}{}", table::gaps("Validation: gaps", &of.positions).html()),
        ));
    }
    if let Some(of) = &page.prediction {
        out.push(("prediction", "Prediction", predicted::content(of, &page.measured_modes)));
    }
    if let Some(of) = &page.comparison {
        out.push(("comparison", "Single- and multi-position identification", comparison::content(of)));
    }
    if let Some(of) = &page.identification {
        out.extend(parameters.filter(|_| !is_complete));
        out.push(("correlation", "Correlated parameters", parameter::correlations(of)));
    }
    let identified = page.identification.as_ref().map(|of| &of.tolerances);
    let diagnosed = page.diagnosis.as_ref().map(|of| &of.tolerances);
    if let Some(of) = identified.into_iter().chain(diagnosed).find(|t| !t.is_empty()) {
        out.push(("tolerances", "Tolerances", parameter::tolerances(of)));
    }
    out.push(("shapes", "Mode shapes", shape::content(page)));
    if let Some(of) = &page.peaks {
        out.push(("peaks", "Peaks of the FRFs", peak::content(page, of)));
    }
    if let Some(of) = &page.hybrid {
        out.push(("hybrid", "Model, neural network and diagnosed effects", loops::hybrid(of)));
    }
    if let Some(of) = &page.bode {
        out.push(("bode", "Frequency response from command to position", loops::bode(of)));
    }
    if let Some(of) = &page.gain {
        out.push(("gains", "Gain of the position loop", loops::gain(of)));
    }
    if let Some(of) = &page.circle {
        out.push(("circles", "Contour error on circles", loops::circle(of)));
    }
    if let Some(of) = &page.identification {
        out.push(("searches", "Convergence", parameter::convergence(of)));
    }
    out.push(("provenance", "Provenance", provenance(page)));
    out
}

/// Returns a note where identification and diagnosis use different descriptions of the machine.
fn other_description(page: &Page) -> String {
    let (Some(identified), Some(diagnosed)) = (&page.identification, &page.diagnosis) else {
        return String::new();
    };
    let described = |stamp: &Stamp| (stamp.overrides.clone(), stamp.without.clone());
    if described(&identified.stamp) == described(&diagnosed.stamp) {
        return String::new();
    }
    let (set, without) = described(&diagnosed.stamp);
    let changes = set
        .into_iter()
        .chain(without.into_iter().map(|id| format!("without {id}")))
        .collect::<Vec<_>>()
        .join(", ");
    let changes = if changes.is_empty() { "as in its configuration file".to_string() } else { changes };
    paragraph(&format!(
        "The following results are those of the identification. The diagnosis above uses another description of the machine: {changes}."
    ))
}

/// Summarises an identification in one sentence.
fn sentence(of: &IdentificationDocument) -> String {
    let listed = |names: &[String]| {
        if names.len() > 8 { format!("{} records", names.len()) } else { names.join(", ") }
    };
    let unfinished = if of.stamp.complete { "" } else { " The run was stopped early." };
    let figure = |key: &str| of.derived.get(key).copied();
    let held_out =
        if of.leave_one_out { "in leave-one-out cross-validation" } else { "of the held-out data" };
    let suffix = if of.leave_one_out { "left_out" } else { "held_out" };
    let result =
        match (figure(&format!("largest_frequency_error_{suffix}")), figure(&format!("gap_{suffix}"))) {
            (Some(error), _) => format!("the largest frequency error {held_out} is {}", percent(error)),
            (None, Some(gap)) => format!("the gap {held_out} is {}", percent(gap)),
            (None, None) => "nothing was held out".into(),
        };
    format!("Fitted on {}; {result}.{unfinished}", listed(&of.fit_positions))
}

fn provenance(page: &Page) -> String {
    let stamps: Vec<(&str, &Stamp)> = [
        ("identification.json", page.identification.as_ref().map(|d| &d.stamp)),
        ("validation.json", page.validation.as_ref().map(|d| &d.stamp)),
        ("prediction.json", page.prediction.as_ref().map(|d| &d.stamp)),
        ("comparison.json", page.comparison.as_ref().map(|d| &d.stamp)),
        ("peaks.json", page.peaks.as_ref().map(|d| &d.stamp)),
        ("diagnosis.json", page.diagnosis.as_ref().map(|d| &d.stamp)),
        ("hybrid.json", page.hybrid.as_ref().map(|d| &d.stamp)),
        ("bode.json", page.bode.as_ref().map(|d| &d.stamp)),
        ("gain.json", page.gain.as_ref().map(|d| &d.stamp)),
        ("circle.json", page.circle.as_ref().map(|d| &d.stamp)),
    ]
    .into_iter()
    .filter_map(|(name, stamp)| Some((name, stamp?)))
    .collect();
    let mut made =
        TextTable::new("Documents", 1, ["Document", "Schema", "Version", "Seed", "Complete", "SHA-256"]);
    for (name, stamp) in &stamps {
        let digest = page.files.iter().find(|f| f.0 == *name).map_or("–", |f| f.1.as_str());
        let complete = if stamp.complete { "yes" } else { "no, stopped early" };
        made.row([*name, &stamp.schema, &stamp.tool_version, &stamp.seed.to_string(), complete, digest]);
    }
    let mut inputs = TextTable::new("Inputs", 1, ["File", "SHA-256", "Input of"]);
    let mut seen: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for (name, stamp) in &stamps {
        for input in &stamp.inputs {
            match seen.iter_mut().find(|s| s.0 == input.path && s.1 == input.sha256) {
                Some(row) => row.2.push(name),
                None => seen.push((&input.path, &input.sha256, vec![name])),
            }
        }
    }
    seen.iter().for_each(|(path, digest, of)| inputs.row([*path, *digest, &of.join(", ")]));
    let mut warnings = String::new();
    for (name, stamp) in stamps.iter().filter(|s| !s.1.warnings.is_empty()) {
        let items: String = stamp.warnings.iter().map(|w| format!("<li>{}</li>", escape(w))).collect();
        warnings += &format!("<h3>Warnings of {name}</h3>\n<ul>{items}</ul>\n");
    }
    let mut changes =
        TextTable::new("Changes of the configuration", 1, ["Document", "Overrides", "Effects taken out"]);
    for (name, stamp) in stamps.iter().filter(|s| !(s.1.overrides.is_empty() && s.1.without.is_empty())) {
        changes.row([*name, &stamp.overrides.join(" "), &stamp.without.join(", ")]);
    }
    let settings = page.identification.as_ref().map(settings).unwrap_or_default();
    let version = format!("Page made by jointid {}.", env!("CARGO_PKG_VERSION"));
    format!("{}{settings}{}{}{warnings}{}", made.html(), inputs.html(), changes.html(), paragraph(&version))
}

fn settings(of: &IdentificationDocument) -> String {
    let mut table = TextTable::new("Settings of the identification", 1, ["Setting", "Value"]);
    let Ok(serde_json::Value::Object(settings)) = serde_json::to_value(&of.settings) else {
        return String::new();
    };
    for (key, value) in settings.iter().filter(|(_, v)| !v.is_null()) {
        let text = match value {
            serde_json::Value::String(text) => text.clone(),
            serde_json::Value::Array(list) if list.is_empty() => continue,
            other => other.to_string(),
        };
        table.row([key.replace('_', " "), text]);
    }
    table.html()
}
