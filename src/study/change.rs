//! Changes between two identifications of one machine, such as before and after a collision.

use std::collections::BTreeMap;
use std::path::Path;

use crate::identified::{check_current, check_identification};
use crate::joint_fit::{ASSUMED_SCATTER, Joint};
use crate::stamp::stamp_files;
use crate::{StudyError, StudyResult};
use config::read_machine_text;
use identification::narrow_width;
use machine::{Machine, Scale};
use numeric::distribution::{normal_upper_tail, t_quantile_95};
use report::certainty::{PosteriorRow, ResidualRow};
use report::change::{ChangeDocument, ChangeRow};
use report::document::{IdentificationDocument, Input};
use report::vocabulary::ObjectiveKind;

/// Probability of claiming any change where nothing changed (1).
const LEVEL: f64 = 0.05;

/// Sets two identifications of one machine side by side, and tests which parameters changed.
///
/// Both fits share the machine's tolerances and the error of its model: a table heavier than described shifts
/// the stiffnesses of both alike. The two are therefore fitted jointly, to first order, with tolerances and
/// model errors in common (`Joint`). The change has the covariance of this joint fit. Gains, delays and nut
/// positions belong to each measurement. Several minima: the least significant pair counts.
///
/// Compared are parameters that are identifiable in both, and those whose change is: it has as narrow an
/// interval, and is no larger than that, so that it is not the step to another minimum. What makes the value
/// less certain, such as the model's error, is common to both.
///
/// # Errors  a result is incomplete, of another version, or has no covariance; the two are of unlike
///   machines.
///
/// # Source  p-values over several parameters: Holm, Scand. J. Stat. 6 (1979) 65–70.
pub fn compare_results(
    first: (&IdentificationDocument, &Input),
    second: (&IdentificationDocument, &Input),
) -> StudyResult<(Machine, ChangeDocument)> {
    let (a, b) = (posterior(first)?, posterior(second)?);
    let machine = common_machine(first, second)?;
    let joint = Joint::new(&machine, a, b);
    let pairs = (0..a.minima.len()).flat_map(|x| (0..b.minima.len()).map(move |y| [x, y]));
    let changes: Vec<Vec<(f64, f64)>> =
        pairs.map(|pair| joint.changes(pair)).collect::<Option<_>>().ok_or_else(|| {
            StudyError::impossible("the covariances of the two results cannot be combined; identify again")
        })?;
    // The noise is known: the quantile is that of the normal distribution.
    let half = t_quantile_95(None);
    let is_determined = |at: usize| {
        let (id, index) = &joint.own[at];
        let (change, sd) = changes[0][at];
        [first.0, second.0].iter().filter_map(|document| document.parameters.get(id)).all(|row| {
            let mut values = machine.start();
            values[*index] = row.value;
            let widest = 0.5 * narrow_width(&machine.parameters, &values, *index);
            // What a stated number shifts, it shifts in both.
            row.identifiable == Some(true)
                || row.depends_on_discrepancy
                || (row.lower < row.value
                    && row.value < row.upper
                    && half * sd <= widest
                    && change.abs() <= widest)
        })
    };
    let z_of = |(change, sd): &(f64, f64)| if *sd > 0.0 { (change / sd).abs() } else { 0.0 };
    let mut p_values: Vec<(usize, f64)> = (0..joint.own.len())
        .filter(|at| is_determined(*at))
        .map(|at| {
            (
                at,
                2.0 * normal_upper_tail(
                    changes.iter().map(|pair| z_of(&pair[at])).fold(f64::INFINITY, f64::min),
                ),
            )
        })
        .collect();
    p_values.sort_by(|x, y| x.1.total_cmp(&y.1));
    let compared = p_values.len();
    let mut adjusted: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    let mut largest = 0.0_f64;
    for (rank, (at, p)) in p_values.iter().enumerate() {
        largest = largest.max(((compared - rank) as f64 * p).min(1.0));
        adjusted.insert(*at, (*p, largest));
    }
    let row = |(at, (id, index)): (usize, &(String, usize))| {
        let parameter = &machine.parameters[*index];
        let (change, sd) = changes[0][at];
        let relative = parameter.scale == Scale::Logarithmic;
        let amount = |by: f64| match relative {
            true => (by * (parameter.upper / parameter.lower).ln()).exp_m1(),
            false => by * (parameter.upper - parameter.lower),
        };
        let p = adjusted.get(&at);
        let value = |document: &IdentificationDocument| {
            document.parameters.get(id).map_or(parameter.start, |row| row.value)
        };
        let row = ChangeRow {
            first: value(first.0),
            second: value(second.0),
            unit: parameter.unit.clone(),
            change: amount(change),
            change95: [amount(change - half * sd), amount(change + half * sd)],
            relative,
            p_value: p.map(|p| p.0),
            p_adjusted: p.map(|p| p.1),
            changed: p.is_some_and(|p| p.1 <= LEVEL),
        };
        (id.clone(), row)
    };
    let document = ChangeDocument {
        stamp: stamp_files(
            "change",
            vec![first.1.clone(), second.1.clone()],
            warnings([first, second], &joint),
        ),
        level: LEVEL,
        compared,
        common: joint.common.iter().map(|(name, _, _)| name.clone()).collect(),
        common_model_errors: joint.common_errors(),
        parameters: joint.own.iter().enumerate().map(row).collect(),
    };
    Ok((machine, document))
}

