//! Identification from motion records.

use std::collections::BTreeMap;

use crate::document_rows::parameter_row;
use crate::motion_records::{add_simulated_gaps, curve_rows, list_positions, list_records, names};
use crate::{Study, StudyError, StudyResult};
use dynamics::inverse_dynamics::{
    InverseError, MotionSignal, Preprocessing, free_parameters, parameters_without_influence, recorded,
};
use identification::motion::{
    ForceFit, SingleFrequency, SmallPrint, ToleranceSize, TolerantFit, correlation, estimate_weighted,
    estimate_with_tolerances, output_error,
};
use identification::{Doubt, Estimate, idle_priors};
use long_work::Control;
use machine::Machine;
use measurement::MotionRecord;
use report::certainty::{PriorRow, ToleranceRow};
use report::document::{IdentificationDocument, ParameterRow, RunSettings};
use report::record::{MotionRecordRow, PreprocessingRow};
use report::vocabulary::{ObjectiveKind, PriorKind, Role};

impl Study {
    /// As [`Study::identify`], from motion records.
    pub(super) fn identify_from_records(&self) -> StudyResult<IdentificationDocument> {
        let simulated = match self.settings.objective {
            None | Some(ObjectiveKind::InverseDynamics) => false,
            Some(ObjectiveKind::OutputError) => true,
            Some(_) => {
                let fault = format!(
                    "{} holds only motion records; write inverse-dynamics or output-error",
                    self.set.path
                );
                return Err(StudyError::setting("objective", "", fault));
            }
        };
        let made = self.settings.identification(&self.set)?;
        let machine = &self.config.machine;
        self.check_frozen()?;
        let (fit, held_out) = self.set.split_motions(self.fit.as_deref(), &self.hold_out)?;
        let (fit, held_out) = (&fit[..], &held_out[..]);
        let (mut motions, rigid, mut warnings) = self.preprocess_all()?;
        let asked = free_parameters(machine, &made.frozen)?;
        let unseen = parameters_without_influence(
            &rigid,
            machine,
            &asked,
            &fit.iter().map(|i| &motions[*i]).collect::<Vec<&MotionSignal>>(),
        );
        let free: Vec<usize> = asked.into_iter().filter(|i| !unseen.contains(i)).collect();
        // Without a parameter to fit the records are compared with the start values.
        let (refined, tolerant) = (simulated && !free.is_empty(), made.tolerances && !free.is_empty());
        let mut found = estimate_weighted(&rigid, machine, &free, &mut motions, fit, &self.control)?;
        let (mut complete, mut tolerances, mut doubts) = (true, BTreeMap::new(), Vec::new());
        warnings.extend(idle_priors(machine, &[], "motion records are fitted without priors"));
        let mut estimates;
        let fitted: Vec<&MotionSignal> = fit.iter().map(|i| &motions[*i]).collect();
        if refined {
            self.control.begin("simulate");
            (found, estimates) = refine_by_simulation(self, (&free, found), (fit, &motions), &self.control)?;
            complete = found.converged;
        } else if tolerant {
            let tolerant = estimate_with_tolerances(&rigid, machine, found, &fitted);
            tolerances = tolerance_rows(&tolerant, fitted[0].load_column);
            let advice = |doubt: &Doubt| {
                format!("values depend on {doubt}; run diagnose to find the effect that the machine lacks")
            };
            warnings.extend(tolerant.doubts.iter().map(advice));
            (found, estimates, doubts) = (tolerant.fit, tolerant.estimates, tolerant.doubts);
        } else {
            estimates = found.estimates(machine, &free, &fitted);
        }
        let shown_nowhere = |i: &usize| Estimate::without_interval(*i, found.values[*i], Some(false));
        estimates.extend(unseen.iter().map(shown_nowhere));
        let values = &found.values;
        let mut records = list_records(self, (&rigid, values), &motions, 0..motions.len(), fit);
        if simulated {
            let all: Vec<&MotionRecord> = self.set.motions.iter().collect();
            complete &= add_simulated_gaps(&mut records, (machine, values), &all, &self.control)?;
        }
        let error =
            |r: &MotionRecordRow| if simulated { r.simulated_force_error } else { Some(r.force_error) };
        let level = if refined {
            let all = fit.iter().flat_map(|i| self.set.motions[*i].load.samples());
            all.map(|x| x * x).sum::<f64>()
        } else {
            recorded(&fitted).norm_squared()
        };
        if lacks_samples(&found, &estimates) {
            warnings.push(too_few_samples(&fitted));
        }
        warnings.extend(found.single_frequency.as_ref().map(|single| inseparable(machine, single)));
        warnings.extend(list_warnings(machine, &unseen, &estimates));
        Ok(IdentificationDocument {
            stamp: self.stamp("identification", made.seed, complete, warnings),
            machine: self.machine_text(),
            manifest: self.manifest(),
            settings: RunSettings {
                objective: if simulated {
                    ObjectiveKind::OutputError
                } else {
                    ObjectiveKind::InverseDynamics
                },
                ..self.run_settings(&made)
            },
            parameters: parameter_rows(machine, values, (&estimates, &doubts)),
            tolerances,
            derived: derived(&records, error),
            cost: found.squares / level,
            evaluations: found.evaluations,
            fitted_parameters: free.iter().map(|i| machine.parameters[*i].id.clone()).collect(),
            correlation: correlation(&found.derivatives),
            fit_positions: names(&self.set, fit),
            held_out_positions: names(&self.set, held_out),
            positions: list_positions(&records, error),
            preprocessing: motions.first().map(|m| recipe_row(&m.preprocessing)),
            friction_curve: curve_rows(&rigid, machine, values, &fitted),
            records,
            ..IdentificationDocument::default()
        })
    }
}

