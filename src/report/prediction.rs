//! Prediction from an identification (`prediction.json`): document, text and CSV.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::csv_cell::csv_cell;
use super::provenance::{Input, Stamp};
use super::terminal::{columns, figure, with_interval, wrapped};
use super::text_table::cell;
use super::vocabulary::Role;

/// A natural mode of the identified machine at one position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NaturalMode {
    /// Mode number in ascending frequency, from 1; rigid-body modes do not count.
    pub order: usize,
    /// Frequency of its peak in the FRF (Hz); absent where the FRF shows none.
    pub frequency_hz: Option<f64>,
    /// Undamped natural frequency (Hz).
    pub natural_hz: f64,
    /// Damping ratio (1); absent for a mode whose damping cannot be stated.
    pub damping_ratio: Option<f64>,
    /// Magnitude of the FRF at the peak (SI units of the quantity); absent where it shows no peak.
    pub amplitude: Option<f64>,
}

impl NaturalMode {
    /// Whether it lies below a frequency (Hz), with its peak or without damping.
    pub fn is_below(&self, hz: f64) -> bool {
        self.natural_hz <= hz || self.frequency_hz.is_some_and(|peak_hz| peak_hz <= hz)
    }
}

/// A natural mode with its 95 % intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedMode {
    /// Values of the best fit.
    #[serde(flatten)]
    pub mode: NaturalMode,
    /// 95 % interval of the frequency of the peak (Hz), from the possible machines that show one; absent where
    /// the best fit shows none.
    pub frequency95: Option<[f64; 2]>,
    /// 95 % interval of the undamped natural frequency (Hz).
    pub natural95: [f64; 2],
    /// 95 % interval of the damping ratio (1).
    pub damping95: Option<[f64; 2]>,
    /// 95 % interval of the amplitude (SI units of the quantity); absent where some of the possible machines
    /// show no peak.
    pub amplitude95: Option<[f64; 2]>,
}

/// A predicted FRF of the machine, without noise, gain and delay of the measuring chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedFrf {
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary part of the best fit (SI units of the quantity).
    pub value: Vec<[f64; 2]>,
    /// Pointwise 95 % band of the magnitude (SI units of the quantity).
    pub magnitude95: Vec<[f64; 2]>,
}

/// Prediction at one position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedPosition {
    /// Nut position from the left end of the screw (m); absent for a machine without a nut.
    pub nut_m: Option<f64>,
    /// `fit` or `held_out` for a position of the measurement set; absent for any other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// Natural modes in ascending frequency.
    pub modes: Vec<PredictedMode>,
    /// Static stiffness at the excited point (N/m or N·m/rad), without integral action of the drive; absent
    /// where response and excitation differ, or a part of the machine is free to move.
    pub static_stiffness: Option<f64>,
    /// 95 % interval of the static stiffness.
    pub static_stiffness95: Option<[f64; 2]>,
    /// The FRF, where it was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frf: Option<PredictedFrf>,
}

/// Predictions of an identified machine (`prediction.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictionDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// File of the identification; absent for a result in memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<Input>,
    /// Quantity of amplitudes and FRFs: `receptance`, `mobility` or `accelerance`.
    pub quantity: String,
    /// Name of the point that responds.
    pub response: String,
    /// Name of the point that is excited.
    pub excitation: String,
    /// Lowest and highest predicted frequency (Hz).
    pub band_hz: [f64; 2],
    /// Number of possible machines behind each interval, about each minimum of χ².
    pub draws: usize,
    /// Number of minima of χ² that the data do not distinguish.
    pub minima: usize,
    /// Standard deviation of a nut position that was not fitted (m).
    pub nut_sd_m: f64,
    /// Predictions by name of the position, or nut position.
    pub positions: BTreeMap<String, PredictedPosition>,
}

impl PredictionDocument {
    /// Returns the positions in ascending nut position.
    pub fn ordered(&self) -> Vec<(&String, &PredictedPosition)> {
        let mut all: Vec<_> = self.positions.iter().collect();
        let at = |p: &PredictedPosition| p.nut_m.unwrap_or(f64::INFINITY);
        all.sort_by(|a, b| at(a.1).total_cmp(&at(b.1)).then(a.0.cmp(b.0)));
        all
    }
}

/// Columns of the table of modes.
pub(super) const HEADER: [&str; 8] =
    ["Nut m", "Order", "Undamped Hz", "Peak Hz", "95 % interval", "Damping %", "95 % interval", "Amplitude"];

/// A prediction as text.
pub fn prediction_text(title: &str, document: &PredictionDocument) -> String {
    let PredictionDocument { quantity, response, excitation, draws, minima, .. } = document;
    let several = if *minima > 1 { format!(" about each of {minima} minima") } else { String::new() };
    let mut text = format!("{title}\n");
    text += &wrapped(&format!(
        "95 % intervals from {draws} machines that data and tolerances leave possible{several}; amplitudes: {quantity} {response}/{excitation}, SI units"
    ));
    text.push('\n');
    let (place, modes) = mode_rows(document);
    text += &columns(
        &HEADER.map(|name| if name == "Nut m" { place } else { name }.to_string()),
        modes.into_iter(),
    );
    let stiffness = stiffness_rows(document);
    if !stiffness.is_empty() {
        text += &format!("\nstatic stiffness at {excitation} (SI units)\n");
        text += &columns(&[place, "Stiffness", "95 % interval"].map(String::from), stiffness.into_iter());
    }
    if !document.stamp.complete {
        text += "stopped early: intervals from the machines drawn so far\n";
    }
    text
}