/// Warns of several minima, and of common frequencies whose scatter is assumed.
fn warnings(results: [(&IdentificationDocument, &Input); 2], joint: &Joint<'_>) -> Vec<String> {
    let minima = |of: usize| results[of].0.posterior.as_ref().map_or(0, |posterior| posterior.minima.len());
    let (first, second) = (minima(0), minima(1));
    let minima = (first * second > 1).then(|| {
        format!(
            "the results have {first} and {second} minima: a change counts only where it is significant between all of them"
        )
    });
    let assumed = results.into_iter().zip(joint.assumed_scatters()).filter(|(_, count)| *count > 0);
    let scatter = assumed.map(|((document, input), count)| {
        format!(
            "{}: the table of modes of {} does not state the scatter of {count} of the compared frequencies: {:.1} % is assumed; state it as frequency_sd_hz and identify again",
            input.path,
            document.settings.measurements,
            100.0 * ASSUMED_SCATTER
        )
    });
    minima.into_iter().chain(scatter).collect()
}

/// Returns the posterior of a result that can be compared.
fn posterior<'d>((document, file): (&'d IdentificationDocument, &Input)) -> StudyResult<&'d PosteriorRow> {
    let fault = |text: String| StudyError::input(&file.path, text);
    check_identification(Path::new(&file.path), document)?;
    check_current(&file.path, &document.stamp, ("identification", "identify"))?;
    let found = document.posterior.as_ref().ok_or_else(|| {
        fault(
            "lacks the covariance of what was fitted (posterior): it is of motion records, of eq26, or of an older version; identify again"
                .into(),
        )
    })?;
    let count = found.coordinates.len();
    let is_whole = found.covariance.len() == count
        && found.covariance.iter().enumerate().all(|(at, row)| row.len() == at + 1);
    let is_at = !found.minima.is_empty() && found.minima.iter().all(|place| place.len() == count);
    let is_fitted = |r: &ResidualRow| r.slopes.len() == count && r.deviations.len() == found.minima.len();
    if is_whole && is_at && found.residuals.iter().all(is_fitted) {
        Ok(found)
    } else {
        Err(fault("is damaged: the sizes of its posterior disagree; identify again".into()))
    }
}

/// Returns the machine that both results describe.
fn common_machine(
    first: (&IdentificationDocument, &Input),
    second: (&IdentificationDocument, &Input),
) -> StudyResult<Machine> {
    let (a, b) = (first.0, second.0);
    let Some(text) = &a.machine else {
        return Err(StudyError::input(&first.1.path, "embeds no machine; identify again"));
    };
    let same_text = b.machine.as_ref().is_some_and(|other| other.text == text.text);
    let same = same_text && (&a.stamp.overrides, &a.stamp.without) == (&b.stamp.overrides, &b.stamp.without);
    let fitted = |document: &IdentificationDocument| {
        (
            document.settings.freeze.clone(),
            document.settings.lumps,
            document.settings.objective == ObjectiveKind::Frf,
        )
    };
    if !same || fitted(a) != fitted(b) {
        let what = if same {
            "frozen parameters, model or objective"
        } else {
            "text, overrides or removed effects of the description"
        };
        let fault = format!(
            "is of another machine than {}: {what} differ; identify both with the same description and settings",
            first.1.path
        );
        return Err(StudyError::input(&second.1.path, fault));
    }
    Ok(read_machine_text(&text.path, &text.text, &a.stamp.overrides, &a.stamp.without)?.machine)
}

#[cfg(test)]
mod tests;
