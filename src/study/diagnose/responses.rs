//! Diagnosis on FRFs, or on modes.

use std::collections::BTreeMap;
use std::path::PathBuf;

use file_access::{MOST_DOCUMENT_BYTES, read_text};

use super::effects::{at_bound, choose_effects, names_effect, status_words, units, verdict_row};
use super::residual_map::{by_band, by_mode, delta_z, ratios, residual_map};
use super::{DiagnosisRequest, FactsDocument};
use super::{null_row, rule_row};
use crate::{Study, StudyError, StudyResult, document_rows};
use diagnosis::{
    Ablation, Diagnosis, DiagnosisSettings, Domain, Fitted, Hypothesis, HypothesisKind, PartialGap,
    VerdictKind, closed, closed_interval, diagnose, explanations, fitter, floor_over, gap_over,
    implausibility, peak_errors, places, relaxes_within, stated_id, values_of,
};
use long_work::{found_in, kept_as};
use machine::{Data, Effect, Parameter, TargetKind};
use measurement::{FitSet, HoldOutSet};
use report::diagnosis as document;
use report::vocabulary::DataKind;
use report::{OutputFolder, digest};

/// Least and largest value.
type Range = (f64, f64);

impl Study {
    /// As [`Study::diagnose`], on FRFs or modes.
    pub(super) fn diagnose_responses(
        &self,
        request: &DiagnosisRequest,
    ) -> StudyResult<(document::DiagnosisDocument, FactsDocument)> {
        let made = self.identification_settings()?;
        let (fit, held_out) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let machine = &self.config.machine;
        let whole = made.frf.is_some();
        self.check_commanded()?;
        let mut effects = choose_effects(request, &self.config.effects, Data::Frf);
        // FRFs of a force do not depend on the loops.
        effects.retain(|effect| self.is_commanded() || !acts_on_loops_alone(effect));
        let blocks = fit.leave_one_out(whole).len();
        if blocks < 2 && (!whole || machine.stroke_m().is_some()) {
            let fault = format!(
                "diagnosis needs at least two positions (or records) to fit, {blocks} {} named: at one position any interface explains any \
                 FRF; name for example l1,l3 as positions",
                if blocks == 1 { "is" } else { "are" }
            );
            return Err(StudyError::input(&self.set.path, fault));
        }
        let domain = made.frf.map_or(Domain::Modes(made.settings), Domain::Frf);
        let mut ablated = request.ablated.clone();
        if !made.tolerances {
            ablated.push(Ablation::NoNuisances);
        }
        let fitter = fitter(&fit, domain, &made.frozen, &ablated);
        let cache = self.cache_file(request, &effects);
        let null = cache.as_ref().and_then(|(folder, file)| {
            found_in(&read_text(&folder.join(file), MOST_DOCUMENT_BYTES).ok()?, file)
        });
        let cached = null.is_some();
        let (seed, draws, all_facts) = (made.seed, request.nulls, request.all_facts);
        // Whoever names candidates asks for no others.
        let library = match request.effects.is_empty() {
            true => Effect::for_data(&self.config.effects, Data::Frf).cloned().collect(),
            false => Vec::new(),
        };
        let settings = DiagnosisSettings { seed, draws, null, all_facts, library };
        let found = diagnose(machine, &effects, &fitter, &held_out, &settings, &self.control)?;
        let interval = closed_interval(&fitter, &held_out, &found, settings.seed, &self.control);
        if let Some((folder, file)) = cache.filter(|_| !cached && found.complete) {
            // A cache that cannot be written costs time, not the result.
            let _ = kept_as(&file, &found.facts.null).map(|line| {
                OutputFolder::prepare(&folder).and_then(|folder| folder.write(&file, line.as_bytes()))
            });
        }
        let document = to_document(self, (&fit, &held_out), &found, (interval, fitter.band_hz()), &effects)?;
        let facts = FactsDocument {
            stamp: self.stamp("facts", made.seed, found.complete, Vec::new()),
            verdict: document.verdict.clone(),
            facts: found.facts,
        };
        Ok((document, facts))
    }

