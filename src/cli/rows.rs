//! Results of the library as rows of documents.

use std::collections::BTreeMap;

use super::common::Loaded;
use crate::identification::{GAIN_RANGE, Identification};
use crate::machine::Machine;
use crate::measurement::MeasurementSet;
use crate::numeric::statistics::{root_mean_square, root_sum_square};
use crate::objective::{MISSING, PositionPrediction};
use crate::report::document::{LonePeak, OrderRow, ParameterRow, PositionRow};

/// Parameters by id, with the gain where amplitudes were compared.
pub fn parameters(machine: &Machine, found: &Identification) -> BTreeMap<String, ParameterRow> {
    let mut rows: BTreeMap<String, ParameterRow> = found
        .estimates
        .iter()
        .map(|e| {
            let p = &machine.parameters[e.parameter];
            let row = ParameterRow {
                value: e.value,
                unit: p.unit.clone(),
                lower: p.lower,
                upper: p.upper,
                interval95: e.interval95.map(|(a, b)| [a, b]),
                identifiable: e.identifiable,
                fitted: found.free.contains(&e.parameter),
            };
            (p.id.clone(), row)
        })
        .collect();
    if found.gain.count > 0 {
        let row = ParameterRow {
            value: found.gain.gain,
            unit: "1".into(),
            lower: GAIN_RANGE.0,
            upper: GAIN_RANGE.1,
            interval95: found.gain_interval95.map(|(a, b)| [a, b]),
            identifiable: found.gain_identifiable,
            fitted: found.certainty.sd.len() > found.free.len(),
        };
        rows.insert("gain".into(), row);
    }
    rows
}

/// Root of the summed squares of the relative errors; `None` where a measured order is not predicted: a model that lost a mode must not
/// look better for it.
fn overall(orders: &[OrderRow], predicted: impl Fn(&OrderRow) -> Option<f64>) -> Option<f64> {
    let measured = orders.iter().filter(|o| o.measured_hz.is_some());
    let errors: Option<Vec<f64>> = measured.map(|o| Some(predicted(o)? / o.measured_hz? - 1.0)).collect();
    root_sum_square(errors?)
}

/// One position's row.
pub fn position(
    set: &MeasurementSet,
    prediction: &PositionPrediction,
    role: &str,
    gain: Option<f64>,
    fit_positions: &[String],
) -> PositionRow {
    let name = &set.positions[prediction.position].name;
    let mut orders: Vec<OrderRow> = Vec::new();
    let mut lone_peaks = Vec::new();
    for deviation in &prediction.deviations {
        match (deviation.observed, deviation.predicted) {
            (Some(observed), peak) => orders.push(OrderRow {
                order: observed.order,
                measured_hz: observed.frequency_hz,
                predicted_hz: peak.map(|p| p.frequency_hz),
                relative_error: peak.and_then(|p| Some(p.frequency_hz / observed.frequency_hz? - 1.0)),
                measured_amplitude: observed.amplitude,
                predicted_amplitude: peak.and_then(|p| Some(gain? * p.amplitude)),
                published_hz: set.published.predicted_hz(fit_positions, name, observed.order),
            }),
            (None, Some(peak)) => {
                lone_peaks.push(LonePeak { frequency_hz: peak.frequency_hz, prominence: peak.prominence, unexpected: deviation.unexpected })
            }
            (None, None) => {}
        }
    }
    if let Some(table) = &set.modes {
        for unseen in table.positions[prediction.position].iter().filter(|m| m.frequency_hz.is_none()) {
            orders.push(OrderRow {
                order: unseen.order,
                measured_hz: None,
                predicted_hz: None,
                relative_error: None,
                measured_amplitude: None,
                predicted_amplitude: None,
                published_hz: None,
            });
        }
    }
    orders.sort_by_key(|o| o.order);
    let step = set.modes.as_ref().and_then(|t| t.resolution_hz);
    let rounded = |x: f64| step.map(|s| (x / s).round() * s);
    PositionRow {
        role: role.into(),
        overall_error: overall(&orders, |o| o.predicted_hz),
        overall_error_rounded: overall(&orders, |o| o.predicted_hz.and_then(rounded)),
        overall_error_published: overall(&orders, |o| o.published_hz),
        orders,
        lone_peaks,
    }
}

/// All positions of an identification.
pub fn positions(loaded: &Loaded, found: &Identification, fit_positions: &[String]) -> BTreeMap<String, PositionRow> {
    let gain = (found.gain.count > 0).then_some(found.gain.gain);
    let rows = |predictions: &[PositionPrediction], role: &'static str| -> Vec<(String, PositionRow)> {
        predictions
            .iter()
            .map(|p| (loaded.set.positions[p.position].name.clone(), position(&loaded.set, p, role, gain, fit_positions)))
            .collect()
    };
    rows(&found.fitted, "fit").into_iter().chain(rows(&found.held_out, "held_out")).collect()
}

/// Quantities that follow: largest errors and scatter, by name.
pub fn derived(positions: &BTreeMap<String, PositionRow>) -> BTreeMap<String, f64> {
    let mut derived = BTreeMap::new();
    for role in ["fit", "held_out"] {
        let of_role = || positions.values().filter(|p| p.role == role);
        if let Some(largest) = of_role().filter_map(|p| p.largest_error(MISSING)).reduce(f64::max) {
            derived.insert(format!("largest_frequency_error_{role}"), largest);
        }
        let logs = of_role().flat_map(|p| &p.orders).filter_map(|o| Some((o.predicted_amplitude? / o.measured_amplitude?).ln()));
        if let Some(rms) = root_mean_square(logs) {
            derived.insert(format!("ln_amplitude_rms_{role}"), rms);
        }
    }
    derived
}

/// Warnings about modes without a partner.
pub fn pairing_warnings(positions: &BTreeMap<String, PositionRow>) -> Vec<String> {
    let mut warnings = Vec::new();
    for (name, p) in positions {
        for o in p.orders.iter().filter(|o| o.predicted_hz.is_none()) {
            if let Some(measured_hz) = o.measured_hz {
                warnings.push(format!(
                    "{name}: the model has no peak for order {} measured at {measured_hz} Hz; it counts as an error of 30 %",
                    o.order
                ));
            }
        }
        for peak in p.lone_peaks.iter().filter(|p| p.unexpected) {
            warnings.push(format!(
                "{name}: the model has a peak at {:.1} Hz that was not measured; it counts as an error of 30 %",
                peak.frequency_hz
            ));
        }
    }
    warnings
}
