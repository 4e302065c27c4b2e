//! Discrimination of rival machines by planned measurements.
//!
//! Of two models whose misfits are close, a further measurement decides if the misfit of the wrong one
//! exceeds that of the right one by a limit. For Gaussian noise the difference has the mean λ and the
//! variance 4λ, with λ the least misfit of the wrong model to the noise-free prediction of the right one. The
//! wrong model may adjust its parameters as far as earlier data, priors and ranges allow, to first order.
//!
//! # Source  Atkinson and Fedorov, The design of experiments for discriminating between two rival models,
//!   Biometrika 62 (1975) 57–70.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::measurement_plan::{FrfPlan, coordinates_of, embedded, planned_frfs, prior_information, union};
use super::uncertainty::RANGE_SD;
use crate::objective::{FrfObjective, FrfSettings, ModeObjective, ModeSettings, ModeSquares, ObjectiveError};
use machine::{Machine, ParameterValues, State};
use measurement::{FitSet, MeasurementSet};
use numeric::distribution::normal_upper_tail;
use optimizer::{LeastSquares, NormalEquations};

/// One of the machines that explain the data alike, fitted to them.
#[derive(Debug, Clone, PartialEq)]
pub struct RivalMachine {
    /// Its effects, joined with `+`.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// Its fitted values.
    pub values: ParameterValues,
}

/// Normal equations and the parameters of their columns.
type Normal = (NormalEquations, Vec<usize>);

/// How well planned measurements discriminate between rival machines.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrimination {
    /// Information of the data that are there, with priors and ranges, by rival.
    earlier: Vec<DMatrix<f64>>,
    /// Misfit of rival `[b]` to what rival `[a]` predicts for the candidate `[c]`: indices c, a, b.
    misfits: Vec<Vec<Vec<NormalEquations>>>,
    /// Difference of χ² above which a rival is rejected.
    limit: f64,
    /// Factor of the variance of the noise, by the misfit of the present model.
    variance: f64,
}

