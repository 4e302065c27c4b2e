//! Undamped natural frequencies and mode shapes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::operating::{Load, Place, find_operating, load_warnings, require_positive};
use crate::modal_density::check_listed;
use crate::{Study, StudyError, StudyResult};
use dynamics::model::{AssembledModel, RodModel, Structure, UndampedMode, undamped_modes};
use machine::{Machine, Operating};
use numeric::unit::omega_rad_s;
use report::simulation::{ModeRow, ModesDocument};

/// What [`modes`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesRequest {
    /// Place of the nut.
    pub place: Place,
    /// Load on the rolling contacts.
    pub load: Load,
    /// Highest frequency (Hz).
    pub max_hz: f64,
    /// Model of the rods.
    pub rods: RodModel,
}

impl Default for ModesRequest {
    fn default() -> Self {
        ModesRequest { place: Place::MidStroke, load: Load::default(), max_hz: 1000.0, rods: RodModel::Exact }
    }
}

/// Computes the undamped modes at the start values of the parameters.
///
/// # Errors  a setting outside its range; the machine does not allow the operating condition, or no point
///   moves.
pub fn modes(study: &Study, request: &ModesRequest) -> StudyResult<ModesDocument> {
    let max_hz = require_positive("max_hz", request.max_hz)?;
    let machine = study.machine();
    let operating = find_operating(study, &request.place, &request.load)?;
    check_listed(machine, request.rods, &operating, max_hz)?;
    let first = machine.points.iter().position(|p| !p.fixed);
    let first = first.ok_or_else(|| StudyError::impossible("the machine has no point that moves"))?;
    let structure =
        Arc::new(Structure::new(machine, first, first, request.rods).map_err(StudyError::impossible)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), &operating);
    let modes = undamped_modes(&model, max_hz, &mut structure.workspace());
    Ok(ModesDocument {
        stamp: study.stamp(
            "modes",
            0,
            true,
            load_warnings(machine, &request.load, std::slice::from_ref(&operating)),
        ),
        nut_m: operating.nut_m,
        velocity_m_s: operating.velocity_m_s,
        acceleration_m_s2: operating.acceleration_m_s2,
        force_n: operating.force_n,
        modes: modes
            .iter()
            .enumerate()
            .map(|(at, mode)| row(machine, (structure.as_ref(), &model), &operating, at + 1, mode))
            .collect(),
    })
}

fn row(
    machine: &Machine,
    (structure, model): (&Structure, &AssembledModel),
    operating: &Operating,
    order: usize,
    mode: &UndampedMode,
) -> ModeRow {
    // A rigid-body mode has no strain energy.
    let energy = match mode.frequency_hz > 0.0 {
        true => model.strain_energy(
            machine,
            &machine.start(),
            operating,
            omega_rad_s(mode.frequency_hz),
            &mode.shape,
        ),
        false => Vec::new(),
    };
    ModeRow {
        order,
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        shape: shape(machine, structure, &mode.shape),
        damped_hz: mode.damping_ratio.filter(|z| *z < 1.0).map(|z| mode.frequency_hz * (1.0 - z * z).sqrt()),
        deformation: energy.iter().filter_map(|e| Some((e.name.clone(), e.deformation?))).collect(),
        strain_energy_share: energy.into_iter().map(|e| (e.name, e.share)).collect(),
    }
}

/// Returns the deflection of every point of the machine.
fn shape(machine: &Machine, structure: &Structure, deflection: &[f64]) -> BTreeMap<String, f64> {
    if deflection.is_empty() {
        return BTreeMap::new();
    }
    let of = |point: usize| structure.coordinate_of(point).map_or(0.0, |c| deflection[c]);
    machine.points.iter().enumerate().map(|(i, p)| (p.name.clone(), of(i))).collect()
}
