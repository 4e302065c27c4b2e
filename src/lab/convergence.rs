//! Convergence of the lumped model with its number of masses.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::document::convergence::{ConvergenceDocument, ConvergenceRow};
use dynamics::model::{RodModel, Structure, undamped_modes};
use identification::{IdentificationSettings, identify};
use machine::{Machine, Operating};
use measurement::{FitSet, HoldOutSet};
use report::vocabulary::Role;
use study::{Study, StudyError, StudyResult, position_rows};

/// Upper limit of the compared natural frequencies (Hz).
const HIGHEST_HZ: f64 = 2000.0;
/// Number of natural frequencies compared.
const COMPARED: usize = 4;

/// Identifies the machine of a study with each of these numbers of masses per rod, in ascending order, and
/// with the exact rod.
///
/// # Errors  a number is 0 or given twice; the machine has no shaft; as [`Study::fit`], and the data do not
///   suffice.
pub fn convergence(study: &Study, counts: &[usize]) -> StudyResult<ConvergenceDocument> {
    let sorted: BTreeSet<usize> = counts.iter().copied().collect();
    if sorted.len() != counts.len() {
        return Err(StudyError::setting("counts", "", "a number is listed twice; write each once"));
    }
    if sorted.contains(&0) {
        return Err(StudyError::setting("counts", 0, "write numbers of masses from 1"));
    }
    let (machine, set) = (&study.machine(), study.measurements());
    if machine.shafts.is_empty() {
        return Err(StudyError::input(
            &study.config().path,
            "has no [[shaft]] to lump; name a machine that has one",
        ));
    }
    let requested = study.identification_settings()?;
    let (fit, held_out) = set.split(study.fitted(), study.held_out())?;
    let fit_positions: Vec<String> = fit.positions().iter().map(|p| set.positions[*p].name.clone()).collect();
    let first = fit.positions().first().map(|p| Operating::at(set.positions[*p].nut_m));
    let condition = first.unwrap_or_else(|| Operating::at(machine.stroke_m().map(|s| 0.5 * s)));
    machine.check_operating("the first position", &condition)?;
    let mut rows = Vec::new();
    for rods in sorted.into_iter().map(RodModel::Lumped).chain([RodModel::Exact]) {
        rows.push(row(study, (&fit, &held_out, &fit_positions), &requested, rods, &condition)?);
        if study.control().stopped() {
            break;
        }
    }
    Ok(ConvergenceDocument {
        stamp: study.stamp("convergence", requested.seed, !study.control().stopped(), Vec::new()),
        nut_m: condition.nut_m,
        fit_positions,
        rows,
    })
}

/// Identifies the machine with one model of the rods.
fn row(
    study: &Study,
    (fit, held_out, fit_positions): (&FitSet<'_>, &HoldOutSet<'_>, &[String]),
    requested: &IdentificationSettings,
    rods: RodModel,
    condition: &Operating,
) -> StudyResult<ConvergenceRow> {
    let machine = &study.machine();
    let mut settings = requested.clone();
    settings.settings.rods = rods;
    if let Some(frf) = &mut settings.frf {
        frf.rods = rods;
    }
    let found = identify(machine, fit, held_out, &settings, study.control())?;
    let positions = position_rows(study, &found, fit_positions);
    let held_out_errors: BTreeMap<String, f64> = positions
        .iter()
        .filter(|(_, row)| row.role == Role::HeldOut)
        .filter_map(|(name, row)| Some((name.clone(), row.overall_error?)))
        .collect();
    Ok(ConvergenceRow {
        lumps: match rods {
            RodModel::Exact => None,
            RodModel::Lumped(lumps) => Some(lumps),
        },
        frequencies_hz: frequencies_hz(machine, rods, condition)?,
        parameters: machine.parameters.iter().zip(&found.values).map(|(p, x)| (p.id.clone(), *x)).collect(),
        fitted: found.free.iter().map(|i| machine.parameters[*i].id.clone()).collect(),
        cost: found.cost,
        held_out_errors,
    })
}

/// Computes the first natural frequencies above 0 (Hz) at the start values.
fn frequencies_hz(machine: &Machine, rods: RodModel, condition: &Operating) -> StudyResult<Vec<f64>> {
    let moving = machine.points.iter().position(|p| !p.fixed);
    let moving = moving.ok_or_else(|| StudyError::impossible("the machine has no point that moves"))?;
    let structure = Arc::new(Structure::new(machine, moving, moving, rods).map_err(StudyError::impossible)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), condition);
    let modes = undamped_modes(&model, HIGHEST_HZ, &mut structure.workspace());
    Ok(modes.iter().map(|m| m.frequency_hz).filter(|f| *f > 0.0).take(COMPARED).collect())
}
