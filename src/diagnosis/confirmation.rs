//! Confirmation of the chosen model by held-out records. The choice uses fitted data alone, and held-out
//! records are compared once.

use rayon::prelude::*;

use super::cross_validation::log_predictive_loss;
use super::evidence::Domain;
use super::fit::{Fitted, Fitter, coordinates_of, values_of};
use super::hypothesis::Hypothesis;
use identification::objective::{ModeObjective, ObjectiveError};
use long_work::Control;
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;
use numeric::statistics::log_sum_exp;

/// Least logarithm of a ratio of predictive densities that decides, in units of the misfit over null
/// simulations: 20 to 1.
///
/// # Source  Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773–795: «strong» evidence from 3 on.
const DECISIVE: f64 = 3.0;

/// How well the named model, or a set of models of which one is named, predicts held-out data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Confirmation {
    /// Logarithm of its predictive density over that of the nominal machine, and of a rival, in units of its
    /// misfit over null simulations.
    over_nominal: f64,
    over_rival: Option<f64>,
    /// Number of named models.
    named: usize,
}

impl Confirmation {
    /// Whether held-out data speak for the model for certain: it predicts them better than the nominal
    /// machine, and no rival predicts them better.
    pub fn is_certain(self) -> bool {
        self.over_nominal >= DECISIVE && self.over_rival.is_none_or(|rival| rival >= -DECISIVE)
    }

    /// Describes why held-out data do not confirm the model.
    pub fn text(self) -> String {
        let effect = if self.named > 1 { "the named effects" } else { "the best effect" };
        match self.over_rival.filter(|_| self.over_nominal >= DECISIVE) {
            Some(rival) => {
                format!(
                    "a generic impedance predicts held-out data better than {effect} (ln of the density ratio {:.1})",
                    -rival
                )
            }
            None => {
                format!(
                    "held-out data do not speak for {effect} for certain (ln of the density ratio {:.1})",
                    self.over_nominal
                )
            }
        }
    }
}

/// Compares the named models with the nominal machine, and with a rival, at held-out data. Where one of
/// several is named, each is as probable as the others, and the mean of their predictive densities counts.
/// `excess` is the misfit of the first over null simulations. `None` where nothing is held out.
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, §28: the evidence of a
///   hypothesis is the mean over its parts.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn confirmation(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, rival): ((&Hypothesis, &Fitted), Option<(&Hypothesis, &Fitted)>),
    named: &[(&Hypothesis, &Fitted)],
    excess: f64,
    control: &Control,
) -> Result<Option<Confirmation>, ObjectiveError> {
    let is_empty = match fitter.domain {
        Domain::Frf(_) => held_out.frfs().is_empty(),
        Domain::Modes(_) => held_out.positions().is_empty(),
    };
    if is_empty || control.stopped() {
        return Ok(None);
    }
    let models: Vec<(&Hypothesis, &Fitted)> =
        std::iter::once(nominal).chain(rival).chain(named.iter().copied()).collect();
    let losses: Vec<f64> = models
        .into_par_iter()
        .map(|(hypothesis, fitted)| held_out_loss(fitter, held_out, hypothesis, fitted, control))
        .or_first_error()?;
    let log_densities: Vec<f64> = losses.iter().map(|loss| -0.5 * loss / excess).collect();
    let (others, named) = log_densities.split_at(1 + usize::from(rival.is_some()));
    let over = |other: &f64| log_mean_exp(named) - other;
    Ok(Some(Confirmation {
        over_nominal: over(&others[0]),
        over_rival: others.get(1).map(over),
        named: named.len(),
    }))
}

/// Computes ln of the mean of numbers given by their logarithms.
fn log_mean_exp(logarithms: &[f64]) -> f64 {
    log_sum_exp(logarithms) - (logarithms.len() as f64).ln()
}

/// Returns −2 ln of the predictive density of held-out data after a fit, up to a constant: of each FRF with
/// its own nut position, gain and delay, over which the density is maximised within their tolerances. For
/// modes it is χ².
fn held_out_loss(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    hypothesis: &Hypothesis,
    fitted: &Fitted,
    control: &Control,
) -> Result<f64, ObjectiveError> {
    let own = fitter.objective(hypothesis)?;
    match fitter.domain {
        Domain::Frf(_) => {
            let of = |frf: &usize| {
                let one = held_out.with_frfs(|at| at == *frf);
                let left = fitter.objective_for_held_out(hypothesis, &one)?;
                Ok::<f64, ObjectiveError>(log_predictive_loss(
                    (&own, &left),
                    own.nut_coordinates().start,
                    fitted,
                    control,
                ))
            };
            Ok(held_out.frfs().par_iter().map(of).or_first_error()?.into_iter().sum())
        }
        Domain::Modes(settings) => {
            let left = ModeObjective::held_out(&hypothesis.machine, held_out, settings, None)?;
            let predicted = left.predict(&values_of(hypothesis, fitted));
            let gain = own.gain(&coordinates_of(&own, fitted));
            Ok(left.residuals(&predicted, gain).iter().map(|r| r * r).sum())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_one_of_several_costs_at_most_their_number() {
        assert_eq!(log_mean_exp(&[-3000.0]), -3000.0);
        assert!((log_mean_exp(&[-3000.0, -3000.0, -3000.0]) + 3000.0).abs() < 1e-12);
        assert!((log_mean_exp(&[-3000.0, -3100.0]) + 3000.0 + 2.0_f64.ln()).abs() < 1e-12);
    }
}
