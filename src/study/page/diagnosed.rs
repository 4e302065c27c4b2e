//! Measured FRFs of a diagnosis and the predictions before and after it, for the page.

use std::collections::BTreeMap;

use super::curves::{CurveModel, Overlay};
use super::inputs::unchanged;
use crate::{Sources, Study, StudyError, StudyResult};
use dynamics::model::RodModel;
use machine::{Joint, Machine, PointMotion, Station};
use report::diagnosis::DiagnosisDocument;
use report::page::{Page, Sketch};
use report::vocabulary::DataKind;

/// Draws the machine as described and as chosen, each at its fit, over the measurements.
///
/// # Errors  an input has changed since the diagnosis; the document has no parameter values.
pub(super) fn draw(of: &DiagnosisDocument, sources: &Sources, page: &mut Page) -> StudyResult<()> {
    let measurements = sources.measurements.as_ref().unwrap_or(&of.measurements);
    let study = Study::reopened((of.machine.as_ref(), &of.config), measurements, &of.stamp, sources);
    let study = unchanged(study, &of.stamp, ("diagnosis", "diagnose"), sources)?;
    page.notes.extend(study.outdated_machine().filter(|note| !page.notes.contains(note)));
    page.title = study.machine().title.clone();
    page.sketch = sketch(study.machine());
    if of.domain == DataKind::Motion {
        return Ok(());
    }
    let Study { config, set, .. } = &study;
    let described = &config.machine;
    let before = model(described.clone(), &of.described);
    let after = described
        .with_chosen(of.chosen.effects(), &study.candidates(&of.chosen.parameters))
        .and_then(|machine| model(machine, &of.chosen.parameters));
    let models: Vec<CurveModel> =
        before.into_iter().chain(after.filter(|_| !of.chosen.is_nominal())).collect();
    if models.is_empty() {
        return Err(StudyError::impossible(
            "the diagnosis does not state its parameter values; diagnose again with this version",
        ));
    }
    let (fit, _) = set.split(Some(&of.fit_positions), &of.held_out_positions)?;
    page.diagnosed = Overlay { set, fit, models: &models }.curves()?;
    Ok(())
}

/// Returns what a sketch of a machine shows: the ground is no point of it, and journals are parts of their shafts.
fn sketch(machine: &Machine) -> Sketch {
    let shown: Vec<usize> = (0..machine.points.len()).filter(|p| !machine.points[*p].fixed).collect();
    let of = |point: usize| shown.iter().position(|p| *p == point);
    let point = |p: &usize| {
        let point = &machine.points[*p];
        (point.name.clone(), point.motion == PointMotion::Rotation)
    };
    let joint = |joint: &Joint| (joint.name.clone(), joint.on.iter().filter_map(|(p, _)| of(*p)).collect());
    let station = |s: &Station| [s.axial, s.torsion].map(|p| p.and_then(of));
    let shafts = machine.shafts.iter().filter(|shaft| shaft.journal_of.is_none());
    Sketch {
        points: shown.iter().map(point).collect(),
        joints: machine.joints.iter().map(joint).collect(),
        shafts: shafts.map(|s| (s.name.clone(), s.stations.iter().map(station).collect())).collect(),
    }
}

fn model(machine: Machine, values: &BTreeMap<String, f64>) -> Option<CurveModel> {
    Some(CurveModel { values: machine.values_of(values)?, machine, rods: RodModel::Exact, gain: None })
}
