//! Whether the records of several positions are those of one position.

use rayon::prelude::*;

use super::data_fault::{AGREES, Fault, RESTORED};
use super::evidence::Domain;
use super::fit::{Fitted, Fitter};
use super::hypothesis::Hypothesis;
use super::null_distribution::NullDistribution;
use super::ranking::EQUIVALENT;
use super::record_checks::factors_of_alike;
use super::screening::nominal_fits;
use identification::objective::ObjectiveError;
use long_work::Control;
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;

/// Returns the fault that all records were measured at one position: they agree with each other within their
/// noise but for a factor, and at one of the positions with the nominal machine: better than at their own
/// with the same factors, and as well as with any effect as they are. `rival`: χ² and number of parameters of
/// the best significant effect.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn one_position(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    rival: Option<(f64, usize)>,
    (null, seed): (&NullDistribution, u64),
    control: &Control,
) -> Result<Option<Fault>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let Some(factors) = factors_of_alike(set, &all) else { return Ok(None) };
    let mut positions: Vec<usize> = all.iter().filter_map(|frf| set.frfs[*frf].position).collect();
    positions.sort_unstable();
    positions.dedup();
    // The same records with their factors removed, at their own positions or all at one.
    let fit_at = |position: &Option<usize>| -> Result<(f64, Option<usize>), ObjectiveError> {
        let mut other = set.clone();
        for (frf, factor) in &factors {
            let frf = &mut other.frfs[*frf];
            frf.position = frf.position.map(|own| position.unwrap_or(own));
            frf.lines.iter_mut().for_each(|line| line.value /= *factor);
        }
        let there = fitter.on(fitter.fit.in_version(&other));
        let part = control.within(&format!("one position {position:?}"));
        Ok((nominal_fits(&there, nominal, seed, &part)?[0].chi_square, *position))
    };
    let places: Vec<Option<usize>> = std::iter::once(None).chain(positions.into_iter().map(Some)).collect();
    let mut fits: Vec<(f64, Option<usize>)> = places.par_iter().map(fit_at).or_first_error()?;
    if control.stopped() {
        return Ok(None);
    }
    let count = fitter.objective(nominal)?.observations() as f64;
    let reach = AGREES + RESTORED.1 * null.excess(base.chi_square / count);
    let margin = |chi_square: f64| EQUIVALENT * null.excess(chi_square / count);
    let at_their_own = fits.remove(0).0;
    let explains = |chi_square: f64| {
        null.excess(chi_square / count) <= reach
            && chi_square + margin(chi_square) <= at_their_own
            && rival.is_none_or(|(rival, _)| chi_square <= rival + margin(rival))
    };
    let best = fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.filter(|(chi_square, _)| explains(*chi_square)).and_then(|(_, at)| at).map(Fault::OnePosition))
}
