//! How well a fitted model predicts held-out records. The choice of a model uses fitted data alone, and held-out
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

/// Returns −2 ln of the predictive density of held-out data after a fit, up to a constant: of each FRF with
/// its own nut position, gain and delay, over which the density is maximised within their tolerances. For
/// modes it is χ².
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn held_out_loss(
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
