//! A natural frequency over the stiffness of each joint.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::document::sensitivity::{SensitivityDocument, SensitivityRow};
use dynamics::model::{RodModel, Structure, elastic_frequencies_hz, undamped_modes};
use machine::{FitRule, Machine, Mechanism, Modifier, Operating, Parameter, Role, Scale};
use numeric::unit::omega_rad_s;
use study::simulation::{Load, Place, find_operating, load_warnings, require_count};
use study::{Study, StudyError, StudyResult};

/// What [`sensitivity`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct SensitivityRequest {
    /// Number of the natural frequency above 0, from 1.
    pub order: usize,
    /// Names of the joints; all with a stiffness where absent.
    pub joints: Option<Vec<String>>,
    /// Smallest factor on the stiffness (1).
    pub from: f64,
    /// Largest factor on the stiffness (1).
    pub to: f64,
    /// Number of factors, evenly spaced.
    pub steps: usize,
    /// Place of the nut.
    pub place: Place,
    /// Load on the rolling contacts.
    pub load: Load,
}

impl Default for SensitivityRequest {
    fn default() -> Self {
        SensitivityRequest {
            order: 1,
            joints: None,
            from: 0.5,
            to: 1.5,
            steps: 11,
            place: Place::MidStroke,
            load: Load::default(),
        }
    }
}

/// Computes the sensitivity of a natural frequency to the stiffness of each joint, and the frequency over
/// factors on it.
///
/// # Errors  a setting outside its range; the machine does not allow the operating condition, or has no such
///   joint or frequency.
pub fn sensitivity(study: &Study, request: &SensitivityRequest) -> StudyResult<SensitivityDocument> {
    if !(request.from > 0.0 && request.to > request.from && request.to.is_finite()) {
        let fault = "write factors above 0, the smaller one first";
        return Err(StudyError::setting("from", format!("{}, to {}", request.from, request.to), fault));
    }
    let (order, count) =
        (require_count("order", request.order, 1)?, require_count("steps", request.steps, 2)?);
    let machine = study.machine();
    let operating = find_operating(study, &request.place, &request.load)?;
    let start = machine.start();
    let chosen = chosen_joints(machine, request.joints.as_deref(), &operating)?;
    let frequency = |machine: &Machine, values: &[f64]| {
        elastic_frequencies_hz(machine, order, values, &operating).get(order - 1).copied()
    };
    let frequency_hz = frequency(machine, &start);
    let frequency_hz = frequency_hz
        .ok_or_else(|| StudyError::setting("order", order, "the machine has no such natural frequency"))?;
    let energy = mode_energy(machine, &operating, frequency_hz)?;
    let factors: Vec<f64> = (0..count)
        .map(|i| request.from + (request.to - request.from) * i as f64 / (count - 1) as f64)
        .collect();
    let mut joints = Vec::new();
    for index in chosen {
        let joint = &machine.joints[index];
        let scaled = with_factor(machine, index);
        let mut frequencies_hz = Vec::new();
        for factor in &factors {
            let values: Vec<f64> = start.iter().copied().chain([*factor]).collect();
            let absent =
                "the natural frequency does not exist at one of the factors; choose a narrower range";
            frequencies_hz.push(frequency(&scaled, &values).ok_or_else(|| StudyError::impossible(absent))?);
        }
        let (deformation, share) = energy.get(&joint.name).copied().unwrap_or((0.0, 0.0));
        joints.push(SensitivityRow {
            joint: joint.name.clone(),
            stiffness: joint.stiffness.at(&start, &operating),
            deformation,
            strain_energy_share: share,
            elasticity: 0.5 * share,
            frequencies_hz,
        });
    }
    joints.sort_by(|a, b| b.strain_energy_share.total_cmp(&a.strain_energy_share));
    Ok(SensitivityDocument {
        stamp: study.stamp(
            "sensitivity",
            0,
            true,
            load_warnings(machine, &request.load, std::slice::from_ref(&operating)),
        ),
        nut_m: operating.nut_m,
        order,
        frequency_hz,
        factors,
        joints,
    })
}

/// Adds a factor on the stiffness of a joint, as a parameter appended to the others.
fn with_factor(machine: &Machine, joint: usize) -> Machine {
    let mut scaled = machine.clone();
    let index = scaled.parameters.len();
    scaled.parameters.push(Parameter {
        id: "factor".into(),
        unit: "1".into(),
        mechanism: Mechanism::Ratio,
        role: Role::Described,
        start: 1.0,
        lower: 0.0,
        upper: f64::INFINITY,
        scale: Scale::Linear,
        fit: FitRule::Never,
        prior: None,
        source: "sensitivity".into(),
        description: String::new(),
    });
    scaled.joints[joint].stiffness.modifiers.push(Modifier::Times(index));
    scaled
}

/// Returns the requested joints, or all that have a stiffness.
fn chosen_joints(
    machine: &Machine,
    names: Option<&[String]>,
    operating: &Operating,
) -> StudyResult<Vec<usize>> {
    let start = machine.start();
    let stiff = |i: &usize| machine.joints[*i].stiffness.at(&start, operating) > 0.0;
    let Some(names) = names else { return Ok((0..machine.joints.len()).filter(stiff).collect()) };
    let mut chosen: Vec<usize> = Vec::new();
    for name in names {
        let known: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
        let index = machine.joints.iter().position(|j| j.name == *name);
        let fault = |fault: &str| StudyError::setting("joint", name, fault);
        let index =
            index.ok_or_else(|| fault(&format!("no such joint; the machine has {}", known.join(", "))))?;
        if chosen.contains(&index) {
            return Err(fault("it is listed twice; name each joint once"));
        }
        if !stiff(&index) {
            return Err(fault("it has no stiffness to vary; name another"));
        }
        chosen.push(index);
    }
    Ok(chosen)
}

/// Computes deformation and share of the strain energy of each joint in the mode at a frequency.
pub(crate) fn mode_energy(
    machine: &Machine,
    operating: &Operating,
    frequency_hz: f64,
) -> StudyResult<BTreeMap<String, (f64, f64)>> {
    let moving = machine
        .points
        .iter()
        .position(|p| !p.fixed)
        .ok_or_else(|| StudyError::impossible("the machine has no point that moves"))?;
    let structure =
        Arc::new(Structure::new(machine, moving, moving, RodModel::Exact).map_err(StudyError::impossible)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), operating);
    let modes = undamped_modes(&model, frequency_hz * (1.0 + 1e-6), &mut structure.workspace());
    let mode = modes.last().ok_or_else(|| StudyError::impossible("the mode is not found a second time"))?;
    let rows = model.strain_energy(
        machine,
        &machine.start(),
        operating,
        omega_rad_s(mode.frequency_hz),
        &mode.shape,
    );
    Ok(rows.into_iter().map(|row| (row.name, (row.deformation.unwrap_or(0.0), row.share))).collect())
}
