//! Changes between two identifications of one machine, such as before and after a collision.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{DMatrix, DVector};

use crate::identified::{check_current, check_identification};
use crate::stamp::stamp_files;
use crate::{StudyError, StudyResult};
use config::read_machine_text;
use machine::{Machine, Scale};
use numeric::distribution::{normal_upper_tail, t_quantile_95};
use report::certainty::PosteriorRow;
use report::change::{ChangeDocument, ChangeRow};
use report::document::{IdentificationDocument, Input, ParameterRow};
use report::vocabulary::ObjectiveKind;

/// Probability of claiming any change where nothing changed (1).
const LEVEL: f64 = 0.05;

/// Sets two identifications of one machine side by side, and tests which parameters changed.
///
/// Both fits share the machine's tolerances: a table heavier than described shifts the stiffnesses of both
/// alike. The two are therefore fitted jointly, to first order: χ² of each is the parabola of its minimum and
/// covariance, the tolerances are common, and their prior counts once. The change has the covariance of this
/// joint fit. Gains, delays and nut positions belong to each measurement. Several minima: the least
/// significant pair counts.
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
    let pairs = a.minima.iter().flat_map(|x| b.minima.iter().map(move |y| (x, y)));
    let changes: Vec<Vec<(f64, f64)>> =
        pairs.map(|(x, y)| joint.changes(x, y)).collect::<Option<_>>().ok_or_else(|| {
            StudyError::impossible("the covariances of the two results cannot be combined; identify again")
        })?;
    // What a stated number shifts, it shifts in both.
    let is_narrow = |row: &ParameterRow| row.identifiable == Some(true) || row.depends_on_discrepancy;
    let is_identifiable = |id: &str| {
        [first.0, second.0].iter().all(|document| document.parameters.get(id).is_some_and(is_narrow))
    };
    let z_of = |(change, sd): &(f64, f64)| if *sd > 0.0 { (change / sd).abs() } else { 0.0 };
    let mut p_values: Vec<(usize, f64)> = (0..joint.own.len())
        .filter(|at| is_identifiable(&joint.own[*at].0))
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
    // The noise is known: the quantile is that of the normal distribution.
    let half = t_quantile_95(None);
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
    let minima = a.minima.len() * b.minima.len();
    let warnings = (minima > 1).then(|| {
        format!(
            "the results have {} and {} minima: a change counts only where it is significant between all of them",
            a.minima.len(),
            b.minima.len()
        )
    });
    let document = ChangeDocument {
        stamp: stamp_files("change", vec![first.1.clone(), second.1.clone()], warnings.into_iter().collect()),
        level: LEVEL,
        compared,
        common: joint.common.iter().map(|(name, _, _)| name.clone()).collect(),
        parameters: joint.own.iter().enumerate().map(row).collect(),
    };
    Ok((machine, document))
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
    if is_whole && is_at {
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

/// The joint fit of two results with common tolerances.
struct Joint {
    /// Parameters that are fitted in both: id, index in the machine.
    own: Vec<(String, usize)>,
    /// Common tolerances: name, standard deviation and centre of the prior in the unit interval.
    common: Vec<(String, f64, f64)>,
    /// Column of the joint state of each coordinate of the first and the second result.
    columns: [Vec<usize>; 2],
    /// Inverse covariance of each result.
    precision: [Option<DMatrix<f64>>; 2],
    size: usize,
}

impl Joint {
    fn new(machine: &Machine, a: &PosteriorRow, b: &PosteriorRow) -> Self {
        let names = |of: &PosteriorRow| of.coordinates.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        let (in_a, in_b) = (names(a), names(b));
        let own: Vec<(String, usize)> = in_a
            .iter()
            .filter(|id| in_b.contains(id))
            .filter_map(|id| Some((id.clone(), machine.parameter(id)?)))
            .collect();
        let tolerance = |c: &report::certainty::CoordinateRow| {
            let [centre, sd] = c.prior.filter(|_| c.of_machine && machine.parameter(&c.name).is_none())?;
            in_b.contains(&c.name).then(|| (c.name.clone(), sd, centre))
        };
        let common: Vec<(String, f64, f64)> = a.coordinates.iter().filter_map(tolerance).collect();
        // Joint state: own parameters of the first and of the second result, common tolerances, then what
        // belongs to one of them.
        let mut size = 2 * own.len() + common.len();
        let mut columns = |names: &[String], which: usize| -> Vec<usize> {
            let column = |name: &String| {
                let of_own = own.iter().position(|(id, _)| id == name).map(|at| which * own.len() + at);
                let of_common = common.iter().position(|(id, _, _)| id == name).map(|at| 2 * own.len() + at);
                of_own.or(of_common).unwrap_or_else(|| {
                    size += 1;
                    size - 1
                })
            };
            names.iter().map(column).collect()
        };
        let columns = [columns(&in_a, 0), columns(&in_b, 1)];
        let precision = [a, b].map(|of| {
            let entry = |row: usize, column: usize| of.covariance[row.max(column)][row.min(column)];
            DMatrix::from_fn(of.coordinates.len(), of.coordinates.len(), entry).try_inverse()
        });
        Joint { own, common, columns, precision, size }
    }

    /// Computes the change of each own parameter, and its standard deviation, between two minima. `None`
    /// where a covariance is singular.
    fn changes(&self, first: &[f64], second: &[f64]) -> Option<Vec<(f64, f64)>> {
        let mut information: DMatrix<f64> = DMatrix::zeros(self.size, self.size);
        let mut target: DVector<f64> = DVector::zeros(self.size);
        for ((columns, precision), place) in self.columns.iter().zip(&self.precision).zip([first, second]) {
            let precision = precision.as_ref()?;
            let pull = precision * DVector::from_row_slice(place);
            for (row, i) in columns.iter().enumerate() {
                target[*i] += pull[row];
                columns
                    .iter()
                    .enumerate()
                    .for_each(|(column, j)| information[(*i, *j)] += precision[(row, column)]);
            }
        }
        for (at, (_, sd, centre)) in self.common.iter().enumerate() {
            let i = 2 * self.own.len() + at;
            information[(i, i)] -= 1.0 / (sd * sd);
            target[i] -= centre / (sd * sd);
        }
        let covariance: DMatrix<f64> = information.try_inverse()?;
        let state: DVector<f64> = &covariance * target;
        let count = self.own.len();
        let change = |at: usize| {
            let variance = covariance[(at, at)] + covariance[(count + at, count + at)]
                - 2.0 * covariance[(at, count + at)];
            (state[count + at] - state[at], variance.max(0.0).sqrt())
        };
        Some((0..count).map(change).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::certainty::CoordinateRow;

    /// One parameter and one common tolerance t ~ N(0.5, 0.1): each result measures θ + t alone, to 0.01.
    fn result(sum: f64) -> PosteriorRow {
        let (measured, prior, range) = (1e4, 1e2, 12.0);
        let information =
            DMatrix::from_row_slice(2, 2, &[measured + range, measured, measured, measured + prior]);
        let covariance = information.try_inverse().unwrap();
        let coordinate = |name: &str, prior| CoordinateRow { name: name.into(), of_machine: true, prior };
        PosteriorRow {
            coordinates: vec![coordinate("k_n", None), coordinate("mass of table", Some([0.5, 0.1]))],
            minima: vec![vec![sum - 0.5, 0.5]],
            covariance: (0..2)
                .map(|row| (0..=row).map(|column| covariance[(row, column)]).collect())
                .collect(),
            variance: 1.0,
        }
    }

    #[test]
    fn limit_common_tolerances_do_not_count_as_a_difference() {
        let machine = crate::read_machine("configs/tian.toml").unwrap().machine;
        let (a, b) = (result(0.9), result(0.95));
        let (change, sd) = Joint::new(&machine, &a, &b).changes(&a.minima[0], &b.minima[0]).unwrap()[0];
        // θ alone is known to 0.1, its change to √2·0.01.
        assert!((change - 0.05).abs() < 2e-3 && (sd - 2_f64.sqrt() * 0.01).abs() < 5e-4, "{change} ± {sd}");
    }
}
