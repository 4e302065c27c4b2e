//! Preprocesses motion records, and lists results on them as rows of documents.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::{Study, StudyError, StudyResult};
use diagnosis::motion::{MisfitAxis, MotionPart, misfit_map, part};
use dynamics::inverse_dynamics::{CurvePoint, ExtraChannel, MotionSignal, Rigid, friction_curve};
use identification::motion::simulated_gaps;
use identification::objective::point_named;
use long_work::Control;
use machine::Machine;
use measurement::{MeasurementSet, MotionRecord};
use numeric::parallel::OrFirstError;
use report::document::PositionRow;
use report::record::{CurveRow, MotionRecordRow, TransmissionRow};
use report::vocabulary::Role;

/// Returns the names of records.
pub(crate) fn names(set: &MeasurementSet, records: &[usize]) -> Vec<String> {
    records.iter().map(|i| set.motions[*i].name.clone()).collect()
}

impl Study {
    /// Preprocesses all records, in the order of the set. Returns them with the rigid machine and the
    /// warnings about their columns.
    pub(crate) fn preprocess_all(&self) -> StudyResult<(Vec<MotionSignal>, Rigid, Vec<String>)> {
        let made: Result<Vec<MotionSignal>, _> =
            self.set.motions.par_iter().map(MotionSignal::of).or_first_error();
        self.add_channels(made?)
    }

    /// Adds the extra channels of the set's records to their preprocessed motions. Returns them with the
    /// rigid machine and the warnings about their columns.
    pub fn add_channels(
        &self,
        made: Vec<MotionSignal>,
    ) -> StudyResult<(Vec<MotionSignal>, Rigid, Vec<String>)> {
        let rigid = self.rigid_model()?;
        let machine = &self.config.machine;
        made.iter().try_for_each(|m| rigid.check(machine, m))?;
        let named = |name: &String| point_named(machine, &self.set.path, "response", name);
        let response = self.set.response.as_ref().map(named).transpose()?;
        let (mut motions, mut warnings) = (Vec::new(), Vec::new());
        for (motion, record) in made.into_iter().zip(&self.set.motions) {
            let (motion, column_warnings) = motion.with_points(record, machine, &rigid)?;
            motions.push(motion.with_reconstructed_encoder(response, record, machine, &rigid)?);
            warnings.extend(column_warnings);
        }
        Ok((motions, rigid, warnings))
    }

    /// Builds the rigid-body model of the machine.
    pub(crate) fn rigid_model(&self) -> StudyResult<Rigid> {
        let machine = &self.config.machine;
        Rigid::new(machine, &machine.start()).map_err(|e| StudyError::input(&self.config.path, e.to_string()))
    }
}

/// Compares a record with a machine by inverse dynamics.
fn record_row(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    motion: &MotionSignal,
    samples: usize,
    role: Role,
) -> MotionRecordRow {
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
        role,
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
pub(crate) fn list_records(
    study: &Study,
    (rigid, values): (&Rigid, &[f64]),
    motions: &[MotionSignal],
    which: impl Iterator<Item = usize>,
    fitted: &[usize],
) -> BTreeMap<String, MotionRecordRow> {
    let row = |at: usize| {
        let role = Role::of(fitted.contains(&at));
        let row = record_row(
            rigid,
            &study.config.machine,
            values,
            &motions[at],
            study.set.motions[at].samples(),
            role,
        );
        (motions[at].name.clone(), row)
    };
    which.map(row).collect()
}

/// Simulates records in closed loop, and writes the force error into their rows. Returns whether all were
/// simulated to their end.
pub(crate) fn add_simulated_gaps(
    rows: &mut BTreeMap<String, MotionRecordRow>,
    (machine, values): (&Machine, &[f64]),
    records: &[&MotionRecord],
    control: &Control,
) -> StudyResult<bool> {
    let mut complete = true;
    for (record, gap) in records.iter().zip(simulated_gaps(machine, values, records, control)?) {
        complete &= gap.is_some();
        if let (Some(row), Some(gap)) = (rows.get_mut(&record.name), gap) {
            row.simulated_force_error = Some(gap.force);
        }
    }
    Ok(complete)
}

/// Lists records in place of the positions of a document, with the given error as the gap.
pub(crate) fn list_positions(
    records: &BTreeMap<String, MotionRecordRow>,
    error: impl Fn(&MotionRecordRow) -> Option<f64>,
) -> BTreeMap<String, PositionRow> {
    let row = |(name, r): (&String, &MotionRecordRow)| {
        (name.clone(), PositionRow::of_gap(r.role, error(r), r.noise_floor))
    };
    records.iter().map(row).collect()
}

/// Lists the residuals of the extra channels of a record, by column.
pub(crate) fn transmission_rows(
    part: &MotionPart,
    motion: &MotionSignal,
) -> BTreeMap<String, TransmissionRow> {
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
pub(crate) fn curve_rows(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    motions: &[&MotionSignal],
) -> Vec<CurveRow> {
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
