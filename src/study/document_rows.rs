//! Results of the library as rows of documents.

use std::collections::BTreeMap;

use crate::Study;
use identification::Identification;
use identification::objective::{FrfGap, PositionPrediction};
use measurement::MeasurementSet;
use numeric::statistics::{root_mean_square_of_parts, root_sum_square};
use report::document::{FrfRow, LonePeak, OrderRow, PositionRow};

/// Returns the root of the summed squares of relative errors. `None` where a measured order is not predicted: a model without that mode must not look
/// better for it.
fn overall(orders: &[OrderRow], predicted: impl Fn(&OrderRow) -> Option<f64>) -> Option<f64> {
    let measured = orders.iter().filter(|o| o.measured_hz.is_some());
    let errors: Option<Vec<f64>> = measured.map(|o| Some(predicted(o)? / o.measured_hz? - 1.0)).collect();
    root_sum_square(errors?)
}

/// Returns the row of one position.
fn position(set: &MeasurementSet, prediction: &PositionPrediction, role: &str, gain: Option<f64>, fit_positions: &[String]) -> PositionRow {
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
        gap: None,
        noise_floor: None,
    }
}

/// Returns FRFs as rows.
fn frfs(set: &MeasurementSet, gaps: &[FrfGap], role: &str) -> Vec<FrfRow> {
    gaps.iter()
        .map(|gap| {
            let frf = &set.frfs[gap.frf];
            FrfRow {
                position: frf.position.map(|p| set.positions[p].name.clone()),
                record: frf.record.clone(),
                response: frf.response.clone(),
                excitation: frf.excitation.clone(),
                role: role.into(),
                gap: gap.gap,
                noise_floor: gap.noise_floor,
                lines: gap.lines,
                accepted_share: frf.lines.len() as f64 / (frf.lines.len() + frf.rejected.len()) as f64,
            }
        })
        .collect()
}

/// Groups FRFs by position, or by record where there is no position or where the records of a position have different roles.
fn gathered(frfs: &[FrfRow]) -> BTreeMap<String, PositionRow> {
    let mixed = |name: &String| {
        frfs.iter().any(|a| a.position.as_ref() == Some(name) && a.role != frfs[0].role)
            && frfs.iter().any(|a| a.position.as_ref() == Some(name) && a.role == frfs[0].role)
    };
    let name = |row: &FrfRow| match (&row.position, &row.record) {
        (Some(position), Some(record)) if mixed(position) => format!("{position} {record}"),
        (Some(position), _) => position.clone(),
        (None, Some(record)) => record.clone(),
        (None, None) => "all".into(),
    };
    let mut groups: BTreeMap<String, Vec<&FrfRow>> = BTreeMap::new();
    for row in frfs {
        groups.entry(name(row)).or_default().push(row);
    }
    let mean = |rows: &[&FrfRow], pick: &dyn Fn(&FrfRow) -> Option<f64>| -> Option<f64> {
        let parts: Option<Vec<(f64, usize)>> = rows.iter().map(|r| Some((pick(r)?, r.lines))).collect();
        root_mean_square_of_parts(parts?)
    };
    groups
        .into_iter()
        .map(|(name, rows)| {
            let row = PositionRow {
                role: rows[0].role.clone(),
                overall_error: None,
                overall_error_rounded: None,
                overall_error_published: None,
                orders: Vec::new(),
                lone_peaks: Vec::new(),
                gap: mean(&rows, &|r| Some(r.gap)),
                noise_floor: mean(&rows, &|r| r.noise_floor),
            };
            (name, row)
        })
        .collect()
}

/// Returns all FRFs of an identification.
fn all_frfs(set: &MeasurementSet, found: &Identification) -> Vec<FrfRow> {
    let mut rows = frfs(set, &found.fitted_frfs, "fit");
    rows.extend(frfs(set, &found.held_out_frfs, "held_out"));
    rows
}

/// Returns all positions of an identification.
pub(crate) fn positions(study: &Study, found: &Identification, fit_positions: &[String]) -> BTreeMap<String, PositionRow> {
    if !found.fitted_frfs.is_empty() {
        return gathered(&all_frfs(&study.set, found));
    }
    let gain = (found.gain.count > 0).then_some(found.gain.gain);
    let rows = |predictions: &[PositionPrediction], role: &'static str| -> Vec<(String, PositionRow)> {
        predictions
            .iter()
            .map(|p| (study.set.positions[p.position].name.clone(), position(&study.set, p, role, gain, fit_positions)))
            .collect()
    };
    rows(&found.fitted, "fit").into_iter().chain(rows(&found.held_out, "held_out")).collect()
}
