//! Preprocesses motion records, and lists results on them as rows of documents.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::outcome::to_message;
use crate::sources::Loaded;
use diagnosis::motion::{MisfitAxis, MotionPart, misfit_map, part};
use dynamics::inverse_dynamics::{CurvePoint, ExtraChannel, MotionSignal, Preprocessing, Rigid, friction_curve};
use identification::motion::simulated_gaps;
use identification::objective::point_named;
use machine::Machine;
use measurement::{MeasurementSet, MotionRecord};
use numeric::parallel::OrFirstError;
use optimizer::Control;
use report::document::PositionRow;
use report::record::{CurveRow, MotionRecordRow, TransmissionRow};

/// Whether a set holds motion records, and neither FRFs nor modes.
pub fn has_only_motion_records(set: &MeasurementSet) -> bool {
    !set.motions.is_empty() && set.frfs.is_empty() && set.modes.is_none()
}

/// Returns the names of records.
pub fn names(set: &MeasurementSet, records: &[usize]) -> Vec<String> {
    records.iter().map(|i| set.motions[*i].name.clone()).collect()
}

/// Preprocesses all records, in the order of the set. Returns them with the rigid machine and the warnings about their columns.
pub fn preprocess_all(loaded: &Loaded) -> Result<(Vec<MotionSignal>, Rigid, Vec<String>), String> {
    let records = &loaded.set.motions;
    let made: Result<Vec<MotionSignal>, _> =
        records.par_iter().map(|r| MotionSignal::new(r, Preprocessing::default_for(r.step_s))).or_first_error();
    add_channels(loaded, made.map_err(to_message)?)
}

/// Adds the extra channels of the set's records to their preprocessed motions. Returns as [`preprocess_all`].
pub fn add_channels(loaded: &Loaded, made: Vec<MotionSignal>) -> Result<(Vec<MotionSignal>, Rigid, Vec<String>), String> {
    let records = &loaded.set.motions;
    let rigid = rigid_model(loaded)?;
    let machine = &loaded.config.machine;
    made.iter().try_for_each(|m| rigid.check(machine, m)).map_err(to_message)?;
    let named = |name: &String| point_named(machine, &loaded.set.path, "response", name);
    let response = loaded.set.response.as_ref().map(named).transpose().map_err(to_message)?;
    let (mut motions, mut warnings) = (Vec::new(), Vec::new());
    for (motion, record) in made.into_iter().zip(records) {
        let (motion, column_warnings) = motion.with_points(record, machine, &rigid).map_err(to_message)?;
        motions.push(motion.with_reconstructed_encoder(response, record, machine, &rigid).map_err(to_message)?);
        warnings.extend(column_warnings);
    }
    Ok((motions, rigid, warnings))
}

/// Builds the rigid-body model of a machine.
pub fn rigid_model(loaded: &Loaded) -> Result<Rigid, String> {
    let machine = &loaded.config.machine;
    Rigid::new(machine, &machine.start()).map_err(|e| format!("{}: {e}", loaded.config.path))
}

/// Compares a record with a machine by inverse dynamics.
fn record_row(rigid: &Rigid, machine: &Machine, values: &[f64], motion: &MotionSignal, samples: usize, role: &str) -> MotionRecordRow {
    let part = part(rigid, machine, values, motion);
    let by_phase: BTreeMap<String, f64> = misfit_map(motion, &part)
        .iter()
        .filter(|c| c.direction == 0 && c.column.is_none())
        .filter_map(|c| match c.kind {
            MisfitAxis::Phase(phase) => Some((phase.word().to_string(), c.gap)),
            _ => None,
        })
        .collect();
    MotionRecordRow {
        role: role.into(),
        force_error: part.own_gap(),
        simulated_force_error: None,
        noise_floor: part.noise_floor(),
        by_phase,
        transmission: transmission_rows(&part, motion),
        samples,
        compared: motion.load.len(),
        period_s: motion.period.map(|p| p as f64 * motion.decimated_step_s()),
    }
}

/// Lists records by name, each compared with a machine by inverse dynamics.
pub fn list_records(
    loaded: &Loaded,
    (rigid, values): (&Rigid, &[f64]),
    motions: &[MotionSignal],
    which: impl Iterator<Item = usize>,
    fitted: &[usize],
) -> BTreeMap<String, MotionRecordRow> {
    let row = |at: usize| {
        let role = if fitted.contains(&at) { "fit" } else { "held_out" };
        let row = record_row(rigid, &loaded.config.machine, values, &motions[at], loaded.set.motions[at].samples(), role);
        (motions[at].name.clone(), row)
    };
    which.map(row).collect()
}

/// Simulates records in closed loop, and writes the force error into their rows. Returns whether all were simulated to their end.
pub fn add_simulated_gaps(
    rows: &mut BTreeMap<String, MotionRecordRow>,
    (machine, values): (&Machine, &[f64]),
    records: &[&MotionRecord],
    control: &Control,
) -> Result<bool, String> {
    let mut complete = true;
    for (record, gap) in records.iter().zip(simulated_gaps(machine, values, records, control).map_err(to_message)?) {
        complete &= gap.is_some();
        if let (Some(row), Some(gap)) = (rows.get_mut(&record.name), gap) {
            row.simulated_force_error = Some(gap.force);
        }
    }
    Ok(complete)
}

/// Lists records in place of the positions of a document, with the given error as the gap.
pub fn list_positions(
    records: &BTreeMap<String, MotionRecordRow>,
    error: impl Fn(&MotionRecordRow) -> Option<f64>,
) -> BTreeMap<String, PositionRow> {
    let row = |(name, r): (&String, &MotionRecordRow)| {
        let row = PositionRow {
            role: r.role.clone(),
            overall_error: None,
            overall_error_rounded: None,
            overall_error_published: None,
            orders: Vec::new(),
            lone_peaks: Vec::new(),
            gap: error(r),
            noise_floor: r.noise_floor,
        };
        (name.clone(), row)
    };
    records.iter().map(row).collect()
}

/// Lists the residuals of the extra channels of a record, by column.
pub fn transmission_rows(part: &MotionPart, motion: &MotionSignal) -> BTreeMap<String, TransmissionRow> {
    let row = |(part, channel): (&MotionPart, &ExtraChannel)| {
        let row = TransmissionRow {
            unit: channel.unit.into(),
            residual: part.residual_rms(),
            gap: part.own_gap(),
            tracking_gap: part.tracking_gap(),
            compared: part.samples,
        };
        (channel.column.clone(), row)
    };
    part.extra_channels.iter().zip(&motion.extra_channels).map(row).collect()
}

/// Computes the friction curve of records, with the prediction of a machine at each speed.
pub fn curve_rows(rigid: &Rigid, machine: &Machine, values: &[f64], motions: &[&MotionSignal]) -> Vec<CurveRow> {
    let inertia = rigid.inertia(machine, values);
    let all: Vec<CurvePoint> = motions.iter().flat_map(|m| friction_curve(m, inertia)).collect();
    let row = |point: CurvePoint| CurveRow {
        predicted: Some(rigid.steady(machine, values, point.velocity_m_s)),
        record: point.record,
        velocity_m_s: point.velocity_m_s,
        load: point.load,
        sd: point.sd,
    };
    all.into_iter().map(row).collect()
}