impl Discrimination {
    /// Predicts the candidates of [`PlanDesign::of_frfs`](super::PlanDesign::of_frfs) by all rivals.
    ///
    /// # Errors  as [`FrfObjective::new`].
    pub fn of_frfs(
        rivals: &[RivalMachine],
        (earlier, frozen): (&FitSet<'_>, &[String]),
        among: (&[(String, String)], &[State]),
        plan: FrfPlan,
        (settings, modes): (FrfSettings, Option<ModeSettings>),
        (limit, variance): (f64, f64),
    ) -> Result<Self, ObjectiveError> {
        let set: &MeasurementSet = earlier.set();
        let known = rivals.iter().map(|rival| match modes {
            Some(modes) => {
                let objective = ModeObjective::new(&rival.machine, earlier, modes, frozen)?;
                let place = objective.extended(&coordinates_of(
                    &rival.machine,
                    &objective.free,
                    &rival.values,
                    false,
                ));
                Ok((ModeSquares::new(&objective, None).normal(&place), objective.free.clone()))
            }
            None => {
                let objective = FrfObjective::new(&rival.machine, earlier, settings, frozen)?;
                let place = coordinates_of(
                    &rival.machine,
                    &objective.free,
                    &rival.values,
                    objective.estimates_gain(),
                );
                Ok((objective.normal(&place), objective.free.clone()))
            }
        });
        let known: Vec<Normal> = known.collect::<Result<_, ObjectiveError>>()?;
        // By truth, rival and candidate.
        let mut found: Vec<Vec<Vec<Normal>>> = Vec::new();
        for truth in rivals {
            let (made, _) = planned_frfs(&truth.machine, &truth.values, set, among, plan)?;
            let (all, _) = made.split(None, &[]).map_err(|error| ObjectiveError::Data(error.to_string()))?;
            let of_rival = |rival: &RivalMachine| -> Result<Vec<Normal>, ObjectiveError> {
                let in_states: Vec<Machine> = among
                    .1
                    .iter()
                    .map(|state| Ok(rival.machine.in_state(*state)?))
                    .collect::<Result<_, ObjectiveError>>()?;
                let of = |(index, machine): (usize, &Machine)| {
                    let objective =
                        FrfObjective::new(machine, &all.with_frfs(|at| at == index), settings, frozen)?;
                    let place =
                        coordinates_of(machine, &objective.free, &rival.values, objective.estimates_gain());
                    Ok((
                        without_prior(objective.normal(&place), machine, &objective.free, &rival.values),
                        objective.free.clone(),
                    ))
                };
                (0..made.frfs.len()).zip(in_states.iter().cycle()).map(of).collect()
            };
            found.push(rivals.iter().map(of_rival).collect::<Result<_, _>>()?);
        }
        let free: Vec<Vec<usize>> = (0..rivals.len())
            .map(|b| {
                union(
                    found
                        .iter()
                        .flat_map(|of| of[b].iter().map(|(_, free)| &free[..]))
                        .chain([&known[b].1[..]]),
                )
            })
            .collect();
        let whole = |(normal, own): &Normal, b: usize| embedded(normal, own, &free[b]);
        let candidates = found.first().map_or(0, |of| of[0].len());
        let misfits: Vec<Vec<Vec<NormalEquations>>> = (0..candidates)
            .map(|c| {
                found
                    .iter()
                    .map(|of| of.iter().enumerate().map(|(b, all)| whole(&all[c], b)).collect())
                    .collect()
            })
            .collect();
        let size = |b: usize| misfits.first().map_or(free[b].len(), |of| of[b][b].gradient.len());
        let earlier = known
            .iter()
            .enumerate()
            .map(|(b, known)| padded(&(whole(known, b).information / variance), size(b)))
            .collect();
        Ok(Discrimination { earlier, misfits, limit, variance })
    }

    /// Returns the least misfit λ of rival b to what rival a predicts for some candidates.
    fn noncentrality(&self, which: &[usize], a: usize, b: usize) -> f64 {
        let mut information = self.earlier[b].clone();
        let mut gradient: DVector<f64> = DVector::zeros(information.nrows());
        let mut chi_square = 0.0;
        for candidate in which {
            let misfit = &self.misfits[*candidate][a][b];
            chi_square += misfit.chi_square / self.variance;
            gradient += &misfit.gradient / self.variance;
            information += &misfit.information / self.variance;
        }
        match Cholesky::new(information) {
            Some(factor) => (chi_square - gradient.dot(&factor.solve(&gradient))).max(0.0),
            None => 0.0,
        }
    }

    /// Returns the probability (a lower bound) that some candidates leave one rival alone, averaged over the
    /// rivals as truth.
    pub fn settled(&self, which: &[usize]) -> f64 {
        let count = self.earlier.len();
        let of_truth = |a: usize| {
            let missed = (0..count)
                .filter(|b| *b != a)
                .map(|b| 1.0 - rejected(self.noncentrality(which, a, b), self.limit));
            (1.0 - missed.sum::<f64>()).max(0.0)
        };
        (0..count).map(of_truth).sum::<f64>() / count.max(1) as f64
    }
}

/// Returns the probability that a difference of χ² with this noncentrality exceeds a limit.
fn rejected(noncentrality: f64, limit: f64) -> f64 {
    if noncentrality > 0.0 {
        normal_upper_tail((limit - noncentrality) / (2.0 * noncentrality.sqrt()))
    } else {
        0.0
    }
}

/// Subtracts the misfit of the priors, which counts once per plan and not once per measurement.
fn without_prior(
    mut found: NormalEquations,
    machine: &Machine,
    free: &[usize],
    values: &ParameterValues,
) -> NormalEquations {
    let prior = prior_information(machine, free, values);
    for (column, (index, information)) in free.iter().zip(prior).enumerate() {
        let deviation = machine.parameters[*index].deviation(values[*index]).unwrap_or(0.0);
        found.chi_square -= deviation * deviation;
        found.gradient[column] -= deviation * information.sqrt();
        found.information[(column, column)] -= information;
    }
    found
}

/// Returns earlier information with that of the ranges, in the coordinates of the planned measurements, whose
/// last one may be a gain.
fn padded(information: &DMatrix<f64>, size: usize) -> DMatrix<f64> {
    let range = 1.0 / (RANGE_SD * RANGE_SD);
    DMatrix::from_fn(size, size, |row, column| {
        let known = if row < information.nrows() && column < information.ncols() {
            information[(row, column)]
        } else {
            0.0
        };
        known + if row == column { range } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rival(chi_square: f64, gradient: f64, information: f64) -> NormalEquations {
        NormalEquations {
            chi_square,
            gradient: DVector::from_element(1, gradient),
            information: DMatrix::from_element(1, 1, information),
        }
    }

    /// One parameter that explains the difference as far as it is free.
    #[test]
    fn limit_a_rival_with_free_parameters_is_not_rejected() {
        let same = rival(0.0, 0.0, 400.0);
        // Residual 20·1 with slope 20: one parameter takes all of it.
        let other = rival(400.0, 400.0, 400.0);
        let of = |earlier: f64| Discrimination {
            earlier: vec![DMatrix::from_element(1, 1, earlier); 2],
            misfits: vec![vec![vec![same.clone(), other.clone()], vec![other.clone(), same.clone()]]],
            limit: 9.0,
            variance: 1.0,
        };
        let free = of(1e-9);
        assert!(free.noncentrality(&[0], 0, 1) < 1e-6 && free.settled(&[0]) < 1e-6);
        // Known as well by earlier data: half of the misfit remains. Known exactly: all.
        assert!((of(400.0).noncentrality(&[0], 0, 1) - 200.0).abs() < 1e-9);
        let exact = of(1e12);
        assert!((exact.noncentrality(&[0], 0, 1) - 400.0).abs() < 1e-3 && exact.settled(&[0]) > 0.999_999);
        assert!(exact.settled(&[]) == 0.0);
    }

    #[test]
    fn limit_a_noncentrality_equal_to_the_limit_decides_in_half_of_the_cases() {
        assert!(
            (rejected(9.0, 9.0) - 0.5).abs() < 1e-12
                && rejected(0.0, 9.0) == 0.0
                && rejected(100.0, 9.0) > 0.999
        );
    }
}
