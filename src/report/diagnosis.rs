//! The document of a diagnosis, and its text on a terminal.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::ToleranceRow;
use super::document::Stamp;
use super::motion_row::MotionRows;
use super::table::moved_tolerances;
use super::terminal::{columns, figure, percent, probability, share_closed, unit, wrapped};

/// `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiagnosisDocument {
    /// Provenance.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// `frf`, `modes` or `motion`.
    pub domain: String,
    /// Configuration.
    #[serde(default)]
    pub config: String,
    /// Measurement set.
    #[serde(default)]
    pub measurements: String,
    /// Positions (or records) fitted.
    #[serde(default)]
    pub fit_positions: Vec<String>,
    /// Positions (or records) held out.
    #[serde(default)]
    pub held_out_positions: Vec<String>,
    /// Gap that the noise alone leaves on what was held out; absent where nothing is known of it.
    pub noise_floor: Option<f64>,
    /// Gaps of the machine as described.
    pub gap: GapRow,
    /// Misfit of the fit over that of the middle null.
    #[serde(default)]
    pub misfit_over_null: f64,
    /// Interfaces, best first.
    #[serde(rename = "where")]
    pub places: Vec<WhereRow>,
    /// Residuals over position, channel and band, of the machine as described.
    #[serde(default)]
    pub residual_map: Vec<ResidualCell>,
    /// What the ratio of measured and modelled looks like, channel by channel.
    #[serde(default)]
    pub ratio: Vec<Ratio>,
    /// The missing dynamic stiffness at the best interfaces.
    #[serde(default)]
    pub delta_z: Vec<DeltaZ>,
    /// All candidates, best first.
    pub effects: Vec<EffectRow>,
    /// Parameters of the machine as described, at its fit.
    #[serde(default)]
    pub described: BTreeMap<String, f64>,
    /// Tolerances as fitted with what is chosen, by name; empty where they were held.
    #[serde(default)]
    pub tolerances: BTreeMap<String, ToleranceRow>,
    /// What motion records say beside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionRows>,
    /// The model that is chosen, over what was held out.
    #[serde(default)]
    pub chosen: Chosen,
    /// The verdict.
    pub verdict: VerdictRow,
}

/// Gaps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapRow {
    /// Over what was fitted.
    pub fit: Option<f64>,
    /// Over what was held out.
    pub held_out: Option<f64>,
    /// By position (or record).
    #[serde(default)]
    pub by_position: BTreeMap<String, f64>,
    /// By band, over everything.
    #[serde(default)]
    pub by_band: Vec<BandGap>,
    /// By order of the mode, from 1, over everything; null for an order that was not observed.
    #[serde(default)]
    pub by_mode: Vec<Option<f64>>,
    /// By phase of a motion.
    #[serde(default)]
    pub by_phase: BTreeMap<String, f64>,
}

/// The gap in a band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BandGap {
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz).
    pub to_hz: f64,
    /// Gap.
    pub gap: f64,
}

/// A cell of the residual map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualCell {
    /// Position (or record).
    pub position: String,
    /// Response/excitation.
    pub channel: String,
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz).
    pub to_hz: f64,
    /// Gap.
    pub gap: f64,
    /// Mean of ln(measured/modelled magnitude).
    #[serde(default)]
    pub log_ratio: f64,
    /// Mean phase (rad) of measured over modelled.
    #[serde(default)]
    pub phase_rad: f64,
}

/// What measured over modelled looks like in a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ratio {
    /// Response/excitation.
    pub channel: String,
    /// Mean factor of the magnitude.
    pub factor: f64,
    /// Slope of ln|ratio| over ln(frequency).
    pub power: f64,
    /// Delay (s) that suits the phase best.
    pub delay_s: f64,
    /// What it looks like, in a word.
    pub looks_like: String,
}

