//! `jointid diagnose` on motion records.

use std::collections::BTreeMap;

use super::arguments::DiagnoseArguments;
use super::effects::{at_bound, choose_effects, names_effect, status_words, units, verdict_row};
use super::learnable::learnable;
use crate::long_work::{control, finish, on_threads};
use crate::motion_records::{curve_rows, preprocess_all, rigid_model, transmission_rows};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::search::{check_frozen, plan};
use crate::sources::{Loaded, stamp};
use diagnosis::VerdictKind;
use diagnosis::motion::{MisfitAxis, MisfitCell, MotionDiagnosis, MotionPart, MotionSettings, diagnose_motion, gap_of};
use dynamics::inverse_dynamics::{MotionSignal, Phase, phases};
use machine::{Data, Effect, Machine, Parameter};
use report::diagnosis as document;
use report::record::{ChannelRow, MeasuringChainRow, MisfitRow, MotionRows, TraceRow, motion_diagnosis_text};

/// Null simulations of motion records per one of `--nulls`: they are cheap.
const NULLS: usize = 10;
/// Most samples of a record in the document, for the page.
const DRAWN: usize = 2500;

/// Runs the command.
pub fn run(given: &DiagnoseArguments, loaded: &Loaded) -> CommandResult {
    let plan = plan(&given.search, &loaded.set)?;
    let machine = &loaded.config.machine;
    check_frozen(loaded, &plan.frozen)?;
    let effects = choose_effects(given, &loaded.config.effects, Data::Motion)?;
    let (fit, held_out) = loaded.set.split_motions(given.split.positions.as_deref(), &given.split.hold_out).map_err(to_message)?;
    let (motions, _, told_of) = preprocess_all(loaded)?;
    let folder = prepare(&given.output)?;
    let of = |records: &[usize]| records.iter().map(|i| &motions[*i]).collect::<Vec<&MotionSignal>>();
    let (fitted, left) = (of(&fit), of(&held_out));
    let settings = MotionSettings { seed: plan.seed, draws: NULLS * usize::from(given.nulls) };
    let progress = WorkProgress::begin(given.output.quiet, "diagnose");
    let control = control(&given.output, folder.as_ref(), &progress, loaded)?;
    let ran = on_threads(given.search.threads, || diagnose_motion(machine, &effects, &plan.frozen, (&fitted, &left), settings, &control))?;
    progress.end();
    let found = ran.map_err(to_message)?;
    let mut document = to_document(given, loaded, (&fitted, &left), &found, &effects)?;
    if let Some(rows) = &mut document.motion {
        let all: Vec<&MotionSignal> = fitted.iter().chain(&left).copied().collect();
        let before: Vec<&MotionPart> = found.fit.iter().chain(&found.held_out).collect();
        let after: Vec<&MotionPart> = found.chosen_fit.iter().chain(&found.chosen_held_out).collect();
        rows.learnable = learnable(&all, (&before, &after), fitted.len(), plan.seed, control.stop());
    }
    document.stamp.warnings.splice(0..0, told_of);
    warn(&given.output, &document.stamp.warnings);
    let text = format!("{}\n{}", machine.title, motion_diagnosis_text(&document));
    deliver(&given.output, folder.as_ref(), "diagnosis.json", &document, &text)?;
    Ok(finish(&given.output, &control, found.complete))
}