    /// Folder and file of the cached null distribution of this machine, these data and this build; `None`
    /// without a cache.
    fn cache_file(&self, request: &DiagnosisRequest, effects: &[Effect]) -> Option<(PathBuf, String)> {
        let folder = request.cache.folder()?;
        // Everything on which null simulations depend enters: settings as a whole, and effects with their
        // ranges.
        let DiagnosisRequest { effects: _, exclude: _, nulls, cache: _, ablated, all_facts: _ } = request;
        let key = self.key(&format!("null distribution {nulls} {ablated:?} {effects:?}"));
        Some((folder, format!("null-{}.json", &digest(key.as_bytes())[..24])))
    }
}

/// Whether an effect changes numbers of the drive alone.
fn acts_on_loops_alone(effect: &Effect) -> bool {
    let patch = &effect.patch;
    let adds = !patch.points.is_empty() || !patch.joints.is_empty() || !patch.reattached.is_empty();
    !adds
        && !patch.rescales.is_empty()
        && patch.rescales.iter().all(|(target, ..)| target.kind == TargetKind::Drive)
}

fn to_document(
    study: &Study,
    (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    found: &Diagnosis,
    (interval, band_hz): (Option<Range>, Option<Range>),
    effects: &[Effect],
) -> StudyResult<document::DiagnosisDocument> {
    let whole = matches!(found.domain, Domain::Frf(_));
    let names =
        |positions: &[usize], frfs: &[usize]| document_rows::names(&study.set, positions, frfs, whole);
    let before = gap_over(&found.held_out);
    let map = residual_map(study, (fit, held_out), found)?;
    let advice = "if it is right, an effect beyond this verdict is missing";
    let mut warnings: Vec<String> = found.tolerances.iter().filter_map(|t| t.warning(advice)).collect();
    warnings.extend(whole.then(|| document_rows::noise_warnings(&study.set)).into_iter().flatten());
    if !whole {
        warnings.push("natural frequencies and amplitudes say little about damping and mode shapes: effects that whole FRFs distinguish may remain ambiguous".into());
    }
    if held_out.is_empty() {
        warnings.push("nothing is held out, so that the closed share of the gap is unknown; hold positions or records out".into());
    }
    let chosen = chosen_row(held_out, found, interval)?;
    let is_missing = !matches!(found.judgement.verdict.kind, VerdictKind::None | VerdictKind::Insufficient);
    let explanations = explanations(&found.facts).unwrap_or_default();
    Ok(document::DiagnosisDocument {
        stamp: study.stamp("diagnosis", study.settings.seed, found.complete, warnings),
        machine: study.machine_text(),
        manifest: study.manifest(),
        domain: if whole { DataKind::Frf } else { DataKind::Modes },
        config: study.config.path.clone(),
        measurements: study.set.path.clone(),
        fit_positions: names(fit.positions(), fit.frfs()),
        held_out_positions: names(held_out.positions(), held_out.frfs()),
        noise_floor: floor_over(if found.held_out.is_empty() { &found.fit } else { &found.held_out }),
        gap: document::GapRow {
            fit: gap_over(&found.fit),
            held_out: before,
            by_position: by_position(study, found.fit.iter().chain(&found.held_out)),
            by_band: by_band(&map),
            by_mode: by_mode((fit, held_out), found)?,
            ..document::GapRow::default()
        },
        misfit_over_null: found.excess,
        null: null_row(&found.facts.null),
        verdict: document::VerdictRow {
            band_hz: found.location.band_hz,
            rule: Some(found.judgement.rule.into()),
            places: if is_missing { places(&explanations) } else { Vec::new() },
            ..verdict_row(&found.judgement.verdict, found.location.interface.clone())
        },
        places: list_places(found),
        ratio: ratios(&map),
        residual_map: map,
        delta_z: delta_z(found),
        motion: None,
        tolerances: document_rows::tolerances(&found.tolerances),
        effects: list_effects(found, interval, &[effects, &found.numbers].concat(), band_hz),
        described: {
            let (hypothesis, fitted) = &found.described;
            hypothesis
                .machine
                .parameters
                .iter()
                .map(|p| p.id.clone())
                .zip(values_of(hypothesis, fitted))
                .collect()
        },
        rules: found.judgement.trials.iter().map(rule_row).collect(),
        chosen,
    })
}

/// Says why a fitted effect may stand for another one: its fit does not agree with its meaning, or a relaxation
/// has its corner outside the band (Hz) of the data.
fn doubt_about(hypothesis: &Hypothesis, fitted: &Fitted, band_hz: Option<Range>) -> Option<String> {
    let implausible = implausibility(hypothesis, fitted);
    if implausible.is_some() {
        return implausible;
    }
    let (from_hz, to_hz) = band_hz.filter(|band_hz| !relaxes_within(hypothesis, fitted, *band_hz))?;
    Some(format!(
        "its corner frequency is outside the band, {from_hz:.1} to {to_hz:.0} Hz, where it is hardly different from a spring or a damper"
    ))
}

/// Returns the rows of all candidates.
fn list_effects(
    found: &Diagnosis,
    interval: Option<Range>,
    effects: &[Effect],
    band_hz: Option<Range>,
) -> Vec<document::EffectRow> {
    found
        .tried
        .iter()
        // What describes a named effect in more detail stands in the row of that effect.
        .filter(|t| {
            let id = &t.candidate.id;
            t.candidate.fitted.is_some()
                || names_effect(&found.judgement.verdict, id)
                || !found.chosen.0.effects.contains(id)
        })
        .map(|t| {
            let (status, why) = status_words(&t.candidate.status);
            // The row of an effect that is named alone is that of the chosen model.
            let is_named_first =
                found.judgement.verdict.effects.first().is_some_and(|first| first.is_only(&t.candidate.id));
            let is_chosen = is_named_first && found.chosen.0.effects.first() == Some(&t.candidate.id);
            let (fitted, held_out, gain) = match is_chosen {
                true => (
                    Some(&found.chosen),
                    &found.chosen_held_out,
                    found.nominal.1.chi_square - found.chosen.1.chi_square,
                ),
                false => (t.candidate.fitted.as_ref(), &t.held_out, t.candidate.gain),
            };
            let why = why
                .or_else(|| fitted.and_then(|(hypothesis, fitted)| doubt_about(hypothesis, fitted, band_hz)));
            let is_selected = names_effect(&found.judgement.verdict, &t.candidate.id);
            // Of the effects of the chosen model the values are those of the joint fit.
            let is_joint = is_selected && found.chosen.0.effects.contains(&t.candidate.id);
            let own: Vec<(&Parameter, f64)> = fitted.map_or_else(Vec::new, |(hypothesis, fitted)| {
                let values = values_of(hypothesis, fitted);
                let joint = values_of(&found.chosen.0, &found.chosen.1);
                let value = |at: usize| {
                    let id = &hypothesis.machine.parameters[at].id;
                    let same = found.chosen.0.machine.parameter(id).filter(|_| is_joint);
                    same.map_or(values[at], |same| joint[same])
                };
                hypothesis.added.iter().map(|i| (&hypothesis.machine.parameters[*i], value(*i))).collect()
            });
            let stated = |id: &str| stated_id(id).to_string();
            document::EffectRow {
                id: t.candidate.id.clone(),
                status,
                why,
                gap_held_out_before: gap_over(&found.held_out),
                gap_held_out_after: gap_over(held_out),
                closed: fitted.and_then(|_| closed(&found.held_out, held_out)),
                closed95: interval.filter(|_| is_chosen).map(|(a, b)| [a, b]),
                p_value: fitted.map(|_| t.p_value),
                seen_from: {
                    let mut all = found.facts.null.seen_from.iter();
                    all.find(|(id, _)| *id == t.candidate.id).map(|(_, change)| *change)
                },
                statistic: t.statistic,
                misfit_reduction: gain / found.nominal.1.chi_square,
                parameters: own.iter().map(|(p, value)| (stated(&p.id), *value)).collect(),
                parameters95: {
                    let named = |id: &String| is_joint && own.iter().any(|(p, _)| p.id == *id);
                    let all = found.intervals.iter().filter(|(id, _)| named(id));
                    all.map(|(id, (low, high))| (stated(id), [*low, *high])).collect()
                },
                parameter_units: units(&own),
                parameters_at_bound: at_bound(&own),
                open: fitted.is_some_and(|(_, fitted)| fitted.found < 2),
                selected: is_selected,
                description: effects.iter().find(|e| e.id == t.candidate.id).map(|e| e.description.clone()),
            }
        })
        .collect()
}

/// Returns the interfaces where a generic impedance reduces χ² most.
fn list_places(found: &Diagnosis) -> Vec<document::WhereRow> {
    // The named effect comes first, at its location.
    let named = found.location.interface.clone().filter(|_| found.judgement.verdict.kind.explains()).map(
        |interface| document::WhereRow {
            interface,
            over: None,
            shape: document::NAMED.into(),
            misfit_reduction: 1.0 - found.chosen.1.chi_square / found.nominal.1.chi_square,
            gap_held_out: gap_over(&found.chosen_held_out),
        },
    );
    named
        .into_iter()
        .chain(found.located.iter().filter_map(|l| match &l.candidate.fitted.as_ref()?.0.kind {
            HypothesisKind::Interface { interface, shape } => Some(document::WhereRow {
                interface: interface.clone(),
                over: None,
                shape: shape.word().into(),
                misfit_reduction: l.candidate.gain / found.nominal.1.chi_square,
                gap_held_out: gap_over(&l.held_out),
            }),
            _ => None,
        }))
        .collect()
}

/// Returns the chosen model and the share of the gap that it closes.
fn chosen_row(
    held_out: &HoldOutSet<'_>,
    found: &Diagnosis,
    interval: Option<(f64, f64)>,
) -> StudyResult<document::Chosen> {
    let ceiling = found
        .located
        .iter()
        .filter_map(|l| closed(&found.held_out, &l.held_out))
        .chain(closed(&found.held_out, &found.chosen_held_out));
    let chosen_values = values_of(&found.explained.0, &found.explained.1);
    Ok(document::Chosen {
        id: found.chosen.0.id(),
        parameters: found
            .explained
            .0
            .machine
            .parameters
            .iter()
            .map(|p| p.id.clone())
            .zip(chosen_values)
            .collect(),
        gap_held_out: gap_over(&found.chosen_held_out),
        misfit_over_null: Some(found.chosen_excess),
        gap_held_out_with_nuisances: found
            .gaps_with_nuisances
            .as_ref()
            .map(|each| each.each_ref().map(|parts| gap_over(parts))),
        closed: closed(&found.held_out, &found.chosen_held_out),
        closed95: interval.map(|(a, b)| [a, b]),
        ceiling: ceiling.reduce(f64::max),
        headline_metrics: headline_metrics(held_out, found)?,
    })
}

fn position_name(study: &Study, part: &PartialGap) -> String {
    let position = part.position.map(|p| study.set.positions[p].name.clone());
    let record = || part.frf.and_then(|f| study.set.frfs[f].record.clone());
    position.or_else(record).unwrap_or_else(|| "all".into())
}

fn by_position<'p>(study: &Study, parts: impl Iterator<Item = &'p PartialGap>) -> BTreeMap<String, f64> {
    let mut groups: BTreeMap<String, Vec<PartialGap>> = BTreeMap::new();
    for part in parts {
        groups.entry(position_name(study, part)).or_default().push(part.clone());
    }
    groups.into_iter().filter_map(|(name, parts)| Some((name, gap_over(&parts)?))).collect()
}

/// Returns the errors of the highest resonance of held-out FRFs, before and after: frequency, damping ratio,
/// peak compliance.
fn headline_metrics(
    held_out: &HoldOutSet<'_>,
    found: &Diagnosis,
) -> StudyResult<Vec<document::HeadlineMetrics>> {
    let Domain::Frf(settings) = found.domain else { return Ok(Vec::new()) };
    if held_out.frfs().is_empty() {
        return Ok(Vec::new());
    }
    let errors = |(hypothesis, fitted): &(Hypothesis, Fitted)| {
        peak_errors(hypothesis, fitted, held_out, settings).map_err(StudyError::from)
    };
    let (Some(before), Some(after)) = (errors(&found.described)?, errors(&found.explained)?) else {
        return Ok(Vec::new());
    };
    let row = |what: &str, before: f64, after: f64| document::HeadlineMetrics {
        figure: format!("{what}, rms error at held-out positions"),
        before,
        after,
    };
    let mut rows = vec![row("frequency of the highest resonance", before.frequency, after.frequency)];
    rows.extend(
        before.damping.zip(after.damping).map(|(before, after)| row("its damping ratio", before, after)),
    );
    rows.push(row("its peak compliance", before.height, after.height));
    Ok(rows)
}