/// Missing dynamic stiffness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DeltaZ {
    /// Where.
    pub interface: String,
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real part (N/m or N·m/rad).
    pub real: Vec<f64>,
    /// Imaginary part.
    pub imag: Vec<f64>,
}

/// The shape of a [`WhereRow`] that stands for what the verdict names.
pub const NAMED: &str = "other";

/// An interface at which something may be missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WhereRow {
    /// Point or joint.
    pub interface: String,
    /// What the force or transmission error left depends on; of motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Shape of a free dynamic stiffness; `other` for what the verdict names, in the place where that acts.
    pub shape: String,
    /// Share of χ² of the fitted data that it takes away.
    #[serde(default, alias = "takes")]
    pub misfit_reduction: f64,
    /// Held-out gap with it.
    pub gap_held_out: Option<f64>,
}

impl WhereRow {
    /// Where, in words.
    pub fn place_text(&self) -> String {
        self.over.as_ref().map_or_else(|| self.interface.clone(), |over| format!("{}, over {over}", self.interface))
    }

    /// What, in words.
    pub fn shape_text(&self) -> &str {
        if self.shape == NAMED { "named effect" } else { &self.shape }
    }
}

/// A candidate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectRow {
    /// Id.
    pub id: String,
    /// `tried`, `failed` or `not-applicable`.
    pub status: String,
    /// Why it failed or does not apply.
    #[serde(default)]
    pub why: Option<String>,
    /// Held-out gap without it.
    pub gap_held_out_before: Option<f64>,
    /// Held-out gap with it.
    pub gap_held_out_after: Option<f64>,
    /// Share of the gap above the noise floor that it closes.
    pub closed: Option<f64>,
    /// 95 % interval of `closed`, for what the verdict names.
    #[serde(default)]
    pub closed95: Option<[f64; 2]>,
    /// Share of nulls that show as much.
    pub p_value: Option<f64>,
    /// Gain in χ² over what nulls show.
    #[serde(default)]
    pub statistic: f64,
    /// Share of χ² of the fitted data that it takes away.
    #[serde(default, alias = "takes")]
    pub misfit_reduction: f64,
    /// Values of its parameters, found beside what is ordinarily a little wrong.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Units of these parameters.
    #[serde(default)]
    pub parameter_units: BTreeMap<String, String>,
    /// Ids of those that lie at an end of their plausible range.
    #[serde(default)]
    pub parameters_at_bound: Vec<String>,
    /// Whether the verdict names it.
    pub selected: bool,
    /// What it is.
    #[serde(default, alias = "says")]
    pub description: Option<String>,
}

/// The chosen model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Chosen {
    /// Id, or combination; `nominal` where nothing is added.
    pub id: String,
    /// All its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Held-out gap.
    pub gap_held_out: Option<f64>,
    /// Misfit over that of the middle null with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfit_over_null: Option<f64>,
    /// Of FRFs: held-out gaps without and with it, where what is ordinarily a little wrong is fitted along.
    #[serde(default, alias = "gap_held_out_beside_ordinary", skip_serializing_if = "Option::is_none")]
    pub gap_held_out_with_nuisances: Option<[Option<f64>; 2]>,
    /// Share of the gap above the floor that it closes.
    pub closed: Option<f64>,
    /// 95 % interval by parametric bootstrap.
    #[serde(default)]
    pub closed95: Option<[f64; 2]>,
    /// Share that the best free shape at an interface closes: a ceiling.
    pub ceiling: Option<f64>,
    /// In plain units, before and after.
    #[serde(default, alias = "plain")]
    pub headline_metrics: Vec<HeadlineMetrics>,
}

/// A figure in plain units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeadlineMetrics {
    /// What.
    pub figure: String,
    /// Machine as described.
    pub before: f64,
    /// Chosen model.
    pub after: f64,
}

