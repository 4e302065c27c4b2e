//! Stiffness and natural frequencies over an operating variable.

use std::collections::BTreeMap;

use super::operating::{Load, Place, checked_nut, find_operating, load_warnings, require_count};
use crate::{Study, StudyError, StudyResult};
use dynamics::model::elastic_frequencies_hz;
use machine::{LoadedPair, Machine, Operating};
use numeric::root::{Bracket, refine};
use report::simulation::{ContactRow, Separation, SweepDocument, SweepRow};

/// Operating variable that is swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SweepVariable {
    /// Nut position (m).
    Position,
    /// Velocity (m/s).
    Velocity,
    /// Acceleration (m/s²).
    Acceleration,
    /// External force (N).
    Force,
}

/// What [`stiffness`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessRequest {
    /// Variable to sweep.
    pub along: SweepVariable,
    /// Start of the sweep (unit of the variable); where absent, 2 % of the stroke for positions.
    pub from: Option<f64>,
    /// End of the sweep (unit of the variable); where absent, 98 % of the stroke for positions.
    pub to: Option<f64>,
    /// Number of values, evenly spaced.
    pub steps: usize,
    /// Place of the nut.
    pub place: Place,
    /// Load on the rolling contacts.
    pub load: Load,
    /// Name of the point at which to compute the static stiffness; none where absent.
    pub at: Option<String>,
    /// Nut position (m) of a second, identical axis in series with the first, as in a cross table.
    pub in_series_with_nut_m: Option<f64>,
    /// Number of natural frequencies above 0 to compute.
    pub orders: usize,
}

impl SweepVariable {
    fn key(self) -> &'static str {
        match self {
            SweepVariable::Position => "nut_m",
            SweepVariable::Velocity => "velocity_m_s",
            SweepVariable::Acceleration => "acceleration_m_s2",
            SweepVariable::Force => "force_n",
        }
    }

    /// Returns the operating condition at one value of the variable.
    fn at(self, base: &Operating, x: f64) -> Operating {
        let mut operating = *base;
        *match self {
            SweepVariable::Position => &mut operating.nut_m,
            SweepVariable::Velocity => &mut operating.velocity_m_s,
            SweepVariable::Acceleration => &mut operating.acceleration_m_s2,
            SweepVariable::Force => &mut operating.force_n,
        } = Some(x);
        operating
    }
}

/// Computes loads and stiffness of contacts and joints, static stiffness and natural frequencies over an
/// operating variable, and where sides of contacts unload.
///
/// # Errors  a setting outside its range; the machine does not allow an operating condition, or no such point
///   moves.
pub fn stiffness(study: &Study, request: &StiffnessRequest) -> StudyResult<SweepDocument> {
    let machine = study.machine();
    let along = request.along;
    let base = find_operating(study, &request.place, &request.load)?;
    let (from, to) = range(request, machine)?;
    let steps = require_count("steps", request.steps, 2)?;
    if let Some(point) = &request.at {
        known_point(machine, point)?;
    }
    let mut warnings = load_warnings(machine, &request.load, &[]);
    if along != SweepVariable::Position && machine.contacts.is_empty() {
        warnings.push(format!(
            "this machine does not depend on {}: none of its joints is a [contact.…]",
            along.key()
        ));
    }
    let mut rows = Vec::with_capacity(steps);
    for step in 0..steps {
        let x = from + (to - from) * step as f64 / (steps - 1) as f64;
        let here = along.at(&base, x);
        machine.check_operating(&format!("{} = {x}", along.key()), &here)?;
        let mut row = sweep_row(machine, &here, x, request.orders)?;
        if let Some(point) = &request.at {
            let mut k = static_stiffness(machine, &here, point)?;
            if let Some(second_m) = request.in_series_with_nut_m {
                let second = checked_nut(
                    machine,
                    "in_series_with_nut_m",
                    Operating { nut_m: Some(second_m), ..here },
                )?;
                k = 1.0 / (1.0 / k + 1.0 / static_stiffness(machine, &second, point)?);
            }
            row.static_stiffness = Some(k);
        }
        rows.push(row);
    }
    Ok(SweepDocument {
        stamp: study.stamp("stiffness", 0, true, warnings),
        along: along.key().into(),
        point: request.at.clone(),
        in_series_with_nut_m: request.in_series_with_nut_m,
        separations: machine
            .contacts
            .iter()
            .flat_map(|contact| separations(contact, (from, to), |x| along.at(&base, x)))
            .collect(),
        rows,
    })
}

