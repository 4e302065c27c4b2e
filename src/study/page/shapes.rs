//! Mode shapes along the shafts of an identified machine, for its page.

use std::sync::Arc;

use super::curves::CurveModel;
use crate::modal_density::highest_hz;
use crate::{StudyError, StudyResult};
use dynamics::model::{Structure, undamped_modes};
use machine::{Operating, PointMotion};
use measurement::MeasurementSet;
use report::page::{Deflection, ModeShape, ShapeGroup};

/// Number of modes shown at each position.
const MODES: usize = 7;
/// Number of points on each rod.
const STEPS: usize = 24;

/// Computes the undamped modes at every position, up to 1.2 times the highest measured frequency; none for a
/// machine without shafts.
pub(super) fn shapes(set: &MeasurementSet, model: &CurveModel) -> StudyResult<Vec<ShapeGroup>> {
    let machine = &model.machine;
    if machine.shafts.is_empty() {
        return Ok(Vec::new());
    }
    let name = set.response.as_ref().or_else(|| set.frfs.first().map(|f| &f.response));
    let observed =
        name.and_then(|n| machine.point(n)).filter(|p| machine.points[*p].motion == PointMotion::Translation);
    let Some(first) = machine.points.iter().position(|p| !p.fixed) else { return Ok(Vec::new()) };
    let structure =
        Arc::new(Structure::new(machine, first, first, model.rods).map_err(StudyError::impossible)?);
    let (mut assembled, mut work) = (structure.empty_model(), structure.workspace());
    let start = &model.values;
    let mut groups = Vec::new();
    for position in &set.positions {
        let operating = Operating::at(position.nut_m);
        assembled.update(machine, start, &operating);
        let modes = undamped_modes(&assembled, 1.2 * highest_hz(set), &mut work)
            .into_iter()
            .filter(|m| m.frequency_hz > 0.0)
            .take(MODES);
        let modes = modes.map(|mode| {
            let along = assembled.shaft_deflections(
                machine,
                start,
                &operating,
                (mode.frequency_hz, &mode.shape),
                STEPS,
            );
            let deflections = along.into_iter().map(|a| {
                let shaft = &machine.shafts[a.shaft];
                // Torsion is shown as the displacement of the circumference, in one scale with the axial
                // deflection.
                let factor = if a.torsional { 0.5 * shaft.diameter.at(start, &operating) } else { 1.0 };
                Deflection {
                    shaft: shaft.name.clone(),
                    torsional: a.torsional,
                    points: a.points.into_iter().map(|(x, u)| (x, u * factor)).collect(),
                }
            });
            let at = observed.and_then(|p| {
                Some((machine.points[p].name.clone(), *mode.shape.get(structure.coordinate_of(p)?)?))
            });
            ModeShape { frequency_hz: mode.frequency_hz, deflections: deflections.collect(), observed: at }
        });
        groups.push(ShapeGroup {
            position: position.name.clone(),
            nut_m: position.nut_m,
            modes: modes.collect(),
        });
    }
    Ok(groups)
}