/// The verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VerdictRow {
    /// Kind.
    pub kind: String,
    /// Effects or combinations.
    pub effects: Vec<String>,
    /// Why.
    pub reason: String,
    /// What to measure next.
    #[serde(default)]
    pub next_measurement: Option<String>,
    /// The interface where most is missing, where something is.
    #[serde(rename = "where")]
    #[serde(default)]
    pub place: Option<String>,
    /// The band where most is missing, where something is.
    #[serde(default)]
    pub band_hz: Option<[f64; 2]>,
    /// The phase of a motion in which what is said shows most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

impl VerdictRow {
    /// The band, in words.
    pub fn band_text(&self) -> Option<String> {
        self.band_hz.map(|[from, to]| format!("it changes the FRFs most from {} to {} Hz", figure(from), figure(to)))
    }

    /// The effects, with commas and «or».
    pub fn effects_text(&self) -> String {
        match self.effects.as_slice() {
            [] => String::new(),
            [one] => one.clone(),
            [most @ .., last] => format!("{} or {last}", most.join(", ")),
        }
    }
}

fn gap(x: Option<f64>) -> String {
    x.map_or("–".into(), percent)
}

/// Width of an interval of the closed share, in gaps, from which on it says nothing.
const UNDETERMINED: f64 = 2.0;

/// Whether an interval of the closed share is too wide to say anything.
pub(super) fn is_undetermined([low, high]: [f64; 2]) -> bool {
    high - low > UNDETERMINED
}

/// The interval of the closed share in brackets.
pub(super) fn interval_text(interval: Option<[f64; 2]>) -> String {
    match interval {
        None => String::new(),
        Some(wide) if is_undetermined(wide) => " (95 %: not determined by these data)".into(),
        Some([low, high]) => format!(" (95 %: {:.0} to {:.0} %)", 100.0 * low, 100.0 * high),
    }
}

/// Verdict, reason and next measurement.
pub(super) fn verdict_text(document: &DiagnosisDocument) -> String {
    let verdict = &document.verdict;
    let named = verdict.effects_text();
    let head = if named.is_empty() { format!("verdict: {}", verdict.kind) } else { format!("verdict: {} — {named}", verdict.kind) };
    let ids = verdict.effects.iter().flat_map(|effect| effect.split('+'));
    let rows = ids.filter_map(|id| document.effects.iter().find(|row| row.id == id));
    let described = rows.filter_map(|row| Some(wrapped(&format!("  {}: {}", row.id, row.description.as_ref()?))));
    let next = verdict.next_measurement.as_ref().map_or(String::new(), |next| wrapped(&format!("next measurement: {next}")));
    wrapped(&head) + &described.collect::<String>() + &wrapped(&verdict.reason) + &next
}

/// Gap at held-out positions before and after, with what the chosen model closes of it. `name` is what the gap is called.
pub(super) fn gap_text(document: &DiagnosisDocument, name: &str) -> String {
    let (chosen, before) = (&document.chosen, document.gap.held_out);
    let floor = document.noise_floor.map_or(String::new(), |floor| format!("; noise floor {}", percent(floor)));
    let ceiling = chosen
        .ceiling
        .map_or(String::new(), |c| format!("; a generic impedance at one interface closes {} at most", share_closed(Some(c))));
    if before.is_none() {
        return wrapped(&format!("{name}: nothing is held out{floor}"));
    }
    if chosen.id.is_empty() || chosen.id == "nominal" {
        return wrapped(&format!("{name}: {}{floor}{ceiling}", gap(before)));
    }
    let interval = interval_text(chosen.closed95);
    let closed = format!("closes {}{interval}", share_closed(chosen.closed));
    let text = format!("{name}: {} as described, {} with {}{floor}; {closed}{ceiling}", gap(before), gap(chosen.gap_held_out), chosen.id);
    wrapped(&text)
}