/// Returns the predicted modes as rows of cells under [`HEADER`], and the head of the first column.
pub(super) fn mode_rows(document: &PredictionDocument) -> (&'static str, Vec<Vec<String>>) {
    let mut rows = Vec::new();
    for (name, position) in document.ordered() {
        let place = match (position.nut_m, position.role) {
            (Some(_), Some(_)) | (None, _) => name.clone(),
            (Some(nut_m), None) => nut_m.to_string(),
        };
        for (at, PredictedMode { mode, frequency95, damping95, .. }) in position.modes.iter().enumerate() {
            let (peak, peak95) = interval_cells(mode.frequency_hz, *frequency95, 1.0);
            let (damping, damping95) = interval_cells(mode.damping_ratio, *damping95, 100.0);
            let place = if at == 0 { place.clone() } else { String::new() };
            rows.push(vec![
                place,
                mode.order.to_string(),
                figure(mode.natural_hz),
                peak,
                peak95,
                damping,
                damping95,
                cell(mode.amplitude, figure),
            ]);
        }
    }
    let is_of_nuts = document.positions.values().any(|p| p.role.is_none() && p.nut_m.is_some());
    (if is_of_nuts { "Nut m" } else { "Position" }, rows)
}

/// Returns the predicted static stiffness of each position, where there is one, as rows of cells: name,
/// value, interval.
pub(super) fn stiffness_rows(document: &PredictionDocument) -> Vec<Vec<String>> {
    let row = |(name, position): (&String, &PredictedPosition)| {
        let value = position.static_stiffness?;
        let (value, interval) = position
            .static_stiffness95
            .map_or_else(|| (figure(value), "–".into()), |ends| with_interval(value, ends));
        Some(vec![name.clone(), value, interval])
    };
    document.ordered().into_iter().filter_map(row).collect()
}

/// Writes a number and its interval, multiplied by a factor, each «–» where it is absent.
fn interval_cells(number: Option<f64>, interval: Option<[f64; 2]>, factor: f64) -> (String, String) {
    match (number, interval) {
        (Some(x), Some(ends)) => with_interval(factor * x, ends.map(|end| factor * end)),
        (Some(x), None) => (figure(factor * x), "–".into()),
        (None, _) => ("–".into(), "–".into()),
    }
}

/// The modes of a prediction as CSV, each with the static stiffness of its position.
pub fn prediction_csv(document: &PredictionDocument) -> String {
    let mut text = String::from(
        "position,nut_m,order,frequency_hz,frequency_low_hz,frequency_high_hz,natural_hz,natural_low_hz,natural_high_hz,damping_ratio,damping_low,damping_high,amplitude,amplitude_low,amplitude_high,static_stiffness,static_stiffness_low,static_stiffness_high\n",
    );
    let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
    for (name, position) in document.ordered() {
        for PredictedMode { mode, frequency95, natural95, damping95, amplitude95 } in &position.modes {
            let ends = |interval: &Option<[f64; 2]>| {
                [number(interval.map(|i| i[0])), number(interval.map(|i| i[1]))].join(",")
            };
            let cells = [
                csv_cell(name).to_string(),
                number(position.nut_m),
                mode.order.to_string(),
                number(mode.frequency_hz),
                ends(frequency95),
                mode.natural_hz.to_string(),
                ends(&Some(*natural95)),
                number(mode.damping_ratio),
                ends(damping95),
                number(mode.amplitude),
                ends(amplitude95),
                number(position.static_stiffness),
                ends(&position.static_stiffness95),
            ];
            text += &(cells.join(",") + "\n");
        }
    }
    text
}

/// The FRFs of a prediction as CSV; `None` where none was requested.
pub fn predicted_frfs_csv(document: &PredictionDocument) -> Option<String> {
    let mut text = String::from("position,nut_m,frequency_hz,real,imag,magnitude_low,magnitude_high\n");
    let head = text.len();
    for (name, position) in document.ordered() {
        let Some(frf) = &position.frf else { continue };
        let nut_m = position.nut_m.map_or(String::new(), |x| x.to_string());
        for ((hz, [re, im]), [low, high]) in frf.frequency_hz.iter().zip(&frf.value).zip(&frf.magnitude95) {
            text += &format!("{},{nut_m},{hz},{re:e},{im:e},{low:e},{high:e}\n", csv_cell(name));
        }
    }
    (text.len() > head).then_some(text)
}

/// The natural frequencies of an identified machine at its positions as a table; empty without any.
pub(super) fn natural_frequencies_text(modes: &BTreeMap<String, Vec<NaturalMode>>) -> String {
    let most = modes.values().flatten().map(|m| m.order).max().unwrap_or(0);
    if most == 0 {
        return String::new();
    }
    let shown = most.min(MOST_SHOWN);
    let header: Vec<String> = std::iter::once("Position".to_string())
        .chain((1..=shown).map(|order| format!("Order {order}")))
        .collect();
    let rows = modes.iter().map(|(name, modes)| {
        let of = |order: usize| {
            modes.iter().find(|m| m.order == order).map_or("–".into(), |m| figure(m.natural_hz))
        };
        std::iter::once(name.clone()).chain((1..=shown).map(of)).collect()
    });
    format!("undamped natural frequencies of the identified machine (Hz)\n{}", columns(&header, rows))
}

/// Number of orders in the table of natural frequencies.
const MOST_SHOWN: usize = 7;
