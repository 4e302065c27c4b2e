//! Diagnosis on motion records.

use std::collections::BTreeMap;

use super::DiagnosisRequest;
use super::effects::{at_bound, choose_effects, names_effect, status_words, units, verdict_row};
use super::learnable::learnable;
use super::{FactsDocument, null_row, rule_row};
use crate::motion_records::{curve_rows, transmission_rows};
use crate::{Study, StudyResult};
use diagnosis::motion::{
    MisfitAxis, MisfitCell, MotionDiagnosis, MotionPart, MotionSettings, TriedMotion, diagnose_motion, gap_of,
};
use diagnosis::{VerdictKind, share_closed};
use dynamics::inverse_dynamics::{MotionSignal, Phase, phases};
use machine::{Data, Effect, Machine, Parameter};
use report::diagnosis as document;
use report::record::{ChannelRow, MeasuringChainRow, MisfitRow, MotionRows, TraceRow};
use report::vocabulary::{DataKind, Direction, MisfitBy, Role};

/// Null simulations of motion records per requested one: they are linear and cheap, and p-values need at
/// least 1000.
const NULLS: usize = 25;
/// Most samples of a record in the document, for the page.
const DRAWN: usize = 2500;

impl Study {
    /// As [`Study::diagnose`], on motion records.
    pub(super) fn diagnose_records(
        &self,
        request: &DiagnosisRequest,
    ) -> StudyResult<(document::DiagnosisDocument, Option<FactsDocument>)> {
        let made = self.settings.identification(&self.set)?;
        let machine = &self.config.machine;
        self.check_frozen()?;
        let effects = choose_effects(request, &self.config.effects, Data::Motion);
        let (fit, held_out) = self.set.split_motions(self.fit.as_deref(), &self.hold_out)?;
        let (motions, _, column_warnings) = self.preprocess_all()?;
        let of = |records: &[usize]| records.iter().map(|i| &motions[*i]).collect::<Vec<&MotionSignal>>();
        let (fitted, left) = (of(&fit), of(&held_out));
        let draws = NULLS * request.nulls;
        let settings = MotionSettings { seed: made.seed, draws, all_facts: request.all_facts };
        let found =
            diagnose_motion(machine, &effects, &made.frozen, (&fitted, &left), settings, &self.control)?;
        let mut document = to_document(self, (&fitted, &left), &found, &effects)?;
        if let Some(rows) = &mut document.motion {
            let all: Vec<&MotionSignal> = fitted.iter().chain(&left).copied().collect();
            let before: Vec<&MotionPart> = found.fit.iter().chain(&found.held_out).collect();
            let after: Vec<&MotionPart> = found.chosen_fit.iter().chain(&found.chosen_held_out).collect();
            rows.learnable = learnable(&all, (&before, &after), fitted.len(), made.seed, self.control.stop());
        }
        document.stamp.warnings.splice(0..0, column_warnings);
        let facts = found.judged.map(|(facts, _)| FactsDocument {
            stamp: self.stamp("facts", made.seed, found.complete, Vec::new()),
            verdict: document.verdict.clone(),
            facts,
        });
        Ok((document, facts))
    }
}