/// Values of the parameters of the effects that the verdict names.
pub(super) fn estimated_text(document: &DiagnosisDocument) -> String {
    let rows: Vec<Vec<String>> = document
        .effects
        .iter()
        .filter(|row| row.selected)
        .flat_map(|row| {
            // Of the chosen model the values are those of the joint fit; of other effects of an ambiguous verdict those of their own.
            let is_chosen = document.chosen.id.split('+').any(|id| id == row.id);
            row.parameters.iter().map(move |(id, own)| {
                let value = document.chosen.parameters.get(id).filter(|_| is_chosen).unwrap_or(own);
                let stated = row.parameter_units.get(id).map_or("", String::as_str);
                let remark = if row.parameters_at_bound.contains(id) { "at the end of its range" } else { "" };
                vec![format!("  {}", row.id), id.clone(), figure(*value), unit(stated), remark.into()]
            })
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    format!("\nestimated parameters\n{}", columns(&["  effect", "parameter", "value", "unit", ""].map(String::from), rows.into_iter()))
}

/// Candidates listed, beyond those that the verdict names.
const LISTED: usize = 8;

/// The candidates as a table: those that the verdict names, then the best others.
pub(super) fn candidates_text(document: &DiagnosisDocument, heads: [&str; 5]) -> String {
    let tried = || document.effects.iter().filter(|row| row.status == "tried");
    let others = tried().filter(|row| !row.selected).take(LISTED);
    let rows = tried().filter(|row| row.selected).chain(others).map(|row| {
        vec![
            format!("{} {}", if row.selected { "*" } else { " " }, row.id),
            percent(row.misfit_reduction),
            gap(row.gap_held_out_after),
            share_closed(row.closed),
            row.p_value.map_or("–".into(), probability),
        ]
    });
    let mut text = format!("\ncandidates, best first (* in the verdict)\n{}", columns(&heads.map(String::from), rows));
    let with_status =
        |status: &str| document.effects.iter().filter(|row| row.status == status).map(|row| row.id.as_str()).collect::<Vec<_>>();
    let failed = with_status("failed");
    if !failed.is_empty() {
        text += &wrapped(&format!("not decided, since their fit failed: {}", failed.join(", ")));
    }
    match with_status("not-applicable").len() {
        0 => {}
        1 => text += "1 effect does not apply to this machine or these data (--verbose names it)\n",
        count => text += &format!("{count} effects do not apply to this machine or these data (--verbose names them)\n"),
    }
    text
}

/// The diagnosis of FRFs or modes as text: the verdict first.
pub fn diagnosis_text(document: &DiagnosisDocument) -> String {
    let mut text = verdict_text(document);
    text.push('\n');
    text += &gap_text(document, "gap at held-out positions");
    if let Some([before, after]) = document.chosen.gap_held_out_with_nuisances {
        text += &wrapped(&format!("  with tolerances fitted as nuisance parameters: {} as described, {} with it", gap(before), gap(after)));
    }
    for metric in &document.chosen.headline_metrics {
        text += &wrapped(&format!("  {}: {} as described, {} with it", metric.figure, percent(metric.before), percent(metric.after)));
    }
    text += &estimated_text(document);
    text += &candidates_text(document, ["effect", "χ² reduction", "held-out gap", "closed", "p"]);
    let first = if document.places.first().is_some_and(|place| place.shape == NAMED) { "the named effect, then " } else { "" };
    text += &format!("\nlocation: {first}generic impedances at interfaces, best first\n");
    text += &document.verdict.band_text().map_or(String::new(), |band| wrapped(&band));
    let rows = document.places.iter().take(5);
    let rows = rows.map(|row| vec![row.place_text(), row.shape_text().into(), percent(row.misfit_reduction), gap(row.gap_held_out)]);
    text += &columns(&["interface", "shape", "χ² reduction", "held-out gap"].map(String::from), rows);
    for ratio in &document.ratio {
        text += &wrapped(&format!("measured over predicted, {}: {}", ratio.channel, ratio.looks_like));
    }
    if let Some(moved) = moved_tolerances(&document.tolerances) {
        text += &format!("\n{moved}");
    }
    text
}