/// Refines the estimate of inverse dynamics by simulating the closed loop.
fn refine_by_simulation(
    study: &Study,
    (free, found): (&[usize], ForceFit),
    (fit, motions): (&[usize], &[MotionSignal]),
    control: &Control,
) -> Result<(ForceFit, Vec<Estimate>), InverseError> {
    let machine = &study.config.machine;
    let records: Vec<&MotionRecord> = fit.iter().map(|i| &study.set.motions[*i]).collect();
    let closed = output_error(machine, &found.values, free, &records, control)?;
    let length = |i: &usize| {
        (study.set.motions[*i].samples(), motions[*i].period.map(|p| p * motions[*i].preprocessing.factor))
    };
    let lengths: Vec<(usize, Option<usize>)> = fit.iter().map(length).collect();
    let refined = ForceFit {
        evaluations: found.evaluations + closed.evaluations,
        single_frequency: found.single_frequency,
        ..closed
    };
    let estimates = refined.estimates_of(machine, free, &lengths);
    Ok((refined, estimates))
}

/// Whether no value of a fit has an interval that should have one: those at a bound, and inertias at a single frequency,
/// lack it whatever the samples.
fn lacks_samples(found: &ForceFit, estimates: &[Estimate]) -> bool {
    let is_open = |e: &&Estimate| {
        let single = found.single_frequency.as_ref();
        found.free.contains(&e.parameter)
            && !e.at_bound
            && single.is_none_or(|single| !single.parameters.contains(&e.parameter))
    };
    let mut open = estimates.iter().filter(is_open).peekable();
    open.peek().is_some() && open.all(|e| e.interval95.is_none())
}

/// Says why the values of a fit have no intervals.
fn too_few_samples(motions: &[&MotionSignal]) -> String {
    let sum = |of: &dyn Fn(&MotionSignal) -> usize| motions.iter().map(|m| of(m)).sum::<usize>();
    let kept = sum(&|m| m.is_moving.iter().filter(|moves| **moves).count());
    let repeated = if motions.iter().any(|m| m.period.is_some()) {
        "; those of moves that repeat count once"
    } else {
        ""
    };
    format!(
        "too few samples for intervals: of {} in motion {} are far enough from a rest, and {kept} remain after decimation{repeated}; record longer moves, or more that differ",
        sum(&|m| m.moving()),
        sum(&|m| m.used())
    )
}

