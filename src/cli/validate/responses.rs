//! `jointid validate` on FRFs, or on the modes taken from them.

use std::collections::BTreeMap;

use super::arguments::ValidateArguments;
use crate::document_rows;
use crate::identified::{identified_machine, tolerances};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::sources::{Loaded, stamp};
use dynamics::model::RodModel;
use identification::channels_of;
use identification::objective::{FrfObjective, FrfSettings, MISSING, ModeObjective, ModeSettings, PositionPrediction};
use report::document::{IdentificationDocument, Input, ValidationDocument};
use report::{gaps_table, positions_table};

/// Runs the command.
pub fn run(
    given: &ValidateArguments,
    (identified, input): (&IdentificationDocument, Input),
    loaded: &Loaded,
    values: &[f64],
    mut warnings: Vec<String>,
) -> CommandResult {
    let settings = &identified.settings;
    let (machine, values) = identified_machine(identified, loaded, values)?;
    let (machine, values) = (&machine, &values);
    let folder = prepare(&given.output)?;
    let whole_frfs = settings.objective == "frf";
    let same_set = given.measurements.is_none();
    // The split of the identification, where the set is the same.
    let split = if same_set { loaded.set.split(settings.positions.as_deref(), &settings.hold_out).ok() } else { None };
    let (fitted, left) = split.unzip();
    let (fitted_positions, fitted_frfs) = fitted.as_ref().map_or((&[][..], &[][..]), |fit| (fit.positions(), fit.frfs()));
    let held_out = match (&given.positions, left) {
        (Some(names), _) => loaded.set.to_predict(names).map_err(to_message)?,
        (None, Some(left)) if !left.is_empty() => left,
        (None, _) => loaded.set.everything_to_predict(),
    };
    if whole_frfs && held_out.frfs().is_empty() {
        return Err(format!("{}: holds no FRF to check at these positions; the identification is on whole FRFs", loaded.set.path));
    }
    let rods = settings.lumps.map_or(RodModel::Exact, RodModel::Lumped);
    // The gain belongs to a measurement set; for another set it is fitted.
    let own_gain = if same_set { identified.parameters.get("gain").map(|g| g.value) } else { None };
    let positions = if whole_frfs {
        let band_hz = settings.band_hz.map_or(FrfSettings::default().band_hz, |[from, to]| (from, to));
        let model_error = if settings.frf_model_error > 0.0 { settings.frf_model_error } else { FrfSettings::default().model_error };
        let frf_settings = FrfSettings { rods, band_hz, model_error, ..FrfSettings::default() };
        let objective = FrfObjective::held_out(machine, &held_out, frf_settings).map_err(to_message)?;
        // Gains and delays belong to the channels of the set they were estimated on.
        let channels = if same_set { channels_of(machine, &tolerances(identified)) } else { Vec::new() };
        let objective = objective.calibrated(&channels);
        let gain = own_gain.unwrap_or_else(|| objective.best_gain(values));
        let mut frfs = Vec::new();
        for gap in objective.gaps(values, gain) {
            frfs.extend(document_rows::frfs(&loaded.set, &[gap], if fitted_frfs.contains(&gap.frf) { "fit" } else { "held_out" }));
        }
        document_rows::gathered(&frfs)
    } else {
        let mode_settings = ModeSettings { rods, ..ModeSettings::default() };
        let objective = ModeObjective::held_out(machine, &held_out, mode_settings, None).map_err(to_message)?;
        let predictions = objective.predict(values);
        let gain = own_gain.or_else(|| Some(objective.amplitude_fit(&predictions)).filter(|f| f.count > 0 && !same_set).map(|f| f.gain));
        let row = |p: &PositionPrediction| {
            let name = loaded.set.positions[p.position].name.clone();
            let role = if fitted_positions.contains(&p.position) { "fit" } else { "held_out" };
            let row = document_rows::position(&loaded.set, p, role, gain, &identified.fit_positions);
            (name, row)
        };
        predictions.iter().map(row).collect::<BTreeMap<_, _>>()
    };
    warnings.extend(document_rows::pairing_warnings(&positions));
    let largest = positions.values().filter_map(|p| p.largest_error(MISSING)).reduce(f64::max);
    let largest_gap = positions.values().filter_map(|p| p.gap).reduce(f64::max);
    let mut stamped = stamp("validation", identified.stamp.seed, true, loaded, warnings);
    stamped.inputs.push(input);
    let document = ValidationDocument { stamp: stamped, positions, largest_error: largest, largest_gap };
    let mut text = if whole_frfs { gaps_table(&document.positions) } else { positions_table(&document.positions, false) };
    if let Some(largest) = largest {
        text += &format!("\nlargest frequency error: {:.2} %\n", 100.0 * largest);
    }
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "validation.json", &document, &text)?;
    Ok(given.judge(if whole_frfs { "gap" } else { "frequency error" }, largest.or(largest_gap)))
}