fn to_document(
    study: &Study,
    (fit, held_out): (&[&MotionSignal], &[&MotionSignal]),
    found: &MotionDiagnosis,
    effects: &[Effect],
) -> StudyResult<document::DiagnosisDocument> {
    let (before, after) = (gap_of(&found.held_out), gap_of(&found.chosen_held_out));
    let mut warnings: Vec<String> = found.contradictions.iter().map(|c| c.description.clone()).collect();
    let corrected = found
        .force_faults
        .iter()
        .map(|fault| format!("{fault}; gaps and values are those of the corrected records"));
    warnings.extend(corrected);
    if held_out.is_empty() {
        warnings.push(
            "nothing is held out, so that the closed share of the gap is unknown; hold records out".into(),
        );
    }
    if found.contradictions.iter().any(|_| found.verdict.kind != VerdictKind::Measurement) {
        warnings.push("the gap of a held-out record that contradicts the fitted ones contains the fault of its measuring chain".into());
    }
    let closed = after.filter(|_| !held_out.is_empty()).and_then(|_| found.closed(&found.chosen_held_out));
    // A named effect has its own location.
    let named = found
        .verdict
        .first_effect()
        .and_then(|id| effects.iter().find(|e| e.id == id))
        .and_then(Effect::location);
    let places = list_places(found, named.clone());
    let place = named
        .or_else(|| places.first().map(|i| i.interface.clone()))
        .filter(|_| found.verdict.kind != VerdictKind::None);
    let is_named = found.verdict.kind.explains();
    let closed_by = |gap: f64| share_closed(before?, gap, found.floor?);
    let ceiling = found.located.iter().filter_map(|l| closed_by(l.gap_held_out?)).chain(closed);
    let chosen = document::Chosen {
        id: found.chosen.0.id(),
        parameters: named_values(&found.chosen.0.machine, &found.chosen.1),
        gap_held_out: after,
        misfit_over_null: Some(found.excess[1]),
        gap_held_out_with_nuisances: None,
        closed: closed.filter(|_| is_named),
        closed95: found.closed95.filter(|_| is_named).map(|(a, b)| [a, b]),
        ceiling: ceiling.reduce(f64::max),
        headline_metrics: headline_metrics(found),
    };
    Ok(document::DiagnosisDocument {
        stamp: study.stamp("diagnosis", study.settings.seed, found.complete, warnings),
        machine: study.machine_text(),
        manifest: study.manifest(),
        domain: DataKind::Motion,
        described: named_values(&found.nominal.0.machine, &found.nominal.1),
        config: study.config.path.clone(),
        measurements: study.set.path.clone(),
        fit_positions: fit.iter().map(|m| m.name.clone()).collect(),
        held_out_positions: held_out.iter().map(|m| m.name.clone()).collect(),
        noise_floor: found.floor,
        gap: document::GapRow {
            fit: gap_of(&found.fit),
            held_out: before,
            by_position: found.fit.iter().chain(&found.held_out).map(|p| (p.name.clone(), p.gap())).collect(),
            by_phase: by_phase(&found.cells, if held_out.is_empty() { fit } else { held_out }),
            ..document::GapRow::default()
        },
        misfit_over_null: found.excess[0],
        null: found.judged.as_ref().and_then(|(facts, _)| null_row(&facts.null)),
        verdict: document::VerdictRow {
            rule: found.judged.as_ref().map(|(_, judgement)| judgement.rule.into()),
            phase: found.phase.map(|phase| phase.word().into()),
            ..verdict_row(&found.verdict, place)
        },
        places,
        ratio: Vec::new(),
        residual_map: Vec::new(),
        delta_z: Vec::new(),
        motion: Some(motion_rows(study, (fit, held_out), found)?),
        rules: found.judged.iter().flat_map(|(_, judgement)| &judgement.trials).map(rule_row).collect(),
        tolerances: BTreeMap::new(),
        effects: list_effects(found, effects, &chosen),
        chosen,
    })
}

/// Returns the rows of all candidates.
fn list_effects(
    found: &MotionDiagnosis,
    effects: &[Effect],
    chosen: &document::Chosen,
) -> Vec<document::EffectRow> {
    found
        .tried
        .iter()
        .map(|t| {
            let (status, why) = status_words(&t.status);
            let patched = || {
                effects.iter().filter(|effect| effect.id == t.id).flat_map(|effect| &effect.patch.parameters)
            };
            let parameters = of_chosen(t, found, chosen);
            let own =
                parameters.iter().filter_map(|(id, value)| Some((patched().find(|p| p.id == *id)?, *value)));
            let own: Vec<(&Parameter, f64)> = own.collect();
            document::EffectRow {
                id: t.id.clone(),
                status,
                why,
                gap_held_out_before: gap_of(&found.held_out),
                gap_held_out_after: gap_of(&t.held_out),
                closed: if t.held_out.is_empty() { None } else { found.closed(&t.held_out) },
                closed95: found
                    .closed95
                    .filter(|_| found.verdict.effects.first().is_some_and(|first| first.is_only(&t.id)))
                    .map(|(a, b)| [a, b]),
                p_value: t.p_value,
                seen_from: None,
                statistic: t.statistic,
                misfit_reduction: t.gain.max(0.0),
                parameters95: BTreeMap::new(),
                parameter_units: units(&own),
                parameters_at_bound: at_bound(&own),
                parameters,
                // The best amplitude of each shape is computed directly.
                open: false,
                selected: names_effect(&found.verdict, &t.id),
                description: effects.iter().find(|e| e.id == t.id).map(|e| e.description.clone()),
            }
        })
        .collect()
}

