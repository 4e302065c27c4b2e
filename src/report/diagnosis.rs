//! The document of a diagnosis, and how it is told on a terminal.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::ToleranceRow;
use super::document::Stamp;
use super::motion_row::MotionRows;
use super::table::moved_tolerances;
use super::terminal::{columns, figure, wrapped};

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
        if self.shape == NAMED { "what is named" } else { &self.shape }
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
        self.band_hz.map(|[from, to]| format!("what it changes lies most from {} to {} Hz", figure(from), figure(to)))
    }
}

fn percent(x: Option<f64>) -> String {
    x.map_or("–".into(), |x| format!("{:.1} %", 100.0 * x))
}

/// Width of an interval of what is closed, in gaps, from which on it tells nothing.
const OPEN: f64 = 2.0;

/// Whether an interval of what is closed is so wide that it tells nothing.
pub(super) fn is_undetermined([low, high]: [f64; 2]) -> bool {
    high - low > OPEN
}

/// The interval of what is closed in brackets, after its name.
pub(super) fn interval_text(interval: Option<[f64; 2]>, name: &str) -> String {
    match interval {
        None => String::new(),
        Some(wide) if is_undetermined(wide) => " (these data leave it open)".into(),
        Some([low, high]) => format!(" ({name}{:.0} to {:.0} %)", 100.0 * low, 100.0 * high),
    }
}

/// The verdict with its reason, and what to measure next.
pub(super) fn verdict_text(v: &VerdictRow) -> String {
    let subject = if v.effects.is_empty() { String::new() } else { format!(": {}", v.effects.join(" or ")) };
    let next = v.next_measurement.as_ref().map_or(String::new(), |next| wrapped(&format!("next: {next}")));
    wrapped(&format!("verdict — {}{subject}", v.kind)) + &wrapped(&v.reason) + &next
}

/// The diagnosis for a person: the verdict first.
pub fn diagnosis_text(document: &DiagnosisDocument) -> String {
    let mut text = verdict_text(&document.verdict);
    text.push('\n');
    let floor = document.noise_floor.map_or(String::new(), |f| format!(", noise leaves {:.1} %", 100.0 * f));
    text += &wrapped(&format!(
        "how far — gap of what was held out: {} before, {} after{floor}; closed {}{}, ceiling {}",
        percent(document.gap.held_out),
        percent(document.chosen.gap_held_out),
        percent(document.chosen.closed),
        interval_text(document.chosen.closed95, ""),
        percent(document.chosen.ceiling)
    ));
    if let Some([before, after]) = document.chosen.gap_held_out_with_nuisances {
        let (before, after) = (percent(before), percent(after));
        text += &wrapped(&format!("  with what is ordinarily a little wrong fitted along: {before} before, {after} after"));
    }
    for plain in &document.chosen.headline_metrics {
        text += &wrapped(&format!("  {}: {:.2} % before, {:.2} % after", plain.figure, 100.0 * plain.before, 100.0 * plain.after));
    }
    text += "\nwhich — candidates, best first\n";
    let rows: Vec<Vec<String>> = document
        .effects
        .iter()
        .filter(|e| e.status == "tried")
        .take(8)
        .map(|e| {
            vec![
                if e.selected { format!("* {}", e.id) } else { format!("  {}", e.id) },
                percent(Some(e.misfit_reduction)),
                percent(e.gap_held_out_after),
                e.closed.map_or("–".into(), |c| format!("{c:.2}")),
                e.p_value.map_or("–".into(), |p| if p < 1e-4 { "<0.0001".into() } else { format!("{p:.4}") }),
            ]
        })
        .collect();
    text += &columns(&["effect", "χ² taken", "held-out gap", "closed", "p"].map(String::from), rows.into_iter());
    let failed: Vec<&str> = document.effects.iter().filter(|e| e.status == "failed").map(|e| e.id.as_str()).collect();
    if !failed.is_empty() {
        text += &wrapped(&format!("their fit failed, so nothing is said of: {}", failed.join(", ")));
    }
    let others: Vec<&str> = document.effects.iter().filter(|e| e.status == "not-applicable").map(|e| e.id.as_str()).collect();
    if !others.is_empty() {
        text += &wrapped(&format!("do not apply to this machine: {}", others.join(", ")));
    }
    let first = if document.places.first().is_some_and(|place| place.shape == NAMED) { "what is named, then " } else { "" };
    text += &format!("\nwhere — {first}free shapes at interfaces, best first\n");
    text += &document.verdict.band_text().map_or(String::new(), |band| wrapped(&band));
    let rows: Vec<Vec<String>> = document
        .places
        .iter()
        .take(5)
        .map(|i| vec![i.place_text(), i.shape_text().into(), percent(Some(i.misfit_reduction)), percent(i.gap_held_out)])
        .collect();
    text += &columns(&["interface", "shape", "χ² taken", "held-out gap"].map(String::from), rows.into_iter());
    for ratio in &document.ratio {
        text += &wrapped(&format!("measured over modelled, {}: {}", ratio.channel, ratio.looks_like));
    }
    if let Some(moved) = moved_tolerances(&document.tolerances) {
        text += &format!("\n{moved}");
    }
    text
}