fn to_document(
    given: &DiagnoseArguments,
    loaded: &Loaded,
    (fit, held_out): (&[&MotionSignal], &[&MotionSignal]),
    found: &MotionDiagnosis,
    effects: &[Effect],
) -> Result<document::DiagnosisDocument, String> {
    let (before, after) = (gap_of(&found.held_out), gap_of(&found.chosen_held_out));
    let mut warnings: Vec<String> = found.contradictions.iter().map(|c| c.description.clone()).collect();
    if held_out.is_empty() {
        warnings.push("nothing is held out, so that the closed share of the gap is unknown; hold records out with --hold-out".into());
    }
    if found.contradictions.iter().any(|_| found.verdict.kind != VerdictKind::Measurement) {
        warnings.push("the gap of a held-out record that contradicts the fitted ones contains the fault of its measuring chain".into());
    }
    let closed = after.filter(|_| !held_out.is_empty()).and_then(|_| found.closed(&found.chosen_held_out));
    let places = list_places(found);
    // A named effect has its own location.
    let named = found.verdict.first_effect().and_then(|id| effects.iter().find(|e| e.id == id)).and_then(Effect::location);
    let place = named.or_else(|| places.first().map(|i| i.interface.clone())).filter(|_| found.verdict.kind != VerdictKind::None);
    let is_named = found.verdict.kind.explains();
    let ceiling = found.tried.iter().filter(|t| !t.held_out.is_empty()).filter_map(|t| found.closed(&t.held_out)).chain(closed);
    let chosen = document::Chosen {
        id: found.chosen.0.id(),
        parameters: named_values(&found.chosen.0.machine, &found.chosen.1),
        gap_held_out: after,
        misfit_over_null: None,
        gap_held_out_with_nuisances: None,
        closed: closed.filter(|_| is_named),
        closed95: found.closed95.filter(|_| is_named).map(|(a, b)| [a, b]),
        ceiling: ceiling.reduce(f64::max),
        headline_metrics: headline_metrics(found),
    };
    Ok(document::DiagnosisDocument {
        stamp: stamp("diagnosis", given.search.seed, found.complete, loaded, warnings),
        domain: "motion".into(),
        described: named_values(&found.nominal.0.machine, &found.nominal.1),
        config: given.sources.config.clone(),
        measurements: given.sources.measurements.clone(),
        fit_positions: fit.iter().map(|m| m.name.clone()).collect(),
        held_out_positions: held_out.iter().map(|m| m.name.clone()).collect(),
        noise_floor: found.floor,
        gap: document::GapRow {
            fit: gap_of(&found.fit),
            held_out: before,
            by_position: found.fit.iter().chain(&found.held_out).map(|p| (p.name.clone(), p.gap())).collect(),
            by_band: Vec::new(),
            by_mode: Vec::new(),
            by_phase: by_phase(&found.cells, if held_out.is_empty() { fit } else { held_out }),
        },
        misfit_over_null: match (gap_of(&found.fit), found.floor_fit) {
            (Some(gap), Some(floor)) if floor > 0.0 => (gap / floor).powi(2),
            _ => 0.0,
        },
        verdict: document::VerdictRow { phase: found.phase.map(|phase| phase.word().into()), ..verdict_row(&found.verdict, place) },
        places,
        ratio: Vec::new(),
        residual_map: Vec::new(),
        delta_z: Vec::new(),
        motion: Some(motion_rows(loaded, (fit, held_out), found)?),
        tolerances: BTreeMap::new(),
        effects: list_effects(found, effects, &chosen),
        chosen,
    })
}

/// Returns the rows of all candidates.
fn list_effects(found: &MotionDiagnosis, effects: &[Effect], chosen: &document::Chosen) -> Vec<document::EffectRow> {
    found
        .tried
        .iter()
        .map(|t| {
            let (status, why) = status_words(&t.status);
            let patched = || effects.iter().filter(|effect| effect.id == t.id).flat_map(|effect| &effect.patch.parameters);
            let own = t.parameters.iter().filter_map(|(id, value)| Some((patched().find(|p| p.id == *id)?, *value)));
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
                statistic: t.gain,
                misfit_reduction: t.gain.max(0.0),
                parameters: t.parameters.iter().cloned().collect(),
                parameter_units: units(&own),
                parameters_at_bound: at_bound(&own, found.chosen.0.effects.contains(&t.id).then_some(&chosen.parameters)),
                selected: names_effect(&found.verdict, &t.id),
                description: effects.iter().find(|e| e.id == t.id).map(|e| e.description.clone()),
            }
        })
        .collect()
}

