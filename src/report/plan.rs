//! Plans of measurements (`plan.json`): document and table.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::provenance::Stamp;
use super::terminal::{percent, table, table_text, wrapped};
use super::vocabulary::DataKind;
use numeric::statistics::median;
/// One choice of further measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChoiceRow {
    /// Names of the measurements to make: position, channel (`RESPONSE/EXCITATION`), or both.
    pub measure: Vec<String>,
    /// Geometric mean over parameters of standard deviation after the measurement over that of the plausible
    /// range (1).
    pub score: f64,
    /// Root mean square of the relative half widths of the 95 % intervals of the natural frequencies to
    /// predict (1); absent where none are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prediction95: Option<f64>,
    /// Probability that the measurements settle the verdict, a lower bound; absent where no diagnosis was
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settled: Option<f64>,
    /// Ids of the identifiable parameters.
    pub determined: Vec<String>,
    /// Half width of the 95 % interval by parameter id, in the unit of the parameter.
    pub half_width95: BTreeMap<String, f64>,
}

/// Ranking of all choices of a given number of measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanRanking {
    /// Number of measurements in each choice.
    pub count: usize,
    /// Rank (from 1) of the split stated in the measurement set; absent where it is not among the choices.
    pub split_rank: Option<usize>,
    /// Choices in ascending score.
    pub choices: Vec<ChoiceRow>,
}

/// Plan of further measurements (`plan.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Kind of measurement: `frf` or `modes`.
    pub data: DataKind,
    /// Names of the measurements already made.
    pub measured: Vec<String>,
    /// Ids of the parameters to identify.
    pub parameters: Vec<String>,
    /// Nut positions (m) whose predicted natural frequencies decide the ranking.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub predict_at_m: Vec<f64>,
    /// Explanations of the data that the measurements are to tell apart; they decide the ranking.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<String>,
    /// Rankings, one for each number of measurements.
    pub rankings: Vec<PlanRanking>,
}

/// Choices of measurements, the best `top` of each size, and how the set's split fares. `size` gives the size
/// of a parameter's value.
pub fn plan_table(plan: &PlanDocument, size: &dyn Fn(&str) -> f64, top: usize) -> String {
    let mut text = String::new();
    if !plan.rivals.is_empty() {
        text += &wrapped(&format!(
            "settled: least probability that the measurements leave one of {}",
            plan.rivals.join(", ")
        ));
    }
    if !plan.predict_at_m.is_empty() {
        let at: Vec<String> = plan.predict_at_m.iter().map(f64::to_string).collect();
        text += &wrapped(&format!(
            "predicted ±: 95 % interval of the natural frequencies at {} m (root mean square)",
            at.join(", ")
        ));
    }
    let half =
        |choice: &ChoiceRow, id: &String| choice.half_width95.get(id).map_or(f64::INFINITY, |h| h / size(id));
    for ranking in &plan.rankings {
        let added = if plan.measured.is_empty() {
            String::new()
        } else {
            format!(" in addition to {}", plan.measured.join(", "))
        };
        let noun = if ranking.count == 1 { "measurement" } else { "measurements" };
        text += &wrapped(&format!(
            "{} {noun}{added}, best first ({} choices)",
            ranking.count,
            ranking.choices.len()
        ));
        text.push('\n');
        let (predicts, settles) = (!plan.predict_at_m.is_empty(), !plan.rivals.is_empty());
        // What decides comes first; a list of parameters would not fit beside it.
        let is_short = predicts || settles;
        let deciding =
            [settles.then_some("Settled"), predicts.then_some("Predicted ±")].into_iter().flatten();
        let rest = ["Range left", "Identifiable", "Median ±", "Not identifiable"]
            .into_iter()
            .take(if is_short { 3 } else { 4 });
        let mut out = table(std::iter::once("Measure").chain(deciding).chain(rest));
        let mut add = |choice: &ChoiceRow| {
            let widths = choice.determined.iter().map(|id| half(choice, id));
            let open: Vec<&str> = plan
                .parameters
                .iter()
                .filter(|id| !choice.determined.contains(id))
                .map(String::as_str)
                .collect();
            let deciding = [choice.settled, choice.prediction95].into_iter().flatten().map(percent);
            let rest = [
                percent(choice.score),
                format!("{} of {}", choice.determined.len(), plan.parameters.len()),
                median(widths).map_or_else(|| "–".into(), percent),
                if open.is_empty() { "–".into() } else { open.join(" ") },
            ];
            let rest = rest.into_iter().take(if is_short { 3 } else { 4 });
            out.add_row(std::iter::once(choice.measure.join(" ")).chain(deciding).chain(rest));
        };
        ranking.choices.iter().take(top).for_each(&mut add);
        let split = ranking.split_rank.filter(|rank| *rank > top);
        split.and_then(|rank| ranking.choices.get(rank - 1)).into_iter().for_each(&mut add);
        text += &table_text(&out);
        if let (Some(rank), Some(best)) = (ranking.split_rank, ranking.choices.first()) {
            let own = &ranking.choices[rank - 1];
            text.push('\n');
            text += &wrapped(&format!(
                "the set's split, {}, is number {rank} of {}: it leaves intervals {:.1} % wider than the best choice",
                own.measure.join(", "),
                ranking.choices.len(),
                100.0
                    * (own.prediction95.unwrap_or(own.score) / best.prediction95.unwrap_or(best.score) - 1.0)
            ));
        }
        text.push('\n');
    }
    text
}