/// Returns the parameters of a candidate: of an effect of the chosen model those of the joint fit.
fn of_chosen(
    tried: &TriedMotion,
    found: &MotionDiagnosis,
    chosen: &document::Chosen,
) -> BTreeMap<String, f64> {
    let is_chosen = found.chosen.0.effects.contains(&tried.id);
    let joint = |id: &String| chosen.parameters.get(id).filter(|_| is_chosen).copied();
    tried.parameters.iter().map(|(id, own)| (id.clone(), joint(id).unwrap_or(*own))).collect()
}

/// Interfaces and columns where a free function reduces the residual most. The named effect comes first, at
/// its location.
fn list_places(found: &MotionDiagnosis, named: Option<String>) -> Vec<document::WhereRow> {
    let named = named.filter(|_| found.verdict.kind.explains()).map(|interface| document::WhereRow {
        interface,
        over: None,
        shape: document::NAMED.into(),
        misfit_reduction: 1.0 - found.loss,
        gap_held_out: gap_of(&found.chosen_held_out).filter(|_| !found.held_out.is_empty()),
    });
    named
        .into_iter()
        .chain(found.located.iter().map(|l| document::WhereRow {
            interface: l.interface.clone(),
            over: Some(match &l.column {
                None => l.over.into(),
                Some(column) => format!("{} of {column}", l.over),
            }),
            shape: l.shape.into(),
            misfit_reduction: l.gain.max(0.0),
            gap_held_out: l.gap_held_out,
        }))
        .collect()
}

/// Returns the values of a machine's parameters by id.
fn named_values(machine: &Machine, values: &[f64]) -> BTreeMap<String, f64> {
    machine.parameters.iter().map(|p| p.id.clone()).zip(values.iter().copied()).collect()
}

/// Returns the gap by phase over all held-out records, or over the fitted ones where none is held out.
fn by_phase(cells: &[MisfitCell], of: &[&MotionSignal]) -> BTreeMap<String, f64> {
    let mut found: BTreeMap<String, Vec<(f64, usize)>> = BTreeMap::new();
    for cell in cells.iter().filter(|c| c.direction == 0 && of.iter().any(|m| m.name == c.record)) {
        if let MisfitAxis::Phase(phase) = cell.kind {
            let of = cell.column.as_ref().map_or(String::new(), |column| format!(" of {column}"));
            found.entry(format!("{}{of}", phase.word())).or_default().push((cell.gap, cell.samples));
        }
    }
    let mean = |parts: Vec<(f64, usize)>| numeric::statistics::root_mean_square_of_parts(parts);
    found.into_iter().filter_map(|(name, parts)| Some((name, mean(parts)?))).collect()
}

/// Returns the force error of each record, before and after.
fn headline_metrics(found: &MotionDiagnosis) -> Vec<document::HeadlineMetrics> {
    let pairs =
        found.fit.iter().zip(&found.chosen_fit).chain(found.held_out.iter().zip(&found.chosen_held_out));
    let channels = pairs.flat_map(|(b, a)| b.channels().zip(a.channels()));
    let row = |(b, a): (&MotionPart, &MotionPart)| match b.tracking_gap().zip(a.tracking_gap()) {
        Some((before, after)) => document::HeadlineMetrics {
            figure: format!("tracking error of {} in {}", b.column, b.name),
            before,
            after,
        },
        None => document::HeadlineMetrics {
            figure: format!("force error of {}", b.name),
            before: b.own_gap(),
            after: a.own_gap(),
        },
    };
    channels.map(row).collect()
}