/// Interfaces and columns where a free function reduces the residual most.
fn list_places(found: &MotionDiagnosis) -> Vec<document::WhereRow> {
    found
        .located
        .iter()
        .map(|l| document::WhereRow {
            interface: l.interface.clone(),
            over: Some(match &l.column {
                None => l.over.into(),
                Some(column) => format!("{} of {column}", l.over),
            }),
            shape: l.shape.into(),
            misfit_reduction: l.gain.max(0.0),
            gap_held_out: None,
        })
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
    let pairs = found.fit.iter().zip(&found.chosen_fit).chain(found.held_out.iter().zip(&found.chosen_held_out));
    let channels = pairs.flat_map(|(b, a)| b.channels().zip(a.channels()));
    let row = |(b, a): (&MotionPart, &MotionPart)| match b.tracking_gap().zip(a.tracking_gap()) {
        Some((before, after)) => {
            document::HeadlineMetrics { figure: format!("tracking error of {} in {}", b.column, b.name), before, after }
        }
        None => document::HeadlineMetrics { figure: format!("force error of {}", b.name), before: b.own_gap(), after: a.own_gap() },
    };
    channels.map(row).collect()
}

fn motion_rows(
    loaded: &Loaded,
    (fit, held_out): (&[&MotionSignal], &[&MotionSignal]),
    found: &MotionDiagnosis,
) -> Result<MotionRows, String> {
    let machine = &found.chosen.0.machine;
    let rigid = rigid_model(loaded)?;
    let all: Vec<&MotionSignal> = fit.iter().chain(held_out).copied().collect();
    let befores: Vec<&MotionPart> = found.fit.iter().chain(&found.held_out).collect();
    let afters: Vec<&MotionPart> = found.chosen_fit.iter().chain(&found.chosen_held_out).collect();
    let role = |name: &str| if fit.iter().any(|m| m.name == name) { "fit" } else { "held_out" };
    let cells = found.cells.iter().map(|c| {
        let (by, phase, range) = match c.kind {
            MisfitAxis::Phase(phase) => ("phase", Some(phase.word().to_string()), None),
            MisfitAxis::Speed(a, b) => ("speed_m_s", None, Some([a, b])),
            MisfitAxis::Position(a, b) => ("position_m", None, Some([a, b])),
        };
        MisfitRow {
            record: c.record.clone(),
            column: c.column.clone(),
            by: by.into(),
            phase,
            range,
            direction: ["backward", "both", "forward"][(c.direction + 1) as usize].into(),
            samples: c.samples,
            gap: c.gap,
            share: c.share,
            mean: c.mean,
        }
    });
    let records = found.shifts.iter().map(|s| {
        let gap = |parts: &[&MotionPart]| parts.iter().find(|p| p.name == s.name).map_or(f64::NAN, |p| p.own_gap());
        MeasuringChainRow {
            record: s.name.clone(),
            role: role(&s.name).into(),
            gap_before: gap(&befores),
            gap_after: gap(&afters),
            gap_own_chain: s.gap_own,
            delay_s: s.delay_s,
            delay95_s: [s.delay_s - s.delay_half95_s, s.delay_s + s.delay_half95_s],
            factor: s.gain.exp(),
        }
    });
    let transmission = befores.iter().zip(&afters).zip(&all).flat_map(|((before, after), motion)| {
        let rows = transmission_rows(before, motion).into_iter().zip(transmission_rows(after, motion).into_values());
        let weights: BTreeMap<&str, f64> = before.extra_channels.iter().map(|f| (f.column.as_str(), f.weight)).collect();
        let record = motion.name.clone();
        rows.map(move |((column, before), after)| {
            let weight = weights.get(column.as_str()).copied().unwrap_or_default();
            ChannelRow { record: record.clone(), column, weight, before, after }
        })
    });
    let transmission = transmission.collect();
    let traces = all.iter().zip(befores.iter().zip(&afters)).map(|(motion, (before, after))| trace(motion, before, after));
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