/// Returns the range of the sweep.
fn range(request: &StiffnessRequest, machine: &Machine) -> StudyResult<(f64, f64)> {
    let default = match request.along {
        SweepVariable::Position => {
            let no_nut =
                || StudyError::setting("along", "position", "the machine has no nut; sweep another variable");
            let stroke_m = machine.stroke_m().ok_or_else(no_nut)?;
            Some((0.02 * stroke_m, 0.98 * stroke_m))
        }
        _ => None,
    };
    let need = |key: &str, own: Option<f64>, default: Option<f64>| {
        let absent = || {
            StudyError::setting(
                key,
                "",
                format!("write the start and end of the sweep along {}", request.along.key()),
            )
        };
        own.or(default).ok_or_else(absent)
    };
    let (from, to) =
        (need("from", request.from, default.map(|d| d.0))?, need("to", request.to, default.map(|d| d.1))?);
    if from.is_finite() && to > from && to.is_finite() {
        Ok((from, to))
    } else {
        Err(StudyError::setting(
            "from",
            format!("{from}, to {to}"),
            "write a range with the smaller value first",
        ))
    }
}

fn known_point(machine: &Machine, name: &str) -> StudyResult<usize> {
    machine.point(name).filter(|p| !machine.points[*p].fixed).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        StudyError::setting("at", name, format!("no such point moves; the machine has {}", known.join(", ")))
    })
}

/// Computes the static stiffness at a point.
pub fn static_stiffness(machine: &Machine, operating: &Operating, point: &str) -> StudyResult<f64> {
    let found =
        dynamics::model::matrices(machine, &machine.start(), operating, 1).map_err(StudyError::impossible)?;
    found.static_stiffness(point).map_err(StudyError::impossible)
}

/// Computes contacts, joints and natural frequencies at one operating condition.
fn sweep_row(machine: &Machine, operating: &Operating, at: f64, orders: usize) -> StudyResult<SweepRow> {
    let start = machine.start();
    let mut contacts = BTreeMap::new();
    for contact in &machine.contacts {
        let state = contact.at(operating).map_err(StudyError::impossible)?;
        contacts.insert(
            contact.name.clone(),
            ContactRow {
                force_n: state.force_n,
                load_a_n: state.share.load_a_n,
                load_b_n: state.share.load_b_n,
                stiffness_n_per_m: state.stiffness_n_per_m,
            },
        );
    }
    let mut joints = BTreeMap::new();
    for joint in &machine.joints {
        let k = joint.stiffness.at(&start, operating);
        for (spring, share) in joint.stiffness.compliance_shares(&start, operating) {
            joints.insert(format!("{}/{spring}", joint.name), k / share);
        }
        joints.insert(joint.name.clone(), k);
    }
    let frequencies_hz =
        if orders == 0 { Vec::new() } else { elastic_frequencies_hz(machine, orders, &start, operating) };
    Ok(SweepRow { at, contacts, joints, static_stiffness: None, frequencies_hz })
}

/// Finds where the force on a contact passes a load at which one of its sides unloads.
pub fn separations(
    contact: &LoadedPair,
    (from, to): (f64, f64),
    at: impl Fn(f64) -> Operating,
) -> Vec<Separation> {
    // Number of intervals in which a crossing is sought.
    const CUTS: usize = 512;
    let (unloads_a_n, unloads_b_n) = contact.pair.unloading_forces_n(contact.rule);
    let place = |cut: usize| from + (to - from) * cut as f64 / CUTS as f64;
    let mut found = Vec::new();
    for (side, force_n) in [("A", unloads_a_n), ("B", unloads_b_n)] {
        let excess = |x: f64| contact.force_n(&at(x)) - force_n;
        for cut in 0..CUTS {
            let (low, high) = (place(cut), place(cut + 1));
            let (below, above) = (excess(low), excess(high));
            if (below < 0.0) != (above < 0.0) {
                let here = refine(Bracket { lower: (low, below), upper: (high, above) }, 1e-14, excess);
                found.push(Separation {
                    contact: contact.name.clone(),
                    side: side.into(),
                    force_n,
                    at: here,
                });
            }
        }
    }
    found
}