fn motion_rows(
    study: &Study,
    (fit, held_out): (&[&MotionSignal], &[&MotionSignal]),
    found: &MotionDiagnosis,
) -> StudyResult<MotionRows> {
    let machine = &found.chosen.0.machine;
    let rigid = study.rigid_model()?;
    let all: Vec<&MotionSignal> = fit.iter().chain(held_out).copied().collect();
    let befores: Vec<&MotionPart> = found.fit.iter().chain(&found.held_out).collect();
    let afters: Vec<&MotionPart> = found.chosen_fit.iter().chain(&found.chosen_held_out).collect();
    let role = |name: &str| Role::of(fit.iter().any(|m| m.name == name));
    let cells = found.cells.iter().map(|c| {
        let (by, phase, range) = match c.kind {
            MisfitAxis::Phase(phase) => (MisfitBy::Phase, Some(phase.word().to_string()), None),
            MisfitAxis::Speed(a, b) => (MisfitBy::SpeedMS, None, Some([a, b])),
            MisfitAxis::Position(a, b) => (MisfitBy::PositionM, None, Some([a, b])),
        };
        MisfitRow {
            record: c.record.clone(),
            column: c.column.clone(),
            by,
            phase,
            range,
            direction: [Direction::Backward, Direction::Both, Direction::Forward][(c.direction + 1) as usize],
            samples: c.samples,
            gap: c.gap,
            share: c.share,
            mean: c.mean,
        }
    });
    let records = found.shifts.iter().map(|s| {
        let gap =
            |parts: &[&MotionPart]| parts.iter().find(|p| p.name == s.name).map_or(f64::NAN, |p| p.own_gap());
        MeasuringChainRow {
            record: s.name.clone(),
            role: role(&s.name),
            gap_before: gap(&befores),
            gap_after: gap(&afters),
            gap_own_chain: s.gap_own,
            delay_s: s.delay_s,
            delay95_s: [s.delay_s - s.delay_half95_s, s.delay_s + s.delay_half95_s],
            factor: s.gain.exp(),
        }
    });
    let transmission = befores.iter().zip(&afters).zip(&all).flat_map(|((before, after), motion)| {
        let rows =
            transmission_rows(before, motion).into_iter().zip(transmission_rows(after, motion).into_values());
        let weights: BTreeMap<&str, f64> =
            before.extra_channels.iter().map(|f| (f.column.as_str(), f.weight)).collect();
        let record = motion.name.clone();
        rows.map(move |((column, before), after)| {
            let weight = weights.get(column.as_str()).copied().unwrap_or_default();
            ChannelRow { record: record.clone(), column, weight, before, after }
        })
    });
    let transmission = transmission.collect();
    let traces = all
        .iter()
        .zip(befores.iter().zip(&afters))
        .map(|(motion, (before, after))| trace(motion, before, after));
    Ok(MotionRows {
        unit: if all.first().is_some_and(|m| m.load_column == "torque_nm") { "N*m" } else { "N" }.into(),
        misfit_map: cells.collect(),
        records: records.collect(),
        contradictions: found.contradictions.iter().map(|c| c.description.clone()).collect(),
        friction_curve: curve_rows(&rigid, machine, &found.chosen.1, fit),
        phases: phase_names(),
        traces: traces.collect(),
        transmission,
        learnable: Vec::new(),
    })
}

/// Returns a record for the page: one period where it repeats.
fn trace(motion: &MotionSignal, before: &MotionPart, after: &MotionPart) -> TraceRow {
    let whole = motion.period.unwrap_or(motion.load.len());
    let every = whole.div_ceil(DRAWN);
    let phases = phases(motion);
    let kept: Vec<usize> = motion.kept().collect();
    let at: Vec<usize> = (0..whole).step_by(every).collect();
    let rounded = |x: &[f64]| at.iter().map(|i| (1e4 * x[*i]).round() / 1e4).collect::<Vec<f64>>();
    TraceRow {
        record: motion.name.clone(),
        time_s: at.iter().map(|i| (1e6 * kept[*i] as f64 * motion.step_s).round() / 1e6).collect(),
        measured: rounded(&before.recorded),
        before: rounded(&before.residual),
        after: rounded(&after.residual),
        phase: at.iter().map(|i| phases[kept[*i]] as u8).collect(),
    }
}

/// Returns the names of phases in their order.
fn phase_names() -> Vec<String> {
    Phase::ALL.iter().map(|p| p.word().to_string()).collect()
}