/// Says which inertias motions at a single frequency leave open, and what determines them.
fn inseparable(machine: &Machine, single: &SingleFrequency) -> String {
    let ids: Vec<&str> = single.parameters.iter().map(|i| machine.parameters[*i].id.as_str()).collect();
    format!(
        "not identifiable: {}; these records move at a single frequency, {:.2} Hz, at which a force in proportion to position acts as inertia does: record a second frequency, or a travel with ramps",
        ids.join(", "),
        single.frequency_hz
    )
}

/// Returns warnings about parameters that the records do not determine, and about those at a bound.
fn list_warnings(machine: &Machine, unseen: &[usize], estimates: &[Estimate]) -> Vec<String> {
    let ids: Vec<&str> = unseen.iter().map(|i| machine.parameters[*i].id.as_str()).collect();
    let nowhere = (!ids.is_empty()).then(|| {
        format!("not identifiable from force and extra channels, held at the start value: {}", ids.join(", "))
    });
    let at_end = estimates.iter().filter(|e| e.at_bound).map(|e| {
        let p = &machine.parameters[e.parameter];
        format!("{} lies at a bound of its range, {} … {} {}", p.id, p.lower, p.upper, p.unit)
    });
    nowhere.into_iter().chain(at_end).collect()
}

fn parameter_rows(
    machine: &Machine,
    values: &[f64],
    (estimates, doubts): (&[Estimate], &[Doubt]),
) -> BTreeMap<String, ParameterRow> {
    let row = |at: usize| {
        let found = estimates.iter().find(|e| e.parameter == at);
        let held = Estimate::without_interval(at, values[at], None);
        (
            machine.parameters[at].id.clone(),
            parameter_row(machine, (found.unwrap_or(&held), doubts), found.is_some()),
        )
    };
    (0..machine.parameters.len()).map(row).collect()
}

/// Returns the tolerances of a fit: delay and friction at reversals by their values, the others by their
/// sizes.
fn tolerance_rows(fit: &TolerantFit, load_column: &str) -> BTreeMap<String, ToleranceRow> {
    let force = if load_column == "torque_nm" { "N*m" } else { "N" };
    let row = |size: &ToleranceSize| {
        let unit = if size.kind == SmallPrint::Delay { "s" } else { force };
        let kind = if size.kind.is_sized() { PriorKind::HalfNormal } else { PriorKind::Normal };
        let prior = PriorRow { mean: 0.0, sd: size.kind.prior_sd() * size.stated, kind };
        (
            size.kind.name().to_string(),
            ToleranceRow {
                unit: unit.into(),
                prior,
                value: size.value * size.stated,
                sd: size.sd * size.stated,
            },
        )
    };
    fit.sizes.iter().map(row).collect()
}

fn derived(
    records: &BTreeMap<String, MotionRecordRow>,
    error: impl Fn(&MotionRecordRow) -> Option<f64>,
) -> BTreeMap<String, f64> {
    let over = |role: Role| {
        let own = records.values().filter(|r| r.role == role).filter_map(|r| Some((error(r)?, r.compared)));
        numeric::statistics::root_mean_square_of_parts(own)
    };
    [("gap_fit", over(Role::Fit)), ("gap_held_out", over(Role::HeldOut))]
        .into_iter()
        .filter_map(|(k, x)| Some((k.to_string(), x?)))
        .collect()
}

fn recipe_row(recipe: &Preprocessing) -> PreprocessingRow {
    PreprocessingRow {
        cutoff_hz: recipe.cutoff_hz,
        order: recipe.order,
        dropped: recipe.dropped,
        decimation: recipe.factor,
    }
}
