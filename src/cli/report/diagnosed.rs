//! Measured FRFs of a diagnosis and the predictions before and after it, for the page.

use std::collections::BTreeMap;

use super::curves::{CurveModel, Overlay};
use super::reread_inputs::read_inputs_again;
use crate::outcome::to_message;
use crate::sources::Loaded;
use dynamics::model::RodModel;
use machine::Machine;
use report::diagnosis::DiagnosisDocument;
use report::page::Page;

/// Draws the machine as described and as chosen, each at its fit, over the measurements.
///
/// # Errors  an input has changed since the diagnosis; the document has no parameter values.
pub(super) fn draw(of: &DiagnosisDocument, page: &mut Page) -> Result<(), String> {
    let loaded = read_inputs_again(&of.config, &of.measurements, &of.stamp, ("diagnosis", "diagnose"))?;
    if of.domain == "motion" {
        return Ok(());
    }
    let Loaded { config, set, .. } = &loaded;
    let described = &config.machine;
    let before = model(described.clone(), &of.described);
    let after = described.with_chosen(of.chosen.effects(), &config.effects).and_then(|machine| model(machine, &of.chosen.parameters));
    let models: Vec<CurveModel> = before.into_iter().chain(after.filter(|_| of.chosen.id != "nominal")).collect();
    if models.is_empty() {
        return Err("the diagnosis does not state its parameter values; diagnose again with this version".into());
    }
    let (fit, _) = set.split(Some(&of.fit_positions), &of.held_out_positions).map_err(to_message)?;
    page.title = config.machine.title.clone();
    page.diagnosed = Overlay { set, fit, models: &models }.curves()?;
    Ok(())
}

fn model(machine: Machine, values: &BTreeMap<String, f64>) -> Option<CurveModel> {
    Some(CurveModel { values: machine.values_of(values)?, machine, rods: RodModel::Exact, gain: None })
}
